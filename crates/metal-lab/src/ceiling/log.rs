//! The log: what the driver met, all that was to be seen there, and what every move would have been worth.

use super::driver::{Counting, in_school};
use super::situation::Situations;
use super::{CeilingOptions, subject::Subject};
use crate::progress::Progress;
use crate::teach::Pool;
use crate::train::RunError;
use metal_rl::counterfactual::judge::sight::{Sight, gather};
use metal_rl::counterfactual::judge::{Drive, Judged, Pupil};
use metal_rl::counterfactual::student::Scratch;
use metal_rl::counterfactual::{CounterfactualError, RollOuts, School, Student};
use metal_rl::explore::Schedule;
use metal_rl::observe::{Observer, Step};
use metal_rl::phase::{Budget, Phase};
use metal_rl::random::Streams;

/// Motor steps that are kept as copies of the world at the same time.
const PIECE: usize = 2000;

/// A moment just before a motor action.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Moment {
    /// What everybody reads, slot by slot.
    pub readings: Vec<f32>,
    /// What every motor action is worth, minus the best: ≤ 0.
    pub advantages: Vec<f64>,
    /// The motor action that was carried out, the driver's own or chance's.
    pub action: usize,
    /// The motor action that the driver finds best.
    pub greedy: usize,
    /// What the moment is like.
    pub situation: usize,
}

impl Moment {
    /// What is lost by `action` instead of the driver's own; negative if it is the better one.
    pub fn loss(&self, action: usize) -> f64 {
        self.advantages[self.greedy] - self.advantages[action]
    }
}

/// The moments of an episode, in order.
pub(super) type Episode = Vec<Moment>;

/// What was carried out at every step, and whether an episode begins with it.
struct Deeds<'a> {
    counting: Counting<'a>,
    steps: Vec<(usize, bool)>,
}

impl Observer for Deeds<'_> {
    fn on_step(&mut self, step: &Step<'_>) {
        self.counting.on_step(step);
        self.steps.push((step.action, step.index == 0));
    }

    fn on_episode(&mut self, episode: usize, progress: f64) {
        self.counting.on_episode(episode, progress);
    }
}

/// Drives and judges.
pub(super) fn kept(
    subject: &Subject<'_>,
    driver: &Student,
    options: &CeilingOptions,
    streams: &Streams,
    progress: &dyn Progress,
) -> Result<Vec<Episode>, RunError> {
    let phase = |steps: usize| Phase {
        exploration: Schedule::Random { from: options.chance, to: options.chance, until: 1.0 },
        budget: Budget::Steps(steps),
        ..Phase::evaluation("log", subject.roster(), 0)
    };
    let mut episodes = Vec::new();
    in_school(subject, streams, progress, |school| {
        for start in (0..options.log_steps).step_by(PIECE) {
            let drive = Drive {
                student: driver,
                driver,
                phase: phase(PIECE.min(options.log_steps - start)),
                limit: subject.plan.spec.horizon,
                price_share: 0.0,
                streams: streams.child("log").nth(start as u64),
            };
            episodes.extend(piece(school, &drive, progress)?);
        }
        Ok(())
    })?;
    Ok(episodes)
}

/// One piece of the log.
fn piece(
    school: &mut School<'_>,
    drive: &Drive<'_>,
    progress: &dyn Progress,
) -> Result<Vec<Episode>, RunError> {
    if progress.interrupted() {
        return Err(RunError::Interrupted);
    }
    let mut deeds = Deeds { counting: Counting { progress, steps: 0 }, steps: Vec::new() };
    let Some((sights, _)) = gather(school, drive, &mut deeds)? else {
        return Err(RunError::Counterfactual(CounterfactualError::NoCopies(
            school.environment.spec().id.clone(),
        )));
    };
    let situations = Situations::new(school.environment.spec());
    let kinds: Vec<usize> =
        sights.iter().map(|s: &Sight| situations.of(s.world.measures(), s.gaze.clock())).collect();
    let (judged, steps) = RollOuts { workers: &Pool }.judge(sights, &Pupil::of(school, drive))?;
    progress.steps(steps);
    let mut scratch = drive.student.scratch();
    let mut episodes: Vec<Episode> = Vec::new();
    for ((judged, situation), (action, begins)) in judged.into_iter().zip(kinds).zip(deeds.steps) {
        if begins {
            episodes.push(Vec::new());
        }
        if let Some(episode) = episodes.last_mut() {
            episode.push(moment(judged, (action, situation), drive.student, &mut scratch));
        }
    }
    Ok(episodes)
}

fn moment(
    judged: Judged,
    (action, situation): (usize, usize),
    driver: &Student,
    scratch: &mut Scratch,
) -> Moment {
    driver.evaluate(&judged.full, scratch);
    let greedy = driver.best_move(scratch);
    let readings = driver.layout().readings_of(&judged.full).to_vec();
    Moment { readings, advantages: judged.advantages, action, greedy, situation }
}
