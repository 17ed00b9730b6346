//! How much is measured.

use crate::plan::PlanError;
use crate::plan::limits::count;
use serde::{Deserialize, Serialize};

/// How much is measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PricesOptions {
    /// Independent trainings of everybody.
    pub seeds: usize,
    /// The one number all randomness comes from.
    pub seed: u64,
    /// What prices are multiplied by, from below to above, each ≥ 0.
    pub factors: Vec<f64>,
    /// Fixed choices, as in `RN/2`; none: those of the plan's `subsets.among`, or all single sensors. All sensors always
    /// take part.
    pub rivals: Vec<String>,
    /// Test episodes of each training, on validation roads.
    pub runs: usize,
}

impl Default for PricesOptions {
    fn default() -> Self {
        Self {
            seeds: 5,
            seed: 1,
            factors: vec![0.0, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0],
            rivals: Vec::new(),
            runs: 500,
        }
    }
}

impl PricesOptions {
    /// Refuses what cannot be measured.
    ///
    /// # Errors
    /// The first impossible field, with what is allowed.
    pub fn check(&self) -> Result<(), PlanError> {
        count("seeds", self.seeds, "trainings")?;
        count("runs", self.runs, "episodes")?;
        let possible = |f: &f64| f.is_finite() && *f >= 0.0;
        if self.factors.is_empty()
            || !self.factors.iter().all(possible)
            || !self.factors.is_sorted_by(|a, b| a < b)
        {
            let message =
                format!("{:?}: at least one, finite and at least 0, from below to above", self.factors);
            return Err(PlanError::at("factors", message));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn impossible_options_are_named() {
        let field = |change: &dyn Fn(&mut PricesOptions)| {
            let mut options = PricesOptions::default();
            change(&mut options);
            options.check().unwrap_err().field
        };
        assert_eq!(PricesOptions::default().check(), Ok(()));
        assert_eq!(field(&|o| o.seeds = 0), "seeds");
        assert_eq!(field(&|o| o.runs = 0), "runs");
        for wrong in
            [vec![], vec![1.0, 1.0], vec![2.0, 1.0], vec![-1.0], vec![f64::NAN], vec![0.0, f64::INFINITY]]
        {
            assert_eq!(field(&|o| o.factors.clone_from(&wrong)), "factors");
        }
    }
}
