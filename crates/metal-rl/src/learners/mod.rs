//! The learners: one file or folder each, all behind [`Learner`].

pub mod absp;
mod frozen;
pub mod given;
pub mod mlp;
pub mod nn;
mod settings;

use crate::learner::{Dims, Learner, LearnerError};
use serde::{Deserialize, Serialize};

pub use absp::{Absp, AbspConfig};
pub use given::{Given, GivenConfig};
pub use mlp::{Mlp, MlpConfig};

/// Which learner, with its settings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LearnerConfig {
    /// Bayesian continuous Q-learning with action-based soft partitioning: the paper's, reconstructed.
    Absp(AbspConfig),
    /// A neural network over replayed samples.
    Mlp(MlpConfig),
    /// No learning: the sensor's reading is an expert's opinion.
    Given(GivenConfig),
}

impl Default for LearnerConfig {
    fn default() -> Self {
        Self::Absp(AbspConfig::default())
    }
}

impl LearnerConfig {
    /// Name in configurations and frozen bytes.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Absp(_) => absp::NAME,
            Self::Mlp(_) => mlp::NAME,
            Self::Given(_) => given::NAME,
        }
    }

    /// Refuses settings outside their range.
    ///
    /// # Errors
    /// Names the first field that is out of range.
    pub fn validate(&self) -> Result<(), LearnerError> {
        match self {
            Self::Absp(config) => config.validate(),
            Self::Mlp(config) => config.validate(),
            Self::Given(_) => Ok(()),
        }
    }

    /// A learner that knows nothing yet; whatever is random in it comes from `seed`.
    ///
    /// # Errors
    /// If a setting is outside its range.
    pub fn build(&self, dims: Dims, seed: u64) -> Result<Box<dyn Learner>, LearnerError> {
        settings::check_dims(self.name(), dims)?;
        Ok(match self {
            Self::Absp(config) => Box::new(Absp::new(config, dims)?),
            Self::Mlp(config) => Box::new(Mlp::new(config, dims, seed)?),
            Self::Given(_) => Box::new(Given::new(dims)?),
        })
    }

    /// The learner frozen in `bytes` under these very settings.
    ///
    /// # Errors
    /// If the bytes are damaged, of another version, or were frozen under other settings.
    pub fn thaw(&self, bytes: &[u8]) -> Result<Box<dyn Learner>, LearnerError> {
        Ok(match self {
            Self::Absp(config) => Box::new(Absp::thaw(config, bytes)?),
            Self::Mlp(config) => Box::new(Mlp::thaw(config, bytes)?),
            Self::Given(_) => Box::new(Given::thaw(bytes)?),
        })
    }
}
