//! The lines of the comparison, each trained with the same number of motor steps on the same seeds.

use super::clock::Clock;
use super::search::{Static, search};
use super::subset::train_subset;
use super::{BenchOptions, Row};
use crate::progress::Progress;
use crate::task::{AttentionMethod, Driver, Learned, Recipe, Score, Task, learn, trial};
use crate::train::RunError;
use metal_rl::environment::EnvironmentSpec;
use metal_rl::num;
use metal_rl::observe::{Observer, Step};
use metal_rl::random::Streams;
use metal_rl::set::IndexSet;
use metal_worlds::priced::Priced;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// The best constant motor action.
pub(super) const BLIND: &str = "blind";
/// A random fixed subset with as many sensors as METAL reads.
pub(super) const RANDOM: &str = "random subset";
/// The best fixed subset.
pub(super) const STATIC: &str = "best static subset";
/// The full observer.
pub(super) const ALL: &str = "all sensors";
/// Everybody together.
pub(super) const FUSION: &str = "fusion";
/// Attention control.
pub(super) const METAL: &str = "METAL";

/// Names of the lines, in the order of the table.
pub const ROWS: [&str; 6] = [BLIND, RANDOM, STATIC, ALL, FUSION, METAL];

/// What every line needs.
pub(super) struct Desk<'a> {
    pub task: &'a dyn Task,
    pub spec: &'a EnvironmentSpec,
    pub recipe: &'a Recipe,
    pub options: &'a BenchOptions,
    pub streams: Streams,
    pub progress: &'a dyn Progress,
}

/// Tells the progress how many steps were made.
pub(super) struct Teller<'a>(pub &'a dyn Progress);

impl Observer for Teller<'_> {
    fn on_step(&mut self, _step: &Step<'_>) {
        self.0.steps(1);
    }
}

/// A score and the seconds it took.
pub(super) type Timed = (Score, f64);

impl Desk<'_> {
    /// All lines, and the fixed subsets that were screened.
    pub fn rows(&self) -> Result<(BTreeMap<String, Row>, Vec<Static>), RunError> {
        let mut rows = BTreeMap::new();
        let mut add = |name: &str, timed: Vec<Timed>, searching: f64, remark: String| {
            let n = timed.len().max(1) as f64;
            let secs = timed.iter().map(|t| t.1).sum::<f64>() / n + searching;
            let scores = timed.into_iter().map(|t| t.0).collect();
            rows.insert(name.to_owned(), Row::new(scores, secs, remark));
        };
        self.stage(METAL)?;
        let metal = self.seeds(|seed| self.trained(self.recipe, Driver::Attention, seed))?;
        let looks = metal.iter().map(|(s, _)| s.looks_per_step()).sum::<f64>() / metal.len() as f64;
        add(METAL, metal, 0.0, String::new());
        self.stage(BLIND)?;
        let action = self.best_constant_action()?;
        let blind = self.seeds(|seed| self.blind(action, seed))?;
        add(BLIND, blind, 0.0, format!("always `{}`", self.spec.actions[action]));
        self.stage(ALL)?;
        let everything = IndexSet::first(self.spec.sensors.len());
        add(ALL, self.seeds(|seed| self.subset(everything, seed))?, 0.0, String::new());
        self.stage(FUSION)?;
        let nobody = AttentionMethod::Values(Box::default());
        let (fusion, recipe) = (self.recipe.steps(), self.recipe.clone());
        let alone = Recipe { fusion: Some(fusion), foa: 0, attention: 1, method: nobody, ..recipe };
        add(FUSION, self.seeds(|seed| self.trained(&alone, Driver::Fusion, seed))?, 0.0, String::new());
        self.stage(RANDOM)?;
        let size = (looks.round() as usize).clamp(1, everything.len());
        let random = self.seeds(|seed| self.subset(self.random_subset(size, seed), seed))?;
        add(RANDOM, random, 0.0, format!("{size} drawn anew for every training"));
        self.stage(STATIC)?;
        let clock = Clock::start();
        let statics = search(self)?;
        let best = statics.iter().max_by(|a, b| a.score.total().total_cmp(&b.score.total()));
        let best = best.map_or(everything, |s| s.sensors);
        let searching = clock.secs() / self.options.seeds as f64;
        add(STATIC, self.seeds(|seed| self.subset(best, seed))?, searching, names(self.spec, best));
        Ok((rows, statics))
    }

    /// METAL trained at other prices; costs are those of the task.
    pub fn at_other_prices(&self) -> Result<Vec<(f64, Vec<Score>)>, RunError> {
        let mut all = Vec::new();
        for &factor in &self.options.price_factors {
            self.stage(&format!("{METAL}, prices x {factor}"))?;
            let task = AtPrice { task: self.task, factor };
            let desk = Desk { task: &task, streams: self.streams, ..*self };
            let timed = desk.seeds(|seed| {
                let (mind, clock) = (desk.learn(self.recipe, seed)?, Clock::start());
                let runs = (self.options.episodes, &self.test_streams(seed));
                Ok((trial(self.task, &mind, Driver::Attention, runs)?, clock.secs()))
            })?;
            all.push((factor, timed.into_iter().map(|t| t.0).collect()));
        }
        Ok(all)
    }

    fn stage(&self, what: &str) -> Result<(), RunError> {
        self.progress.stage(what);
        if self.progress.interrupted() { Err(RunError::Interrupted) } else { Ok(()) }
    }

    /// One job per training; on threads where the task allows it, and always with the same numbers.
    fn seeds(&self, job: impl Fn(u64) -> Result<Timed, RunError> + Sync) -> Result<Vec<Timed>, RunError> {
        let seeds = 0..self.options.seeds as u64;
        if self.task.is_parallel() {
            return seeds.into_par_iter().map(&job).collect();
        }
        seeds.map(job).collect()
    }

    pub(super) fn train_streams(&self, seed: u64) -> Streams {
        self.streams.child("training").nth(seed)
    }

    /// Everybody is tested on the same episodes of a seed.
    fn test_streams(&self, seed: u64) -> Streams {
        self.streams.child("test").nth(seed)
    }

    fn learn(&self, recipe: &Recipe, seed: u64) -> Result<Learned, RunError> {
        learn(self.task, recipe, &self.train_streams(seed), &mut Teller(self.progress))
    }

    fn trained(&self, recipe: &Recipe, driver: Driver, seed: u64) -> Result<Timed, RunError> {
        let clock = Clock::start();
        let mind = self.learn(recipe, seed)?;
        let score = trial(self.task, &mind, driver, (self.options.episodes, &self.test_streams(seed)))?;
        Ok((score, clock.secs()))
    }

    fn subset(&self, sensors: IndexSet, seed: u64) -> Result<Timed, RunError> {
        let clock = Clock::start();
        let mut student = train_subset(self, sensors, 1.0, &self.train_streams(seed))?;
        let mut world = self.task.testing()?;
        let score = student.drive(world.as_mut(), (self.options.episodes, &self.test_streams(seed)))?;
        Ok((score, clock.secs()))
    }

    fn blind(&self, action: usize, seed: u64) -> Result<Timed, RunError> {
        let clock = Clock::start();
        let mind = self.newborn()?;
        let runs = (self.options.episodes, &self.test_streams(seed));
        Ok((trial(self.task, &mind, Driver::Blind(action), runs)?, clock.secs()))
    }

    fn newborn(&self) -> Result<Learned, RunError> {
        Learned::newborn(self.spec, &self.task.opinions(), self.recipe, &self.streams)
    }

    /// The best constant action in the world of learning.
    fn best_constant_action(&self) -> Result<usize, RunError> {
        let (mind, validation) = (self.newborn()?, self.streams.child("validation"));
        let task = Rehearsal(self.task);
        let totals: Result<Vec<f64>, RunError> = (0..self.spec.actions.len())
            .map(|a| Ok(trial(&task, &mind, Driver::Blind(a), (self.options.episodes, &validation))?.total()))
            .collect();
        Ok(num::argmax(&totals?))
    }

    fn random_subset(&self, size: usize, seed: u64) -> IndexSet {
        let mut all: Vec<usize> = (0..self.spec.sensors.len()).collect();
        self.streams.child("random subset").nth(seed).stream("draw").shuffle(&mut all);
        all.into_iter().take(size).collect()
    }
}

/// Names of the `sensors`.
pub(super) fn names(spec: &EnvironmentSpec, sensors: IndexSet) -> String {
    let names: Vec<&str> = sensors.iter().map(|s| spec.sensors[s].name.as_str()).collect();
    names.join(" + ")
}

/// A task tested where it is learned: choices are made here, never on the test world.
pub(super) struct Rehearsal<'a>(pub &'a dyn Task);

impl Task for Rehearsal<'_> {
    fn training(&self) -> Result<Box<dyn metal_rl::environment::Environment>, RunError> {
        self.0.training()
    }
}

/// A task whose looks cost a multiple.
struct AtPrice<'a> {
    task: &'a dyn Task,
    factor: f64,
}

impl Task for AtPrice<'_> {
    fn training(&self) -> Result<Box<dyn metal_rl::environment::Environment>, RunError> {
        Ok(Box::new(Priced::new(self.task.training()?, self.factor)))
    }

    fn watching(&self) -> Result<Box<dyn metal_rl::environment::Environment>, RunError> {
        Ok(Box::new(Priced::new(self.task.watching()?, self.factor)))
    }

    fn is_parallel(&self) -> bool {
        self.task.is_parallel()
    }

    fn opinions(&self) -> Vec<usize> {
        self.task.opinions()
    }
}
