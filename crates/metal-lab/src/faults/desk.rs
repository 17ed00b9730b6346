//! Trainings and tests with sensors that fail.

use super::{Cell, FaultOptions};
use crate::evaluate::{Candidate, drive};
use crate::plan::{Acting, Plan, PlanError};
use crate::progress::Progress;
use crate::registry::EnvironmentConfig;
use crate::reproduce::table::{over_seeds, share_over_seeds};
use crate::results::Estimate;
use crate::trace::{EpisodeRecord, Trace, Watcher};
use crate::train::{RunError, Trained, train_seed};
use metal_rl::random::Streams;
use metal_worlds::faulty::{Fault, Faults};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// Trained minds: seed → phase.
pub(super) type Minds = Vec<BTreeMap<String, Trained>>;

/// What every part of the trial needs.
pub(super) struct Desk<'a> {
    /// The experiment without what nobody asks about.
    pub plan: Plan,
    /// How much is tried.
    pub options: &'a FaultOptions,
    /// Who is told how far it is.
    pub progress: &'a dyn Progress,
    streams: Streams,
}

/// The experiment with these policies and the phases they come from, and nothing else.
pub(super) fn pupils(plan: &Plan, policies: &[String]) -> Result<Plan, PlanError> {
    let mut file = plan.file.clone();
    file.policy.retain(|name, _| policies.contains(name));
    let mut wanted = BTreeSet::new();
    for row in file.policy.values() {
        let mut next = row.after.clone();
        while let Some(name) = next {
            next = file.phase[&name].after.clone();
            wanted.insert(name);
        }
    }
    file.phase.retain(|name, _| wanted.contains(name));
    let controls =
        |name: &String| file.phase.values().any(|row| row.acting == Acting::Attention(name.clone()));
    let attention = file.attention.clone().into_iter().filter(|(name, _)| controls(name)).collect();
    file.attention = attention;
    file.subsets = None;
    Plan::check(file)
}

impl<'a> Desk<'a> {
    pub fn new(
        plan: &Plan,
        options: &'a FaultOptions,
        progress: &'a dyn Progress,
    ) -> Result<Self, PlanError> {
        let plan = pupils(plan, &options.policies)?;
        Ok(Self { plan, options, progress, streams: Streams::new(options.seed).child("faults") })
    }

    /// Streams of one training.
    pub fn seed(&self, seed: usize) -> Streams {
        self.streams.nth(seed as u64)
    }

    /// The world of the experiment with this in front of its sensors.
    pub fn broken(&self, faults: Faults) -> EnvironmentConfig {
        self.plan.file.environment.clone().with_faults(faults)
    }

    /// Every seed, all sensors sound or failing like this.
    pub fn train(&self, faults: Option<Faults>) -> Result<Minds, RunError> {
        let mut file = self.plan.file.clone();
        if let Some(faults) = faults {
            file.environment = self.broken(faults);
        }
        let plan = Plan::check(file)?;
        self.per_seed(|seed| train_seed(&plan, &self.seed(seed), self.progress))
    }

    /// The same work for every seed, in parallel, in order.
    pub fn per_seed<T: Send>(
        &self,
        work: impl Fn(usize) -> Result<T, RunError> + Sync,
    ) -> Result<Vec<T>, RunError> {
        let checked = |seed| {
            let done = work(seed)?;
            if self.progress.interrupted() { Err(RunError::Interrupted) } else { Ok(done) }
        };
        (0..self.options.seeds).into_par_iter().map(checked).collect()
    }

    /// `policy` as it was trained.
    pub fn candidate<'c>(&'c self, policy: &str, trained: &'c BTreeMap<String, Trained>) -> Candidate<'c> {
        let row = &self.plan.file.policy[policy];
        let phase = row.after.as_ref().expect("checked: it was trained");
        Candidate {
            plan: &self.plan,
            mind: &trained[phase].mind,
            acting: &row.acting,
            roster: self.plan.roster(&row.roster),
            blind: 0,
        }
    }

    /// Test episodes of one candidate in this world, the same ones for everybody.
    pub fn test(
        &self,
        candidate: &Candidate<'_>,
        world: &EnvironmentConfig,
        seed: usize,
    ) -> Result<Vec<EpisodeRecord>, RunError> {
        let mut environment = world.build()?;
        let trace = Trace::new(environment.spec());
        let mut watcher = Watcher { trace, progress: self.progress };
        let streams = self.seed(seed).child("test");
        drive(candidate, environment.as_mut(), (self.options.runs, &streams), &mut watcher)?;
        Ok(watcher.trace.episodes)
    }

    /// Everybody with sound sensors, then under every fault at every rate.
    pub fn test_all(&self, minds: &Minds) -> Result<Vec<Cell>, RunError> {
        let rates = |fault| self.options.rates.iter().map(move |&rate| (Some(fault), rate));
        let faults = self.options.faults.iter().copied().flat_map(rates);
        let cases: Vec<(Option<Fault>, f64)> = std::iter::once((None, 0.0)).chain(faults).collect();
        let mut cells = Vec::new();
        for (fault, rate) in cases {
            cells.extend(self.cells(minds, (fault, rate), false)?);
        }
        Ok(cells)
    }

    /// Everybody trained and tested with `fault`, and tested with sound sensors after such a training.
    pub fn trained_with(&self, fault: Fault) -> Result<Vec<Cell>, RunError> {
        let rate = self.options.training_rate;
        let minds = self.train(Some(all_sensors(fault, rate)))?;
        let mut cells = self.cells(&minds, (Some(fault), rate), true)?;
        cells.extend(self.cells(&minds, (Some(fault), 0.0), true)?);
        Ok(cells)
    }

    fn cells(
        &self,
        minds: &Minds,
        (fault, rate): (Option<Fault>, f64),
        trained_with_it: bool,
    ) -> Result<Vec<Cell>, RunError> {
        let world = match fault {
            Some(fault) => self.broken(all_sensors(fault, rate)),
            None => self.plan.file.environment.clone(),
        };
        let mut cells = Vec::new();
        for policy in &self.options.policies {
            let test = |seed: usize| self.test(&self.candidate(policy, &minds[seed]), &world, seed);
            let runs = self.per_seed(test)?;
            let numbers = Numbers::of(&runs);
            cells.push(Cell {
                policy: policy.clone(),
                fault: fault.map(|f| f.name().to_owned()),
                rate,
                trained_with_it,
                total: numbers.total,
                motor: numbers.motor,
                looks: numbers.looks,
                accidents: numbers.accidents,
            });
        }
        Ok(cells)
    }
}

/// `fault` in any sensor at this rate.
pub(super) fn all_sensors(fault: Fault, rate: f64) -> Faults {
    Faults { fault: Some(fault), rate, ..Faults::default() }
}

/// The numbers of a cell.
pub(super) struct Numbers {
    pub total: Estimate,
    pub motor: Estimate,
    pub looks: Estimate,
    pub accidents: Estimate,
}

impl Numbers {
    /// Means per training, intervals over trainings.
    pub fn of(runs: &[Vec<EpisodeRecord>]) -> Self {
        let mean = |f: &dyn Fn(&EpisodeRecord) -> f64| -> Vec<f64> {
            runs.iter().map(|r| r.iter().map(f).sum::<f64>() / r.len().max(1) as f64).collect()
        };
        let accidents = mean(&|r| f64::from(u8::from(r.driving.accident)));
        Self {
            total: over(&mean(&|r| r.per_step(r.motor + r.perceptual))),
            motor: over(&mean(&|r| r.per_step(r.motor))),
            looks: over(&mean(&|r| r.per_step(r.look_count() as f64))),
            accidents: share_over_seeds(&accidents).unwrap_or(Estimate::point(0.0, 0)),
        }
    }
}

/// An estimate over trainings.
pub(super) fn over(values: &[f64]) -> Estimate {
    over_seeds(values).unwrap_or(Estimate::point(0.0, 0))
}
