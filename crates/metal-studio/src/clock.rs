//! When the next motor step is due.

use metal_worlds::highway::kinematics::ACTION_SECS;
use std::time::{Duration, Instant};

/// Slowest and fastest, times real time.
pub const SPEEDS: (f64, f64) = (0.25, 16.0);

/// A clock that can stand still, run at some speed, or run as fast as the machine can.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    running: bool,
    times: f64,
    due: Instant,
}

impl Clock {
    /// A clock at real time.
    #[must_use]
    pub fn new(running: bool) -> Self {
        Self { running, times: 1.0, due: Instant::now() }
    }

    /// Whether it runs.
    #[must_use]
    pub fn is_running(&self) -> bool {
        self.running
    }

    /// Starts or stops it.
    pub fn run(&mut self, running: bool) {
        self.running = running;
        self.due = Instant::now();
    }

    /// Times real time; 0: as fast as possible.
    #[must_use]
    pub fn times(&self) -> f64 {
        self.times
    }

    /// Sets the speed: 0 for as fast as possible, else within [`SPEEDS`].
    pub fn set_times(&mut self, times: f64) {
        self.times = if times > 0.0 { times.clamp(SPEEDS.0, SPEEDS.1) } else { 0.0 };
        self.due = Instant::now();
    }

    /// Seconds of a motor step on the screen.
    #[must_use]
    pub fn step_secs(&self) -> f64 {
        if self.times > 0.0 { ACTION_SECS / self.times } else { 0.0 }
    }

    /// How long to wait for the next step; none if the clock stands.
    #[must_use]
    pub fn wait(&self) -> Option<Duration> {
        self.running.then(|| self.due.saturating_duration_since(Instant::now()))
    }

    /// A step was made: the next is due a step later, or later still if this one was late.
    pub fn stepped(&mut self) {
        let step = Duration::from_secs_f64(self.step_secs());
        self.due = (self.due + step).max(Instant::now());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speeds_are_kept_within_their_range() {
        let mut clock = Clock::new(false);
        assert!(clock.wait().is_none());
        for (asked, got) in
            [(1.0, 1.0), (100.0, 16.0), (0.01, 0.25), (0.0, 0.0), (-3.0, 0.0), (f64::NAN, 0.0)]
        {
            clock.set_times(asked);
            assert_eq!(clock.times(), got);
        }
        assert_eq!(clock.step_secs(), 0.0);
        clock.run(true);
        assert_eq!(clock.wait(), Some(Duration::ZERO));
        clock.set_times(1.0);
        clock.stepped();
        assert!(clock.wait().unwrap() > Duration::from_millis(300));
    }
}
