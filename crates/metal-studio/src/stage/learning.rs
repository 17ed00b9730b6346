//! Starting, holding and ending a training run, and taking in what it has learned.

use super::{Stage, StageError};
use crate::training::{SEED, State, Syllabus, Training};
use metal_lab::plan::{Acting, Plan};
use metal_lab::store::RunCard;
use std::collections::BTreeMap;
use std::sync::Arc;

impl Stage {
    pub(super) fn train(&mut self, from_person: bool) -> Result<(), StageError> {
        if self.training.as_ref().is_some_and(Training::is_alive) {
            return Err(StageError::Request("a run is training already"));
        }
        self.end_demonstration()?;
        let mut file = self.subject.plan.file.clone();
        if from_person {
            let Some(name) = &self.saved else {
                return Err(StageError::Request("no demonstration was saved yet"));
            };
            file.watch_demonstrations(&self.subject.store.path(name));
        }
        let plan = Arc::new(Plan::check(file)?);
        if !self.subject.is_run() {
            self.subject.store.remove("run.json")?;
        }
        self.taken_in.clear();
        self.run_kept = false;
        let tape = self.subject.tape(&plan)?;
        let training = Training::start(Syllabus { plan, seed: SEED, hub: self.hub.clone(), tape })?;
        *crate::hub::lock(&self.shared) = Some(training.learned.clone());
        self.training = Some(training);
        self.hub.show_training(true);
        Ok(())
    }

    pub(super) fn control_training(&mut self, state: State) -> Result<(), StageError> {
        let Some(training) = &mut self.training else {
            return Err(StageError::Request("no run is training"));
        };
        training.control.set(state);
        if state == State::Stopped {
            training.join();
            self.take_in_what_was_learned()?;
        }
        Ok(())
    }

    pub(super) fn pace(&mut self, steps_per_sec: f64) -> Result<(), StageError> {
        let Some(training) = &self.training else {
            return Err(StageError::Request("no run is training"));
        };
        training.control.pace(if steps_per_sec.is_finite() { steps_per_sec.clamp(0.0, 1000.0) } else { 0.0 });
        Ok(())
    }

    /// Minds of phases that were finished meanwhile become drivers, and are kept in the folder unless it holds a run.
    pub(super) fn take_in_what_was_learned(&mut self) -> Result<(), StageError> {
        let Some(training) = &self.training else { return Ok(()) };
        let keeps = !self.subject.is_run();
        for phase in training.learned.finished() {
            if self.taken_in.contains(&phase) {
                continue;
            }
            let Some(mind) = training.learned.mind(&phase) else { continue };
            if keeps {
                let frozen = mind.freeze(&rosters(&training.plan));
                self.subject.store.write_mind(0, &phase, &frozen)?;
            }
            self.subject.add_fresh(&phase, mind);
            self.taken_in.push(phase);
        }
        if let Some(blind) = training.learned.blind().filter(|_| keeps && !self.run_kept) {
            self.subject.store.write_run(&training.plan, &card(blind))?;
            self.run_kept = true;
        }
        if !training.is_alive() {
            self.hub.show_training(false);
        }
        Ok(())
    }
}

/// Who each attention controller may ask.
fn rosters(plan: &Plan) -> BTreeMap<String, Vec<String>> {
    let rows = plan.file.phase.values();
    rows.filter_map(|row| match &row.acting {
        Acting::Attention(name) => Some((name.clone(), row.roster.clone())),
        _ => None,
    })
    .collect()
}

fn card(blind: usize) -> RunCard {
    let version = env!("CARGO_PKG_VERSION").to_owned();
    RunCard { version, seed: SEED, seeds: 1, blind, quick: false }
}
