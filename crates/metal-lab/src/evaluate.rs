//! Testing trained minds: greedy, nobody learns, every policy on the same starts, traffic and noise (R58).

use crate::mind::Mind;
use crate::plan::{Acting, Plan};
use crate::progress::Progress;
use crate::registry::{Roads, roads_name};
use crate::trace::{EpisodeRecord, Trace, Watcher};
use crate::train::RunError;
use metal_rl::environment::Environment;
use metal_rl::observe::Observer;
use metal_rl::phase::Phase;
use metal_rl::random::Streams;
use metal_rl::run::{self, Decided, Stage, run};
use metal_rl::set::IndexSet;

/// Somebody to be tested.
pub struct Candidate<'a> {
    /// The experiment.
    pub plan: &'a Plan,
    /// The mind that was trained.
    pub mind: &'a Mind,
    /// Who is at the wheel.
    pub acting: &'a Acting,
    /// Who may be consulted.
    pub roster: IndexSet,
    /// The action of a blind driver.
    pub blind: usize,
}

impl Candidate<'_> {
    /// Lets `act` have the candidate at the wheel in `environment`.
    fn on_stage<T>(&self, environment: &mut dyn Environment, act: impl FnOnce(&mut Stage<'_>) -> T) -> T {
        let mut policy = self.mind.policy(self.plan, self.acting, self.roster, self.blind);
        let mut members = self.mind.members.clone();
        let scaling = self.plan.file.scaling;
        act(&mut Stage { environment, members: &mut members, policy: policy.as_mut(), scaling })
    }
}

/// Where and how long somebody is tested.
#[derive(Clone, Debug)]
pub struct Course {
    /// Scenario, as the environment names it.
    pub scenario: String,
    /// Roads, where the environment has them.
    pub roads: Roads,
    /// Number of runs.
    pub runs: usize,
}

/// Runs `candidate` over `course`; the same `streams` give every candidate the same episodes.
///
/// # Errors
/// If the world cannot be built or fails, or the user interrupts.
pub fn test(
    candidate: &Candidate<'_>,
    course: &Course,
    streams: &Streams,
    progress: &dyn Progress,
) -> Result<Vec<EpisodeRecord>, RunError> {
    let mut watcher = Watcher { trace: Trace::new(&candidate.plan.spec), progress };
    watch(candidate, course, streams, &mut watcher)?;
    // Asked here as well as after every phase: testing everybody takes minutes, too.
    if progress.interrupted() { Err(RunError::Interrupted) } else { Ok(watcher.trace.episodes) }
}

/// As [`test()`], under the eyes of any observer.
///
/// # Errors
/// If the world cannot be built or fails.
pub fn watch(
    candidate: &Candidate<'_>,
    course: &Course,
    streams: &Streams,
    observer: &mut dyn Observer,
) -> Result<(), RunError> {
    let (mut environment, streams) = ground(candidate.plan, course, streams)?;
    drive(candidate, environment.as_mut(), (course.runs, &streams), observer)
}

/// The world of a course, and the streams of its episodes.
///
/// # Errors
/// If the world cannot be built.
pub fn ground(
    plan: &Plan,
    course: &Course,
    streams: &Streams,
) -> Result<(Box<dyn Environment>, Streams), RunError> {
    let environment = plan.environment(&course.scenario, Some(&course.roads)).build()?;
    let streams = streams.child("evaluation").child(&roads_name(&course.roads)).child(&course.scenario);
    Ok((environment, streams))
}

/// As [`watch`], in a world that stands ready: `runs` episodes, all randomness from the streams beside them.
///
/// # Errors
/// If the world fails.
pub fn drive(
    candidate: &Candidate<'_>,
    environment: &mut dyn Environment,
    (runs, streams): (usize, &Streams),
    observer: &mut dyn Observer,
) -> Result<(), RunError> {
    let phase = Phase::evaluation("drive", candidate.roster, runs);
    candidate.on_stage(environment, |stage| run(stage, &phase, streams, observer))?;
    Ok(())
}

/// What `candidate` looks at and how it would move where the world stands now; nothing is carried out.
///
/// # Errors
/// If a sensor does not answer.
pub fn decide(
    candidate: &Candidate<'_>,
    environment: &mut dyn Environment,
    streams: &Streams,
) -> Result<Decided, RunError> {
    let phase = Phase::evaluation("decide", candidate.roster, 1);
    Ok(candidate.on_stage(environment, |stage| run::decide(stage, &phase, streams))?)
}

/// The best constant motor action: the blind baseline, chosen on the validation roads of `course`.
///
/// # Errors
/// If the world cannot be built or fails.
pub fn best_blind_action(
    plan: &Plan,
    mind: &Mind,
    course: &Course,
    streams: &Streams,
    progress: &dyn Progress,
) -> Result<usize, RunError> {
    let mut totals = Vec::new();
    for action in 0..plan.spec.actions.len() {
        let candidate =
            Candidate { plan, mind, acting: &Acting::Blind, roster: IndexSet::EMPTY, blind: action };
        let runs = test(&candidate, course, streams, progress)?;
        totals.push(runs.iter().map(|r| r.motor).sum::<f64>());
    }
    Ok(metal_rl::num::argmax(&totals))
}

/// The measures of a set of runs: name and mean over the runs. Units and signs: `docs/results-json.md`.
#[must_use]
pub fn measures(runs: &[EpisodeRecord]) -> Vec<(&'static str, f64)> {
    let n = runs.len().max(1) as f64;
    let mean = |f: &dyn Fn(&EpisodeRecord) -> f64| runs.iter().map(f).sum::<f64>() / n;
    let share = |f: &dyn Fn(&EpisodeRecord) -> bool| mean(&|r| f64::from(u8::from(f(r))));
    vec![
        ("total", mean(&|r| r.per_step(r.motor + r.perceptual))),
        ("motor", mean(&|r| r.per_step(r.motor))),
        ("perceptual", mean(&|r| r.per_step(r.perceptual))),
        ("looks", mean(&|r| r.per_step(r.look_count() as f64))),
        ("accident_rate", share(&|r| r.driving.accident)),
        ("fault_rate", share(&|r| r.driving.accidents_own_fault > 0)),
        ("contact_steps", mean(&|r| r.driving.contact_steps as f64)),
        ("off_road_rate", mean(&|r| r.driving.off_road_share.unwrap_or(0.0))),
        ("path_smoothness", mean(&|r| r.driving.turn_change_rad_per_step.unwrap_or(0.0))),
        ("speed_smoothness", mean(&|r| r.driving.speed_change_share.unwrap_or(0.0))),
        ("lane_offset", mean(&|r| r.driving.lane_offset_m.unwrap_or(0.0))),
        ("speed", mean(&|r| r.speed_mps)),
    ]
}
