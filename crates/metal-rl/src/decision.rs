//! The decision state: what the consulted tiny agents said, and null where nobody was asked. Eq. (10).

use crate::set::IndexSet;
use crate::support::SupportLevel;
use serde::{Deserialize, Serialize};

/// Sizes of everything a decision state holds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DecisionDims {
    /// Length of each member's own state s_TA, Eq. (1).
    pub member_inputs: Vec<usize>,
    /// Number of motor actions |A|.
    pub actions: usize,
}

/// s_ACL of Eq. (10): one decision vector per consulted member, in which absence is a type of its own, not a number.
///
/// Order of consultation is kept for records but is no part of the state (a set, not a sequence, as in Eq. 10).
#[derive(Clone, Debug, PartialEq)]
pub struct DecisionState {
    actions: usize,
    offsets: Vec<usize>,
    attended: IndexSet,
    silent: IndexSet,
    order: Vec<usize>,
    readings: Vec<f64>,
    values: Vec<f64>,
    supports: Vec<f64>,
}

/// What one consulted member says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Opinion<'a> {
    /// The state it saw, s_TA of Eq. (1), scaled to [0, 1].
    pub reading: &'a [f64],
    /// Its action values Q(s_TA, ·).
    pub values: &'a [f64],
    /// Its degree of support of every motor action, Eq. (11).
    pub support: &'a [f64],
}

impl DecisionState {
    /// The all-null state.
    #[must_use]
    pub fn new(dims: &DecisionDims) -> Self {
        let mut offsets = vec![0];
        for n in &dims.member_inputs {
            offsets.push(offsets[offsets.len() - 1] + n);
        }
        let members = dims.member_inputs.len();
        Self {
            actions: dims.actions,
            attended: IndexSet::EMPTY,
            silent: IndexSet::EMPTY,
            order: Vec::with_capacity(members),
            readings: vec![0.0; offsets[members]],
            values: vec![0.0; members * dims.actions],
            supports: vec![0.0; members * dims.actions],
            offsets,
        }
    }

    /// Back to all null: a look never outlives the motor step it was paid for.
    pub fn clear(&mut self) {
        (self.attended, self.silent) = (IndexSet::EMPTY, IndexSet::EMPTY);
        self.order.clear();
    }

    /// Opens the slot of `member` for its opinion (reading, values, support) and marks it attended.
    pub fn attend(&mut self, member: usize) -> (&mut [f64], &mut [f64], &mut [f64]) {
        if !self.attended.contains(member) {
            self.attended = self.attended.with(member);
            self.order.push(member);
        }
        self.silent = self.silent.minus(IndexSet::EMPTY.with(member));
        let range = member * self.actions..(member + 1) * self.actions;
        (
            &mut self.readings[self.offsets[member]..self.offsets[member + 1]],
            &mut self.values[range.clone()],
            &mut self.supports[range],
        )
    }

    /// `member` was consulted and has nothing to say, because its sensors did not answer (reading R130).
    pub fn silence(&mut self, member: usize) {
        self.silent = self.silent.with(member);
    }

    /// What `member` said, or null: it was not asked, or had nothing to say.
    #[must_use]
    pub fn opinion(&self, member: usize) -> Option<Opinion<'_>> {
        let range = member * self.actions..(member + 1) * self.actions;
        self.heard().contains(member).then(|| Opinion {
            reading: &self.readings[self.offsets[member]..self.offsets[member + 1]],
            values: &self.values[range.clone()],
            support: &self.supports[range],
        })
    }

    /// Who was consulted.
    #[must_use]
    pub fn attended(&self) -> IndexSet {
        self.attended
    }

    /// Who was consulted and had something to say.
    #[must_use]
    pub fn heard(&self) -> IndexSet {
        self.attended.minus(self.silent)
    }

    /// Who was consulted, in order.
    #[must_use]
    pub fn order(&self) -> &[usize] {
        &self.order
    }

    /// Number of members, consulted or not.
    #[must_use]
    pub fn members(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Number of motor actions |A|.
    #[must_use]
    pub fn actions(&self) -> usize {
        self.actions
    }
}

/// What of an opinion enters the attention learner's state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Content {
    /// Degrees of support: the paper's decision space. Eq. (11).
    #[default]
    Support,
    /// Advantages Q − max Q: what softens into support, before it is softened.
    Advantages,
    /// The consulted member's raw readings: the perceptual space, masked.
    Readings,
    /// Support and readings.
    SupportAndReadings,
}

/// How a decision state becomes the fixed-length vector that a [`crate::learner::Learner`] takes; readings R16 and R19.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Encoding {
    /// What of each opinion is written.
    pub content: Content,
    /// Level of detail of supports (Sec. 3.1.1).
    pub level: SupportLevel,
    /// The number that stands for null.
    pub null: f64,
    /// Whether one bit per member says "was consulted", so that null differs from every real opinion.
    pub presence_bits: bool,
}

impl Default for Encoding {
    fn default() -> Self {
        Self {
            content: Content::Support,
            level: SupportLevel::DegreeOfSupport,
            null: 0.0,
            presence_bits: true,
        }
    }
}

impl Encoding {
    /// Length of the encoded vector for `members` of these sizes.
    #[must_use]
    pub fn len(&self, dims: &DecisionDims, members: &[usize]) -> usize {
        members.iter().map(|&m| self.block(dims.member_inputs[m], dims.actions)).sum::<usize>()
            + if self.presence_bits { members.len() } else { 0 }
    }

    /// Length of what is written of one opinion over `inputs` numbers.
    #[must_use]
    pub fn block(&self, inputs: usize, actions: usize) -> usize {
        match self.content {
            Content::Support | Content::Advantages => actions,
            Content::Readings => inputs,
            Content::SupportAndReadings => actions + inputs,
        }
    }

    /// Writes the state of `members` into `out` (length [`Self::len`]): blocks in the order of `members`, then presence bits.
    pub fn encode(&self, state: &DecisionState, members: &[usize], out: &mut [f64]) {
        let mut at = 0;
        for &m in members {
            let size = self.block(state.offsets[m + 1] - state.offsets[m], state.actions);
            let block = &mut out[at..at + size];
            match state.opinion(m) {
                None => block.fill(self.null),
                Some(opinion) => self.write(&opinion, block),
            }
            at += size;
        }
        if self.presence_bits {
            for (bit, &m) in out[at..].iter_mut().zip(members) {
                *bit = f64::from(u8::from(state.attended.contains(m)));
            }
        }
    }

    /// Writes one opinion into `block` (length [`Self::block`]).
    pub fn write(&self, opinion: &Opinion<'_>, block: &mut [f64]) {
        let actions = opinion.support.len();
        match self.content {
            Content::Support => {
                block.copy_from_slice(opinion.support);
                self.level.reduce(block);
            }
            Content::Advantages => {
                let best = crate::num::max(opinion.values);
                for (b, v) in block.iter_mut().zip(opinion.values) {
                    *b = v - best;
                }
            }
            Content::Readings => block.copy_from_slice(opinion.reading),
            Content::SupportAndReadings => {
                block[..actions].copy_from_slice(opinion.support);
                self.level.reduce(&mut block[..actions]);
                block[actions..].copy_from_slice(opinion.reading);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state() -> DecisionState {
        let mut state = DecisionState::new(&dims());
        let (reading, values, support) = state.attend(1);
        reading.copy_from_slice(&[0.5]);
        values.copy_from_slice(&[-1.0, -3.0]);
        support.copy_from_slice(&[0.0, 1.0]);
        state
    }

    fn dims() -> DecisionDims {
        DecisionDims { member_inputs: vec![3, 1], actions: 2 }
    }

    fn encoded(encoding: &Encoding, state: &DecisionState) -> Vec<f64> {
        let mut out = vec![f64::NAN; encoding.len(&dims(), &[0, 1])];
        encoding.encode(state, &[0, 1], &mut out);
        out
    }

    #[test]
    fn null_is_no_opinion_and_differs_from_a_zero_support() {
        let state = state();
        assert!(state.opinion(0).is_none());
        assert_eq!(encoded(&Encoding::default(), &state), [0.0, 0.0, 0.0, 1.0, 0.0, 1.0]);
        let advantages = Encoding { content: Content::Advantages, ..Encoding::default() };
        assert_eq!(encoded(&advantages, &state), [0.0, 0.0, 0.0, -2.0, 0.0, 1.0]);
    }

    #[test]
    fn the_null_constant_is_the_users() {
        let encoding = Encoding {
            null: -1.0,
            presence_bits: false,
            content: Content::SupportAndReadings,
            ..Encoding::default()
        };
        assert_eq!(encoded(&encoding, &state()), [-1.0, -1.0, -1.0, -1.0, -1.0, 0.0, 1.0, 0.5]);
    }

    #[test]
    fn clearing_forgets_every_look() {
        let mut state = state();
        state.clear();
        assert!(state.attended().is_empty() && state.order().is_empty() && state.opinion(1).is_none());
    }
}
