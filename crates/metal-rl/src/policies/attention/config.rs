//! Settings of attention control learning.

use crate::decision::Encoding;
use crate::learner::Rate;
use crate::policies::RestConfig;
use crate::returns::Credit;
use serde::{Deserialize, Serialize};

/// What the value of a move is learned from; reading R14.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MotorTarget {
    /// As printed: r + γ max Q(null, ·), at once. Every move leads to the same all-null state, so this is nearly
    /// blind to consequences; kept to show what the paper's text says.
    Literal,
    /// Returns that skip the null state: r + γ (−price of the next step's looks + value where they ended).
    #[default]
    MacroReturn,
    /// r alone: one-step tasks, such as classification.
    Myopic,
}

/// Attention control learning, Sec. 3.2.3, as data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct AttentionConfig {
    /// How the decision state is written for the learner.
    pub encoding: Encoding,
    /// What the value of a move is learned from.
    pub motor_target: MotorTarget,
    /// Discount per motor action and λ.
    pub credit: Credit,
    /// Learning rate.
    pub rate: Rate,
    /// Fewest looks before a move.
    pub min_looks: usize,
    /// Most looks before a move (more than the roster holds means no limit).
    pub max_looks: usize,
    /// Share of the phase over which the price that is learned from rises from 0 to its true value. Prices paid and
    /// reported are always the true ones. Reading R15.
    pub price_ramp: f64,
    /// When members that give no answer are left alone. Reading R116.
    pub rests: RestConfig,
}

impl Default for AttentionConfig {
    fn default() -> Self {
        Self {
            encoding: Encoding::default(),
            motor_target: MotorTarget::default(),
            credit: Credit::default(),
            rate: Rate::Constant(0.1),
            min_looks: 0,
            max_looks: usize::MAX >> 1,
            price_ramp: 0.3,
            rests: RestConfig::default(),
        }
    }
}

impl AttentionConfig {
    /// The paper's text taken at its word: zero for null, no presence bits, one-step targets, no price ramp.
    #[must_use]
    pub fn paper_literal() -> Self {
        Self {
            encoding: Encoding { presence_bits: false, ..Encoding::default() },
            motor_target: MotorTarget::Literal,
            price_ramp: 0.0,
            rests: RestConfig::NEVER,
            ..Self::default()
        }
    }
}
