//! The fusion centre of Phase II: many opinions in, one motor action out. Eq. (7), Fig. 4.

use crate::num;
use serde::{Deserialize, Serialize};

/// What one agent that was heard tells the fusion centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Opinion<'a> {
    /// Index of the agent in its roster: weights belong to it, and the lowest one wins a tie.
    pub agent: usize,
    /// Its greedy motor action, arg max Q(s, ·). Eqs. (5, 6).
    pub proposal: usize,
    /// Its degree of support of every motor action, a distribution. Eq. (11).
    pub support: &'a [f64],
}

impl Opinion<'_> {
    /// How sure the agent is of its own proposal: P(proposal | s), the measure of expertness of Eq. (7).
    #[must_use]
    pub fn confidence(&self) -> f64 {
        self.support[self.proposal]
    }
}

/// A rule that fuses opinions. Eq. (7) and its competitors.
///
/// Every rule looks only at those who were heard, and the order in which they speak does not matter (sums differ at
/// most in their last bits). Equal actions: the lowest index wins.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Fuser {
    /// The proposal of the most confident agent wins; of equally confident agents, the lowest. Eq. (7),
    /// reading R65.
    #[default]
    MaxConfidence,
    /// Independent evidence multiplies: soft-max of Σⱼ ln max(Pⱼ, 0.001).
    LogOpinionPool,
    /// The same with a weight per agent: soft-max of Σⱼ wⱼ ln max(Pⱼ, 0.001).
    WeightedLogOpinionPool {
        /// One weight ≥ 0 per agent of the roster.
        weights: Vec<f64>,
    },
    /// Mean support.
    Sum,
    /// Product of supports without a floor: one agent's zero is a veto. If everything is vetoed, the sum decides.
    Product,
    /// Rank points (n − 1 for the best … 0; equal supports share theirs), added up.
    Borda,
    /// One vote per agent for its proposal.
    Majority,
    /// Ordered weighted average: supports of an action sorted from the largest, then averaged with these weights.
    Owa {
        /// Weights ≥ 0, from the largest support to the smallest. They are scaled to sum 1 and stretched over those
        /// heard (their cumulative sum, linearly interpolated), so any number of weights suits any number of agents.
        weights: Vec<f64>,
    },
}

/// Why a fuser cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FuserError {
    /// A weight is negative or not a number.
    #[error("weight {index} of the fuser is {value}, but weights are finite and at least 0")]
    Weight {
        /// Position in the list.
        index: usize,
        /// Value found.
        value: f64,
    },
    /// The weights are missing or all zero.
    #[error("the weights of the fuser add up to nothing")]
    NoWeight,
    /// The log opinion pool has not one weight per agent.
    #[error("the fuser has {weights} weights for {agents} agents")]
    Count {
        /// Weights found.
        weights: usize,
        /// Agents of the roster.
        agents: usize,
    },
}

/// Supports below this count as this in a log opinion pool: nobody may veto.
const POOL_FLOOR: f64 = 1e-3;

impl Fuser {
    /// Checks the weights for a roster of `agents` agents.
    ///
    /// # Errors
    /// If a weight is negative or not finite, if all are zero, or if a pool has not one weight per agent.
    pub fn check(&self, agents: usize) -> Result<(), FuserError> {
        match self {
            Self::WeightedLogOpinionPool { weights } => {
                check_weights(weights)?;
                if weights.len() == agents {
                    Ok(())
                } else {
                    Err(FuserError::Count { weights: weights.len(), agents })
                }
            }
            Self::Owa { weights } => check_weights(weights),
            _ => Ok(()),
        }
    }

    /// The motor action the opinions lead to; their combined support (a distribution) goes into `combined`, one
    /// entry per motor action. Eq. (7).
    ///
    /// # Panics
    /// If nobody was heard, or if a weighted pool knows no weight for an agent (see [`Self::check`]).
    #[must_use]
    pub fn fuse(&self, opinions: &[Opinion<'_>], combined: &mut [f64]) -> usize {
        assert!(!opinions.is_empty(), "a fusion centre decides only after somebody was heard");
        combined.fill(0.0);
        match self {
            Self::MaxConfidence => max_confidence(opinions, combined),
            Self::LogOpinionPool => log_pool(opinions, POOL_FLOOR, |_| 1.0, combined),
            Self::WeightedLogOpinionPool { weights } => {
                log_pool(opinions, POOL_FLOOR, |agent| weights[agent], combined);
            }
            Self::Sum => sum(opinions, combined),
            Self::Product => product(opinions, combined),
            Self::Borda => borda(opinions, combined),
            Self::Majority => majority(opinions, combined),
            Self::Owa { weights } => ordered_average(opinions, weights, combined),
        }
        scale_to_one(combined);
        match self {
            Self::MaxConfidence => most_confident(opinions).proposal,
            _ => num::argmax(combined),
        }
    }
}

fn check_weights(weights: &[f64]) -> Result<(), FuserError> {
    if let Some(index) = weights.iter().position(|w| !w.is_finite() || *w < 0.0) {
        return Err(FuserError::Weight { index, value: weights[index] });
    }
    if weights.iter().any(|&w| w > 0.0) { Ok(()) } else { Err(FuserError::NoWeight) }
}

/// The opinion of the most confident agent; the lowest agent wins a tie.
fn most_confident<'a, 'b>(opinions: &'b [Opinion<'a>]) -> &'b Opinion<'a> {
    opinions.iter().fold(&opinions[0], |best, opinion| {
        let order = opinion.confidence().total_cmp(&best.confidence());
        if order.then(best.agent.cmp(&opinion.agent)).is_gt() { opinion } else { best }
    })
}

/// Every action is worth the best confidence with which it was proposed.
fn max_confidence(opinions: &[Opinion<'_>], combined: &mut [f64]) {
    for opinion in opinions {
        combined[opinion.proposal] = combined[opinion.proposal].max(opinion.confidence());
    }
}

/// p[a] ∝ exp Σⱼ wⱼ ln max(Pⱼ[a], floor)
fn log_pool(opinions: &[Opinion<'_>], floor: f64, weight: impl Fn(usize) -> f64, combined: &mut [f64]) {
    for opinion in opinions {
        let w = weight(opinion.agent);
        for (c, &p) in combined.iter_mut().zip(opinion.support) {
            *c += w * num::ln(p.max(floor));
        }
    }
    num::soft_max(combined, 1.0);
}

fn sum(opinions: &[Opinion<'_>], combined: &mut [f64]) {
    for opinion in opinions {
        for (c, &p) in combined.iter_mut().zip(opinion.support) {
            *c += p;
        }
    }
}

fn product(opinions: &[Opinion<'_>], combined: &mut [f64]) {
    let vetoed = |a: usize| opinions.iter().any(|o| o.support[a] <= 0.0);
    if (0..combined.len()).all(vetoed) {
        return sum(opinions, combined);
    }
    log_pool(opinions, 0.0, |_| 1.0, combined);
}

fn borda(opinions: &[Opinion<'_>], combined: &mut [f64]) {
    for opinion in opinions {
        for (c, &p) in combined.iter_mut().zip(opinion.support) {
            let beaten = opinion.support.iter().filter(|&&other| other < p).count();
            let equal = opinion.support.iter().filter(|&other| other.total_cmp(&p).is_eq()).count();
            *c += beaten as f64 + (equal as f64 - 1.0) / 2.0;
        }
    }
}

fn majority(opinions: &[Opinion<'_>], combined: &mut [f64]) {
    for opinion in opinions {
        combined[opinion.proposal] += 1.0;
    }
}

fn ordered_average(opinions: &[Opinion<'_>], weights: &[f64], combined: &mut [f64]) {
    let n = opinions.len();
    for (a, c) in combined.iter_mut().enumerate() {
        for opinion in opinions {
            let rank = opinions.iter().filter(|o| speaks_before(o, opinion, a)).count();
            *c += share(weights, rank, n) * opinion.support[a];
        }
    }
}

/// Whether `one` stands before `other` when the supports of `action` are sorted from the largest.
fn speaks_before(one: &Opinion<'_>, other: &Opinion<'_>, action: usize) -> bool {
    let order = other.support[action].total_cmp(&one.support[action]);
    order.then(one.agent.cmp(&other.agent)).is_lt()
}

/// Weight of the `rank`-th of `n` supports: W((rank + 1)/n) − W(rank/n),  W: cumulative weights scaled to sum 1.
fn share(weights: &[f64], rank: usize, n: usize) -> f64 {
    let total: f64 = weights.iter().sum();
    (cumulative(weights, (rank + 1) as f64 / n as f64) - cumulative(weights, rank as f64 / n as f64)) / total
}

/// Sum of the first share `part` (0 … 1) of `weights`, linear in between.
fn cumulative(weights: &[f64], part: f64) -> f64 {
    let place = part * weights.len() as f64;
    weights.iter().enumerate().map(|(i, &w)| w * (place - i as f64).clamp(0.0, 1.0)).sum()
}

/// Scales non-negative entries to sum 1; nothing at all becomes the uniform distribution.
fn scale_to_one(values: &mut [f64]) {
    let total: f64 = values.iter().sum();
    let n = values.len() as f64;
    for v in values {
        *v = if total > 0.0 { *v / total } else { 1.0 / n };
    }
}

#[cfg(test)]
mod tests;
