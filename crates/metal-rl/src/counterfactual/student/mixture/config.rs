//! Settings of the mixture.

use crate::counterfactual::config::{count, within};
use crate::learner::LearnerError;
use serde::{Deserialize, Serialize};

/// What moves are expected to be worth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Moves {
    /// The conditional mean of the joint density, given what is known: all by marginalisation.
    Marginal,
    /// Local linear values of what is known, fitted where the student looks as it does.
    #[default]
    Fitted,
}

/// What looks and moving now are expected to be worth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Looks {
    /// The value of information: by how much the best move's worth is expected to rise, less the price. Nothing is
    /// learned, and nothing of what a look is good for later is known.
    Expected,
    /// Local linear values with that as one of their inputs, fitted to counterfactual looks.
    #[default]
    Fitted,
}

/// A mixture of Gaussians in place of networks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MixtureConfig {
    /// Gaussians.
    pub components: usize,
    /// Directions in which each of them is stretched; what they do not explain is independent noise.
    pub factors: usize,
    /// Least standard deviation of that noise, in standard deviations of all that was seen.
    pub least_noise: f64,
    /// Observations that the prior counts for: each Gaussian's shape is drawn towards that of all data, and its local
    /// values towards one linear function for all.
    pub prior: f64,
    /// Rounds of expectation and maximisation in the first fit.
    pub first_sweeps: usize,
    /// The same in later ones, which start where the last one ended.
    pub sweeps: usize,
    /// Rounds of fitting local values; looks are judged by the student of the round before.
    pub rounds: usize,
    /// States drawn for each of them.
    pub draws: usize,
    /// Kinds of readings of a member that are told apart to say what a look is expected to tell.
    pub codewords: usize,
    /// What moves are worth.
    pub moves: Moves,
    /// What looks are worth.
    pub looks: Looks,
}

impl Default for MixtureConfig {
    fn default() -> Self {
        Self {
            components: 48,
            factors: 6,
            least_noise: 0.15,
            prior: 4.0,
            first_sweeps: 15,
            sweeps: 4,
            rounds: 4,
            draws: 30_000,
            codewords: 8,
            moves: Moves::default(),
            looks: Looks::default(),
        }
    }
}

/// Most directions of a Gaussian.
pub(super) const MOST_FACTORS: usize = 8;

impl MixtureConfig {
    /// Refuses settings outside their range.
    ///
    /// # Errors
    /// Names the first field that is out of range.
    pub fn validate(&self) -> Result<(), LearnerError> {
        count("mixture.components", self.components, 1..=4096)?;
        let factors = (1..=MOST_FACTORS).contains(&self.factors);
        within("mixture.factors", self.factors as f64, factors, "must be 1 to 8")?;
        let noise = self.least_noise;
        within("mixture.least_noise", noise, (1e-6..=10.0).contains(&noise), "must be at least 1e-6")?;
        let prior = self.prior;
        within("mixture.prior", prior, (1e-9..=1e9).contains(&prior), "must be above 0")?;
        count("mixture.first_sweeps", self.first_sweeps, 1..=100_000)?;
        count("mixture.sweeps", self.sweeps, 0..=100_000)?;
        count("mixture.rounds", self.rounds, 1..=100_000)?;
        count("mixture.draws", self.draws, 1..=100_000_000)?;
        count("mixture.codewords", self.codewords, 1..=4096)
    }
}
