//! One member alone at the wheel: the full observer (the paper's benchmark), or any fixed subset of sensors.

use crate::policy::{Choice, Policy, Situation};
use crate::random::Rng;
use crate::set::IndexSet;

/// Consults one member before every move and acts by its values: greedy as in Eqs. (5, 6), or exploring.
#[derive(Clone, Debug)]
pub struct Solo {
    member: usize,
    scratch: Vec<f64>,
}

impl Solo {
    /// `member` at the wheel, with `actions` motor actions.
    #[must_use]
    pub fn new(member: usize, actions: usize) -> Self {
        Self { member, scratch: vec![0.0; actions] }
    }
}

impl Policy for Solo {
    fn choose(&mut self, situation: &Situation<'_>, rng: &mut Rng) -> Choice {
        let Some(opinion) = situation.state.opinion(self.member) else {
            return Choice::Consult(self.member);
        };
        self.scratch.copy_from_slice(opinion.values);
        let all = IndexSet::first(self.scratch.len());
        Choice::Move(situation.exploration.choose(&mut self.scratch, all, rng))
    }
}
