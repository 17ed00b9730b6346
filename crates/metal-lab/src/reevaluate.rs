//! Testing the minds of a finished run again, on any roads.

use crate::evaluate::{Candidate, Course, test};
use crate::mind::Mind;
use crate::plan::Plan;
use crate::progress::Silent;
use crate::registry::{Roads, roads_name};
use crate::reproduce::subsets::SUBSET;
use crate::reproduce::table::cell;
use crate::results::{Results, SCHEMA, Scenarios};
use crate::store::{RunCard, Store};
use metal_rl::random::Streams;
use rayon::prelude::*;

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

/// Tests every policy of the run in `store`, and every fixed choice of sensors beside them, on `roads`, `runs` per
/// scenario and seed. Without a choice of roads: on the
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
    for name in plan.file.policy.keys() {
        let minds = minds(store, &plan, &card, name)?;
        results.policies.insert(name.clone(), scenarios(&plan, &card, (name, &minds), (roads, runs))?);
    }
    for rival in store.rivals()? {
        let (plan, card) = rival.read_run()?;
        let minds = minds(&rival, &plan, &card, SUBSET)?;
        let tested = scenarios(&plan, &card, (SUBSET, &minds), (roads, runs))?;
        results.policies.insert(plan.file.title, tested);
    }
    Ok(results)
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
) -> Result<Scenarios, ReevaluateError> {
    let row = &plan.file.policy[policy];
    let mut scenarios = Scenarios::new();
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
        scenarios.insert(scenario, cell(&runs));
    }
    Ok(scenarios)
}
