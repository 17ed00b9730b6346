//! Range checks of settings, all with one kind of message.

use crate::learner::{Dims, LearnerError};
use std::ops::RangeInclusive;

/// Checks the settings of the learner of this name.
pub(super) struct Settings(pub &'static str);

/// A test and what it demands, in words.
pub(super) type Test = (fn(f64) -> bool, &'static str);

/// Finite and above 0.
pub(super) const POSITIVE: Test = (|x| x.is_finite() && x > 0.0, "must be finite and above 0");

impl Settings {
    /// Refuses a value that fails the test.
    pub fn check(&self, field: &'static str, value: f64, test: Test) -> Result<(), LearnerError> {
        if (test.0)(value) { Ok(()) } else { Err(self.refuse(field, value, test.1)) }
    }

    /// Refuses a value outside a range (and NaN).
    pub fn within(
        &self,
        field: &'static str,
        value: f64,
        range: RangeInclusive<f64>,
        allowed: &'static str,
    ) -> Result<(), LearnerError> {
        if range.contains(&value) { Ok(()) } else { Err(self.refuse(field, value, allowed)) }
    }

    fn refuse(&self, field: &'static str, value: f64, allowed: &'static str) -> LearnerError {
        LearnerError::Setting { learner: self.0, field, value, allowed }
    }
}

/// Refuses shapes without inputs or choices.
pub(super) fn check_dims(learner: &'static str, dims: Dims) -> Result<(), LearnerError> {
    let settings = Settings(learner);
    settings.within("dims.inputs", dims.inputs as f64, 1.0..=1e6, "there must be 1 to a million inputs")?;
    settings.within("dims.choices", dims.choices as f64, 1.0..=1e5, "there must be 1 to 100000 choices")
}
