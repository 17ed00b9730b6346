//! The whole experiment: train every seed, test everybody on every road, compare with the fixed subsets, and gather
//! the numbers. What `metal reproduce` and `metal run` do.

pub mod curves;
mod gather;
pub mod quick;
pub mod subsets;
pub mod table;

pub use gather::gather;

use crate::checkpoint::Ledger;
use crate::checkpoint::ledger::chapter_of_seed;
use crate::evaluate::{Candidate, Course, best_blind_action, test};
use crate::mind::Mind;
use crate::plan::Plan;
use crate::plan::file::SubsetsFile;
use crate::progress::Progress;
use crate::registry::{Roads, roads_name};
use crate::train::{RunError, Trained, train_seed_kept};
use metal_rl::random::Streams;
use metal_rl::set::IndexSet;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};
use subsets::{Confirmed, Rival, Screened, TrainedSubset, screen, train_subset_kept};
use table::RunsBySeed;

/// What to run beyond what the plan says.
#[derive(Clone, Debug)]
pub struct Options {
    /// Independent trainings, ≥ 1.
    pub seeds: usize,
    /// The one number all randomness comes from.
    pub seed: u64,
    /// Whether budgets are cut so that the numbers only show that everything works.
    pub quick: bool,
    /// Whether every subset of sensors is screened.
    pub all_subsets: bool,
}

/// Test runs: roads → policy → scenario → seed → runs.
pub type Tables = BTreeMap<String, BTreeMap<String, BTreeMap<String, RunsBySeed>>>;

/// Everything a finished experiment knows.
pub struct Outcome {
    /// The plan that was run.
    pub plan: Plan,
    /// How it was run.
    pub options: Options,
    /// Trained minds: seed → phase.
    pub trained: Vec<BTreeMap<String, Trained>>,
    /// Best constant action.
    pub blind: usize,
    /// Test runs.
    pub tables: Tables,
    /// Screened subsets.
    pub screened: Vec<Screened>,
    /// Subsets trained again on fresh seeds, in the order of their screening.
    pub confirmed: Vec<Confirmed>,
    /// The fixed subset that did best on validation roads among the confirmed, as a policy name.
    pub best_fixed: Option<String>,
    /// Busy seconds of all threads together, by part of the work.
    pub busy: BTreeMap<String, f64>,
}

/// Runs the experiment. The same plan and options give the same outcome, whatever the number of threads.
///
/// # Errors
/// If a world fails, or the user interrupts.
pub fn execute(plan: Plan, options: Options, progress: &dyn Progress) -> Result<Outcome, RunError> {
    execute_kept(plan, options, &Ledger::none(progress))
}

/// As [`execute`]: every finished piece of work is kept in `ledger`, and what is kept is not done again. The outcome is
/// the same bit for bit, but for the time it took.
///
/// # Errors
/// If a world fails, the user interrupts, or a piece cannot be kept.
pub fn execute_kept(plan: Plan, options: Options, ledger: &Ledger<'_>) -> Result<Outcome, RunError> {
    let (streams, progress) = (Streams::new(options.seed), ledger.progress());
    let desk = Desk { plan: &plan, options: &options, streams, ledger, busy: Busy::default() };
    progress.stage("phases I to III");
    let trained = desk.train()?;
    progress.stage("testing every policy");
    let blind = desk.blind(&trained[0])?;
    let mut tables = desk.test_policies(&trained, blind)?;
    let (mut screened, mut confirmed) = (Vec::new(), Vec::new());
    if let Some(rows) = &plan.file.subsets {
        progress.stage("screening fixed subsets");
        screened = desk.busy.time("fixed subsets: screening", || {
            screen(&plan, rows, options.all_subsets, &streams, &ledger.chapter("screening"))
        })?;
        progress.stage("confirming the best subsets");
        confirmed = desk.confirm(rows, &candidates(&plan, rows, &screened), &mut tables)?;
    }
    let best_fixed = best_fixed(&plan, &tables);
    let busy = desk.busy.seconds();
    Ok(Outcome { trained, blind, tables, screened, confirmed, best_fixed, busy, plan, options })
}

/// The best of the screened subsets, and the one that sees everything.
fn candidates(plan: &Plan, rows: &SubsetsFile, screened: &[Screened]) -> Vec<Rival> {
    let mut order: Vec<&Screened> = screened.iter().collect();
    order.sort_by(|a, b| b.total().total_cmp(&a.total()).then(a.rival.cmp(&b.rival)));
    let mut chosen: Vec<Rival> = order.iter().take(rows.confirmed).map(|s| s.rival).collect();
    let everything = Rival::always(IndexSet::first(plan.spec.sensors.len()));
    if !chosen.contains(&everything) {
        chosen.push(everything);
    }
    chosen
}

/// The winner among confirmed subsets: chosen on validation roads with fresh seeds.
fn best_fixed(plan: &Plan, tables: &Tables) -> Option<String> {
    let scenario = plan.file.environment.training_scenario();
    let fixed =
        tables.get(&roads_name(&Roads::Validation))?.iter().filter(|(name, _)| name.starts_with("fixed:"));
    let totals = fixed.filter_map(|(name, cells)| {
        let runs = cells.get(&scenario)?;
        Some((name, runs.iter().map(|r| table::total(r)).sum::<f64>()))
    });
    totals.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(name, _)| name.clone())
}

/// Busy time by part of the work.
#[derive(Default)]
struct Busy {
    training: AtomicU64,
    testing: AtomicU64,
    screening: AtomicU64,
}

impl Busy {
    fn counter(&self, part: &str) -> &AtomicU64 {
        match part {
            "training" => &self.training,
            "testing" => &self.testing,
            _ => &self.screening,
        }
    }

    fn time<T>(&self, part: &str, work: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let result = work();
        let nanos = u64::try_from(start.elapsed().as_nanos()).unwrap_or(u64::MAX);
        self.counter(part).fetch_add(nanos, Ordering::Relaxed);
        result
    }

    fn seconds(&self) -> BTreeMap<String, f64> {
        let parts = [
            ("training", &self.training),
            ("testing", &self.testing),
            ("fixed subsets: screening", &self.screening),
        ];
        let seconds = |n: &AtomicU64| Duration::from_nanos(n.load(Ordering::Relaxed)).as_secs_f64();
        parts.iter().map(|(name, n)| ((*name).to_owned(), seconds(n))).collect()
    }
}

/// Streams of one reported seed of a run.
#[must_use]
pub fn seed_streams(seed: u64, training: usize) -> Streams {
    Streams::new(seed).child("report").nth(training as u64)
}

/// Where every policy is tested first: the scenario and the roads that it learned on, shared among `seeds` trainings.
#[must_use]
pub fn tested_on(plan: &Plan, seeds: usize) -> Course {
    course(plan, seeds, &plan.file.environment.training_scenario())
}

fn course(plan: &Plan, seeds: usize, scenario: &str) -> Course {
    let runs = plan.file.evaluation.runs.div_ceil(seeds);
    Course { scenario: scenario.to_owned(), roads: Roads::Training, runs }
}

/// Everything that every policy is tested on: each scenario on each kind of road, shared among `seeds` trainings.
#[must_use]
pub fn courses(plan: &Plan, seeds: usize) -> Vec<Course> {
    let roads = plan.file.environment.road_sets();
    let scenarios = plan.scenarios();
    let on = |r: &Roads, s: &str| course_on(plan, seeds, (s, r));
    roads.iter().flat_map(|r| scenarios.iter().map(move |s| on(r, s))).collect()
}

fn course_on(plan: &Plan, seeds: usize, (scenario, roads): (&str, &Roads)) -> Course {
    let whole = course(plan, seeds, scenario);
    // Further roads only have to show that nothing was learned by heart: half the runs do.
    let runs = if *roads == Roads::Training { whole.runs } else { whole.runs.div_ceil(2) };
    Course { roads: roads.clone(), runs, ..whole }
}

/// What every part of the experiment needs.
struct Desk<'a> {
    plan: &'a Plan,
    options: &'a Options,
    streams: Streams,
    ledger: &'a Ledger<'a>,
    busy: Busy,
}

impl Desk<'_> {
    /// Streams of one reported seed.
    fn seed(&self, seed: usize) -> Streams {
        seed_streams(self.options.seed, seed)
    }

    fn train(&self) -> Result<Vec<BTreeMap<String, Trained>>, RunError> {
        let seeds = (0..self.options.seeds).into_par_iter();
        let train = |s| {
            let ledger = self.ledger.chapter(&chapter_of_seed(s));
            self.busy.time("training", || train_seed_kept(self.plan, &self.seed(s), &ledger))
        };
        seeds.map(train).collect()
    }

    fn blind(&self, trained: &BTreeMap<String, Trained>) -> Result<usize, RunError> {
        let Some(any) = trained.values().next() else { return Ok(0) };
        let scenario = self.plan.file.environment.training_scenario();
        let course = course_on(self.plan, self.options.seeds, (&scenario, &Roads::Validation));
        let (streams, progress) = (self.streams.child("blind"), self.ledger.progress());
        self.ledger.once("blind", || best_blind_action(self.plan, &any.mind, &course, &streams, progress))
    }

    fn test_policies(&self, trained: &[BTreeMap<String, Trained>], blind: usize) -> Result<Tables, RunError> {
        let newborn = Mind::newborn(self.plan, &self.streams)?;
        let mut tables = Tables::new();
        for (name, row) in &self.plan.file.policy {
            let mind = |seed: usize| row.after.as_ref().map_or(&newborn, |phase| &trained[seed][phase].mind);
            let roster = self.plan.roster(&row.roster);
            self.test_on_all(&mut tables, name, |seed| Candidate {
                plan: self.plan,
                mind: mind(seed),
                acting: &row.acting,
                roster,
                blind,
            })?;
        }
        Ok(tables)
    }

    fn test_on_all<'c>(
        &self,
        tables: &mut Tables,
        name: &str,
        candidate: impl Fn(usize) -> Candidate<'c> + Sync,
    ) -> Result<(), RunError> {
        for course in courses(self.plan, self.options.seeds) {
            let seeds = (0..self.options.seeds).into_par_iter();
            let roads = roads_name(&course.roads);
            let (ledger, progress) = (self.ledger.chapter("test"), self.ledger.progress());
            let test = |s| {
                let piece = format!("{roads}/{name}/{}/seed-{s}", course.scenario);
                let work = || test(&candidate(s), &course, &self.seed(s), progress);
                self.busy.time("testing", || ledger.once(&piece, work))
            };
            let runs: RunsBySeed = seeds.map(test).collect::<Result<_, RunError>>()?;
            let tables = tables.entry(roads.clone()).or_default();
            tables.entry(name.to_owned()).or_default().insert(course.scenario.clone(), runs);
        }
        Ok(())
    }

    /// Trains the chosen subsets again, on the reported seeds and with the whole budget, and tests them like everybody.
    fn confirm(
        &self,
        rows: &SubsetsFile,
        chosen: &[Rival],
        tables: &mut Tables,
    ) -> Result<Vec<Confirmed>, RunError> {
        let seeds = self.options.seeds;
        let jobs: Vec<(Rival, usize)> =
            chosen.iter().flat_map(|&r| (0..seeds).map(move |i| (r, i))).collect();
        let train = |&(rival, seed): &(Rival, usize)| {
            let streams = self.seed(seed).child("subset");
            let name = subsets::name(self.plan, rival);
            let ledger = self.ledger.chapter("confirm").chapter(&name).chapter(&format!("seed-{seed}"));
            self.busy.time("training", || train_subset_kept(self.plan, rows, (rival, 1.0), &streams, &ledger))
        };
        let minds: Vec<TrainedSubset> = jobs.par_iter().map(train).collect::<Result<_, RunError>>()?;
        let mut minds = minds.into_iter();
        let mut confirmed = Vec::with_capacity(chosen.len());
        for &rival in chosen {
            let trainings: Vec<TrainedSubset> = minds.by_ref().take(seeds).collect();
            self.test_on_all(tables, &subsets::name(self.plan, rival), |seed| trainings[seed].candidate())?;
            confirmed.push(Confirmed { rival, trainings });
        }
        Ok(confirmed)
    }
}

/// About how many motor steps [`execute`] will simulate, for a progress bar.
#[must_use]
pub fn planned_steps(plan: &Plan, options: &Options) -> usize {
    let horizon = plan.spec.horizon;
    let phases: usize = plan.order.iter().map(|n| plan.budget_steps(n)).sum();
    let scenarios = plan.scenarios().len();
    let runs = plan.file.evaluation.runs;
    let roads = plan.file.environment.road_sets().len();
    let tests_of_one = scenarios * horizon * (runs + (roads - 1) * runs / 2);
    let blind = plan.spec.actions.len() * horizon * runs / options.seeds / 2;
    let mut steps = options.seeds * phases + plan.file.policy.len() * tests_of_one + blind;
    if let Some(rows) = &plan.file.subsets {
        let budget: usize = rows.budget_of.iter().map(|n| plan.budget_steps(n)).sum();
        let screened = subsets::screened_count(plan.spec.sensors.len(), options.all_subsets, rows)
            * rows.screening_seeds;
        let screening = (budget as f64 * rows.screening_share) as usize + rows.screening_runs * horizon;
        steps += screened * screening + (rows.confirmed + 1) * (options.seeds * budget + tests_of_one);
    }
    steps
}
