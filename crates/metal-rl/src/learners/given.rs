//! An opinion that comes ready-made: the sensor *is* an expert, a classifier or a hand rule, and its reading is the
//! degree of support of every action ("from naive classifier to expert advisor", Sec. 3.1.1). Nothing is learned.

use crate::learner::{Dims, Learner, LearnerError, Rate, Sample};
use serde::{Deserialize, Serialize};

/// Name in configurations.
pub(super) const NAME: &str = "given";

/// Settings of [`Given`]: none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GivenConfig {}

/// Passes its state on as values and (scaled to sum 1) as support.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Given {
    choices: usize,
}

impl Given {
    /// An expert over `dims.choices` actions whose state has one entry per action.
    ///
    /// # Errors
    /// If the state is not as long as there are actions.
    pub fn new(dims: Dims) -> Result<Self, LearnerError> {
        if dims.inputs == dims.choices {
            return Ok(Self { choices: dims.choices });
        }
        Err(LearnerError::Setting {
            learner: NAME,
            field: "inputs",
            value: dims.inputs as f64,
            allowed: "the sensor must deliver one number per action",
        })
    }
}

impl Learner for Given {
    fn dims(&self) -> Dims {
        Dims { inputs: self.choices, choices: self.choices }
    }

    fn values(&self, state: &[f64], out: &mut [f64]) {
        out.copy_from_slice(state);
    }

    fn support(&self, state: &[f64], out: &mut [f64]) {
        let sum: f64 = state.iter().map(|x| x.max(0.0)).sum();
        let usable = sum > 0.0 && sum.is_finite();
        for (o, x) in out.iter_mut().zip(state) {
            *o = if usable { x.max(0.0) / sum } else { 1.0 / self.choices as f64 };
        }
    }

    fn learn(&mut self, sample: Sample<'_>, _rate: Rate) -> f64 {
        sample.target - sample.state[sample.choice]
    }

    fn size(&self) -> (usize, &'static str) {
        (0, "parameters")
    }

    fn freeze(&self) -> Vec<u8> {
        (self.choices as u64).to_le_bytes().to_vec()
    }

    fn boxed_clone(&self) -> Box<dyn Learner> {
        Box::new(*self)
    }
}

impl Given {
    /// Thaws what [`Learner::freeze`] wrote.
    ///
    /// # Errors
    /// If the bytes are damaged.
    pub fn thaw(bytes: &[u8]) -> Result<Self, LearnerError> {
        let damaged = || LearnerError::Frozen { learner: NAME, reason: "8 bytes expected".to_owned() };
        let bytes: [u8; 8] = bytes.try_into().map_err(|_e| damaged())?;
        let choices = usize::try_from(u64::from_le_bytes(bytes)).map_err(|_e| damaged())?;
        Ok(Self { choices })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn support_is_the_reading_scaled_to_one() {
        let expert = Given::new(Dims { inputs: 3, choices: 3 }).unwrap();
        let mut out = [0.0; 3];
        expert.support(&[1.0, 3.0, 0.0], &mut out);
        assert_eq!(out, [0.25, 0.75, 0.0]);
        expert.support(&[0.0, 0.0, 0.0], &mut out);
        assert!((out[2] - 1.0 / 3.0).abs() < 1e-15, "nothing said is no preference");
        assert!(Given::new(Dims { inputs: 2, choices: 3 }).is_err());
        assert_eq!(Given::thaw(&expert.freeze()), Ok(expert));
        assert!(Given::thaw(&[1, 2]).is_err());
    }
}
