//! Testing the minds of a finished run again, on any roads.

use crate::evaluate::{Candidate, Course, test};
use crate::mind::Mind;
use crate::plan::{Acting, Plan};
use crate::progress::Silent;
use crate::registry::{Roads, roads_name};
use crate::reproduce::subsets::SUBSET;
use crate::reproduce::table::{RunsBySeed, cell, ratio};
use crate::results::{Estimate, Results, SCHEMA, lookup};
use crate::store::{RunCard, Store};
use metal_rl::random::Streams;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// What kept minds from being tested.
#[derive(Debug, thiserror::Error)]
pub enum ReevaluateError {
    /// The run folder.
    #[error(transparent)]
    Store(#[from] crate::store::StoreError),
    /// The world.
    #[error(transparent)]
    Run(#[from] crate::train::RunError),
    /// Roads were asked for where there are none.
    #[error("{0} has no roads to choose")]
    NoRoads(String),
    /// The learners.
    #[error(transparent)]
    Learner(#[from] metal_rl::learner::LearnerError),
}

/// Test runs of a policy by scenario.
type Tested = BTreeMap<String, RunsBySeed>;

/// Tests every policy of the run in `store`, and every fixed choice of sensors beside them, on `roads`, `runs` per
/// scenario and seed; and says how many times the cost of everybody else attention costs. Without a choice of roads: on the
/// test roads, or where the world has none, in the world as it is.
///
/// # Errors
/// If the run folder is damaged, a world fails, or a world without roads is asked for some.
pub fn on(store: &Store, roads: Option<&Roads>, runs: usize) -> Result<Results, ReevaluateError> {
    let (plan, card) = store.read_run()?;
    let roads = &choose(&plan, roads)?;
    let mut results = Results {
        schema: SCHEMA,
        quick: card.quick,
        seeds: card.seeds as u32,
        roads: roads_name(roads),
        ..Results::default()
    };
    let mut all = BTreeMap::new();
    for name in plan.file.policy.keys() {
        let minds = minds(store, &plan, &card, name)?;
        all.insert(name.clone(), scenarios(&plan, &card, (name, &minds), (roads, runs))?);
    }
    for rival in store.rivals()? {
        let (plan, card) = rival.read_run()?;
        let minds = minds(&rival, &plan, &card, SUBSET)?;
        let tested = scenarios(&plan, &card, (SUBSET, &minds), (roads, runs))?;
        all.insert(plan.file.title, tested);
    }
    results.ratios = ratios(&plan, &all);
    for (name, tested) in all {
        let cells = tested.iter().map(|(scenario, runs)| (scenario.clone(), cell(runs)));
        results.policies.insert(name, cells.collect());
    }
    Ok(results)
}

/// What attention costs by what everybody else costs, paired by seed: the mean of the scenarios (of the three, where there
/// are those) as `acl/foa`, and each by itself as `acl/foa in mix`.
fn ratios(plan: &Plan, all: &BTreeMap<String, Tested>) -> BTreeMap<String, Estimate> {
    let attends =
        |name: &str| plan.file.policy.get(name).is_some_and(|row| matches!(row.acting, Acting::Attention(_)));
    let mut ratios = BTreeMap::new();
    for (ours, of) in all.iter().filter(|(name, _)| attends(name)) {
        for (theirs, to) in all.iter().filter(|(name, _)| !attends(name)) {
            let of_three = |tested: &Tested| lookup::SCENARIOS.iter().all(|s| tested.contains_key(*s));
            let three = of_three(of) && of_three(to);
            let counts = |scenario: &str| !three || lookup::SCENARIOS.contains(&scenario);
            let pairs = || of.iter().filter_map(|(s, runs)| Some((s, runs, to.get(s)?)));
            let (a, b): (Vec<_>, Vec<_>) =
                pairs().filter(|(s, ..)| counts(s)).map(|(_, a, b)| (a, b)).unzip();
            let mean = (format!("{ours}/{theirs}"), ratio(&a, &b));
            let each = pairs().map(|(s, a, b)| (format!("{ours}/{theirs} in {s}"), ratio(&[a], &[b])));
            ratios.extend(each.chain([mean]).filter_map(|(name, estimate)| Some((name, estimate?))));
        }
    }
    ratios
}

fn choose(plan: &Plan, asked: Option<&Roads>) -> Result<Roads, ReevaluateError> {
    let kinds = plan.file.environment.road_sets();
    match asked {
        Some(_) if kinds.len() < 2 => Err(ReevaluateError::NoRoads(plan.spec.id.clone())),
        Some(roads) => Ok(roads.clone()),
        None => Ok(kinds.into_iter().next_back().unwrap_or_default()),
    }
}

/// The minds of a policy, one per seed.
fn minds(store: &Store, plan: &Plan, card: &RunCard, policy: &str) -> Result<Vec<Mind>, ReevaluateError> {
    let after = &plan.file.policy[policy].after;
    (0..card.seeds)
        .map(|seed| match after {
            Some(phase) => Ok(store.read_mind(plan, seed, phase)?),
            None => Ok(Mind::newborn(plan, &Streams::new(card.seed))?),
        })
        .collect()
}

fn scenarios(
    plan: &Plan,
    card: &RunCard,
    (policy, minds): (&str, &[Mind]),
    (roads, runs): (&Roads, usize),
) -> Result<Tested, ReevaluateError> {
    let row = &plan.file.policy[policy];
    let mut scenarios = Tested::new();
    for scenario in plan.scenarios() {
        let course = Course { scenario: scenario.clone(), roads: roads.clone(), runs };
        let seeds: Vec<usize> = (0..card.seeds).collect();
        let runs = seeds
            .par_iter()
            .map(|&seed| {
                let roster = plan.roster(&row.roster);
                let candidate =
                    Candidate { plan, mind: &minds[seed], acting: &row.acting, roster, blind: card.blind };
                test(&candidate, &course, &Streams::new(card.seed).child("report").nth(seed as u64), &Silent)
            })
            .collect::<Result<Vec<_>, _>>()?;
        scenarios.insert(scenario, runs);
    }
    Ok(scenarios)
}
