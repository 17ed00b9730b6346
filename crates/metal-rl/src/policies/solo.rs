//! One member alone at the wheel: the full observer (the paper's benchmark), or any fixed subset of sensors.

use crate::policy::{Choice, Policy, Situation};
use crate::random::Rng;
use crate::set::IndexSet;

/// Consults one member before every move and acts by its values: greedy as in Eqs. (5, 6), or exploring. If the member
/// has nothing to say, what it last said in this episode stands (reading R130).
#[derive(Clone, Debug)]
pub struct Solo {
    member: usize,
    values: Vec<f64>,
    scratch: Vec<f64>,
}

impl Solo {
    /// `member` at the wheel, with `actions` motor actions.
    #[must_use]
    pub fn new(member: usize, actions: usize) -> Self {
        Self { member, values: vec![0.0; actions], scratch: vec![0.0; actions] }
    }
}

impl Policy for Solo {
    fn begin(&mut self, _learning: bool) {
        self.values.fill(0.0);
    }

    fn choose(&mut self, situation: &Situation<'_>, rng: &mut Rng) -> Choice {
        if !situation.state.attended().contains(self.member) {
            return Choice::Consult(self.member);
        }
        if let Some(opinion) = situation.state.opinion(self.member) {
            self.values.copy_from_slice(opinion.values);
        }
        self.scratch.copy_from_slice(&self.values);
        let all = IndexSet::first(self.scratch.len());
        Choice::Move(situation.exploration.choose(&mut self.scratch, all, rng))
    }
}
