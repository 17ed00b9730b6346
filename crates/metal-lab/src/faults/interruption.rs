//! A sensor breaks in the middle of an episode and is mended before its end: does whoever drives stop looking there, and
//! come back? Nobody learns: this is what a mind does that went out of the laboratory as it is.

use super::desk::{Desk, Minds, over};
use super::favourite::favourite;
use crate::evaluate::drive;
use crate::plan::Acting;
use crate::registry::EnvironmentConfig;
use crate::results::Estimate;
use crate::train::RunError;
use metal_rl::observe::{Observer, Step};
use metal_worlds::faulty::{Fault, Faults};
use serde::{Deserialize, Serialize};

/// Sound, broken, mended.
const STAGES: [&str; 3] = ["sound", "broken", "mended"];

/// Spells per stage.
const SPELLS: usize = 5;

/// Some motor steps in a row, the same ones of every episode; means over them, intervals over trainings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spell {
    /// How the sensor is: `sound`, `broken` or `mended`.
    pub sensor: String,
    /// Its first motor step, and the first after it.
    pub steps: (usize, usize),
    /// Looks per motor step at the sensor in question.
    pub looks_there: Estimate,
    /// The same in the same episodes with a sound sensor.
    pub looks_there_sound: Estimate,
    /// Looks per motor step at all sensors.
    pub looks: Estimate,
    /// Motor reward minus prices, per motor step.
    pub total: Estimate,
    /// How much more that is than in the same episodes with a sound sensor, training by training.
    pub gain: Estimate,
}

/// A fault, for the middle third of every episode, of the sensor that a policy looks at most.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Interruption {
    /// Name of the fault.
    pub fault: String,
    /// Name of the policy.
    pub policy: String,
    /// The sensor each training looks at most.
    pub sensors: Vec<String>,
    /// What happened.
    pub spells: Vec<Spell>,
}

/// Every policy that chooses its looks, through every fault that is followed; nothing where episodes are too short for it.
pub(super) fn all(desk: &Desk<'_>, minds: &Minds) -> Result<Vec<Interruption>, RunError> {
    // As long as three episodes of the training, where a world can last that long: a third is then what everybody knows.
    let world = desk.plan.file.environment.clone().for_longer(STAGES.len());
    let horizon = world.build()?.spec().horizon;
    let mut found = Vec::new();
    if horizon < STAGES.len() * SPELLS {
        return Ok(found);
    }
    let chooses = |policy: &&String| matches!(desk.plan.file.policy[*policy].acting, Acting::Attention(_));
    for policy in desk.options.policies.iter().filter(chooses) {
        for &fault in &desk.options.followed {
            found.push(interruption((desk, minds), (&world, horizon), policy, fault)?);
        }
    }
    Ok(found)
}

fn interruption(
    (desk, minds): (&Desk<'_>, &Minds),
    (world, horizon): (&EnvironmentConfig, usize),
    policy: &str,
    fault: Fault,
) -> Result<Interruption, RunError> {
    let third = horizon / STAGES.len();
    let through = |seed: usize| {
        let candidate = desk.candidate(policy, &minds[seed]);
        let sensor = favourite(desk, &candidate, seed)?;
        let name = desk.plan.spec.sensors[sensor].name.clone();
        let broken = Faults {
            fault: Some(fault),
            rate: 1.0,
            sensors: vec![name.clone()],
            during: Some((third, 2 * third)),
            ..Faults::default()
        };
        let streams = desk.seed(seed).child("interruption");
        let sums = |faults: Faults| {
            let mut diary = Diary { sensor, horizon, sums: vec![Sums::default(); STAGES.len() * SPELLS] };
            let mut environment = world.clone().with_faults(faults).build()?;
            drive(&candidate, environment.as_mut(), (desk.options.runs, &streams), &mut diary)?;
            Ok::<_, RunError>(diary.sums)
        };
        Ok((name, sums(Faults::default())?, sums(broken)?))
    };
    let rows = desk.per_seed(through)?;
    let spell = |at: usize| {
        let estimate = |number: &dyn Fn(&Sums, &Sums) -> f64| {
            over(&rows.iter().map(|(_, sound, broken)| number(&sound[at], &broken[at])).collect::<Vec<_>>())
        };
        Spell {
            sensor: STAGES[at / SPELLS].to_owned(),
            steps: (first_step(at, horizon), first_step(at + 1, horizon)),
            looks_there: estimate(&|_, broken| broken.per_step(broken.there)),
            looks_there_sound: estimate(&|sound, _| sound.per_step(sound.there)),
            looks: estimate(&|_, broken| broken.per_step(broken.looks)),
            total: estimate(&|_, broken| broken.per_step(broken.total)),
            gain: estimate(&|sound, broken| broken.per_step(broken.total) - sound.per_step(sound.total)),
        }
    };
    Ok(Interruption {
        fault: fault.name().to_owned(),
        policy: policy.to_owned(),
        sensors: rows.iter().map(|(name, ..)| name.clone()).collect(),
        spells: (0..STAGES.len() * SPELLS).map(spell).collect(),
    })
}

/// The first motor step of a spell: every stage has a third of the episode, the last one what is left over, too.
fn first_step(spell: usize, horizon: usize) -> usize {
    let third = horizon / STAGES.len();
    let (stage, within) = (spell / SPELLS, spell % SPELLS);
    match stage {
        0 | 1 => stage * third + within * third / SPELLS,
        2 => 2 * third + within * (horizon - 2 * third) / SPELLS,
        _ => horizon,
    }
}

/// Sums over the motor steps of a spell, in all episodes.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    steps: f64,
    there: f64,
    looks: f64,
    total: f64,
}

impl Sums {
    fn per_step(&self, sum: f64) -> f64 {
        sum / self.steps.max(1.0)
    }
}

/// Adds up every spell.
struct Diary {
    sensor: usize,
    horizon: usize,
    sums: Vec<Sums>,
}

impl Observer for Diary {
    fn on_step(&mut self, step: &Step<'_>) {
        let last = self.sums.len() - 1;
        let spell =
            (1..=last).find(|&spell| step.index < first_step(spell, self.horizon)).map_or(last, |s| s - 1);
        let now = &mut self.sums[spell];
        now.steps += 1.0;
        now.there += f64::from(u8::from(step.percept.read().contains(self.sensor)));
        now.looks += step.percept.read().len() as f64;
        now.total += step.motor_reward - step.look_price;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spells_cover_every_motor_step_once_and_stages_are_thirds() {
        for horizon in [15, 17, 50, 150, 151] {
            let firsts: Vec<usize> = (0..=STAGES.len() * SPELLS).map(|s| first_step(s, horizon)).collect();
            assert!(firsts.is_sorted(), "{firsts:?}");
            assert_eq!((firsts[0], firsts[SPELLS], firsts[3 * SPELLS]), (0, horizon / 3, horizon));
            assert_eq!(firsts[2 * SPELLS], 2 * (horizon / 3));
        }
    }
}
