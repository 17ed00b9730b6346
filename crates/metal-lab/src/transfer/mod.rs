//! Transfer: minds that learned in one world, sent to another after a few demonstrations there. Sec. 5, Fig. 11.
//!
//! Who has learned on the training road watches 0, 5 or 20 episodes of Phase I in the other world and is tested; a
//! newborn that saw as many demonstrations stands for learning from scratch. Then all learn on. What `metal transfer` does.

pub mod file;
mod page;
mod verdict;

pub use file::{TRANSFER, Transfer, TransferFile, parse};
pub use page::render;

use crate::evaluate::{Candidate, Course, watch};
use crate::mind::Mind;
use crate::plan::{Acting, Plan, PlanError};
use crate::progress::Progress;
use crate::registry::Roads;
use crate::reproduce::table::{RunsBySeed, cell, over_seeds};
use crate::results::{Estimate, Measures};
use crate::store::{Store, StoreError};
use crate::trace::{EpisodeRecord, Trace, Watcher};
use crate::train::{RunError, train_phase, train_seed};
use metal_rl::measure::curve::{accumulated, moving_average};
use metal_rl::observe::{Observer, Step};
use metal_rl::random::Streams;
use metal_rl::set::IndexSet;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Window of the moving average, as in Fig. 11.
const WINDOW: usize = 5;

/// Who is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Arm {
    /// Whether it has learned nowhere else.
    pub newborn: bool,
    /// Episodes of demonstration in the other world.
    pub episodes: usize,
}

impl Arm {
    /// Name in `results.json`.
    #[must_use]
    pub fn name(self) -> String {
        format!("{}-{}", if self.newborn { "scratch" } else { "transfer" }, self.episodes)
    }

    /// Name in the report.
    #[must_use]
    pub fn label(self) -> String {
        let origin = if self.newborn { "from scratch" } else { "transferred" };
        format!("{origin}, {} demonstrations", self.episodes)
    }
}

/// Why a transfer could not be carried out.
#[derive(Debug, thiserror::Error)]
pub enum TransferError {
    /// The experiment or a derived plan is refused.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// A world failed, or somebody interrupted.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The folder the minds come from.
    #[error(transparent)]
    Store(#[from] StoreError),
}

/// How much is done, and from what seed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TransferOptions {
    /// Independent trainings.
    pub seeds: usize,
    /// The one number all randomness comes from.
    pub seed: u64,
    /// Whether budgets were cut.
    pub quick: bool,
}

/// A line of Fig. 11: mean over trainings with its interval, point by point.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Curve {
    /// Reward per motor step, looks included.
    pub reward: Vec<Estimate>,
    /// Its moving average over five points.
    pub moving_average: Vec<Estimate>,
    /// Its sum since the first point (for learning: of all motor steps).
    pub accumulated: Vec<Estimate>,
}

/// Everything a transfer found out: `results.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TransferResults {
    /// Version of this layout.
    pub schema: u32,
    /// How it was run.
    pub options: TransferOptions,
    /// The experiment.
    pub experiment: TransferFile,
    /// Tests without learning: arm → policy → measure.
    pub tests: BTreeMap<String, BTreeMap<String, Measures>>,
    /// Tests of the lead policy after learning on: arm → measure.
    pub learned: BTreeMap<String, Measures>,
    /// Minds as they are, without a demonstration: world → policy → measure. `source` is the world they come from.
    pub worlds: BTreeMap<String, BTreeMap<String, Measures>>,
    /// The expert in the experiment's world.
    pub expert: Measures,
    /// The lead policy's test drives, motor step by motor step: arm → curve. Fig. 11.
    pub drives: BTreeMap<String, Curve>,
    /// The lead policy learning on, episode by episode: arm → curve.
    pub learning: BTreeMap<String, Curve>,
}

/// What one training came to.
#[derive(Default)]
struct OfSeed {
    tests: BTreeMap<String, BTreeMap<String, Vec<EpisodeRecord>>>,
    learned: BTreeMap<String, Vec<EpisodeRecord>>,
    worlds: BTreeMap<String, BTreeMap<String, Vec<EpisodeRecord>>>,
    expert: Vec<EpisodeRecord>,
    drives: BTreeMap<String, Vec<f64>>,
    learning: BTreeMap<String, Vec<EpisodeRecord>>,
}

/// Carries out the experiment. Minds come from the finished run in `store`, or are trained by the plan.
///
/// # Errors
/// If a plan is refused, a world fails, minds cannot be read, or somebody interrupts.
pub fn execute(
    transfer: &Transfer,
    options: TransferOptions,
    store: Option<&Store>,
    progress: &dyn Progress,
) -> Result<TransferResults, TransferError> {
    let seeds: Vec<OfSeed> = (0..options.seeds)
        .into_par_iter()
        .map(|seed| {
            let streams = Streams::new(options.seed).child("report").nth(seed as u64);
            let minds = match store {
                Some(store) => stored(transfer, store, seed)?,
                None => trained(transfer, &streams, progress)?,
            };
            Journey { transfer, minds, streams: streams.child("transfer"), progress }.travel()
        })
        .collect::<Result<_, TransferError>>()?;
    Ok(gathered(transfer, options, &seeds))
}

/// Minds by the phase they were left by.
type Minds = BTreeMap<String, Mind>;

fn stored(transfer: &Transfer, store: &Store, seed: usize) -> Result<Minds, TransferError> {
    let phases = transfer.source.file.policy.values().filter_map(|row| row.after.clone());
    phases.map(|phase| Ok((phase.clone(), store.read_mind(&transfer.source, seed, &phase)?))).collect()
}

fn trained(transfer: &Transfer, streams: &Streams, progress: &dyn Progress) -> Result<Minds, TransferError> {
    let trained = train_seed(&transfer.source, streams, progress)?;
    Ok(trained.into_iter().map(|(phase, trained)| (phase, trained.mind)).collect())
}

/// One training's way through the experiment.
struct Journey<'a> {
    transfer: &'a Transfer,
    minds: Minds,
    streams: Streams,
    progress: &'a dyn Progress,
}

impl Journey<'_> {
    fn travel(&self) -> Result<OfSeed, TransferError> {
        let mut found = OfSeed::default();
        for arm in self.transfer.file.arms() {
            self.arm(arm, &mut found)?;
        }
        for (i, plan) in self.transfer.worlds.iter().enumerate() {
            let name = self.transfer.file.world[i].name.clone();
            found.worlds.insert(name, self.test_as_they_are(plan)?);
        }
        found.worlds.insert("source".to_owned(), self.test_as_they_are(&self.transfer.source)?);
        let mind = Mind::newborn(&self.transfer.worlds[0], &self.streams).map_err(RunError::from)?;
        let plan = &self.transfer.worlds[0];
        found.expert = self.test(plan, &mind, (&Acting::Advisor, IndexSet::EMPTY))?.0;
        Ok(found)
    }

    /// Demonstrations, tests, learning on, and a test again.
    fn arm(&self, arm: Arm, found: &mut OfSeed) -> Result<(), TransferError> {
        let world = &self.transfer.worlds[0];
        for (name, row) in &self.transfer.source.file.policy {
            let mind = self.prepared(arm, row.after.as_deref().unwrap_or_default())?;
            if !able(&mind, &row.acting) {
                continue;
            }
            let (runs, drive) = self.test(world, &mind, (&row.acting, world.roster(&row.roster)))?;
            found.tests.entry(arm.name()).or_default().insert(name.clone(), runs);
            if name == self.transfer.lead() {
                found.drives.insert(arm.name(), drive);
            }
        }
        let plan = self.transfer.learning(arm)?;
        let mind = self.prepared(arm, self.transfer.lead_phase())?;
        let learned = train_phase(&plan, self.transfer.lead_phase(), mind, &self.streams, self.progress)?;
        let row = &plan.file.policy[self.transfer.lead()];
        let (runs, _) = self.test(&plan, &learned.mind, (&row.acting, plan.roster(&row.roster)))?;
        found.learned.insert(arm.name(), runs);
        found.learning.insert(arm.name(), learned.trace.episodes);
        Ok(())
    }

    /// The mind of a phase (or a newborn one) after the arm's demonstrations.
    fn prepared(&self, arm: Arm, phase: &str) -> Result<Mind, TransferError> {
        let plan = self.transfer.watching(arm.episodes.max(1))?;
        let mind = if arm.newborn {
            Mind::newborn(&plan, &self.streams).map_err(RunError::from)?
        } else {
            self.minds[phase].clone()
        };
        if arm.episodes == 0 {
            return Ok(mind);
        }
        let watched =
            train_phase(&plan, &self.transfer.file.demonstration, mind, &self.streams, self.progress)?;
        Ok(watched.mind)
    }

    fn test_as_they_are(&self, plan: &Plan) -> Result<BTreeMap<String, Vec<EpisodeRecord>>, TransferError> {
        let rows = plan.file.policy.iter();
        rows.map(|(name, row)| {
            let mind = &self.minds[row.after.as_deref().unwrap_or_default()];
            Ok((name.clone(), self.test(plan, mind, (&row.acting, plan.roster(&row.roster)))?.0))
        })
        .collect()
    }

    /// Test runs, and the mean reward of each motor step over them.
    fn test(
        &self,
        plan: &Plan,
        mind: &Mind,
        (acting, roster): (&Acting, IndexSet),
    ) -> Result<(Vec<EpisodeRecord>, Vec<f64>), TransferError> {
        let candidate = Candidate { plan, mind, acting, roster, blind: 0 };
        let scenario = plan.file.environment.training_scenario();
        let course = Course { scenario, roads: Roads::Training, runs: self.transfer.file.runs };
        let watcher = Watcher { trace: Trace::new(&plan.spec), progress: self.progress };
        let mut drive = Drive { watcher, step: 0, sums: Vec::new() };
        watch(&candidate, &course, &self.streams, &mut drive)?;
        if self.progress.interrupted() {
            return Err(RunError::Interrupted.into());
        }
        let rewards = drive.sums.iter().map(|sum| sum / course.runs as f64).collect();
        Ok((drive.watcher.trace.episodes, rewards))
    }
}

/// Whether a mind can do this: attention must have been born.
fn able(mind: &Mind, acting: &Acting) -> bool {
    !matches!(acting, Acting::Attention(name) if !mind.has_attention(name))
}

/// A trace, and the rewards of all runs by motor step.
struct Drive<'a> {
    watcher: Watcher<'a>,
    step: usize,
    sums: Vec<f64>,
}

impl Observer for Drive<'_> {
    fn on_step(&mut self, step: &Step<'_>) {
        self.watcher.on_step(step);
        if self.sums.len() <= self.step {
            self.sums.push(0.0);
        }
        self.sums[self.step] += step.motor_reward - step.look_price;
        self.step += 1;
    }

    fn on_episode(&mut self, episode: usize, progress: f64) {
        self.watcher.on_episode(episode, progress);
        self.step = 0;
    }
}

/// Rewards of one training, point by point, and the number of motor steps a point stands for.
type Line = (Vec<f64>, f64);

fn gathered(transfer: &Transfer, options: TransferOptions, seeds: &[OfSeed]) -> TransferResults {
    let names = || transfer.file.arms().into_iter().map(Arm::name);
    let curves = |values: &dyn Fn(&OfSeed, &str) -> Option<Line>| -> BTreeMap<String, Curve> {
        let curve = |arm: String| {
            let lines: Vec<Line> = seeds.iter().filter_map(|s| values(s, &arm)).collect();
            (lines.len() == seeds.len()).then(|| (arm, curve(&lines)))
        };
        names().filter_map(curve).collect()
    };
    TransferResults {
        schema: 1,
        options,
        experiment: transfer.file.clone(),
        tests: cells(seeds, |s| &s.tests),
        learned: flat_cells(seeds, |s| &s.learned),
        worlds: cells(seeds, |s| &s.worlds),
        expert: cell(&seeds.iter().map(|s| s.expert.clone()).collect::<RunsBySeed>()),
        drives: curves(&|s, arm| Some((s.drives.get(arm)?.clone(), 1.0))),
        learning: curves(&|s, arm| {
            let episodes = s.learning.get(arm)?;
            let steps = episodes.first()?.steps() as f64;
            Some((episodes.iter().map(|e| e.per_step(e.motor + e.perceptual)).collect(), steps))
        }),
    }
}

type Cells = BTreeMap<String, BTreeMap<String, Vec<EpisodeRecord>>>;

fn cells(seeds: &[OfSeed], pick: fn(&OfSeed) -> &Cells) -> BTreeMap<String, BTreeMap<String, Measures>> {
    let Some(first) = seeds.first() else { return BTreeMap::new() };
    let row = |(arm, policies): (&String, &BTreeMap<String, Vec<EpisodeRecord>>)| {
        let of = |policy: &String| {
            let runs: RunsBySeed = seeds.iter().map(|s| pick(s)[arm][policy].clone()).collect();
            (policy.clone(), cell(&runs))
        };
        (arm.clone(), policies.keys().map(of).collect())
    };
    pick(first).iter().map(row).collect()
}

fn flat_cells(
    seeds: &[OfSeed],
    pick: fn(&OfSeed) -> &BTreeMap<String, Vec<EpisodeRecord>>,
) -> BTreeMap<String, Measures> {
    let Some(first) = seeds.first() else { return BTreeMap::new() };
    let of = |arm: &String| {
        let runs: RunsBySeed = seeds.iter().map(|s| pick(s)[arm].clone()).collect();
        (arm.clone(), cell(&runs))
    };
    pick(first).keys().map(of).collect()
}

/// The three quantities of Fig. 11 over the lines of all trainings.
fn curve(lines: &[Line]) -> Curve {
    let over = |transform: &dyn Fn(&[f64], f64) -> Vec<f64>| {
        let lines: Vec<Vec<f64>> = lines.iter().map(|(line, steps)| transform(line, *steps)).collect();
        let length = lines.iter().map(Vec::len).min().unwrap_or(0);
        let point = |i: usize| over_seeds(&lines.iter().map(|line| line[i]).collect::<Vec<_>>());
        (0..length).filter_map(point).collect()
    };
    Curve {
        reward: over(&|line, _| line.to_vec()),
        moving_average: over(&|line, _| moving_average(line, WINDOW)),
        accumulated: over(&|line, steps| accumulated(line).into_iter().map(|sum| sum * steps).collect()),
    }
}

/// About how many motor steps [`execute`] will simulate, for a progress bar.
#[must_use]
pub fn planned_steps(transfer: &Transfer, options: TransferOptions, is_trained: bool) -> usize {
    let (file, plan) = (&transfer.file, &transfer.source);
    let horizon = plan.spec.horizon;
    let training: usize =
        if is_trained { 0 } else { plan.order.iter().map(|name| plan.budget_steps(name)).sum() };
    let arms = file.arms();
    let watched: usize = arms.iter().map(|arm| arm.episodes).sum::<usize>() * (file.policies.len() + 1);
    let tests = (arms.len() + file.world.len() + 1) * file.policies.len() + arms.len() + 1;
    let there = watched + tests * file.runs + arms.len() * file.learning.episodes;
    options.seeds * (training + there * horizon)
}
