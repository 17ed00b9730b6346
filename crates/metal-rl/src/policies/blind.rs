//! The blind baseline: one action, whatever happens, without a look.

use crate::policy::{Choice, Policy, Situation};
use crate::random::Rng;

/// Always the same motor action.
#[derive(Clone, Copy, Debug)]
pub struct Blind {
    /// The action.
    pub action: usize,
}

impl Policy for Blind {
    fn choose(&mut self, _situation: &Situation<'_>, _rng: &mut Rng) -> Choice {
        Choice::Move(self.action)
    }
}
