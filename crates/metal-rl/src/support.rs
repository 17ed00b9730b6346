//! Degree of support of the motor actions, and its three levels of detail (Sec. 3.1.1).

use crate::num;
use serde::{Deserialize, Serialize};

/// What a tiny agent tells: the three levels of the decision space (Sec. 3.1.1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SupportLevel {
    /// Only the best action: 1 there, 0 elsewhere.
    BestAction,
    /// The order of the actions: rank points (n − 1 for the best … 0), scaled to sum 1.
    Ranking,
    /// The degree of support of every action. Eq. (11); the paper's choice.
    #[default]
    DegreeOfSupport,
}

impl SupportLevel {
    /// Reduces a degree-of-support vector to this level, in place. Ties favour the lower index.
    pub fn reduce(self, support: &mut [f64]) {
        match self {
            Self::DegreeOfSupport => {}
            Self::BestAction => {
                let best = num::argmax(support);
                support.fill(0.0);
                support[best] = 1.0;
            }
            Self::Ranking => rank_points(support),
        }
    }
}

/// Replaces each entry by the share of rank points it earns (Borda's count scaled to sum 1).
fn rank_points(support: &mut [f64]) {
    let n = support.len();
    if n < 2 {
        support.fill(1.0);
        return;
    }
    let original: Vec<f64> = support.to_vec();
    let total = (n * (n - 1) / 2) as f64;
    for (i, out) in support.iter_mut().enumerate() {
        let beaten =
            (0..n).filter(|&j| original[j] < original[i] || (original[j] == original[i] && j > i)).count();
        *out = beaten as f64 / total;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_keep_the_best_action_and_sum_to_one() {
        for level in [SupportLevel::BestAction, SupportLevel::Ranking, SupportLevel::DegreeOfSupport] {
            let mut support = [0.2, 0.5, 0.2, 0.1];
            level.reduce(&mut support);
            assert_eq!(num::argmax(&support), 1);
            assert!((support.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn ranking_forgets_how_far_apart_supports_are() {
        let (mut a, mut b) = ([0.1, 0.2, 0.7], [0.01, 0.02, 0.97]);
        SupportLevel::Ranking.reduce(&mut a);
        SupportLevel::Ranking.reduce(&mut b);
        assert_eq!(a, b);
    }
}
