//! How much is measured.

use crate::plan::PlanError;
use crate::plan::limits::count;
use serde::{Deserialize, Serialize};

/// How much is measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CeilingOptions {
    /// Independent drivers, each with a log of its own.
    pub seeds: usize,
    /// The one number all randomness comes from.
    pub seed: u64,
    /// Phase of the plan whose roster and recipe are taken; none: the first one that learns attention.
    pub phase: Option<String>,
    /// Motor steps that the driver drives itself to be taught, and so each universal student.
    pub driver_steps: usize,
    /// Iterations of these trainings.
    pub driver_iterations: usize,
    /// Motor steps of the log.
    pub log_steps: usize,
    /// Share of the log's moves that are left to chance, in (0, 1].
    pub chance: f64,
    /// Shares of the log that take turns in teaching, choosing and judging, ≥ 3.
    pub folds: usize,
    /// Training steps of every fit.
    pub batches: usize,
    /// Rounds of learning to look with memory, each on looks of the round before.
    pub rounds: usize,
    /// Ways of looking through which every episode is seen in a round.
    pub copies: usize,
    /// Motor steps over which a look that is remembered is followed.
    pub lookahead: usize,
    /// Episodes in which each way of looking is put at the wheel.
    pub runs: usize,
}

impl Default for CeilingOptions {
    fn default() -> Self {
        Self {
            seeds: 3,
            seed: 1,
            phase: None,
            driver_steps: 80_000,
            driver_iterations: 16,
            log_steps: 12_000,
            chance: 0.1,
            folds: 3,
            batches: 4000,
            rounds: 2,
            copies: 3,
            lookahead: 6,
            runs: 200,
        }
    }
}

impl CeilingOptions {
    /// So little that the numbers only show that everything works.
    #[must_use]
    pub fn shrunk(self) -> Self {
        Self {
            seeds: 1,
            driver_steps: self.driver_steps.min(400),
            driver_iterations: 1,
            log_steps: self.log_steps.min(400),
            folds: 3,
            batches: self.batches.min(60),
            rounds: 1,
            copies: 1,
            runs: self.runs.min(4),
            ..self
        }
    }

    /// Refuses what cannot be measured.
    ///
    /// # Errors
    /// The first impossible field, with what is allowed.
    pub fn check(&self) -> Result<(), PlanError> {
        count("seeds", self.seeds, "drivers")?;
        count("driver_steps", self.driver_steps, "motor steps")?;
        count("driver_iterations", self.driver_iterations, "iterations")?;
        count("log_steps", self.log_steps, "motor steps")?;
        count("batches", self.batches, "training steps")?;
        count("rounds", self.rounds, "rounds")?;
        count("copies", self.copies, "ways of looking")?;
        count("runs", self.runs, "episodes")?;
        if !(3..=64).contains(&self.folds) {
            return Err(PlanError::at(
                "folds",
                format!("{}: 3 to 64, to teach, to choose and to judge", self.folds),
            ));
        }
        if !(self.chance > 0.0 && self.chance <= 1.0) {
            return Err(PlanError::at("chance", format!("{}: in (0, 1]", self.chance)));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn impossible_options_are_named() {
        let field = |change: &dyn Fn(&mut CeilingOptions)| {
            let mut options = CeilingOptions::default();
            change(&mut options);
            options.check().unwrap_err().field
        };
        assert_eq!(CeilingOptions::default().check(), Ok(()));
        assert_eq!(CeilingOptions::default().shrunk().check(), Ok(()));
        assert_eq!(field(&|o| o.seeds = 0), "seeds");
        assert_eq!(field(&|o| o.folds = 2), "folds");
        assert_eq!(field(&|o| o.chance = f64::NAN), "chance");
        assert_eq!(field(&|o| o.runs = 0), "runs");
    }
}
