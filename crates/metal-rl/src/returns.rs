//! Targets of learning: temporal-difference errors and λ-returns over the moments an agent actually saw. Eqs. (3, 4).

use serde::{Deserialize, Serialize};

/// How credit flows back in time; readings R3 and R4.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Credit {
    /// Discount γ per motor action, in [0, 1). Looks take no time and are never discounted.
    pub gamma: f64,
    /// Share λ of the observed continuation against the current estimate, in [0, 1]; 0 is one-step Q-learning.
    pub lambda: f64,
}

impl Default for Credit {
    fn default() -> Self {
        Self { gamma: 0.9, lambda: 0.7 }
    }
}

/// One moment at which an agent saw its state, and what happened until it saw again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link {
    /// Reward from this moment to the next one seen, discounted to this moment.
    pub reward: f64,
    /// γ to the number of motor actions until the next moment seen.
    pub discount: f64,
    /// Estimated value of the next moment seen (0 if the world ended there).
    pub next_value: f64,
}

/// λ-returns of a chain of links, into `out` (same length).
///
/// # Formula
/// G\[k\] = R\[k\] + Γ\[k\] · ((1 − λ) · V\[k+1\] + λ · G\[k+1\]),  with G = V behind the last link.
/// λ = 0: the one-step target of Q-learning (R + Γ max Q), λ = 1: what was really earned.
///
/// # Panics
/// If the lengths differ.
pub fn lambda_returns(links: &[Link], lambda: f64, out: &mut [f64]) {
    assert_eq!(links.len(), out.len(), "one return per link");
    let mut following = links.last().map_or(0.0, |l| l.next_value);
    for (link, g) in links.iter().zip(out).rev() {
        following = link.reward + link.discount * ((1.0 - lambda) * link.next_value + lambda * following);
        *g = following;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chain() -> Vec<Link> {
        vec![
            Link { reward: -1.0, discount: 0.9, next_value: -5.0 },
            Link { reward: -2.0, discount: 0.81, next_value: -7.0 },
            Link { reward: -4.0, discount: 0.9, next_value: -10.0 },
        ]
    }

    #[test]
    fn zero_lambda_is_the_one_step_target() {
        let mut out = [0.0; 3];
        lambda_returns(&chain(), 0.0, &mut out);
        assert_eq!(out, [-1.0 - 4.5, -2.0 - 0.81 * 7.0, -13.0]);
    }

    #[test]
    fn full_lambda_is_what_was_earned() {
        let mut out = [0.0; 3];
        lambda_returns(&chain(), 1.0, &mut out);
        assert!((out[0] - (-1.0 + 0.9 * (-2.0 + 0.81 * (-4.0 + 0.9 * -10.0)))).abs() < 1e-12);
    }

    #[test]
    fn a_terminal_end_is_worth_nothing() {
        let mut out = [0.0; 1];
        lambda_returns(&[Link { reward: -3.0, discount: 0.9, next_value: 0.0 }], 0.7, &mut out);
        assert_eq!(out, [-3.0]);
    }
}
