//! Trait [`Learner`]: continuous reinforcement learning behind one small door. Eqs. (3, 4).
//!
//! "The Bayesian learning framework utilized here can be replaced by any other continuous RL approach" (Sec. 3.2.1):
//! tiny agents, full observer and attention control all learn through this trait. Targets are computed outside
//! (see [`crate::returns`]), so every learner works in every phase.

use serde::{Deserialize, Serialize};

/// Shape of a learner: numbers in, choices out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Dims {
    /// Length of a state.
    pub inputs: usize,
    /// Number of choices (motor actions; for attention control also looks).
    pub choices: usize,
}

/// How far one sample moves the estimate; reading R2.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Rate {
    /// The "full learning rate" of Phase I: step size 1.
    Full,
    /// Constant step size in (0, 1].
    Constant(f64),
    /// Running average: step size 1/n, never below this floor.
    Average(f64),
}

/// One thing to learn from.
#[derive(Clone, Copy, Debug)]
pub struct Sample<'a> {
    /// State, scaled to [0, 1] per entry.
    pub state: &'a [f64],
    /// Choice made.
    pub choice: usize,
    /// What the choice turned out to be worth (temporal-difference target or return).
    pub target: f64,
    /// Whether a flawless expert made the choice (Phase I), so that it counts as a success whatever it earned.
    pub demonstrated: bool,
}

/// A Gaussian of a learner that has some, for figures.
#[derive(Clone, Debug, PartialEq)]
pub struct Bump {
    /// The choice it belongs to.
    pub choice: usize,
    /// Its mean, one entry per input.
    pub mean: Vec<f64>,
    /// Its standard deviation along each input.
    pub deviation: Vec<f64>,
}

/// A learner of action values and of degrees of support over a continuous state.
///
/// Laws, tested for every learner: values and supports are finite for every finite state; a support is a distribution;
/// a frozen and thawed learner goes on with the same bits; the same seed and samples give the same bits.
pub trait Learner: Send + Sync {
    /// Shape.
    fn dims(&self) -> Dims;

    /// Q(s, ·), one value per choice, into `out`.
    fn values(&self, state: &[f64], out: &mut [f64]);

    /// P(· | s): degree of support of every choice, a distribution, into `out`. Eq. (11).
    fn support(&self, state: &[f64], out: &mut [f64]);

    /// Values and supports at once, for learners that share the work.
    fn values_and_support(&self, state: &[f64], values: &mut [f64], support: &mut [f64]) {
        self.values(state, values);
        self.support(state, support);
    }

    /// Standard deviation of each Q(s, ·) as the learner sees it; false if it keeps none (`out` is then untouched).
    fn uncertainty(&self, _state: &[f64], _out: &mut [f64]) -> bool {
        false
    }

    /// Learns one sample and returns the error (target − value) before it. Eqs. (3, 4).
    fn learn(&mut self, sample: Sample<'_>, rate: Rate) -> f64;

    /// Size of the model in its own natural unit (components, weights …) and that unit's name.
    fn size(&self) -> (usize, &'static str);

    /// The Gaussians it is made of, if it is made of Gaussians.
    fn bumps(&self) -> Vec<Bump> {
        Vec::new()
    }

    /// The complete state as bytes: thawing gives a learner that goes on bit for bit.
    fn freeze(&self) -> Vec<u8>;

    /// A copy on the heap.
    fn boxed_clone(&self) -> Box<dyn Learner>;
}

impl Clone for Box<dyn Learner> {
    fn clone(&self) -> Self {
        self.boxed_clone()
    }
}

/// Why a learner could not be built or thawed.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum LearnerError {
    /// A setting is outside its range.
    #[error("{learner}.{field} = {value}: {allowed}")]
    Setting {
        /// Learner's configuration name.
        learner: &'static str,
        /// Field.
        field: &'static str,
        /// Value found.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// Frozen bytes are damaged or of another version.
    #[error("frozen {learner} cannot be read: {reason}")]
    Frozen {
        /// Learner's configuration name.
        learner: &'static str,
        /// Why.
        reason: String,
    },
}
