//! The fixed subsets of sensors: "choose a fixed subset of sensors for all states", the paper's first possible answer
//! (Sec. 1), which it never measured (reading R35). One learner on a constant set, trained with the budget of everybody else.

use super::table::motor;
use crate::evaluate::{Candidate, Course, test};
use crate::plan::file::{MemberFile, PhaseFile, SubsetsFile};
use crate::plan::{Acting, Plan, PlanError};
use crate::progress::Progress;
use crate::train::{RunError, Trained, train_seed};
use metal_rl::phase::{Budget, Sensing};
use metal_rl::random::Streams;
use metal_rl::set::IndexSet;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Name of the only member of a subset's mind, and of the phase that trains it.
const SUBSET: &str = "subset";

/// A screened subset: what it cost on validation roads, per screening seed.
#[derive(Clone, Debug, PartialEq)]
pub struct Screened {
    /// Sensors, as indices into the spec.
    pub sensors: IndexSet,
    /// Mean motor reward per motor step, one entry per screening seed.
    pub motor: Vec<f64>,
    /// Price of reading all of them once.
    pub price: f64,
}

impl Screened {
    /// Mean total reward per motor step.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.motor.iter().sum::<f64>() / self.motor.len().max(1) as f64 - self.price
    }
}

/// Name of a subset in results: `fixed:MN+MF`.
#[must_use]
pub fn name(plan: &Plan, sensors: IndexSet) -> String {
    let names: Vec<&str> = sensors.iter().map(|s| plan.spec.sensors[s].name.as_str()).collect();
    format!("fixed:{}", names.join("+"))
}

/// The experiment in which one learner sees `sensors` and nothing else, for `share` of the common budget.
///
/// Demonstration phases of the common budget are watched as they are; all other steps become one phase of its own.
///
/// # Errors
/// If the plan has no such phases (a checked plan has).
pub fn subset_plan(
    plan: &Plan,
    rows: &SubsetsFile,
    sensors: IndexSet,
    share: f64,
) -> Result<Plan, PlanError> {
    let mut file = plan.file.clone();
    let sensors = sensors.iter().map(|s| plan.spec.sensors[s].name.clone()).collect();
    file.member =
        BTreeMap::from([(SUBSET.to_owned(), MemberFile { sensors, learner: rows.learner.clone() })]);
    file.attention.clear();
    file.policy.clear();
    file.subsets = None;
    let watched = rows.budget_of.iter().find(|n| file.phase[*n].acting.is_watched()).cloned();
    let active = rows.budget_of.iter().filter(|n| !file.phase[*n].acting.is_watched());
    let steps: usize = active.map(|n| plan.budget_steps(n)).sum();
    let like = file.phase[&rows.like].clone();
    let mut phases = BTreeMap::new();
    if let Some(name) = &watched {
        let row = PhaseFile {
            roster: vec![SUBSET.into()],
            after: None,
            bootstrap: None,
            ..file.phase[name].clone()
        };
        phases.insert(name.clone(), row);
    }
    let steps = ((steps as f64 * share).round() as usize).max(1);
    let row = PhaseFile {
        after: watched,
        roster: vec![SUBSET.into()],
        acting: Acting::Solo(SUBSET.into()),
        sensing: Sensing::OnDemand,
        bootstrap: None,
        budget: Budget::Steps(steps),
        ..like
    };
    phases.insert(SUBSET.to_owned(), row);
    file.phase = phases;
    Plan::check(file)
}

/// A subset's mind and the plan it belongs to.
pub struct TrainedSubset {
    /// The plan of the subset.
    pub plan: Plan,
    /// What its own phase left behind.
    pub trained: Trained,
}

impl TrainedSubset {
    /// The trained learner, ready to be tested.
    #[must_use]
    pub fn candidate<'a>(&'a self, acting: &'a Acting) -> Candidate<'a> {
        Candidate { plan: &self.plan, mind: &self.trained.mind, acting, roster: IndexSet::first(1), blind: 0 }
    }
}

/// How a subset acts.
#[must_use]
pub fn acting() -> Acting {
    Acting::Solo(SUBSET.to_owned())
}

/// Trains one subset on one seed with `share` of the common budget.
///
/// # Errors
/// If the world fails.
pub fn train_subset(
    plan: &Plan,
    rows: &SubsetsFile,
    (sensors, share): (IndexSet, f64),
    streams: &Streams,
    progress: &dyn Progress,
) -> Result<TrainedSubset, RunError> {
    let plan = subset_plan(plan, rows, sensors, share)?;
    let streams = streams.child(&name(&plan, sensors));
    let mut trained = train_seed(&plan, &streams, progress)?;
    let trained = trained.remove(SUBSET).ok_or(RunError::Interrupted)?;
    Ok(TrainedSubset { plan, trained })
}

/// Screens subsets on few seeds and validation roads, apart from the seeds and roads of the report.
///
/// All singles and pairs; then from the best pair on, one more sensor at a time, the best addition kept; with `all`,
/// every subset there is.
///
/// # Errors
/// If the world fails.
pub fn screen(
    plan: &Plan,
    rows: &SubsetsFile,
    all: bool,
    streams: &Streams,
    progress: &dyn Progress,
) -> Result<Vec<Screened>, RunError> {
    let desk = Screening { plan, rows, streams: streams.child("screening"), progress };
    let n = plan.spec.sensors.len();
    if all {
        return desk.measure(&(1..1_u64 << n).map(IndexSet::from_bits).collect::<Vec<_>>());
    }
    let small = (1..1_u64 << n).map(IndexSet::from_bits).filter(|s| s.len() <= 2);
    let mut screened = desk.measure(&small.collect::<Vec<_>>())?;
    let mut best = best_of(screened.iter().filter(|s| s.sensors.len() == 2.min(n)));
    while best.len() < n {
        let larger: Vec<IndexSet> = IndexSet::first(n).minus(best).iter().map(|s| best.with(s)).collect();
        let measured = desk.measure(&larger)?;
        best = best_of(measured.iter());
        screened.extend(measured);
    }
    Ok(screened)
}

/// How many subsets [`screen`] measures among `sensors` sensors.
#[must_use]
pub fn screened_count(sensors: usize, all: bool) -> usize {
    if all {
        return (1 << sensors) - 1;
    }
    let pairs = sensors * sensors.saturating_sub(1) / 2;
    let grown: usize = (3..=sensors).map(|size| sensors - size + 1).sum();
    sensors + pairs + grown
}

fn best_of<'a>(screened: impl Iterator<Item = &'a Screened>) -> IndexSet {
    screened.max_by(|a, b| a.total().total_cmp(&b.total())).map_or(IndexSet::EMPTY, |s| s.sensors)
}

struct Screening<'a> {
    plan: &'a Plan,
    rows: &'a SubsetsFile,
    streams: Streams,
    progress: &'a dyn Progress,
}

impl Screening<'_> {
    fn measure(&self, subsets: &[IndexSet]) -> Result<Vec<Screened>, RunError> {
        let seeds = self.rows.screening_seeds;
        let jobs: Vec<(IndexSet, usize)> =
            subsets.iter().flat_map(|&s| (0..seeds).map(move |i| (s, i))).collect();
        let motors: Vec<f64> = jobs.par_iter().map(|&job| self.one(job)).collect::<Result<_, RunError>>()?;
        let price = |s: IndexSet| s.iter().map(|i| self.plan.spec.sensors[i].price).sum();
        let rows = subsets.iter().zip(motors.chunks(seeds));
        Ok(rows.map(|(&sensors, m)| Screened { sensors, motor: m.to_vec(), price: price(sensors) }).collect())
    }

    /// Mean motor reward of one subset on one seed.
    fn one(&self, (sensors, seed): (IndexSet, usize)) -> Result<f64, RunError> {
        let streams = self.streams.nth(seed as u64);
        let job = (sensors, self.rows.screening_share);
        let subset = train_subset(self.plan, self.rows, job, &streams, self.progress)?;
        let course = Course {
            scenario: self.plan.file.environment.training_scenario(),
            roads: crate::registry::Roads::Validation,
            runs: self.rows.screening_runs,
        };
        let runs = test(&subset.candidate(&acting()), &course, &streams, self.progress)?;
        Ok(motor(&runs))
    }
}
