//! The fixed subsets of sensors: "choose a fixed subset of sensors for all states", the paper's first possible answer
//! (Sec. 1), which it never measured (reading R35). One learner on a constant set, trained with the budget of everybody else.

use super::table::motor;
use crate::checkpoint::Ledger;
use crate::evaluate::{Candidate, Course, test};
use crate::plan::file::{MemberFile, PhaseFile, PlanFile, PolicyFile, SubsetsFile};
pub use crate::plan::rival::Rival;
use crate::plan::{Acting, Plan, PlanError};
use crate::progress::Progress;
use crate::train::{RunError, Trained, train_seed_kept};
use metal_rl::counterfactual::LookRule;
use metal_rl::decision::Content;
use metal_rl::phase::{Budget, Sensing};
use metal_rl::random::Streams;
use metal_rl::set::IndexSet;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Name of the only member of a subset's mind, of the phase that trains it, and of the policy that drives by it.
pub const SUBSET: &str = "subset";

/// A screened subset: what it cost on validation roads, per screening seed.
#[derive(Clone, Debug, PartialEq)]
pub struct Screened {
    /// The subset.
    pub rival: Rival,
    /// Mean motor reward per motor step, one entry per screening seed.
    pub motor: Vec<f64>,
    /// Price of its looks per motor step.
    pub price: f64,
}

impl Screened {
    /// Mean total reward per motor step.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.motor.iter().sum::<f64>() / self.motor.len().max(1) as f64 - self.price
    }
}

/// Name of a subset in results: `fixed:MN+MF`, or `fixed:MN+MF/2` if it looks every second time.
#[must_use]
pub fn name(plan: &Plan, rival: Rival) -> String {
    format!("fixed:{}", rival.words(plan))
}

/// The experiment in which one learner looks at `rival` and nothing else, for `share` of the common budget; its title is
/// the [`name`] of the subset.
///
/// # Errors
/// If the plan has no such phases (a checked plan has).
pub fn subset_plan(plan: &Plan, rows: &SubsetsFile, rival: Rival, share: f64) -> Result<Plan, PlanError> {
    let mut file = plan.file.clone();
    file.title = name(plan, rival);
    file.subsets = None;
    match plan.counterfactual(&rows.like) {
        Some((controller, _)) => same_recipe(plan, rows, (controller, rival, share), &mut file),
        None => own_learner(plan, rows, (rival.sensors, share), &mut file),
    }
    let PhaseFile { roster, acting, .. } = file.phase[SUBSET].clone();
    file.policy =
        BTreeMap::from([(SUBSET.to_owned(), PolicyFile { after: Some(SUBSET.into()), roster, acting })]);
    Plan::check(file)
}

/// Motor steps of the phases `names`, `share` of them.
fn steps<'a>(plan: &Plan, names: impl Iterator<Item = &'a String>, share: f64) -> usize {
    let steps: usize = names.map(|n| plan.budget_steps(n)).sum();
    ((steps as f64 * share).round() as usize).max(1)
}

/// The recipe of attention with the looks of `rival`: the same members, network, iterations, roll-outs and fits.
fn same_recipe(
    plan: &Plan,
    rows: &SubsetsFile,
    (controller, rival, share): (&str, Rival, f64),
    file: &mut PlanFile,
) {
    let eyes = plan.single_eyes(&rows.like).unwrap_or_default();
    let members: Vec<String> = rival.sensors.iter().map(|s| eyes[s].clone()).collect();
    file.attention.retain(|name, _| name == controller);
    let mut like = file.phase[&rows.like].clone();
    for config in file.attention.values_mut().filter_map(|row| row.counterfactual.as_mut()) {
        if config.judges_twice() {
            // Moves are judged after one set of looks only where looks are not free, so twice the moments cost the same.
            config.judged = (2.0 * config.judged).min(1.0);
        }
        config.looks = match rival.every {
            1 => LookRule::Fixed(members.clone()),
            steps => LookRule::Every { steps, members: members.clone() },
        };
        *config = config.clone().with_fits(share, usize::MAX);
        if config.content == Content::Readings {
            // Whoever learns from readings has no use for what members learned before.
            like.after = None;
        }
    }
    like.budget = Budget::Steps(steps(plan, rows.budget_of.iter(), share));
    let mut kept = BTreeMap::new();
    let mut at = like.after.clone();
    while let Some(name) = at {
        let row = file.phase[&name].clone();
        at = row.after.clone();
        kept.insert(name, row);
    }
    kept.insert(SUBSET.to_owned(), like);
    file.phase = kept;
}

/// A learner of its own on a constant set. Demonstration phases of the common budget are watched as they are; all other
/// steps become one phase of its own.
fn own_learner(plan: &Plan, rows: &SubsetsFile, (sensors, share): (IndexSet, f64), file: &mut PlanFile) {
    let sensors = sensors.iter().map(|s| plan.spec.sensors[s].name.clone()).collect();
    let learner = rows.learner.clone().unwrap_or_default();
    file.member = BTreeMap::from([(SUBSET.to_owned(), MemberFile { sensors, learner })]);
    file.attention.clear();
    let watched = rows.budget_of.iter().find(|n| file.phase[*n].acting.is_watched()).cloned();
    let active = rows.budget_of.iter().filter(|n| !file.phase[*n].acting.is_watched());
    let steps = steps(plan, active, share);
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
}

/// A subset that was trained with the whole budget, on every reported seed.
pub struct Confirmed {
    /// The subset.
    pub rival: Rival,
    /// Its trainings, seed by seed.
    pub trainings: Vec<TrainedSubset>,
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
    pub fn candidate(&self) -> Candidate<'_> {
        let row = &self.plan.file.phase[SUBSET];
        Candidate {
            plan: &self.plan,
            mind: &self.trained.mind,
            acting: &row.acting,
            roster: self.plan.roster(&row.roster),
            blind: 0,
        }
    }
}

/// Trains one subset on one seed with `share` of the common budget.
///
/// # Errors
/// If the world fails.
pub fn train_subset(
    plan: &Plan,
    rows: &SubsetsFile,
    (rival, share): (Rival, f64),
    streams: &Streams,
    progress: &dyn Progress,
) -> Result<TrainedSubset, RunError> {
    train_subset_kept(plan, rows, (rival, share), streams, &Ledger::none(progress))
}

/// As [`train_subset`], with its phases kept in `ledger`.
pub(super) fn train_subset_kept(
    plan: &Plan,
    rows: &SubsetsFile,
    (rival, share): (Rival, f64),
    streams: &Streams,
    ledger: &Ledger<'_>,
) -> Result<TrainedSubset, RunError> {
    let plan = subset_plan(plan, rows, rival, share)?;
    let streams = streams.child(&name(&plan, rival));
    let mut trained = train_seed_kept(&plan, &streams, ledger)?;
    let trained = trained.remove(SUBSET).ok_or(RunError::Interrupted)?;
    Ok(TrainedSubset { plan, trained })
}

/// Screens subsets on few seeds and validation roads, apart from the seeds and roads of the report.
///
/// All singles and pairs; then from the best pair on, one more sensor at a time, the best addition kept; with `all`,
/// every subset there is. Of those who look now and then, all singles and pairs. If the plan names rivals, these alone. What
/// is in `ledger` is not measured again.
///
/// # Errors
/// If the world fails.
pub fn screen(
    plan: &Plan,
    rows: &SubsetsFile,
    all: bool,
    streams: &Streams,
    ledger: &Ledger<'_>,
) -> Result<Vec<Screened>, RunError> {
    let desk = Screening { plan, rows, streams: streams.child("screening"), ledger };
    if !rows.among.is_empty() {
        let parse = |words: &String| Rival::parse(plan, "subsets.among", words);
        return desk.measure(&rows.among.iter().map(parse).collect::<Result<Vec<_>, _>>()?);
    }
    let n = plan.spec.sensors.len();
    let mut screened = Vec::new();
    for &every in &rows.every {
        let most = if all { n } else { 2 };
        let sets = (1..1_u64 << n).map(IndexSet::from_bits).filter(|s| s.len() <= most);
        let rivals: Vec<Rival> = sets.map(|sensors| Rival { sensors, every }).collect();
        let measured = desk.measure(&rivals)?;
        let pairs = measured.iter().filter(|s| s.rival.sensors.len() == 2.min(n));
        let mut best = best_of(pairs);
        screened.extend(measured);
        while !all && every == 1 && best.len() < n {
            let larger = IndexSet::first(n).minus(best).iter().map(|s| Rival::always(best.with(s)));
            let measured = desk.measure(&larger.collect::<Vec<_>>())?;
            best = best_of(measured.iter());
            screened.extend(measured);
        }
    }
    Ok(screened)
}

/// How many subsets [`screen`] measures among `sensors` sensors.
#[must_use]
pub fn screened_count(sensors: usize, all: bool, rows: &SubsetsFile) -> usize {
    let every = &rows.every;
    if !rows.among.is_empty() {
        return rows.among.len();
    }
    if all {
        return every.len() * ((1 << sensors) - 1);
    }
    let pairs = sensors * sensors.saturating_sub(1) / 2;
    let grown: usize = (3..=sensors).map(|size| sensors - size + 1).sum();
    every.iter().map(|&steps| sensors + pairs + if steps == 1 { grown } else { 0 }).sum()
}

fn best_of<'a>(screened: impl Iterator<Item = &'a Screened>) -> IndexSet {
    screened.max_by(|a, b| a.total().total_cmp(&b.total())).map_or(IndexSet::EMPTY, |s| s.rival.sensors)
}

struct Screening<'a> {
    plan: &'a Plan,
    rows: &'a SubsetsFile,
    streams: Streams,
    ledger: &'a Ledger<'a>,
}

impl Screening<'_> {
    fn measure(&self, rivals: &[Rival]) -> Result<Vec<Screened>, RunError> {
        let seeds = self.rows.screening_seeds;
        let jobs: Vec<(Rival, usize)> =
            rivals.iter().flat_map(|&r| (0..seeds).map(move |i| (r, i))).collect();
        let motors: Vec<f64> = jobs.par_iter().map(|&job| self.one(job)).collect::<Result<_, RunError>>()?;
        let price = |r: Rival| -> f64 {
            r.sensors.iter().map(|i| self.plan.spec.sensors[i].price).sum::<f64>() / r.every as f64
        };
        let rows = rivals.iter().zip(motors.chunks(seeds));
        Ok(rows.map(|(&rival, m)| Screened { rival, motor: m.to_vec(), price: price(rival) }).collect())
    }

    /// Mean motor reward of one subset on one seed.
    fn one(&self, (rival, seed): (Rival, usize)) -> Result<f64, RunError> {
        let piece = format!("{}/seed-{seed}", name(self.plan, rival));
        self.ledger.once(&piece, || self.measure_one((rival, seed)))
    }

    fn measure_one(&self, (rival, seed): (Rival, usize)) -> Result<f64, RunError> {
        let progress = self.ledger.progress();
        let streams = self.streams.nth(seed as u64);
        let job = (rival, self.rows.screening_share);
        let subset = train_subset(self.plan, self.rows, job, &streams, progress)?;
        let course = Course {
            scenario: self.plan.file.environment.training_scenario(),
            roads: crate::registry::Roads::Validation,
            runs: self.rows.screening_runs,
        };
        let runs = test(&subset.candidate(), &course, &streams, progress)?;
        Ok(motor(&runs))
    }
}
