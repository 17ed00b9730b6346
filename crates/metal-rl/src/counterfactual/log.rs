//! The log of the student's own drives: at every motor step all that could have been seen, what was done, and what came
//! of it. Looking changes nothing, so everybody may be read without the student's knowing. No copies are needed.

use super::eyes::Eyes;
use super::gaze::Gaze;
use super::iterate::School;
use super::judge::{Drive, Pupil};
use super::sight::{Note, Scout, lock};
use crate::environment::{End, Environment, EnvironmentError, EnvironmentSpec, Outcome};
use crate::observe::Observer;
use crate::policies::Counterfactual;
use crate::run::{Stage, run};

/// A motor step as it went.
#[derive(Clone, Debug, PartialEq)]
pub struct Moment {
    /// What the student knew when it moved.
    pub gaze: Gaze,
    /// The network's input as if everybody had been looked at before the move.
    pub full: Vec<f32>,
    /// The motor action.
    pub action: usize,
    /// Its reward.
    pub reward: f64,
    /// Everybody's readings after it, slot by slot; none if the world was over.
    pub after: Option<Vec<f32>>,
}

/// A motor step in the world's own readings.
struct Entry {
    gaze: Gaze,
    before: Vec<f64>,
    action: usize,
    outcome: Outcome,
    after: Vec<f64>,
}

/// A world that keeps a log.
struct Logger<'a> {
    world: &'a mut dyn Environment,
    note: Note,
    limit: usize,
    steps: usize,
    now: Vec<f64>,
    entries: Vec<Entry>,
}

impl Logger<'_> {
    /// Reads all sensors, one behind the other.
    fn read_all(&mut self) -> Result<(), EnvironmentError> {
        let lengths: Vec<usize> = self.world.spec().sensors.iter().map(|s| s.features.len()).collect();
        let mut start = 0;
        for (sensor, length) in lengths.into_iter().enumerate() {
            self.now.resize(start + length, 0.0);
            self.world.sense(sensor, &mut self.now[start..])?;
            start += length;
        }
        Ok(())
    }
}

impl Environment for Logger<'_> {
    fn spec(&self) -> &EnvironmentSpec {
        self.world.spec()
    }

    fn reset(&mut self, seed: u64) -> Result<(), EnvironmentError> {
        self.steps = 0;
        self.world.reset(seed)?;
        self.read_all()
    }

    fn sense(&mut self, sensor: usize, out: &mut [f64]) -> Result<(), EnvironmentError> {
        self.world.sense(sensor, out)
    }

    fn step(&mut self, action: usize) -> Result<Outcome, EnvironmentError> {
        let gaze = lock(&self.note).take();
        let before = self.now.clone();
        self.steps += 1;
        let mut outcome = self.world.step(action)?;
        if outcome.end == End::Running && self.steps >= self.limit {
            outcome.end = End::TimeLimit;
        }
        if outcome.end != End::Terminal {
            self.read_all()?;
        }
        if let Some(gaze) = gaze {
            self.entries.push(Entry { gaze, before, action, outcome, after: self.now.clone() });
        }
        Ok(outcome)
    }

    fn measures(&self) -> &[f64] {
        self.world.measures()
    }
}

/// A world that stands still, to be looked at: readings taken before.
struct Still<'a> {
    spec: &'a EnvironmentSpec,
    readings: &'a [f64],
}

impl Environment for Still<'_> {
    fn spec(&self) -> &EnvironmentSpec {
        self.spec
    }

    fn reset(&mut self, _seed: u64) -> Result<(), EnvironmentError> {
        Ok(())
    }

    fn sense(&mut self, sensor: usize, out: &mut [f64]) -> Result<(), EnvironmentError> {
        let start = self.spec.sensors[..sensor].iter().map(|s| s.features.len()).sum::<usize>();
        out.copy_from_slice(&self.readings[start..start + out.len()]);
        Ok(())
    }

    fn step(&mut self, action: usize) -> Result<Outcome, EnvironmentError> {
        Err(EnvironmentError::Motor {
            environment: self.spec.id.clone(),
            action: self.spec.actions.get(action).cloned().unwrap_or_default(),
            reason: "it stands still".into(),
        })
    }

    fn measures(&self) -> &[f64] {
        &[]
    }
}

/// Lets the student drive and returns every motor step.
///
/// # Errors
/// If the world fails.
pub fn log(
    school: &mut School<'_>,
    drive: &Drive<'_>,
    observer: &mut dyn Observer,
) -> Result<Vec<Moment>, EnvironmentError> {
    let note = Note::default();
    let mut driver = Counterfactual::new(drive.student.clone(), school.roster.clone());
    let mut scout = Scout { driver: &mut driver, note: note.clone() };
    let (now, entries) = (Vec::new(), Vec::new());
    let world = &mut *school.environment;
    let mut logger = Logger { world, note, limit: drive.limit, steps: 0, now, entries };
    let mut stage = Stage {
        environment: &mut logger,
        members: &mut *school.members,
        policy: &mut scout,
        scaling: school.scaling,
    };
    run(&mut stage, &drive.phase, &drive.streams, observer)?;
    let entries = logger.entries;
    moments(school, drive, entries)
}

/// What the members make of a log's readings.
fn moments(
    school: &School<'_>,
    drive: &Drive<'_>,
    entries: Vec<Entry>,
) -> Result<Vec<Moment>, EnvironmentError> {
    let pupil = Pupil::of(school, drive);
    let spec = school.environment.spec();
    let layout = drive.student.layout();
    let mut eyes = Eyes::new(pupil, spec);
    let mut see = |readings: &[f64], mut gaze: Gaze| -> Result<Gaze, EnvironmentError> {
        eyes.blink();
        for slot in 0..layout.slots() {
            eyes.look(&mut Still { spec, readings }, slot, &mut gaze)?;
        }
        Ok(gaze)
    };
    let nothing = Gaze::new(layout);
    let moment = |entry: Entry| {
        let full = see(&entry.before, entry.gaze.clone())?.input().to_vec();
        let over = entry.outcome.end == End::Terminal;
        let after = if over { None } else { Some(see(&entry.after, nothing.clone())?) };
        Ok(Moment {
            gaze: entry.gaze,
            full,
            action: entry.action,
            reward: entry.outcome.motor_reward,
            after: after.map(|gaze| layout.readings_of(gaze.input()).to_vec()),
        })
    };
    entries.into_iter().map(moment).collect()
}
