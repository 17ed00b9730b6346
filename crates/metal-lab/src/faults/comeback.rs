//! A sensor breaks and is mended while a mind learns on: where does it look?

use super::desk::{Desk, Minds, over};
use super::favourite::favourite;
use crate::learn_on::{can_learn_on, learning_on};
use crate::mind::Mind;
use crate::plan::{Acting, Plan};
use crate::results::Estimate;
use crate::train::{RunError, Watch, learn_phase};
use metal_rl::observe::{Observer, Step};
use metal_rl::policy::Heard;
use metal_rl::random::Streams;
use metal_worlds::faulty::{Fault, Faults};
use serde::{Deserialize, Serialize};

/// Blocks of episodes per stage.
const BLOCKS: usize = 6;

/// Some episodes in a row of learning, means over them; intervals are over trainings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Block {
    /// Episodes until the end of the block, since learning went on.
    pub episodes: usize,
    /// Looks per motor step at the sensor in question.
    pub looks_there: Estimate,
    /// Looks per motor step at all sensors.
    pub looks: Estimate,
    /// Motor reward minus prices, per motor step.
    pub total: Estimate,
}

/// A fault of the sensor that a mind looks at most: a third of the episodes before, a third during, a third after.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Comeback {
    /// Name of the fault.
    pub fault: String,
    /// Name of the policy.
    pub policy: String,
    /// The sensor each training looks at most.
    pub sensors: Vec<String>,
    /// What happened.
    pub blocks: Vec<Block>,
}

/// Follows the first policy that chooses its looks and can learn on through `fault`; nothing if there is none.
pub(super) fn follow(desk: &Desk<'_>, minds: &Minds, fault: Fault) -> Result<Option<Comeback>, RunError> {
    let attends = |policy: &String| {
        let row = &desk.plan.file.policy[policy];
        let phase = row.after.clone().filter(|phase| can_learn_on(&desk.plan, phase))?;
        matches!(row.acting, Acting::Attention(_)).then_some((policy.clone(), phase))
    };
    let Some((policy, phase)) = desk.options.policies.iter().find_map(attends) else { return Ok(None) };
    let (policy, phase) = (policy.as_str(), phase.as_str());
    let plan = learning_on(&desk.plan, phase, desk.options.lasting)?;
    let through = |seed: usize| {
        let sensor = favourite(desk, &desk.candidate(policy, &minds[seed]), seed)?;
        let mut diary = Diary::new(sensor);
        let mut mind = Mind::thaw(&plan, &minds[seed][phase].mind.freeze_for(&desk.plan))?;
        let name = plan.spec.sensors[sensor].name.clone();
        let broken =
            Faults { fault: Some(fault), rate: 1.0, sensors: vec![name.clone()], ..Faults::default() };
        for (stage, faults) in [Faults::default(), broken, Faults::default()].into_iter().enumerate() {
            let streams = desk.seed(seed).child("comeback").nth(stage as u64);
            let world = desk.broken(faults);
            go_on(&plan, (phase, &mut mind), &world, &streams, (&mut diary, desk))?;
        }
        Ok((name, diary.blocks(desk.options.lasting)))
    };
    let (sensors, diaries): (Vec<_>, Vec<_>) = desk.per_seed(through)?.into_iter().unzip();
    let blocks = (0..3 * BLOCKS).map(|b| block(&diaries, b, desk.options.lasting)).collect();
    Ok(Some(Comeback { fault: fault.name().to_owned(), policy: policy.to_owned(), sensors, blocks }))
}

/// Lets `mind` learn on in `world` as the plan's phase says.
pub(super) fn go_on(
    plan: &Plan,
    (phase, mind): (&str, &mut Mind),
    world: &crate::registry::EnvironmentConfig,
    streams: &Streams,
    (observer, desk): (&mut dyn Observer, &Desk<'_>),
) -> Result<(), RunError> {
    let mut environment = world.build()?;
    let ear = &mut |_: &Heard<'_>| {};
    let watch = Watch { environment: environment.as_mut(), observer, ear, progress: desk.progress };
    learn_phase(plan, phase, mind, streams, watch)?;
    desk.progress.steps(plan.budget_steps(phase));
    Ok(())
}

/// Sums over one episode.
#[derive(Clone, Copy, Default)]
struct Page {
    steps: f64,
    there: f64,
    looks: f64,
    total: f64,
}

/// Writes down every episode.
struct Diary {
    sensor: usize,
    now: Page,
    pages: Vec<Page>,
}

impl Diary {
    fn new(sensor: usize) -> Self {
        Self { sensor, now: Page::default(), pages: Vec::new() }
    }

    /// Means over blocks of episodes: looks there, looks, total.
    fn blocks(&self, lasting: usize) -> Vec<[f64; 3]> {
        let mut blocks = Vec::new();
        for stage in self.pages.chunks(lasting) {
            blocks.extend((0..BLOCKS).map(|b| {
                let pages = &stage[b * lasting / BLOCKS..(b + 1) * lasting / BLOCKS];
                let sum = |f: &dyn Fn(&Page) -> f64| pages.iter().map(f).sum::<f64>();
                let steps = sum(&|p| p.steps).max(1.0);
                [sum(&|p| p.there) / steps, sum(&|p| p.looks) / steps, sum(&|p| p.total) / steps]
            }));
        }
        blocks
    }
}

impl Observer for Diary {
    fn on_step(&mut self, step: &Step<'_>) {
        self.now.steps += 1.0;
        self.now.there += f64::from(u8::from(step.percept.read().contains(self.sensor)));
        self.now.looks += step.percept.read().len() as f64;
        self.now.total += step.motor_reward - step.look_price;
    }

    fn on_episode(&mut self, _episode: usize, _progress: f64) {
        self.pages.push(std::mem::take(&mut self.now));
    }
}

fn block(diaries: &[Vec<[f64; 3]>], at: usize, lasting: usize) -> Block {
    let estimate = |i: usize| over(&diaries.iter().map(|d| d[at][i]).collect::<Vec<_>>());
    let (stage, within) = (at / BLOCKS, at % BLOCKS + 1);
    let episodes = stage * lasting + within * lasting / BLOCKS;
    Block { episodes, looks_there: estimate(0), looks: estimate(1), total: estimate(2) }
}
