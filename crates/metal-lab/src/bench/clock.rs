//! Processor time of the thread that works, so that neighbours on the machine do not count.

use std::time::Instant;

/// A stopwatch.
pub(super) struct Clock {
    wall: Instant,
    thread_secs: Option<f64>,
}

impl Clock {
    /// Started now.
    pub fn start() -> Self {
        Self { wall: Instant::now(), thread_secs: thread_secs() }
    }

    /// Seconds of processor time of this thread since the start; wall time where the system does not tell.
    pub fn secs(&self) -> f64 {
        match (self.thread_secs, thread_secs()) {
            (Some(then), Some(now)) => now - then,
            _ => self.wall.elapsed().as_secs_f64(),
        }
    }
}

/// Linux: nanoseconds on a processor stand first in the thread's scheduler statistics.
fn thread_secs() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    text.split_whitespace().next()?.parse::<f64>().ok().map(|ns| ns * 1e-9)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_takes_time() {
        let clock = Clock::start();
        let mut x = 1_u64;
        while clock.wall.elapsed().as_millis() < 30 {
            x = x.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        }
        assert!(clock.secs() > 0.0 && x != 1, "{}", clock.secs());
    }
}
