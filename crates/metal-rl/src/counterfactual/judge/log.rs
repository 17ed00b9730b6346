//! The log of the student's own drives: at every motor step all that could have been seen, what was done, and what came
//! of it. Looking changes nothing, so everybody may be read without the student's knowing. No copies are needed.

use crate::counterfactual::iterate::School;
use crate::counterfactual::judge::eyes::Eyes;
use crate::counterfactual::judge::sight::{Note, Scout, lock};
use crate::counterfactual::judge::{Drive, Pupil};
use crate::counterfactual::student::gaze::Gaze;
use crate::environment::{End, Environment, EnvironmentError, EnvironmentSpec, Outcome};
use crate::observe::Observer;
use crate::policies::Counterfactual;
use crate::run::{Stage, run};
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// A motor step as it went.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
    entries: VecDeque<Entry>,
    most: usize,
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
            self.entries.push_back(Entry { gaze, before, action, outcome, after: self.now.clone() });
            if self.entries.len() > self.most {
                self.entries.pop_front();
            }
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

/// Lets the student drive and returns its motor steps, the last `most` of them.
///
/// # Errors
/// If the world fails.
pub fn log(
    school: &mut School<'_>,
    drive: &Drive<'_>,
    most: usize,
    observer: &mut dyn Observer,
) -> Result<Vec<Moment>, EnvironmentError> {
    let note = Note::default();
    let mut driver = Counterfactual::new(drive.driver.clone(), school.roster.clone());
    let mut scout = Scout { driver: &mut driver, note: note.clone(), ear: &mut *school.ear };
    let (now, entries) = (Vec::new(), VecDeque::new());
    let world = &mut *school.environment;
    let mut logger = Logger { world, note, limit: drive.limit, steps: 0, now, entries, most };
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
    entries: VecDeque<Entry>,
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::counterfactual::config::CounterfactualConfig;
    use crate::counterfactual::judge::Alone;
    use crate::counterfactual::student::rule::Rule;
    use crate::counterfactual::student::{Student, StudentShape};
    use crate::environment::{Feature, SensorSpec};
    use crate::learner::Dims;
    use crate::learners::{LearnerConfig, TileConfig};
    use crate::member::Member;
    use crate::phase::{Budget, Phase};
    use crate::random::Streams;
    use crate::set::IndexSet;
    use crate::view::{Scaling, View};

    /// A clock with two faces, over after four steps.
    struct Clock {
        spec: EnvironmentSpec,
        time: usize,
    }

    impl Environment for Clock {
        fn spec(&self) -> &EnvironmentSpec {
            &self.spec
        }
        fn reset(&mut self, _seed: u64) -> Result<(), EnvironmentError> {
            self.time = 0;
            Ok(())
        }
        fn sense(&mut self, sensor: usize, out: &mut [f64]) -> Result<(), EnvironmentError> {
            out[0] = self.time as f64 / 10.0 + 0.5 * sensor as f64;
            Ok(())
        }
        fn step(&mut self, action: usize) -> Result<Outcome, EnvironmentError> {
            self.time += 1;
            let end = if self.time == 4 { End::Terminal } else { End::Running };
            Ok(Outcome { motor_reward: -(action as f64), end })
        }
        fn measures(&self) -> &[f64] {
            &[]
        }
    }

    fn clock() -> Clock {
        let sensor = |name: &str| SensorSpec {
            name: name.into(),
            features: vec![Feature { name: "t".into(), low: 0.0, high: 1.0 }],
            price: 1.0,
        };
        let spec = EnvironmentSpec {
            id: "Clock-v0".into(),
            sensors: vec![sensor("a"), sensor("b")],
            actions: vec!["wait".into(), "pay".into()],
            horizon: 10,
            measures: vec![],
        };
        Clock { spec, time: 0 }
    }

    /// The log of six steps of a student that looks at the second face only; episodes end after `limit` steps.
    fn logged(limit: usize, most: usize) -> Vec<Moment> {
        let (mut world, mut other) = (clock(), clock());
        let dims = Dims { inputs: 1, choices: 2 };
        let learner = || LearnerConfig::Tile(TileConfig::default()).build(dims, 0).unwrap();
        let member = |s: usize| Member {
            name: format!("m{s}"),
            view: View::new(&clock().spec, &[s]),
            learner: learner(),
        };
        let mut members: Vec<Member> = (0..2).map(member).collect();
        let rule = Rule::Scheduled { slots: IndexSet::EMPTY.with(1), every: 1 };
        let shape = StudentShape { blocks: vec![1; 2], prices: vec![1.0; 2], actions: 2, rule };
        let student = Student::new(&CounterfactualConfig::default(), &shape, &Streams::new(1)).unwrap();
        let mut school = School {
            environment: &mut world,
            validation: &mut other,
            members: &mut members,
            roster: vec![0, 1],
            scaling: Scaling::Linear,
            workers: &Alone,
            interrupted: &|| false,
            ear: &mut |_| {},
        };
        let phase = Phase { budget: Budget::Steps(6), ..Phase::evaluation("drive", IndexSet::first(2), 0) };
        let streams = Streams::new(2);
        let drive = Drive { student: &student, driver: &student, phase, limit, price_share: 1.0, streams };
        struct Nobody;
        impl Observer for Nobody {
            fn on_step(&mut self, _step: &crate::observe::Step<'_>) {}
        }
        log(&mut school, &drive, most, &mut Nobody).unwrap()
    }

    #[test]
    fn everything_is_logged_and_only_what_was_attended_was_known() {
        let moments = logged(10, 100);
        assert!(moments.len() >= 6, "whole episodes: {}", moments.len());
        for (step, moment) in moments.iter().enumerate() {
            let time = (step % 4) as f32 / 10.0;
            assert_eq!(moment.gaze.attended(), IndexSet::EMPTY.with(1));
            assert_eq!(moment.gaze.input()[..2], [0.0, time + 0.5], "step {step}");
            assert_eq!(moment.full[..4], [time, time + 0.5, 1.0, 1.0], "step {step}");
            assert_eq!(moment.reward, -(moment.action as f64));
            let after = (step % 4 < 3).then(|| vec![time + 0.1, time + 0.6]);
            assert_eq!(moment.after.is_some(), after.is_some(), "the world is over after four steps");
            for (is, should) in moment.after.iter().flatten().zip(after.iter().flatten()) {
                assert!((is - should).abs() < 1e-6, "step {step}");
            }
        }
    }

    #[test]
    fn a_drive_that_is_cut_short_goes_on_in_mind_and_old_steps_are_forgotten() {
        let moments = logged(2, 3);
        assert_eq!(moments.len(), 3);
        assert!(moments.iter().all(|m| m.after.is_some()), "nothing was over");
        assert!(moments.iter().all(|m| m.full[0] < 0.15), "episodes of two steps");
    }
}
