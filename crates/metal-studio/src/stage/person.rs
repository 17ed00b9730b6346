//! A person at the wheel.

use super::{Stage, StageError};
use crate::demonstration::{self, Demonstration, Shown};
use crate::frame::Source;
use metal_rl::environment::End;

impl Stage {
    /// One step of a person, written down.
    pub(super) fn demonstrate(&mut self, action: usize) -> Result<(), StageError> {
        let Some(demonstration) = &mut self.demonstration else { return Ok(()) };
        let lane = &mut self.lanes[0];
        let readings = demonstration.before(lane)?;
        let mut frame = lane.watch(action)?;
        let (step, episode) = (lane.step, lane.episode);
        let outcome = lane.act(&mut frame)?;
        let (advice, accident) = (frame.advice, frame.accident);
        demonstration.record(readings, &Shown { step, action, advice, accident, outcome });
        let complete = demonstration.quality().steps == demonstration::WANTED;
        if outcome.end != End::Running {
            demonstration.close_episode(lane)?;
        }
        self.publish(vec![frame], (episode, step), Source::Demonstration);
        if outcome.end != End::Running {
            self.begin_episode()?;
        }
        if complete {
            self.clock.run(false);
            self.save()?;
        }
        Ok(())
    }

    pub(super) fn save(&mut self) -> Result<(), StageError> {
        if let Some(demonstration) = self.demonstration.as_mut().filter(|d| d.is_unsaved()) {
            self.saved = Some(demonstration.save(&self.subject.store)?);
        }
        Ok(())
    }

    /// A person takes the wheel: the clock stands until they move.
    pub(super) fn take_over(&mut self) -> Result<(), StageError> {
        self.hub.show_training(false);
        self.lanes.truncate(1);
        self.clock.run(false);
        self.clock.set_times(1.0);
        (self.held, self.cruise, self.scene) = (None, 1, None);
        if self.demonstration.is_none() {
            self.demonstration = Some(Demonstration::new(&self.subject.plan.spec));
            self.begin_episode()?;
        }
        self.preview()
    }

    /// The person leaves the wheel; nothing they showed is lost.
    pub(super) fn end_demonstration(&mut self) -> Result<(), StageError> {
        if let Some(demonstration) = &mut self.demonstration {
            demonstration.close_episode(&mut self.lanes[0])?;
        }
        self.save()?;
        self.demonstration = None;
        Ok(())
    }

    pub(super) fn press(&mut self, action: usize) -> Result<(), StageError> {
        if action >= self.subject.plan.spec.actions.len() || self.demonstration.is_none() {
            return Err(StageError::Request("press needs a person at the wheel and one of the actions"));
        }
        if !self.clock.is_running() {
            return self.demonstrate(action);
        }
        // A turn lasts as long as its key is held; a speed stays.
        self.held = Some(action);
        if action < 3 {
            self.cruise = action;
        }
        Ok(())
    }

    pub(super) fn undo(&mut self) -> Result<(), StageError> {
        let lane = &mut self.lanes[0];
        let undone = self.demonstration.as_mut().is_some_and(|d| d.undo(lane));
        if !undone {
            return Err(StageError::Request("there is no step to take back"));
        }
        self.clock.run(false);
        self.hub.forget_last();
        self.preview()
    }
}
