//! Holding and ending a run from outside.

use crate::hub::lock;
use metal_rl::environment::{EnvironmentError, EnvironmentSpec};
use serde::Serialize;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Condvar, Mutex, PoisonError};
use std::time::Duration;

/// How a run stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum State {
    /// It learns.
    Running,
    /// It is held.
    Paused,
    /// Somebody ended it.
    Stopped,
    /// Every phase is learned.
    Finished,
    /// Something went wrong.
    Failed,
}

/// Why a stopped world gives no more steps.
const STOPPED: &str = "stopped from the studio";

/// What page and run share.
pub struct Control {
    state: Mutex<State>,
    changed: Condvar,
    /// Looked at before every step; the lock is taken only if it is set.
    attention_needed: AtomicBool,
    nap_micros: AtomicU64,
}

impl Control {
    pub(super) fn new() -> Self {
        Self {
            state: Mutex::new(State::Running),
            changed: Condvar::new(),
            attention_needed: AtomicBool::new(false),
            nap_micros: AtomicU64::new(0),
        }
    }

    /// How the run stands.
    pub fn state(&self) -> State {
        *lock(&self.state)
    }

    /// Changes how the run stands; a run that is over stays over.
    pub fn set(&self, wanted: State) {
        let mut state = lock(&self.state);
        if matches!(*state, State::Running | State::Paused) {
            *state = wanted;
        }
        self.attention_needed.store(*state != State::Running, Ordering::Relaxed);
        self.changed.notify_all();
    }

    /// At most so many motor steps a second; 0: as fast as it can.
    pub fn pace(&self, steps_per_sec: f64) {
        let micros = if steps_per_sec > 0.0 { 1e6 / steps_per_sec } else { 0.0 };
        self.nap_micros.store(micros as u64, Ordering::Relaxed);
    }

    /// Lets the run through, holds it, or ends it.
    pub(super) fn gate(&self, environment: &EnvironmentSpec) -> Result<(), EnvironmentError> {
        let nap = self.nap_micros.load(Ordering::Relaxed);
        if nap > 0 {
            std::thread::sleep(Duration::from_micros(nap));
        }
        if !self.attention_needed.load(Ordering::Relaxed) {
            return Ok(());
        }
        let mut state = lock(&self.state);
        while *state == State::Paused {
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        if *state == State::Running {
            return Ok(());
        }
        Err(EnvironmentError::Motor {
            environment: environment.id.clone(),
            action: "step".to_owned(),
            reason: STOPPED.to_owned(),
        })
    }
}
