//! The random-attention baseline: as many looks as asked for on average, at nobody in particular.

use super::fusion::fuse;
use crate::fuse::Fuser;
use crate::policy::{Choice, Policy, Situation};
use crate::random::Rng;
use crate::set::IndexSet;

/// Consults random members (the first look always, each further one with probability 1 − 1/mean), then fuses. If nobody
/// has anything to say, it does as it did last in this episode (reading R130).
#[derive(Clone, Debug)]
pub struct RandomLooks {
    fuser: Fuser,
    roster: IndexSet,
    mean_looks: f64,
    scratch: Vec<f64>,
    last: usize,
}

impl RandomLooks {
    /// About `mean_looks` (≥ 1) looks per motor action among `roster`, fused over `actions` motor actions.
    #[must_use]
    pub fn new(fuser: Fuser, roster: IndexSet, mean_looks: f64, actions: usize) -> Self {
        Self { fuser, roster, mean_looks: mean_looks.max(1.0), scratch: vec![0.0; actions], last: 0 }
    }
}

impl Policy for RandomLooks {
    fn begin(&mut self, _learning: bool) {
        self.last = 0;
    }

    fn choose(&mut self, situation: &Situation<'_>, rng: &mut Rng) -> Choice {
        let unseen = self.roster.minus(situation.state.attended());
        let first = situation.state.attended().is_empty();
        if !unseen.is_empty() && (first || rng.chance(1.0 - 1.0 / self.mean_looks)) {
            let nth = rng.below(unseen.len());
            if let Some(member) = unseen.iter().nth(nth) {
                return Choice::Consult(member);
            }
        }
        // Nobody had anything to say: as before.
        self.last = fuse(&self.fuser, self.roster, situation, &mut self.scratch).unwrap_or(self.last);
        Choice::Move(self.last)
    }
}
