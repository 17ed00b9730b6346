//! Attention control learning (Phase III): look at somebody next, or move? Eqs. (8)-(11), Fig. 5.

mod config;
mod memory;

pub use config::{AttentionConfig, MotorTarget};

use crate::decision::DecisionDims;
use crate::learner::{Learner, Sample};
use crate::policies::rests::{Rests, slots_of};
use crate::policy::{Choice, Experience, Policy, Situation};
use crate::random::Rng;
use crate::set::IndexSet;
use memory::{Decision, Memory};

/// The attention control learning agent: values over moves and looks in the decision space.
#[derive(Clone)]
pub struct Attention {
    config: AttentionConfig,
    learner: Box<dyn Learner>,
    members: Vec<usize>,
    prices: Vec<f64>,
    actions: usize,
    input: Vec<f64>,
    values: Vec<f64>,
    scratch: Vec<f64>,
    targets: Vec<f64>,
    memory: Memory,
    rests: Rests,
    learning: bool,
}

/// Who may be consulted, and at what price.
#[derive(Clone, Debug, PartialEq)]
pub struct Consultable {
    /// Members that may be consulted. Eq. (9).
    pub members: Vec<usize>,
    /// Price of each, in the same order. Fig. 7b.
    pub prices: Vec<f64>,
}

/// Shape of the learner that attention control over `members` needs.
#[must_use]
pub fn learner_dims(
    config: &AttentionConfig,
    dims: &DecisionDims,
    members: &[usize],
) -> crate::learner::Dims {
    crate::learner::Dims { inputs: config.encoding.len(dims, members), choices: dims.actions + members.len() }
}

impl Attention {
    /// Attention over `consultable` with a learner of the shape [`learner_dims`].
    ///
    /// # Panics
    /// If the learner has another shape, or prices and members differ in number.
    #[must_use]
    pub fn new(
        config: AttentionConfig,
        learner: Box<dyn Learner>,
        dims: &DecisionDims,
        consultable: Consultable,
    ) -> Self {
        let needed = learner_dims(&config, dims, &consultable.members);
        assert_eq!(learner.dims(), needed, "the attention learner's shape");
        assert_eq!(consultable.members.len(), consultable.prices.len(), "one price per member");
        Self {
            rests: Rests::new(config.rests, consultable.members.len()),
            config,
            input: vec![0.0; needed.inputs],
            values: vec![0.0; needed.choices],
            scratch: vec![0.0; needed.choices],
            targets: Vec::new(),
            memory: Memory::default(),
            learner,
            members: consultable.members,
            prices: consultable.prices,
            actions: dims.actions,
            learning: false,
        }
    }

    /// Its learner, for freezing and figures.
    #[must_use]
    pub fn learner(&self) -> &dyn Learner {
        self.learner.as_ref()
    }

    /// Which choices are open: every move once enough looks were taken, every member not yet consulted (reading R17)
    /// that does not rest (R116).
    fn available(&self, attended: IndexSet) -> IndexSet {
        let (looks, resting) = (attended.len(), self.rests.resting());
        let may_look = looks < self.config.max_looks;
        let is_open = |slot: usize, m: usize| may_look && !attended.contains(m) && !resting.contains(slot);
        let unseen = self.members.iter().enumerate().filter(|(slot, m)| is_open(*slot, **m));
        let unseen = unseen.fold(IndexSet::EMPTY, |open, (slot, _)| open.with(self.actions + slot));
        let may_move = looks >= self.config.min_looks || unseen.is_empty();
        if may_move { unseen.union(IndexSet::first(self.actions)) } else { unseen }
    }

    /// Price of a choice as it is learned from at `progress` of the phase.
    fn price(&self, choice: usize, progress: f64) -> f64 {
        if choice < self.actions {
            return 0.0;
        }
        let ramp =
            if self.config.price_ramp > 0.0 { (progress / self.config.price_ramp).min(1.0) } else { 1.0 };
        self.prices[choice - self.actions] * ramp
    }

    /// The printed rule: as soon as a decision has led to the next state, its value moves there.
    fn learn_literally(&mut self, worth: f64) {
        let Some(decision) = self.memory.last().copied() else { return };
        let i = self.memory.decisions().len() - 1;
        let state = self.memory.input(i, self.input.len());
        let target = worth - decision.price;
        let sample = Sample { state, choice: decision.choice, target, demonstrated: false };
        self.learner.learn(sample, self.config.rate);
    }

    fn null_value(&mut self) -> f64 {
        self.input.fill(self.config.encoding.null);
        let n = self.input.len();
        if self.config.encoding.presence_bits {
            self.input[n - self.members.len()..].fill(0.0);
        }
        self.learner.values(&self.input, &mut self.scratch);
        let open = self.available(IndexSet::EMPTY);
        open.iter().map(|i| self.scratch[i]).fold(f64::NEG_INFINITY, f64::max)
    }

    fn literal(&self) -> bool {
        self.config.motor_target == MotorTarget::Literal
    }
}

impl Policy for Attention {
    fn begin(&mut self, learning: bool) {
        self.learning = learning;
        self.memory.clear();
        self.rests.begin();
    }

    fn choose(&mut self, situation: &Situation<'_>, rng: &mut Rng) -> Choice {
        self.config.encoding.encode(situation.state, &self.members, &mut self.input);
        self.learner.values(&self.input, &mut self.values);
        let open = self.available(situation.state.attended());
        let best = open.iter().map(|i| self.values[i]).fold(f64::NEG_INFINITY, f64::max);
        if self.learning && self.literal() && !situation.state.attended().is_empty() {
            self.learn_literally(best);
        }
        self.scratch.copy_from_slice(&self.values);
        let choice = situation.exploration.choose(&mut self.scratch, open, rng);
        if self.learning {
            let price = self.price(choice, situation.progress);
            self.memory.record(&self.input, Decision { choice, price, best }, choice < self.actions);
        }
        if choice < self.actions {
            let slots = |of: IndexSet| slots_of(&self.members, of);
            let (asked, heard) = (slots(situation.state.attended()), slots(situation.state.heard()));
            self.rests.end_step(asked, heard);
            Choice::Move(choice)
        } else {
            Choice::Consult(self.members[choice - self.actions])
        }
    }

    fn weighed(&self) -> Option<&[f64]> {
        Some(&self.values)
    }

    fn experience(&mut self, experience: Experience) {
        self.memory.experienced(experience);
        if self.literal() {
            let future = if experience.terminal { 0.0 } else { self.config.credit.gamma * self.null_value() };
            self.learn_literally(experience.motor_reward + future);
        }
    }

    fn learn(&mut self) {
        let gamma = match self.config.motor_target {
            MotorTarget::Literal => return,
            MotorTarget::MacroReturn => self.config.credit.gamma,
            MotorTarget::Myopic => 0.0,
        };
        let mut targets = std::mem::take(&mut self.targets);
        self.memory.targets(gamma, self.config.credit.lambda, &mut targets);
        for (i, &target) in targets.iter().enumerate() {
            if target.is_nan() {
                continue;
            }
            let state = self.memory.input(i, self.input.len());
            let choice = self.memory.decisions()[i].choice;
            self.learner.learn(Sample { state, choice, target, demonstrated: false }, self.config.rate);
        }
        self.targets = targets;
    }
}
