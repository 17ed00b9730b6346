//! Counterfactual policy iteration as a phase of a plan: its world, its validation roads, its threads.

use crate::mind::Mind;
use crate::plan::Plan;
use crate::registry::Roads;
use crate::train::{RunError, Watch};
use metal_rl::counterfactual::judge::Verdict;
use metal_rl::counterfactual::judge::sight::Sight;
use metal_rl::counterfactual::{
    CounterfactualConfig, CounterfactualError, Graduate, School, Term, Workers, iterate_term,
};
use metal_rl::phase::Phase;
use metal_rl::random::Streams;

/// Counterfactual policy iteration in the world of the plan; iterates are compared on validation roads, or on starts of
/// their own where there are no roads. A term of it.
pub(crate) fn teach(
    plan: &Plan,
    (config, phase): (&CounterfactualConfig, &Phase),
    mind: &mut Mind,
    streams: &Streams,
    (watch, term): (Watch<'_>, &mut Term<'_>),
) -> Result<Graduate, RunError> {
    let scenario = plan.file.environment.training_scenario();
    let mut validation = plan.environment(&scenario, Some(&Roads::Validation)).build()?;
    let Watch { environment, observer, ear, progress } = watch;
    let mut school = School {
        environment,
        validation: validation.as_mut(),
        members: &mut mind.members,
        roster: phase.roster.iter().collect(),
        scaling: plan.file.scaling,
        workers: &Pool,
        interrupted: &|| progress.interrupted(),
        ear,
    };
    iterate_term(&mut school, (config, phase, streams), term, observer).map_err(RunError::from)
}

/// All threads there are; results come back in order, so that they do not depend on the number of threads.
pub(crate) struct Pool;

impl Workers for Pool {
    fn map(&self, pieces: Vec<Vec<Sight>>, work: &(dyn Fn(Vec<Sight>) -> Verdict + Sync)) -> Vec<Verdict> {
        use rayon::prelude::*;
        pieces.into_par_iter().map(work).collect()
    }
}

impl From<CounterfactualError> for RunError {
    fn from(error: CounterfactualError) -> Self {
        match error {
            CounterfactualError::Environment(e) => Self::Environment(e),
            CounterfactualError::Learner(e) => Self::Learner(e),
            CounterfactualError::Interrupted => Self::Interrupted,
            other => Self::Counterfactual(other),
        }
    }
}
