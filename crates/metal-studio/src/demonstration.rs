//! A person at the wheel: what was shown so far, taking back, and saving.

use crate::faults::Faulty;
use crate::lane::Lane;
use metal_lab::demonstrations::{Demonstrations, Header, Moment, Quality};
use metal_lab::store::{Store, StoreError};
use metal_rl::environment::{End, EnvironmentError, EnvironmentSpec, Outcome};
use std::collections::VecDeque;

/// Steps that can be taken back.
pub const UNDOABLE: usize = 20;
/// Steps of the paper's demonstration (Sec. 4.4).
pub const WANTED: usize = 200;
/// Folder of the sets within the run folder.
const FOLDER: &str = "demonstrations";
/// Most sets kept in one folder.
const MOST: usize = 9999;

/// Where a step began, so that it can be taken back.
struct Before {
    world: Faulty,
    step: usize,
    episode: usize,
    moments: usize,
}

/// A demonstration that is going on.
pub struct Demonstration {
    set: Demonstrations,
    before: VecDeque<Before>,
    episode: usize,
    saved: usize,
    name: Option<String>,
}

impl Demonstration {
    /// Nothing shown yet, in the world of `spec`.
    #[must_use]
    pub fn new(spec: &EnvironmentSpec) -> Self {
        let set = Demonstrations { header: Header::new(spec), moments: Vec::new() };
        Self { set, before: VecDeque::new(), episode: 0, saved: 0, name: None }
    }

    /// Remembers where `lane` stands before a step.
    ///
    /// # Errors
    /// If a sensor fails.
    pub fn before(&mut self, lane: &mut Lane) -> Result<Vec<Vec<f64>>, EnvironmentError> {
        if self.before.len() == UNDOABLE {
            self.before.pop_front();
        }
        let (step, episode, moments) = (lane.step, self.episode, self.set.moments.len());
        self.before.push_back(Before { world: lane.world.clone(), step, episode, moments });
        lane.readings()
    }

    /// Writes down a step that was made.
    pub fn record(&mut self, readings: Vec<Vec<f64>>, shown: &Shown) {
        self.set.moments.push(Moment {
            episode: self.episode,
            step: shown.step,
            readings,
            action: Some(shown.action),
            advice: shown.advice,
            motor_reward: shown.outcome.motor_reward,
            accident: shown.accident,
            end: shown.outcome.end,
        });
    }

    /// The episode is over, by the clock or because the person went elsewhere: what is seen last is written down.
    ///
    /// # Errors
    /// If a sensor fails.
    pub fn close_episode(&mut self, lane: &mut Lane) -> Result<(), EnvironmentError> {
        let Some(last) = self.set.moments.last_mut().filter(|m| m.action.is_some()) else { return Ok(()) };
        if last.end == End::Running {
            last.end = End::TimeLimit;
        }
        if last.end == End::TimeLimit {
            let (episode, step) = (last.episode, last.step + 1);
            let readings = lane.readings()?;
            self.set.moments.push(Moment {
                episode,
                step,
                readings,
                action: None,
                advice: None,
                motor_reward: 0.0,
                accident: false,
                end: End::TimeLimit,
            });
        }
        self.episode += 1;
        Ok(())
    }

    /// Takes back the last step; false if there is none to take back.
    pub fn undo(&mut self, lane: &mut Lane) -> bool {
        let Some(before) = self.before.pop_back() else { return false };
        self.set.moments.truncate(before.moments);
        if let Some(last) = self.set.moments.last_mut().filter(|m| m.episode == before.episode) {
            last.end = End::Running;
        }
        self.episode = before.episode;
        (lane.world, lane.step) = (before.world, before.step);
        true
    }

    /// Steps that can be taken back now.
    #[must_use]
    pub fn undoable(&self) -> usize {
        self.before.len()
    }

    /// How good it is so far.
    #[must_use]
    pub fn quality(&self) -> Quality {
        self.set.quality()
    }

    /// Whether there is something that is not on disk.
    #[must_use]
    pub fn is_unsaved(&self) -> bool {
        self.set.moments.len() != self.saved
    }

    /// Writes the set to the folder, under the next free name when it is saved first.
    ///
    /// # Errors
    /// If the file system refuses.
    pub fn save(&mut self, store: &Store) -> Result<String, StoreError> {
        let name = self.name.get_or_insert_with(|| next_name(store)).clone();
        let lines = self
            .set
            .to_lines()
            .map_err(|e| StoreError::Damaged { path: store.path(&name), reason: e.to_string() })?;
        store.write(&name, lines.as_bytes())?;
        self.saved = self.set.moments.len();
        Ok(name)
    }
}

/// A step of a person.
pub struct Shown {
    /// Motor step within the episode.
    pub step: usize,
    /// What the person did.
    pub action: usize,
    /// What the expert would have done.
    pub advice: Option<usize>,
    /// Whether something was hit.
    pub accident: bool,
    /// What came of it.
    pub outcome: Outcome,
}

fn name(number: usize) -> String {
    format!("{FOLDER}/{number:04}.jsonl")
}

fn next_name(store: &Store) -> String {
    (1..=MOST).map(name).find(|n| !store.path(n).exists()).unwrap_or_else(|| name(MOST))
}

/// The last set of the folder.
#[must_use]
pub fn last_saved(store: &Store) -> Option<String> {
    (1..=MOST).map(name).take_while(|n| store.path(n).exists()).last()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lane::world_of;
    use crate::subject::{Subject, paper};
    use metal_rl::environment::Environment;

    fn drive(demonstration: &mut Demonstration, lane: &mut Lane, action: usize) {
        let readings = demonstration.before(lane).unwrap();
        let mut frame = lane.watch(action).unwrap();
        let step = lane.step;
        let outcome = lane.act(&mut frame).unwrap();
        let accident = frame.accident;
        demonstration.record(readings, &Shown { step, action, advice: frame.advice, accident, outcome });
        if Lane::is_over(&outcome) {
            demonstration.close_episode(lane).unwrap();
            lane.reset(9).unwrap();
        }
    }

    #[test]
    fn a_demonstration_is_saved_read_undone_and_learned_from() {
        let out = std::env::temp_dir().join(format!("metal-studio-demo-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&out);
        let mut subject = Subject::experiment(paper().unwrap(), &out).unwrap();
        let world = Faulty::new(world_of(&subject.plan, |config| config.horizon = 30).unwrap());
        let mut lane = Lane::new(&mut subject, 0, world).unwrap();
        lane.reset(3).unwrap();
        let mut demonstration = Demonstration::new(lane.world.spec());
        for i in 0..40 {
            drive(&mut demonstration, &mut lane, i % 5);
        }
        assert_eq!(demonstration.quality().steps, 40);
        let stood = lane.world.world.learner();
        for _ in 0..3 {
            drive(&mut demonstration, &mut lane, 0);
        }
        for _ in 0..3 {
            assert!(demonstration.undo(&mut lane));
        }
        assert_eq!((lane.world.world.learner(), demonstration.undoable()), (stood, UNDOABLE - 3));
        demonstration.close_episode(&mut lane).unwrap();
        let name = demonstration.save(&subject.store).unwrap();
        assert_eq!((name.as_str(), demonstration.is_unsaved()), ("demonstrations/0001.jsonl", false));
        let set = Demonstrations::read(&subject.store.path(&name), lane.world.spec()).unwrap();
        assert_eq!((set.quality().steps, set.moments.len()), (40, 42), "two cuts show what lies behind them");
        assert_eq!(last_saved(&subject.store), Some(name));
        std::fs::remove_dir_all(&out).unwrap();
    }

    #[test]
    fn undo_reaches_across_the_end_of_an_episode() {
        let out = std::env::temp_dir().join(format!("metal-studio-undo-{}", std::process::id()));
        let mut subject = Subject::experiment(paper().unwrap(), &out).unwrap();
        let world = Faulty::new(world_of(&subject.plan, |config| config.horizon = 5).unwrap());
        let mut lane = Lane::new(&mut subject, 0, world).unwrap();
        lane.reset(3).unwrap();
        let mut demonstration = Demonstration::new(lane.world.spec());
        for _ in 0..6 {
            drive(&mut demonstration, &mut lane, 1);
        }
        for _ in 0..3 {
            demonstration.undo(&mut lane);
        }
        assert_eq!((lane.step, demonstration.quality().steps), (3, 3));
        for _ in 0..2 {
            drive(&mut demonstration, &mut lane, 1);
        }
        assert_eq!(demonstration.set.moments.len(), 6, "five steps and what lies behind the fifth");
        std::fs::remove_dir_all(&out).unwrap();
    }
}
