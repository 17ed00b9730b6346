//! How wrong a learner usually is: the running mean of its squared errors.

use serde::{Deserialize, Serialize};

/// Running mean of squared errors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct UsualError {
    /// The mean, in squared units of reward; 0 before the first error.
    pub square: f64,
    /// Errors taken in.
    pub count: f64,
}

impl UsualError {
    /// Takes in an error: with weight 1/n, but never less than `slowest`.
    pub fn take_in(&mut self, error: f64, slowest: f64) {
        self.count += 1.0;
        self.square += (1.0 / self.count).max(slowest) * (error * error - self.square);
    }
}
