//! Initial active learning (Phase II): everybody is consulted, a fixed fuser decides. Eq. (7), Fig. 4.

use crate::fuse::{Fuser, Opinion};
use crate::num;
use crate::policy::{Choice, Policy, Situation};
use crate::random::Rng;
use crate::set::IndexSet;

/// Consults every member of `roster`, then moves as the fuser says. If nobody has anything to say, it does as it did
/// last in this episode (reading R130).
#[derive(Clone, Debug)]
pub struct Fusion {
    fuser: Fuser,
    roster: IndexSet,
    scratch: Vec<f64>,
    last: usize,
}

impl Fusion {
    /// Fusion of the members in `roster` over `actions` motor actions.
    #[must_use]
    pub fn new(fuser: Fuser, roster: IndexSet, actions: usize) -> Self {
        Self { fuser, roster, scratch: vec![0.0; actions], last: 0 }
    }
}

/// The action `fuser` makes of everything `roster` said so far, if anybody did; weights belong to places in the roster.
pub(crate) fn fuse(
    fuser: &Fuser,
    roster: IndexSet,
    situation: &Situation<'_>,
    scratch: &mut [f64],
) -> Option<usize> {
    let mut opinions = [Opinion { agent: 0, proposal: 0, support: &[] }; IndexSet::CAPACITY];
    let mut heard = 0;
    for (agent, m) in roster.iter().enumerate() {
        if let Some(opinion) = situation.state.opinion(m) {
            opinions[heard] =
                Opinion { agent, proposal: num::argmax(opinion.values), support: opinion.support };
            heard += 1;
        }
    }
    (heard > 0).then(|| fuser.fuse(&opinions[..heard], scratch))
}

impl Policy for Fusion {
    fn begin(&mut self, _learning: bool) {
        self.last = 0;
    }

    fn choose(&mut self, situation: &Situation<'_>, rng: &mut Rng) -> Choice {
        if let Some(next) = self.roster.minus(situation.state.attended()).iter().next() {
            return Choice::Consult(next);
        }
        let action = fuse(&self.fuser, self.roster, situation, &mut self.scratch).unwrap_or(self.last);
        self.last = action;
        // The fuser names one action, so exploration sees a preference of 1 for it and of 0 for the others.
        self.scratch.fill(0.0);
        self.scratch[action] = 1.0;
        let all = IndexSet::first(self.scratch.len());
        Choice::Move(situation.exploration.choose(&mut self.scratch, all, rng))
    }
}
