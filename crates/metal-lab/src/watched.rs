//! Hearing a policy think: every choice, with the values it was made from. For pages and figures; nothing can be changed.

use metal_rl::decision::DecisionState;
use metal_rl::policies::Attention;
use metal_rl::policy::{Choice, Experience, Policy, Situation};
use metal_rl::random::Rng;

/// One choice of a policy: a look or a move.
#[derive(Clone, Copy, Debug)]
pub struct Heard<'a> {
    /// Who had said what so far.
    pub state: &'a DecisionState,
    /// The values of all choices, if the policy is attention control: moves first, then looks by slot of the roster.
    pub values: Option<&'a [f64]>,
    /// What was chosen.
    pub choice: Choice,
}

/// Told of every choice.
pub type Ear<'a> = &'a mut (dyn FnMut(&Heard<'_>) + Send);

/// Who is at the wheel while somebody listens.
pub enum Wheel<'a> {
    /// Attention control, whose values can be heard.
    Attention(&'a mut Attention),
    /// Anybody else.
    Other(&'a mut dyn Policy),
}

/// A policy under somebody's ears: it chooses and learns exactly as it would alone.
pub struct Overheard<'w, 'e> {
    wheel: Wheel<'w>,
    ear: Ear<'e>,
}

impl<'w, 'e> Overheard<'w, 'e> {
    /// `wheel` under the ears of `ear`.
    pub fn new(wheel: Wheel<'w>, ear: Ear<'e>) -> Self {
        Self { wheel, ear }
    }

    fn policy(&mut self) -> &mut dyn Policy {
        match &mut self.wheel {
            Wheel::Attention(attention) => *attention,
            Wheel::Other(policy) => *policy,
        }
    }
}

impl Policy for Overheard<'_, '_> {
    fn wants_advice(&self) -> bool {
        match &self.wheel {
            Wheel::Attention(attention) => attention.wants_advice(),
            Wheel::Other(policy) => policy.wants_advice(),
        }
    }

    fn choose(&mut self, situation: &Situation<'_>, rng: &mut Rng) -> Choice {
        let choice = self.policy().choose(situation, rng);
        let values = match &self.wheel {
            Wheel::Attention(attention) => Some(attention.values()),
            Wheel::Other(_) => None,
        };
        (self.ear)(&Heard { state: situation.state, values, choice });
        choice
    }

    fn experience(&mut self, experience: Experience) {
        self.policy().experience(experience);
    }

    fn learn(&mut self) {
        self.policy().learn();
    }

    fn begin(&mut self, learning: bool) {
        self.policy().begin(learning);
    }
}
