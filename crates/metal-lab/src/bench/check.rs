//! `metal check TASK`: whether a task is well posed, before anybody spends an hour on learning it. What blindness costs,
//! what each sensor tells alone, how rewards and prices compare, and what is badly posed.

use super::BenchOptions;
use super::problems::{problems, warnings};
use super::rows::Desk;
use super::search::screen;
use crate::plan::{PlanError, limits};
use crate::progress::Progress;
use crate::task::{Driver, Learned, Recipe, Score, Task, trial};
use crate::train::RunError;
use metal_rl::environment::{End, Environment};
use metal_rl::num;
use metal_rl::random::{Rng, Streams};
use metal_rl::set::IndexSet;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// How much is tried.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CheckOptions {
    /// The one number all randomness comes from.
    pub seed: u64,
    /// Episodes of every drive: blind, at random, and with what was learned.
    pub episodes: usize,
    /// Motor steps from which everybody who sees something learns.
    pub steps: usize,
}

impl Default for CheckOptions {
    fn default() -> Self {
        Self { seed: 1, episodes: 100, steps: 10_000 }
    }
}

/// A motor action taken whatever happens.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Constant {
    /// Name of the action.
    pub action: String,
    /// Motor reward of an episode, mean.
    pub motor: f64,
}

/// What is known of a sensor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SensorCheck {
    /// Its name.
    pub name: String,
    /// Price of one look.
    pub price: f64,
    /// Share of its features that ever change, in [0, 1].
    pub changing: f64,
    /// Share of its readings that are no numbers, or outside their declared range, in [0, 1].
    pub outside: f64,
    /// Entropy of its readings in bits, each feature cut into eight parts of what was seen.
    pub bits: f64,
    /// Motor reward of an episode, mean, of a mind that reads only this sensor, before every move.
    pub alone: f64,
    /// What it pays for that.
    pub cost: f64,
}

/// The findings. Drives take place in the world of learning: the test stays unseen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Check {
    /// Name of the world.
    pub task: String,
    /// How much was tried.
    pub options: CheckOptions,
    /// Every constant motor action.
    pub blind: Vec<Constant>,
    /// Motor reward of an episode at random.
    pub random: f64,
    /// Motor steps of an episode at random.
    pub steps: f64,
    /// Smallest and largest motor reward of a step.
    pub rewards: (f64, f64),
    /// Every sensor.
    pub sensors: Vec<SensorCheck>,
    /// Motor reward of an episode of a mind that reads all sensors before every move.
    pub everything: f64,
    /// What it pays for that.
    pub everything_cost: f64,
    /// What is badly posed, for certain.
    pub problems: Vec<String>,
    /// What is perhaps badly posed: as far as those who learned so briefly can tell.
    pub warnings: Vec<String>,
}

impl Check {
    /// The best constant motor action: what attention has to beat.
    #[must_use]
    pub fn best_blind(&self) -> Option<&Constant> {
        self.blind.iter().max_by(|a, b| a.motor.total_cmp(&b.motor))
    }

    /// What seeing everything is worth over seeing nothing.
    #[must_use]
    pub fn gain(&self) -> f64 {
        self.everything - self.best_blind().map_or(0.0, |c| c.motor)
    }
}

/// Motor steps of learning that [`check()`] makes.
#[must_use]
pub fn planned_check_steps(options: &CheckOptions, sensors: usize) -> usize {
    (sensors + usize::from(sensors > 1)) * options.steps
}

/// Checks `task`: drives it blindly and at random, and learns it once with every sensor alone and once with all.
///
/// # Errors
/// If options or task are impossible, the world fails, or the user interrupts.
pub fn check(task: &dyn Task, options: &CheckOptions, progress: &dyn Progress) -> Result<Check, RunError> {
    limits::count("episodes", options.episodes, "episodes")?;
    let recipe = Recipe::of_steps(options.steps);
    recipe.check()?;
    let mut world = task.training()?;
    let (spec, recipe) = (world.spec().clone(), recipe.for_task(task, world.as_ref()));
    if spec.sensors.is_empty() {
        return Err(PlanError::at("sensors", "none: there is nothing to look at").into());
    }
    let streams = Streams::new(options.seed);
    let amounts =
        BenchOptions { episodes: options.episodes, screening_share: 1.0, ..BenchOptions::default() };
    let desk = Desk { task, spec: &spec, recipe: &recipe, options: &amounts, streams, progress };
    let drives = Drives::random(world.as_mut(), options.episodes, &streams.child("random"))?;
    let blind = blind(&desk)?;
    let mut subsets: Vec<IndexSet> = (0..spec.sensors.len()).map(|s| IndexSet::EMPTY.with(s)).collect();
    subsets.push(IndexSet::first(spec.sensors.len()));
    subsets.dedup();
    let learned: Vec<Score> = screen(&desk, &subsets)?.into_iter().map(|s| s.score).collect();
    let sensors = (0..spec.sensors.len()).map(|s| drives.sensor(world.as_ref(), s, &learned[s]));
    let everything = &learned[learned.len() - 1];
    let mut found = Check {
        task: spec.id.clone(),
        options: options.clone(),
        blind,
        random: drives.total / options.episodes as f64,
        steps: drives.steps as f64 / options.episodes as f64,
        rewards: drives.rewards,
        sensors: sensors.collect(),
        everything: everything.mean_motor(),
        everything_cost: everything.mean_price(),
        problems: Vec::new(),
        warnings: Vec::new(),
    };
    (found.problems, found.warnings) = (problems(&found), warnings(&found));
    Ok(found)
}

/// Every constant action in the world of learning.
fn blind(desk: &Desk<'_>) -> Result<Vec<Constant>, RunError> {
    let mind = Learned::newborn(desk.spec, &desk.task.opinions(), desk.recipe, &desk.streams)?;
    let task = super::rows::Rehearsal(desk.task);
    let runs = (desk.options.episodes, &desk.streams.child("validation"));
    let one = |(a, name): (usize, &String)| {
        let motor = trial(&task, &mind, Driver::Blind(a), runs)?.mean_motor();
        Ok(Constant { action: name.clone(), motor })
    };
    desk.spec.actions.iter().enumerate().map(one).collect()
}

/// What was read and earned while moves were left to chance, everything read, nobody paying.
struct Drives {
    total: f64,
    steps: usize,
    rewards: (f64, f64),
    /// Readings of every sensor, one after the other.
    readings: Vec<Vec<f64>>,
}

impl Drives {
    fn random(world: &mut dyn Environment, episodes: usize, streams: &Streams) -> Result<Self, RunError> {
        let sensors = world.spec().sensors.len();
        let rewards = (f64::INFINITY, f64::NEG_INFINITY);
        let mut drives = Self { total: 0.0, steps: 0, rewards, readings: vec![Vec::new(); sensors] };
        let mut seeds = streams.stream("episodes");
        let mut moves = streams.stream("moves");
        for _ in 0..episodes {
            world.reset(seeds.bits())?;
            drives.episode(world, &mut moves)?;
        }
        Ok(drives)
    }

    fn episode(&mut self, world: &mut dyn Environment, moves: &mut Rng) -> Result<(), RunError> {
        let (horizon, actions) = (world.spec().horizon, world.spec().actions.len());
        for _ in 0..horizon {
            for (sensor, log) in self.readings.iter_mut().enumerate() {
                let (start, width) = (log.len(), world.spec().sensors[sensor].features.len());
                log.resize(start + width, 0.0);
                world.sense(sensor, &mut log[start..])?;
            }
            let outcome = world.step(moves.below(actions))?;
            self.total += outcome.motor_reward;
            self.steps += 1;
            self.rewards.0 = self.rewards.0.min(outcome.motor_reward);
            self.rewards.1 = self.rewards.1.max(outcome.motor_reward);
            if outcome.end != End::Running {
                break;
            }
        }
        Ok(())
    }

    fn sensor(&self, world: &dyn Environment, sensor: usize, alone: &Score) -> SensorCheck {
        let spec = &world.spec().sensors[sensor];
        let (readings, width) = (&self.readings[sensor], spec.features.len());
        let ranges: Vec<(f64, f64)> = (0..width).map(|f| range(readings, (f, width))).collect();
        let changing = ranges.iter().filter(|(low, high)| high > low).count();
        let outside = |(i, x): &(usize, &f64)| {
            let feature = &spec.features[i % width];
            !(feature.low..=feature.high).contains(*x)
        };
        SensorCheck {
            name: spec.name.clone(),
            price: spec.price,
            changing: changing as f64 / width.max(1) as f64,
            outside: readings.iter().enumerate().filter(outside).count() as f64
                / readings.len().max(1) as f64,
            bits: bits(readings, &ranges),
            alone: alone.mean_motor(),
            cost: alone.mean_price(),
        }
    }
}

/// Smallest and largest value of one of `width` features.
fn range(readings: &[f64], (feature, width): (usize, usize)) -> (f64, f64) {
    let mine = readings.iter().skip(feature).step_by(width).filter(|x| x.is_finite());
    mine.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &x| (low.min(x), high.max(x)))
}

/// Parts into which a feature is cut.
const PARTS: f64 = 8.0;

/// Entropy of the readings in bits; at most the logarithm of how many there are.
fn bits(readings: &[f64], ranges: &[(f64, f64)]) -> f64 {
    if ranges.is_empty() {
        return 0.0;
    }
    let part = |(&x, &(low, high)): (&f64, &(f64, f64))| {
        let place = if high > low { PARTS * (x - low) / (high - low) } else { 0.0 };
        place.clamp(0.0, PARTS - 1.0) as u8
    };
    let mut counts: BTreeMap<Vec<u8>, usize> = BTreeMap::new();
    for reading in readings.chunks_exact(ranges.len()) {
        *counts.entry(reading.iter().zip(ranges).map(part).collect()).or_default() += 1;
    }
    let all = counts.values().sum::<usize>() as f64;
    let entropy: f64 = counts.values().map(|&n| -(n as f64 / all) * num::ln(n as f64 / all)).sum();
    entropy / num::ln(2.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eight_equally_frequent_readings_are_three_bits_and_a_constant_is_none() {
        let readings: Vec<f64> = (0..80).flat_map(|i| [f64::from(i % 8), 5.0]).collect();
        let ranges = [range(&readings, (0, 2)), range(&readings, (1, 2))];
        assert_eq!(ranges, [(0.0, 7.0), (5.0, 5.0)]);
        assert!((bits(&readings, &ranges) - 3.0).abs() < 1e-9);
        assert_eq!(bits(&[1.0, 1.0], &[(1.0, 1.0)]).abs(), 0.0);
    }
}
