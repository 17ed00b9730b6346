//! Sights: moments of the student's own drives, with a copy of the world as it stood. Gathered by the one loop itself,
//! through a world and a policy that take notes.

use crate::counterfactual::iterate::School;
use crate::counterfactual::judge::Drive;
use crate::counterfactual::student::gaze::Gaze;
use crate::counterfactual::student::recollection::Footstep;
use crate::environment::{End, Environment, EnvironmentError, EnvironmentSpec, Outcome};
use crate::observe::Observer;
use crate::policies::Counterfactual;
use crate::policy::{Choice, Ear, Heard, Policy, Situation};
use crate::random::{Rng, Streams};
use crate::run::{Stage, run};
use std::sync::{Arc, Mutex, PoisonError};

/// A moment just before a motor action: what the student had seen, and the world.
pub struct Sight {
    /// What the student knew when it decided.
    pub gaze: Gaze,
    /// A copy of the world.
    pub world: Box<dyn Environment>,
    /// All noise that judging this sight needs.
    pub streams: Streams,
}

/// What the student knew at its last move, on the way from the policy to the world.
pub(in crate::counterfactual) type Note = Arc<Mutex<Option<Gaze>>>;

pub(in crate::counterfactual) fn lock(note: &Note) -> std::sync::MutexGuard<'_, Option<Gaze>> {
    note.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A driver that notes what it knew at every move, and is overheard.
pub(in crate::counterfactual) struct Scout<'a> {
    pub driver: &'a mut Counterfactual,
    pub note: Note,
    pub ear: Ear<'a>,
}

impl Policy for Scout<'_> {
    fn choose(&mut self, situation: &Situation<'_>, rng: &mut Rng) -> Choice {
        let choice = self.driver.choose(situation, rng);
        if matches!(choice, Choice::Move(_)) {
            *lock(&self.note) = Some(self.driver.gaze().clone());
        }
        (self.ear)(&Heard { state: situation.state, values: self.driver.weighed(), choice });
        choice
    }

    fn begin(&mut self, learning: bool) {
        self.driver.begin(learning);
    }
}

/// A world that copies itself before some of its motor steps.
struct Track<'a> {
    world: &'a mut dyn Environment,
    note: Note,
    share: f64,
    owed: f64,
    limit: usize,
    steps: usize,
    streams: Streams,
    sights: Vec<Sight>,
    /// Length of what is seen in a step, if a trail is kept.
    seen: Option<usize>,
    trail: Vec<Footstep>,
    stuck: bool,
}

impl Track<'_> {
    fn take_note(&mut self, action: usize) {
        self.owed += self.share;
        let Some(gaze) = lock(&self.note).take() else { return };
        let judged = (self.owed >= 1.0).then_some(self.sights.len());
        if let Some(seen) = self.seen {
            let seen = gaze.input()[..seen].to_vec();
            self.trail.push(Footstep { first: self.steps == 0, seen, action, judged });
        }
        if judged.is_none() {
            return;
        }
        self.owed -= 1.0;
        let streams = self.streams.nth(self.sights.len() as u64);
        match self.world.fork() {
            Some(world) => self.sights.push(Sight { gaze, world, streams }),
            None => self.stuck = true,
        }
    }
}

impl Environment for Track<'_> {
    fn spec(&self) -> &EnvironmentSpec {
        self.world.spec()
    }

    fn reset(&mut self, seed: u64) -> Result<(), EnvironmentError> {
        self.steps = 0;
        self.world.reset(seed)
    }

    fn sense(&mut self, sensor: usize, out: &mut [f64]) -> Result<(), EnvironmentError> {
        self.world.sense(sensor, out)
    }

    fn step(&mut self, action: usize) -> Result<Outcome, EnvironmentError> {
        self.take_note(action);
        self.steps += 1;
        let outcome = self.world.step(action)?;
        let cut = outcome.end == End::Running && self.steps >= self.limit;
        Ok(if cut { Outcome { end: End::TimeLimit, ..outcome } } else { outcome })
    }

    fn measures(&self) -> &[f64] {
        self.world.measures()
    }
}

/// Moments that are to be judged, and the trail of all motor steps.
pub type Gathered = (Vec<Sight>, Vec<Footstep>);

/// Lets the driver drive, and returns the share of moments that is to be judged, evenly spread, and the trail of all motor
/// steps if the student has a recollection; none if the world cannot be copied.
///
/// # Errors
/// If the world fails.
pub fn gather(
    school: &mut School<'_>,
    drive: &Drive<'_>,
    observer: &mut dyn Observer,
) -> Result<Option<Gathered>, EnvironmentError> {
    let note = Note::default();
    let mut driver = Counterfactual::new(drive.driver.clone(), school.roster.clone());
    let mut scout = Scout { driver: &mut driver, note: note.clone(), ear: &mut *school.ear };
    let mut track = Track {
        world: &mut *school.environment,
        note,
        share: drive.student.config().judged,
        owed: 0.0,
        limit: drive.limit,
        steps: 0,
        streams: drive.streams.child("sights"),
        sights: Vec::new(),
        seen: drive.student.recollection().map(|_| drive.student.layout().seen()),
        trail: Vec::new(),
        stuck: false,
    };
    let mut scouting = Stage {
        environment: &mut track,
        members: &mut *school.members,
        policy: &mut scout,
        scaling: school.scaling,
    };
    run(&mut scouting, &drive.phase, &drive.streams, observer)?;
    Ok(if track.stuck { None } else { Some((track.sights, track.trail)) })
}
