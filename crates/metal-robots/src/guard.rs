//! The safety wrapper around every body: nothing that drives is reached but through it.
//!
//! The wheels stop on any error, when the guard is dropped (so also when a panic unwinds), when the emergency stop is
//! pressed (Ctrl-C), when the link is lost (as soon as it is back; see each body for what a robot does alone), and when
//! no command came for [`SILENCE`]. A stop waits for the answer that is on its way, if there is one: two cannot talk on a
//! line at once. No command exceeds the limits of speed and acceleration.

use crate::body::{Body, Wheels};
use crate::error::BodyError;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// How long the wheels may turn without a new command.
pub const SILENCE: Duration = Duration::from_millis(500);
/// Time for which a new command may speed up: at least a moment, or nobody could start; at most a tenth of a second, or
/// whoever stood for long could jump.
const SPURT: [Duration; 2] = [Duration::from_millis(50), Duration::from_millis(100)];
/// How often the watchdog looks.
const ROUND: Duration = Duration::from_millis(20);

/// A button that stops everything; clones are the same button.
#[derive(Clone, Debug, Default)]
pub struct Emergency(Arc<AtomicBool>);

impl Emergency {
    /// Presses the button. Safe to call from a signal handler's thread.
    pub fn press(&self) {
        self.0.store(true, Ordering::SeqCst);
    }

    /// Whether it was pressed.
    #[must_use]
    pub fn pressed(&self) -> bool {
        self.0.load(Ordering::SeqCst)
    }
}

/// What a body may do at most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Speed of a wheel, in metres per second.
    pub speed_mps: f64,
    /// Growth of the faster wheel's speed, in metres per second squared. Braking is always allowed.
    pub acceleration_mps2: f64,
}

impl Default for Limits {
    /// The E-puck's own speed; from standing to it within 0.13 s.
    fn default() -> Self {
        Self { speed_mps: 0.1256, acceleration_mps2: 1.0 }
    }
}

struct Guarded {
    body: Box<dyn Body>,
    turning: bool,
    commanded: Instant,
    /// Speed of the faster wheel by the last command.
    fastest_mps: f64,
}

impl Guarded {
    /// Lets the wheels turn from now on. Noted before it is sent: a command that fails may have arrived.
    fn drive(&mut self, wheels: Wheels) -> Result<(), BodyError> {
        self.turning = wheels != Wheels::STILL;
        self.commanded = Instant::now();
        self.fastest_mps = wheels.fastest_mps();
        self.body.drive(wheels)
    }

    /// Whether the wheels turn, and nobody commanded them for too long.
    fn left_alone(&self) -> bool {
        self.turning && self.commanded.elapsed() >= SILENCE
    }

    /// Stops the wheels. Tried twice: the first attempt may find out that the link is gone.
    fn stop(&mut self) -> Result<(), BodyError> {
        let first = self.body.drive(Wheels::STILL);
        let stopped = if first.is_err() { self.body.drive(Wheels::STILL) } else { first };
        // Tried in any case; asking a dead link again and again helps nobody.
        self.turning = false;
        self.fastest_mps = 0.0;
        stopped
    }
}

/// A body under guard.
pub struct Guard {
    shared: Arc<Mutex<Guarded>>,
    emergency: Emergency,
    limits: Limits,
    over: Option<Sender<()>>,
    watchdog: Option<JoinHandle<()>>,
}

impl Guard {
    /// Puts `body` under guard and stops it.
    ///
    /// # Errors
    /// If it cannot be stopped: then nobody should start it.
    pub fn new(body: Box<dyn Body>, limits: Limits, emergency: Emergency) -> Result<Self, BodyError> {
        let speed_mps = limits.speed_mps.min(body.fastest_mps());
        let mut guarded = Guarded { body, turning: false, commanded: Instant::now(), fastest_mps: 0.0 };
        guarded.stop()?;
        let shared = Arc::new(Mutex::new(guarded));
        let (over, ended) = channel();
        let (watched, button) = (Arc::clone(&shared), emergency.clone());
        let watchdog = std::thread::Builder::new()
            .name("watchdog".to_owned())
            .spawn(move || watch(&watched, &button, &ended))?;
        let limits = Limits { speed_mps, ..limits };
        Ok(Self { shared, emergency, limits, over: Some(over), watchdog: Some(watchdog) })
    }

    /// Drives `wheels` for `secs` seconds' worth of way, then stands still. What the limits forbid takes longer instead:
    /// the way is the same.
    ///
    /// # Errors
    /// If the body or its link fails or the emergency stop is pressed; the wheels were told to stop then.
    pub fn drive_for(&self, wheels: Wheels, secs: f64) -> Result<(), BodyError> {
        let most = self.most(wheels);
        let mut factor = 0.0;
        // Seconds' worth of way that is left.
        let mut left = secs;
        while left > 1e-9 {
            let tick = lock(&self.shared).body.tick_secs();
            let growth = self.limits.acceleration_mps2 * tick / wheels.fastest_mps().max(1e-9);
            factor = (factor + growth).min(most).min(left / tick);
            left -= factor * tick;
            self.with_state(|state| state.drive(wheels.scaled(factor)))?;
            self.with(|body| body.pass(tick))?;
        }
        self.halt()
    }

    /// How much of `wheels` the limit of speed allows, 0 to 1.
    fn most(&self, wheels: Wheels) -> f64 {
        (self.limits.speed_mps / wheels.fastest_mps().max(1e-9)).min(1.0)
    }

    /// Lets the wheels turn until the next command, at most for [`SILENCE`]; within the limits of speed and, by the time
    /// since the last command, of acceleration.
    ///
    /// # Errors
    /// As for [`Self::drive_for`].
    pub fn command(&self, wheels: Wheels) -> Result<(), BodyError> {
        let most = self.most(wheels);
        self.with_state(|state| {
            let spurt = state.commanded.elapsed().clamp(SPURT[0], SPURT[1]).as_secs_f64();
            let reachable_mps = state.fastest_mps + self.limits.acceleration_mps2 * spurt;
            state.drive(wheels.scaled(most.min(reachable_mps / wheels.fastest_mps().max(1e-9))))
        })
    }

    /// Stops the wheels.
    ///
    /// # Errors
    /// If the link fails.
    pub fn halt(&self) -> Result<(), BodyError> {
        lock(&self.shared).stop()
    }

    /// Asks the body for something; an error stops it.
    ///
    /// # Errors
    /// What `ask` fails with, or that the emergency stop is pressed.
    pub fn with<T>(&self, ask: impl FnOnce(&mut dyn Body) -> Result<T, BodyError>) -> Result<T, BodyError> {
        self.with_state(|state| {
            // Whoever asks without a pause never lets the watchdog at the body.
            if state.left_alone() {
                state.stop()?;
            }
            ask(state.body.as_mut())
        })
    }

    fn with_state<T>(&self, ask: impl FnOnce(&mut Guarded) -> Result<T, BodyError>) -> Result<T, BodyError> {
        let mut state = lock(&self.shared);
        let outcome = if self.emergency.pressed() { Err(BodyError::Stopped) } else { ask(&mut state) };
        if outcome.is_err() && state.turning {
            // The first error is the one to report.
            let _ = state.stop();
        }
        outcome
    }
}

impl Drop for Guard {
    fn drop(&mut self) {
        drop(self.over.take());
        if let Some(watchdog) = self.watchdog.take() {
            let _ = watchdog.join();
        }
        // Nobody is left to hear of an error; a robot that hears nothing stops by itself or at its end of the link.
        let _ = lock(&self.shared).stop();
    }
}

/// A panic elsewhere must not keep the wheels from being stopped.
fn lock(shared: &Mutex<Guarded>) -> MutexGuard<'_, Guarded> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

fn watch(shared: &Mutex<Guarded>, emergency: &Emergency, ended: &Receiver<()>) {
    while ended.recv_timeout(ROUND) == Err(RecvTimeoutError::Timeout) {
        let mut state = lock(shared);
        if state.left_alone() || (state.turning && emergency.pressed()) {
            let _ = state.stop();
        }
    }
}
