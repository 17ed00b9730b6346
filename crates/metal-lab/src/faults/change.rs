//! The claims of Sec. 6.2 as a table: the world changes, the mind learns on.

use super::comeback::go_on;
use super::desk::{Desk, Minds, over};
use crate::evaluate::Candidate;
use crate::learn_on::{can_learn_on, learning_on};
use crate::mind::Mind;
use crate::plan::Acting;
use crate::registry::{EnvironmentConfig, Roads};
use crate::reproduce::table::total;
use crate::results::Estimate;
use crate::train::RunError;
use metal_rl::observe::Unobserved;
use metal_rl::set::IndexSet;
use metal_worlds::faulty::Faults;
use metal_worlds::highway::Scenario;
use serde::{Deserialize, Serialize};

/// How much faster the red cars drive after the change of speed.
const HASTE: f64 = 1.6;

/// What a change of the world does to a policy: motor reward minus prices, per motor step; intervals are over trainings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Change {
    /// What changes, in words.
    pub what: String,
    /// Name of the policy.
    pub policy: String,
    /// In the old world.
    pub before: Estimate,
    /// In the new world, nothing learned there.
    pub at_once: Estimate,
    /// In the new world, after learning on there; none if it cannot learn on.
    pub adapted: Option<Estimate>,
    /// What learning on brought, training by training.
    pub gain: Option<Estimate>,
    /// The expert with ground truth in the old and in the new world: how much harder it is for anybody.
    pub expert: (Estimate, Estimate),
}

/// All changes that the world of the plan knows, for all policies.
pub(super) fn all(desk: &Desk<'_>, minds: &Minds) -> Result<Vec<Change>, RunError> {
    let mut rows = Vec::new();
    for (what, world) in worlds(desk) {
        for policy in &desk.options.policies {
            rows.push(change(desk, minds, (policy, &what), &world)?);
        }
    }
    Ok(rows)
}

/// The changed worlds of a highway; none for any other world.
fn worlds(desk: &Desk<'_>) -> Vec<(String, EnvironmentConfig)> {
    let old = &desk.plan.file.environment;
    if old.as_highway().is_none() {
        return Vec::new();
    }
    let scenario = Scenario::Approaching.name();
    let mut fast = old.clone();
    if let EnvironmentConfig::Highway(config) | EnvironmentConfig::HighwayScripted(config) = &mut fast {
        config.car_speed = HASTE;
    }
    let crossed = Faults { crossed: Some(("LN".to_owned(), "RN".to_owned())), ..Faults::default() };
    vec![
        (
            "the road: test roads instead of the one learned on".to_owned(),
            desk.plan.environment(&old.training_scenario(), Some(&Roads::Test)),
        ),
        (
            "positions of the obstacles: a car always comes towards it".to_owned(),
            desk.plan.environment(scenario, None),
        ),
        (format!("speed of the obstacles: {HASTE} times as fast"), fast),
        (
            "expertise of the tiny agents: LN and RN see what the other learned to see".to_owned(),
            desk.broken(crossed),
        ),
    ]
}

fn change(
    desk: &Desk<'_>,
    minds: &Minds,
    (policy, what): (&str, &str),
    world: &EnvironmentConfig,
) -> Result<Change, RunError> {
    let old = &desk.plan.file.environment;
    let phase = desk.plan.file.policy[policy].after.as_deref().expect("checked: it was trained");
    let learns = can_learn_on(&desk.plan, phase);
    let rows = desk.per_seed(|seed| {
        let trained = &minds[seed];
        let candidate = desk.candidate(policy, trained);
        let expert = Candidate { acting: &Acting::Advisor, roster: IndexSet::EMPTY, ..candidate };
        let cost = |who: &Candidate<'_>, world: &EnvironmentConfig| {
            Ok::<f64, RunError>(total(&desk.test(who, world, seed)?))
        };
        let untaught =
            [cost(&candidate, old)?, cost(&candidate, world)?, cost(&expert, old)?, cost(&expert, world)?];
        if !learns {
            return Ok((untaught, None));
        }
        let plan = learning_on(&desk.plan, phase, desk.options.lasting)?;
        let mut mind = Mind::thaw(&plan, &trained[phase].mind.freeze_for(&desk.plan))?;
        let streams = desk.seed(seed).child("change").child(what);
        go_on(&plan, (phase, &mut mind), world, &streams, (&mut Unobserved, desk))?;
        let adapted = cost(&Candidate { plan: &plan, mind: &mind, ..candidate }, world)?;
        Ok((untaught, Some(adapted)))
    })?;
    let estimate = |i: usize| over(&rows.iter().map(|(untaught, _)| untaught[i]).collect::<Vec<_>>());
    let adapted: Vec<f64> = rows.iter().filter_map(|(_, adapted)| *adapted).collect();
    let gains: Vec<f64> =
        adapted.iter().zip(&rows).map(|(adapted, (untaught, _))| adapted - untaught[1]).collect();
    Ok(Change {
        what: what.to_owned(),
        policy: policy.to_owned(),
        before: estimate(0),
        at_once: estimate(1),
        adapted: learns.then(|| over(&adapted)),
        gain: learns.then(|| over(&gains)),
        expert: (estimate(2), estimate(3)),
    })
}
