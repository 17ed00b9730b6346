//! The expert advisor at the wheel (Phase I), and the oracle row of the report: ground truth, no looks.

use crate::policy::{Choice, Policy, Situation};
use crate::random::Rng;

/// Does what the environment's expert advisor says. Fig. 3.
#[derive(Clone, Copy, Debug, Default)]
pub struct Advisor;

impl Policy for Advisor {
    fn wants_advice(&self) -> bool {
        true
    }

    /// # Panics
    /// If the environment has no advisor (check [`crate::environment::Environment::advise`] before the phase).
    fn choose(&mut self, situation: &Situation<'_>, _rng: &mut Rng) -> Choice {
        Choice::Move(situation.advice.expect("the advisor phase needs an environment with an expert advisor"))
    }
}
