//! Hearing a policy think: every choice, with the values it was made from. For pages and figures; nothing can be changed.

use metal_rl::policy::{Choice, Ear, Experience, Heard, Policy, Situation};
use metal_rl::random::Rng;

/// A policy under somebody's ears: it chooses and learns exactly as it would alone.
pub struct Overheard<'w, 'e> {
    policy: &'w mut dyn Policy,
    ear: Ear<'e>,
}

impl<'w, 'e> Overheard<'w, 'e> {
    /// `policy` under the ears of `ear`.
    pub fn new(policy: &'w mut dyn Policy, ear: Ear<'e>) -> Self {
        Self { policy, ear }
    }
}

impl Policy for Overheard<'_, '_> {
    fn wants_advice(&self) -> bool {
        self.policy.wants_advice()
    }

    fn choose(&mut self, situation: &Situation<'_>, rng: &mut Rng) -> Choice {
        let choice = self.policy.choose(situation, rng);
        (self.ear)(&Heard { state: situation.state, values: self.policy.weighed(), choice });
        choice
    }

    fn experience(&mut self, experience: Experience) {
        self.policy.experience(experience);
    }

    fn learn(&mut self) {
        self.policy.learn();
    }

    fn begin(&mut self, learning: bool) {
        self.policy.begin(learning);
    }

    fn weighed(&self) -> Option<&[f64]> {
        self.policy.weighed()
    }
}
