//! Training one seed: the plan's tree of phases, each from the minds its parent left behind.

use crate::checkpoint::Ledger;
use crate::checkpoint::ledger::Draft;
use crate::demonstrations::{DemonstrationError, Demonstrations, Recording};
use crate::mind::Mind;
use crate::plan::{Acting, Plan};
use crate::progress::Progress;
use crate::registry::EnvironmentConfig;
use crate::teach::teach;
use crate::trace::{Trace, Watcher};
use crate::watched::Overheard;
use metal_rl::counterfactual::{CounterfactualError, Iterate, Term};
use metal_rl::environment::{Environment, EnvironmentError};
use metal_rl::learner::LearnerError;
use metal_rl::member::Member;
use metal_rl::observe::Observer;
use metal_rl::phase::Phase;
use metal_rl::policy::{Ear, Heard, Policy};
use metal_rl::random::Streams;
use metal_rl::run::{Leg, Position, Stage, run_leg};
use metal_rl::view::Scaling;
use std::collections::BTreeMap;
use std::sync::Mutex;

/// What a phase leaves behind.
pub struct Trained {
    /// Minds at its end.
    pub mind: Mind,
    /// What happened, episode by episode.
    pub trace: Trace,
    /// What each iteration of counterfactual policy iteration came to; empty for all other phases.
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
    /// A set of demonstrations cannot be used.
    #[error(transparent)]
    Demonstrations(#[from] DemonstrationError),
    /// What was finished cannot be kept.
    #[error("{0}; what was kept before is safe")]
    Checkpoint(crate::store::StoreError),
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
    train_seed_kept(plan, streams, &Ledger::none(progress))
}

/// As [`train_seed`]: every finished phase is kept in `ledger`, and what is kept is not trained again.
///
/// # Errors
/// The first failure of any branch.
pub fn train_seed_kept(
    plan: &Plan,
    streams: &Streams,
    ledger: &Ledger<'_>,
) -> Result<BTreeMap<String, Trained>, RunError> {
    let done = Mutex::new(BTreeMap::new());
    let newborn = Mind::newborn(plan, streams)?;
    let roots = children(plan, None);
    branch(&Grove { plan, streams, ledger, done: &done }, &roots, &newborn)?;
    Ok(done.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner))
}

/// What every branch needs.
struct Grove<'a> {
    plan: &'a Plan,
    streams: &'a Streams,
    ledger: &'a Ledger<'a>,
    done: &'a Mutex<BTreeMap<String, Trained>>,
}

fn children<'a>(plan: &'a Plan, parent: Option<&str>) -> Vec<&'a str> {
    let names = plan.order.iter().map(String::as_str);
    names.filter(|n| plan.file.phase[*n].after.as_deref() == parent).collect()
}

fn branch(grove: &Grove<'_>, names: &[&str], parent: &Mind) -> Result<(), RunError> {
    use rayon::prelude::*;
    let Grove { plan, streams, ledger, .. } = grove;
    names.par_iter().try_for_each(|name| {
        let trained = match ledger.finished(plan, name) {
            Some(trained) => trained,
            None => train_phase_kept(plan, name, parent.clone(), streams, ledger)?,
        };
        let mind = trained.mind.clone();
        grove
            .done
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner)
            .insert((*name).to_owned(), trained);
        branch(grove, &children(grove.plan, Some(name)), &mind)
    })
}

/// Trains phase `name` from newborn minds, and before it only those that it starts from.
///
/// # Errors
/// As [`train_phase`].
pub fn train_up_to(
    plan: &Plan,
    name: &str,
    streams: &Streams,
    progress: &dyn Progress,
) -> Result<Trained, RunError> {
    let mind = match plan.file.phase[name].after.as_deref() {
        Some(before) => train_up_to(plan, before, streams, progress)?.mind,
        None => Mind::newborn(plan, streams)?,
    };
    train_phase(plan, name, mind, streams, progress)
}

/// Runs one phase from the minds `mind`.
///
/// # Errors
/// If the world fails or a learner cannot be built.
pub fn train_phase(
    plan: &Plan,
    name: &str,
    mind: Mind,
    streams: &Streams,
    progress: &dyn Progress,
) -> Result<Trained, RunError> {
    train_phase_kept(plan, name, mind, streams, &Ledger::none(progress))
}

/// As [`train_phase`]: saved from time to time in `ledger`, gone on with where it was saved, and kept at its end.
fn train_phase_kept(
    plan: &Plan,
    name: &str,
    mind: Mind,
    streams: &Streams,
    ledger: &Ledger<'_>,
) -> Result<Trained, RunError> {
    let mut environment = classroom(plan, name)?;
    let progress = ledger.progress();
    let newborn = || Draft::newborn(mind, Trace::new(&plan.spec));
    let mut draft = ledger.draft(plan, name).unwrap_or_else(newborn);
    // A recording is read from its first line to its last: it cannot be begun in the middle.
    let shown = matches!(plan.file.phase[name].acting, Acting::Demonstrations(_));
    let divisible = !shown && !matches!(plan.file.environment, EnvironmentConfig::Replay(_));
    let diary = loop {
        let (due, ear) = (ledger.alarm(), &mut |_: &Heard<'_>| {});
        let mut observer = Watcher { trace: draft.trace, progress };
        let watch = Watch { environment: environment.as_mut(), observer: &mut observer, ear, progress };
        let pause = &mut || divisible && (due() || progress.interrupted());
        let mut stretch = Stretch { at: draft.at, course: draft.course, pause };
        let learned = learn_stretch((plan, name), &mut draft.mind, streams, watch, &mut stretch)?;
        (draft.at, draft.course) = (stretch.at, stretch.course);
        draft.trace = observer.trace;
        if let Some(diary) = learned {
            break diary;
        }
        ledger.save(plan, name, &draft)?;
        draft.saved += 1;
        if progress.interrupted() {
            return Err(RunError::Interrupted);
        }
    };
    let trained = Trained { mind: draft.mind, trace: draft.trace, diary };
    ledger.finish(plan, name, &trained)?;
    if progress.interrupted() { Err(RunError::Interrupted) } else { Ok(trained) }
}

/// The world of a phase: the plan's own, or the recording that its demonstrations are.
///
/// # Errors
/// If the world cannot be built or the demonstrations cannot be read.
pub fn classroom(plan: &Plan, name: &str) -> Result<Box<dyn Environment>, RunError> {
    match &plan.file.phase[name].acting {
        Acting::Demonstrations(path) => {
            Ok(Box::new(Recording::new(Demonstrations::read(path, &plan.spec)?, &plan.spec)))
        }
        _ => Ok(plan.file.environment.build()?),
    }
}

/// Where a phase is learned, and who watches.
pub struct Watch<'a> {
    /// The world, with the plan's contract.
    pub environment: &'a mut dyn Environment,
    /// Told of every step.
    pub observer: &'a mut dyn Observer,
    /// Told of every choice.
    pub ear: Ear<'a>,
    /// Asked whether to go on.
    pub progress: &'a dyn Progress,
}

/// As [`train_phase`], in a world that stands ready and under the eyes and ears of anybody. If the world fails, what
/// was learned until then stays in `mind`. Returns the diary of counterfactual policy iteration.
///
/// # Errors
/// If the world fails or a learner cannot be built.
pub fn learn_phase(
    plan: &Plan,
    name: &str,
    mind: &mut Mind,
    streams: &Streams,
    watch: Watch<'_>,
) -> Result<Vec<Iterate>, RunError> {
    let mut never = || false;
    let mut whole = Stretch::first(&mut never);
    Ok(learn_stretch((plan, name), mind, streams, watch, &mut whole)?.unwrap_or_default())
}

/// A part of a phase: from where, and until when.
pub(crate) struct Stretch<'a> {
    /// Where the phase stands between two of its episodes.
    pub at: Position,
    /// Where it stands between two iterations, if it is one of counterfactual policy iteration.
    pub course: Option<Vec<u8>>,
    /// Asked between episodes, or between iterations, whether to pause.
    pub pause: &'a mut dyn FnMut() -> bool,
}

impl<'a> Stretch<'a> {
    /// From the beginning of the phase.
    pub fn first(pause: &'a mut dyn FnMut() -> bool) -> Self {
        Self { at: Position::default(), course: None, pause }
    }
}

/// As [`learn_phase`], a part of it. Nothing comes back from a pause.
pub(crate) fn learn_stretch(
    (plan, name): (&Plan, &str),
    mind: &mut Mind,
    streams: &Streams,
    watch: Watch<'_>,
    stretch: &mut Stretch<'_>,
) -> Result<Option<Vec<Iterate>>, RunError> {
    let row = &plan.file.phase[name];
    let phase = plan.phase(name);
    let streams = streams.child("phase").child(name);
    let lesson = Lesson { phase: &phase, scaling: plan.file.scaling, streams: &streams };
    if let Some((controller, config)) = plan.counterfactual(name) {
        let mut term = Term { course: stretch.course.take(), pause: &mut *stretch.pause };
        let graduate = teach(plan, (config, &phase), mind, &streams, (watch, &mut term))?;
        stretch.course = term.course;
        mind.students.insert(controller.to_owned(), graduate.policy);
        return Ok(stretch.course.is_none().then_some(graduate.diary));
    }
    let mut leg = Leg { at: stretch.at, pause: &mut *stretch.pause };
    let finished = if let Acting::Attention(controller) = &row.acting {
        // Taken out for the phase, so that what it learns stays with this mind.
        let mut attention = mind.take_attention(plan, controller, phase.roster, &streams)?;
        let result = learn(&mut mind.members, &mut attention, &lesson, watch, &mut leg);
        mind.attention.insert(controller.clone(), attention);
        result?
    } else {
        let mut policy = mind.policy(plan, &row.acting, phase.roster, 0);
        learn(&mut mind.members, policy.as_mut(), &lesson, watch, &mut leg)?
    };
    stretch.at = leg.at;
    Ok(finished.then(Vec::new))
}

/// What is to be learned.
struct Lesson<'a> {
    phase: &'a Phase,
    scaling: Scaling,
    streams: &'a Streams,
}

fn learn(
    members: &mut [Member],
    policy: &mut dyn Policy,
    lesson: &Lesson<'_>,
    watch: Watch<'_>,
    leg: &mut Leg<'_>,
) -> Result<bool, EnvironmentError> {
    let Watch { environment, observer, ear, .. } = watch;
    let mut policy = Overheard::new(policy, ear);
    let mut stage = Stage { environment, members, policy: &mut policy, scaling: lesson.scaling };
    run_leg(&mut stage, lesson.phase, lesson.streams, leg, observer)
}
