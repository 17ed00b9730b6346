//! Training one seed: the plan's tree of phases, each from the minds its parent left behind.

use crate::mind::Mind;
use crate::plan::{Acting, Plan};
use crate::progress::Progress;
use crate::registry::Roads;
use crate::trace::{Trace, Watcher};
use metal_rl::counterfactual::judge::Verdict;
use metal_rl::counterfactual::sight::Sight;
use metal_rl::counterfactual::{
    CounterfactualConfig, CounterfactualError, Graduate, Iterate, RollOuts, School, Workers, iterate,
};
use metal_rl::environment::EnvironmentError;
use metal_rl::learner::LearnerError;
use metal_rl::member::Member;
use metal_rl::phase::Phase;
use metal_rl::policy::Policy;
use metal_rl::random::Streams;
use metal_rl::run::{Stage, run};
use std::collections::BTreeMap;
use std::sync::Mutex;

/// What a phase leaves behind.
pub struct Trained {
    /// Minds at its end.
    pub mind: Mind,
    /// What happened, episode by episode.
    pub trace: Trace,
    /// Iterations of counterfactual policy iteration; none if the phase learned otherwise.
    pub diary: Vec<Iterate>,
}

/// Why a run stopped.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// A world, a body or its link failed.
    #[error(transparent)]
    Environment(#[from] EnvironmentError),
    /// A learner could not be built or thawed.
    #[error(transparent)]
    Learner(#[from] LearnerError),
    /// The world could not be built.
    #[error("environment: {0}")]
    World(#[from] crate::registry::WorldError),
    /// A derived plan (of a fixed subset) is impossible.
    #[error(transparent)]
    Plan(#[from] crate::plan::PlanError),
    /// Counterfactual policy iteration is impossible here.
    #[error(transparent)]
    Counterfactual(CounterfactualError),
    /// The user interrupted.
    #[error("interrupted")]
    Interrupted,
}

/// Trains one seed: every phase of the plan. Branches of the tree run in parallel; results do not depend on it.
///
/// # Errors
/// The first failure of any branch.
pub fn train_seed(
    plan: &Plan,
    streams: &Streams,
    progress: &dyn Progress,
) -> Result<BTreeMap<String, Trained>, RunError> {
    let done = Mutex::new(BTreeMap::new());
    let newborn = Mind::newborn(plan, streams)?;
    let roots = children(plan, None);
    branch(&Grove { plan, streams, progress, done: &done }, &roots, &newborn)?;
    Ok(done.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner))
}

/// What every branch needs.
struct Grove<'a> {
    plan: &'a Plan,
    streams: &'a Streams,
    progress: &'a dyn Progress,
    done: &'a Mutex<BTreeMap<String, Trained>>,
}

fn children<'a>(plan: &'a Plan, parent: Option<&str>) -> Vec<&'a str> {
    let names = plan.order.iter().map(String::as_str);
    names.filter(|n| plan.file.phase[*n].after.as_deref() == parent).collect()
}

fn branch(grove: &Grove<'_>, names: &[&str], parent: &Mind) -> Result<(), RunError> {
    use rayon::prelude::*;
    names.par_iter().try_for_each(|name| {
        let trained = train_phase(grove.plan, name, parent.clone(), grove.streams, grove.progress)?;
        let mind = trained.mind.clone();
        grove
            .done
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner)
            .insert((*name).to_owned(), trained);
        branch(grove, &children(grove.plan, Some(name)), &mind)
    })
}

/// Runs one phase from the minds `mind`.
///
/// # Errors
/// If the world fails or a learner cannot be built.
pub fn train_phase(
    plan: &Plan,
    name: &str,
    mut mind: Mind,
    streams: &Streams,
    progress: &dyn Progress,
) -> Result<Trained, RunError> {
    let row = &plan.file.phase[name];
    let phase = plan.phase(name);
    let streams = streams.child("phase").child(name);
    let mut observer = Watcher { trace: Trace::new(&plan.spec), progress };
    let mut environment = plan.file.environment.build()?;
    let mut learn = |members: &mut [Member], policy: &mut dyn Policy, observer: &mut Watcher<'_>| {
        let scaling = plan.file.scaling;
        let mut stage = Stage { environment: environment.as_mut(), members, policy, scaling };
        run(&mut stage, &phase, &streams, observer)
    };
    let mut diary = Vec::new();
    if let Some((controller, config)) = plan.counterfactual(name) {
        let graduate = teach(plan, (config, &phase), &mut mind, &streams, &mut observer)?;
        mind.students.insert(controller.to_owned(), graduate.policy);
        diary = graduate.diary;
    } else if let Acting::Attention(controller) = &row.acting {
        // Taken out for the phase, so that what it learns stays with this mind.
        let mut attention = mind.take_attention(plan, controller, phase.roster, &streams)?;
        learn(&mut mind.members, &mut attention, &mut observer)?;
        mind.attention.insert(controller.clone(), attention);
    } else {
        let mut policy = mind.policy(plan, &row.acting, phase.roster, 0);
        learn(&mut mind.members, policy.as_mut(), &mut observer)?;
    }
    if progress.interrupted() {
        return Err(RunError::Interrupted);
    }
    Ok(Trained { mind, trace: observer.trace, diary })
}

/// Counterfactual policy iteration in the world of the plan; iterates are compared on validation roads, or on starts of
/// their own where there are no roads.
fn teach(
    plan: &Plan,
    (config, phase): (&CounterfactualConfig, &Phase),
    mind: &mut Mind,
    streams: &Streams,
    observer: &mut Watcher<'_>,
) -> Result<Graduate, RunError> {
    let scenario = plan.file.environment.training_scenario();
    let mut environment = plan.file.environment.build()?;
    let mut validation = plan.environment(&scenario, Some(&Roads::Validation)).build()?;
    let progress = observer.progress;
    let mut school = School {
        environment: environment.as_mut(),
        validation: validation.as_mut(),
        members: &mut mind.members,
        roster: phase.roster.iter().collect(),
        scaling: plan.file.scaling,
        judge: &RollOuts { workers: &Pool },
        interrupted: &|| progress.interrupted(),
    };
    iterate(&mut school, config, phase, streams, observer).map_err(RunError::from)
}

/// All threads there are; results come back in order, so that they do not depend on the number of threads.
struct Pool;

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
