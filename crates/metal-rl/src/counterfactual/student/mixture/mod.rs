//! The student as a mixture of Gaussians: the paper's own family of learner (Sec. 3.2.1), taught by the same counterfactual
//! targets as the networks.
//!
//! One joint density of readings, memories and what moves are worth serves all sets of looks: what was not looked at is
//! marginalised, exactly, and never a zero. What moves are worth is its conditional mean, or a local linear function of
//! what is known; what a look is worth is the value of information, or a local linear function of it. In the order of
//! the data: [`config`] → `blocks` → `density` → `start`, `em` → `information` → `heads` → `teach`.
//! Reading R133.

mod blocks;
pub mod config;
mod density;
mod em;
mod heads;
mod information;
mod start;
mod teach;
#[cfg(test)]
mod tests;

pub use config::{Looks, MixtureConfig, Moves};
pub(in crate::counterfactual) use teach::fit;

use crate::counterfactual::student::gaze::Layout;
use crate::set::IndexSet;
use blocks::Blocks;
use density::{Belief, Density};
use heads::{Heads, Shape, largest};
use information::Information;
use serde::{Deserialize, Serialize};

/// Inputs of local values that are values themselves: what the best move is expected to be worth, and what a look is
/// expected to add to that.
const HINTS: usize = 2;

/// What a student knows as a mixture. Before the first fit it knows nothing, and all its values are 0.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(in crate::counterfactual) struct Mixture {
    config: MixtureConfig,
    actions: usize,
    slots: usize,
    knowledge: Option<Knowledge>,
}

/// What was learned.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Knowledge {
    blocks: Blocks,
    density: Density,
    information: Information,
    heads: Heads,
    /// What a look costs, in the unit of values; for looks whose worth is not learned.
    prices: Vec<f64>,
    /// Whether a look is valued against moving now.
    relative: bool,
}

/// Working memory.
#[derive(Clone, Debug, Default)]
pub(in crate::counterfactual) struct Work {
    x: Vec<f64>,
    seen: Vec<bool>,
    belief: Belief,
    inputs: Vec<f64>,
    opinions: Vec<f64>,
    worth: Vec<f64>,
    gains: Vec<f64>,
    /// The value of the state that was evaluated last, in its unit.
    pub value: f64,
}

impl Mixture {
    /// A mixture that knows nothing.
    pub fn new(config: &MixtureConfig, actions: usize, slots: usize) -> Self {
        Self { config: config.clone(), actions, slots, knowledge: None }
    }

    /// Whether a thawed mixture was born for this, and is whole.
    pub fn fits(&self, config: &MixtureConfig, layout: &Layout, actions: usize) -> bool {
        let own = self.config == *config && self.actions == actions && self.slots == layout.slots();
        own && self.knowledge.as_ref().is_none_or(|k| k.is_sound(config, layout, actions))
    }

    /// Whether it was ever taught.
    pub fn knows_something(&self) -> bool {
        self.knowledge.is_some()
    }

    /// How many numbers it learned.
    pub fn numbers(&self) -> usize {
        self.knowledge.as_ref().map_or(0, |k| k.density.numbers() + k.heads.numbers())
    }

    /// Changes the unit of advantages by `gain`, and values of states v into `value.0`·v + `value.1`.
    pub fn rescale(&mut self, gain: f64, value: (f64, f64)) {
        let Some(knowledge) = &mut self.knowledge else { return };
        knowledge.density.scale_targets(gain);
        knowledge.information.rescale(gain);
        let shape = knowledge.heads.shape();
        let (last, hints) = (shape.outputs - 1, shape.inputs - HINTS);
        (0..last).for_each(|output| knowledge.heads.rescale(output, (gain, 0.0), hints));
        knowledge.heads.rescale(last, value, hints);
        knowledge.prices.iter_mut().for_each(|price| *price *= gain);
    }

    /// What moves, looks and moving now are worth, and the value of the state, for a network's input.
    pub fn evaluate(&self, input: &[f32], values: &mut [f64], work: &mut Work) {
        values.fill(0.0);
        work.value = 0.0;
        if let Some(knowledge) = &self.knowledge {
            knowledge.infer(input, work);
            knowledge.value_moves((self.config.moves, self.actions), values, work);
            knowledge.value_looks((self.config.looks, self.actions, self.slots), values, work);
        }
    }
}

/// The shape of local values: moves and the state's value, moving now, and every look are fitted apart.
fn shape(blocks: &Blocks, factors: usize, actions: usize, slots: usize) -> Shape {
    Shape {
        outputs: actions + slots + 2,
        inputs: 1 + factors + blocks.flags() + HINTS,
        own: factors,
        groups: 2 + slots,
    }
}

impl Knowledge {
    fn is_sound(&self, config: &MixtureConfig, layout: &Layout, actions: usize) -> bool {
        let shape = shape(&self.blocks, config.factors, actions, layout.slots());
        let visible = |slot: &usize| self.blocks.reading(*slot).is_some();
        let visible: IndexSet = (0..layout.slots()).filter(visible).collect();
        self.blocks == Blocks::new(layout, visible, actions)
            && self.density.is_sound(&self.blocks.ranges(), config.factors)
            && self.heads.is_sound(shape, self.density.components())
            && self.information.is_sound(self.density.components(), layout.slots(), config.codewords)
            && self.prices.len() == layout.slots()
    }

    /// What is known, and what follows from it for every component.
    fn infer(&self, input: &[f32], work: &mut Work) {
        work.x.resize(self.blocks.width(), 0.0);
        work.seen.resize(self.density.blocks().len(), false);
        self.blocks.read(input, &mut work.x, &mut work.seen);
        self.density.infer(&work.x, &work.seen, &mut work.belief);
        let shape = self.heads.shape();
        work.inputs.resize(shape.inputs, 0.0);
        work.inputs[0] = 1.0;
        self.blocks.bits(&work.seen, &mut work.inputs[1 + shape.own..shape.inputs - HINTS]);
        work.inputs[shape.inputs - HINTS..].fill(0.0);
    }

    /// What all moves are worth by every component, and together; and the value of the state.
    fn value_moves(&self, (moves, actions): (Moves, usize), values: &mut [f64], work: &mut Work) {
        let last = self.heads.shape().outputs - 1;
        work.opinions.clear();
        for &(c, share) in &work.belief.active {
            self.locate(c, &work.belief, &mut work.inputs);
            for (a, value) in values[..actions].iter_mut().enumerate() {
                // What a component holds a move to be worth if it were the right one. A fitted value is no such thing:
                // where nothing was seen, all components learn the same.
                let opinion = self.density.expected((c, self.blocks.features() + a), &work.belief);
                work.opinions.push(opinion);
                *value += share
                    * match moves {
                        Moves::Marginal => opinion,
                        Moves::Fitted => self.heads.value((c, a), &work.inputs),
                    };
            }
            work.value += share * self.heads.value((c, last), &work.inputs);
        }
    }

    /// What looks and moving now are worth, once the moves are valued.
    fn value_looks(
        &self,
        (looks, actions, slots): (Looks, usize, usize),
        values: &mut [f64],
        work: &mut Work,
    ) {
        let best = largest(&values[..actions]);
        self.foresee((actions, slots), work);
        let (stop, hints) = (actions + slots, self.heads.shape().inputs - HINTS);
        if looks == Looks::Expected {
            values[stop] = best;
            let base = if self.relative { 0.0 } else { best };
            for slot in 0..slots {
                values[actions + slot] = base + work.gains[slot] - self.prices[slot];
            }
            return;
        }
        for &(c, share) in &work.belief.active {
            self.locate(c, &work.belief, &mut work.inputs);
            work.inputs[hints] = best;
            // Moving now tells nothing more.
            for (n, value) in values[actions..=stop].iter_mut().enumerate() {
                work.inputs[hints + 1] = work.gains.get(n).copied().unwrap_or(0.0);
                *value += share * self.heads.value((c, actions + n), &work.inputs);
            }
        }
    }

    /// What every look is expected to add to the worth of the best move.
    fn foresee(&self, (actions, slots): (usize, usize), work: &mut Work) {
        work.worth.resize(actions, 0.0);
        work.gains.clear();
        for slot in 0..slots {
            let gain = self.information.gain(slot, &work.belief.active, &work.opinions, &mut work.worth);
            work.gains.push(gain);
        }
    }

    /// Writes where component `c` thinks that it is into the inputs of its local values.
    fn locate(&self, c: usize, belief: &Belief, inputs: &mut [f64]) {
        /// Places farther out than this were hardly ever seen; a linear function ends there.
        const FAR: f64 = 3.0;
        let factors = self.density.factors();
        for (j, input) in inputs[1..=factors].iter_mut().enumerate() {
            *input = belief.place(c, j, factors).clamp(-FAR, FAR);
        }
    }
}
