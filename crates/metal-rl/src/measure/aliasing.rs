//! How likely two different physical states look alike in the decision space. Sec. 6.1, Eqs. (13)-(26), Table 3.
//!
//! Three kinds of numbers are easily mixed up: `features` is the k of Eqs. (13)-(16), what one tiny agent sees;
//! `merged_states` is the k of Eqs. (22)-(26), called AliasedNo in Eq. (21): how many physical states look the same
//! to a tiny agent; `levels` is q, the quantisation of a value, be it called q_bel or q_dec (reading R61).
//!
//! The paper's Eq. (24) contradicts itself and its own Table 3; the reading that reproduces all five rows is
//! r(n, q, 1) = 1 for 0 ≤ n ≤ q − 1 and else 0, with no special rule for n = 0 (reading R60).

use crate::num;
use serde::{Deserialize, Serialize};

/// Why there is no such number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AliasingError {
    /// One level tells nothing.
    #[error("{0} quantisation levels: at least 2 are needed")]
    TooFewLevels(usize),
    /// Nothing is merged.
    #[error("no merged states: a message stands for at least 1 state")]
    NoMergedStates,
    /// Nothing to choose.
    #[error("no motor actions: at least 1 is needed")]
    NoActions,
    /// Nobody or nothing observes.
    #[error("{agents} agents with {features} features observe nothing")]
    NothingObserved {
        /// Number of agents, l.
        agents: usize,
        /// Features per agent, k of Eq. (13).
        features: usize,
    },
    /// More work than anybody can want.
    #[error("{merged_states} merged states of {levels} levels: their product must not exceed {MAX_SUM}")]
    TooLarge {
        /// Levels, q.
        levels: usize,
        /// Merged states, k.
        merged_states: usize,
    },
}

/// Largest `levels` × `merged_states` that is computed (the work grows with its product with `merged_states`).
pub const MAX_SUM: usize = 1_000_000;

/// Natural logarithm of the number of perceptual states, ln |S_per|. Eq. (13); the n × n maze of Eq. (14) has n
/// levels, two agents and one feature each.
///
/// # Formula
/// ln |S_per| = l k ln q,  l: `agents`, k: `features` per agent, q: `levels` per feature
///
/// # Errors
/// If `levels` < 2 or nothing is observed.
pub fn ln_perceptual_states(levels: usize, agents: usize, features: usize) -> Result<f64, AliasingError> {
    check_levels(levels)?;
    if agents == 0 || features == 0 {
        return Err(AliasingError::NothingObserved { agents, features });
    }
    Ok(agents as f64 * features as f64 * num::ln(levels as f64))
}

/// Natural logarithm of the number of decision states, ln |S_dec|. Eq. (15).
///
/// # Formula
/// ln |S_dec| = l |A| ln q,  l: `agents`, |A|: `actions`, q: `levels` per degree of support
///
/// # Errors
/// If `levels` < 2 or there are no agents or actions.
pub fn ln_decision_states(levels: usize, agents: usize, actions: usize) -> Result<f64, AliasingError> {
    if actions == 0 {
        return Err(AliasingError::NoActions);
    }
    ln_perceptual_states(levels, agents, actions)
}

/// Levels the decision space needs to have as many states as the perceptual space: the necessary condition for the
/// least ambiguity, q_dec of Eq. (16).
///
/// # Formula
/// q_dec = exp(k ln(q_per) / |A|),  k: `features` per agent, |A|: `actions`
///
/// # Errors
/// If `perceptual_levels` < 2, or there are no features or actions.
pub fn required_decision_levels(
    perceptual_levels: usize,
    features: usize,
    actions: usize,
) -> Result<f64, AliasingError> {
    if actions == 0 {
        return Err(AliasingError::NoActions);
    }
    Ok(num::exp(ln_perceptual_states(perceptual_levels, 1, features)? / actions as f64))
}

/// Largest sum C₁ of quantised values either side of Eq. (21) can reach. Eq. (25).
///
/// # Formula
/// C₁ ≤ (q − 1) max(AliasedNo₁, AliasedNo₂)
///
/// # Errors
/// If `levels` < 2 or a message stands for no state.
pub fn largest_sum(levels: usize, merged_states: [usize; 2]) -> Result<usize, AliasingError> {
    check_sums(levels, merged_states[0])?;
    check_sums(levels, merged_states[1])?;
    Ok((levels - 1) * merged_states[0].max(merged_states[1]))
}

/// Number of ways to write n as an ordered sum of `merged_states` values of 0 … `levels` − 1 each: r(n, q, k) for
/// n = 0 … k(q − 1), or `None` if one of them exceeds 128 bits. Eqs. (23, 24).
///
/// # Errors
/// If `levels` < 2, `merged_states` is 0, or the numbers are absurdly large.
pub fn ways(levels: usize, merged_states: usize) -> Result<Option<Vec<u128>>, AliasingError> {
    check_sums(levels, merged_states)?;
    let mut row = vec![1_u128; levels];
    for _ in 1..merged_states {
        match next_ways(&row, levels) {
            Some(next) => row = next,
            None => return Ok(None),
        }
    }
    Ok(Some(row))
}

/// One step of the recursion r(n, q, k) = Σᵢ r(n − i, q, k − 1), as a sliding window. Eq. (23).
fn next_ways(row: &[u128], levels: usize) -> Option<Vec<u128>> {
    let mut window = 0_u128;
    let mut next = Vec::with_capacity(row.len() + levels - 1);
    for n in 0..row.len() + levels - 1 {
        window = window.checked_add(row.get(n).copied().unwrap_or(0))?;
        if n >= levels {
            window -= row[n - levels];
        }
        next.push(window);
    }
    Some(next)
}

/// Probability p₀ that two independent sums of `merged_states` uniform values of `levels` levels are equal, as an
/// exact fraction (numerator, denominator), or `None` if it does not fit 128 bits. Eq. (22).
///
/// # Errors
/// If `levels` < 2, `merged_states` is 0, or the numbers are absurdly large.
pub fn exact_collision(levels: usize, merged_states: usize) -> Result<Option<(u128, u128)>, AliasingError> {
    let Some(row) = ways(levels, merged_states)? else { return Ok(None) };
    let squares = row.iter().try_fold(0_u128, |sum, r| sum.checked_add(r.checked_mul(*r)?));
    let all = u32::try_from(2 * merged_states).ok().and_then(|k| (levels as u128).checked_pow(k));
    Ok(squares.zip(all))
}

/// Probability p₀ that two independent sums of `merged_states` uniform values of `levels` levels are equal: exact to
/// the last bits where 128-bit integers suffice, a convolution of probabilities beyond. Eq. (22).
///
/// # Formula
/// p₀ = Σₙ (r(n, q, k) / qᵏ)²,  n = 0 … k(q − 1)
///
/// # Errors
/// If `levels` < 2, `merged_states` is 0, or the numbers are absurdly large.
pub fn collision(levels: usize, merged_states: usize) -> Result<f64, AliasingError> {
    Ok(match exact_collision(levels, merged_states)? {
        Some((numerator, denominator)) => numerator as f64 / denominator as f64,
        None => convolved_collision(levels, merged_states),
    })
}

/// Eq. (22) by repeated convolution of the distribution of the sum. All terms are positive, so nothing cancels.
fn convolved_collision(levels: usize, merged_states: usize) -> f64 {
    let mut row = vec![1.0 / levels as f64; levels];
    for _ in 1..merged_states {
        row = next_distribution(&row, levels);
    }
    row.iter().map(|p| p * p).sum()
}

/// Distribution of the sum with one more uniform value. Each window starts afresh every `levels` entries (a prefix
/// sum from the left and one from the right of the block), because subtracting would lose the small tails.
fn next_distribution(row: &[f64], levels: usize) -> Vec<f64> {
    let blocks = (row.len() + levels).div_ceil(levels);
    let mut padded = row.to_vec();
    padded.resize(blocks * levels, 0.0);
    let (mut before, mut after) = (padded.clone(), padded);
    for n in 1..before.len() {
        if n % levels != 0 {
            before[n] += before[n - 1];
        }
    }
    for n in (0..after.len() - 1).rev() {
        if (n + 1) % levels != 0 {
            after[n] += after[n + 1];
        }
    }
    let window = |n: usize| match n.checked_sub(levels - 1) {
        Some(start) if start % levels == 0 => before[n],
        Some(start) => before[n] + after[start],
        None => before[n],
    };
    (0..row.len() + levels - 1).map(|n| window(n) / levels as f64).collect()
}

/// Upper bounds of the probability that two states, different to one tiny agent only, are aliased. Table 3.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AliasingBound {
    /// Probability that the supports of one action agree, p₀ of Eq. (22).
    pub collision: f64,
    /// p₀^|A|, the paper's figure: all actions agree, taken as independent. Eqs. (20, 26).
    pub all_actions: f64,
    /// p₀^(|A| − 1): supports sum to 1, so the last one follows from the others. The defensible figure
    /// (reading R63).
    pub free_actions: f64,
}

/// The bound for tiny agents that merge `merged_states` states, values of `levels` levels and `actions` motor
/// actions. Eq. (20) for the one agent that can tell the states apart (reading R62), Eq. (26).
///
/// # Errors
/// If `levels` < 2, `merged_states` or `actions` is 0, or the numbers are absurdly large.
pub fn bound(levels: usize, merged_states: usize, actions: usize) -> Result<AliasingBound, AliasingError> {
    if actions == 0 {
        return Err(AliasingError::NoActions);
    }
    let collision = collision(levels, merged_states)?;
    let power = |n: usize| num::pow(collision, n as f64);
    Ok(AliasingBound { collision, all_actions: power(actions), free_actions: power(actions - 1) })
}

/// A printed number and one unit of its last digit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Printed {
    /// The number.
    pub value: f64,
    /// One unit in its last digit.
    pub unit: f64,
}

impl Printed {
    /// Whether `computed` agrees, rounded or truncated: it lies within one unit of the last digit.
    #[must_use]
    pub fn agrees_with(self, computed: f64) -> bool {
        (computed - self.value).abs() < self.unit
    }
}

/// One row of Table 3 as printed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Table3Row {
    /// Maximum probability of aliasing.
    pub aliasing: Printed,
    /// p₀.
    pub collision: Printed,
    /// k, the number of merged states.
    pub merged_states: usize,
    /// q_bel, the number of levels (the paper's q_dec and q_bel are one number here).
    pub levels: usize,
    /// |A|, the number of motor actions.
    pub actions: usize,
}

const fn printed(value: f64, unit: f64) -> Printed {
    Printed { value, unit }
}

const fn row(aliasing: Printed, collision: Printed, [k, q, a]: [usize; 3]) -> Table3Row {
    Table3Row { aliasing, collision, merged_states: k, levels: q, actions: a }
}

/// Table 3 as printed.
pub const TABLE_3: [Table3Row; 5] = [
    row(printed(0.1234, 1e-4), printed(0.1234, 1e-4), [4, 4, 1]),
    row(printed(2.32e-4, 1e-6), printed(0.1234, 1e-4), [4, 4, 4]),
    row(printed(5.1e-7, 1e-8), printed(0.055, 1e-3), [3, 10, 5]),
    row(printed(9.71e-8, 1e-10), printed(0.0396, 1e-4), [6, 10, 5]),
    row(printed(1.07e-5, 1e-7), printed(0.10, 1e-2), [6, 4, 5]),
];

fn check_levels(levels: usize) -> Result<(), AliasingError> {
    if levels < 2 { Err(AliasingError::TooFewLevels(levels)) } else { Ok(()) }
}

fn check_sums(levels: usize, merged_states: usize) -> Result<(), AliasingError> {
    check_levels(levels)?;
    if merged_states == 0 {
        return Err(AliasingError::NoMergedStates);
    }
    match levels.checked_mul(merged_states) {
        Some(size) if size <= MAX_SUM => Ok(()),
        _ => Err(AliasingError::TooLarge { levels, merged_states }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Eq. (23) word for word, with the base case that reproduces Table 3.
    fn r(n: usize, q: usize, k: usize) -> u128 {
        if k == 1 {
            return u128::from(n < q);
        }
        (0..=n.min(q - 1)).map(|i| r(n - i, q, k - 1)).sum()
    }

    #[test]
    fn all_five_rows_of_table_3_are_reproduced() {
        for row in TABLE_3 {
            let ours = bound(row.levels, row.merged_states, row.actions).unwrap();
            assert!(row.collision.agrees_with(ours.collision), "{row:?}: {ours:?}");
            assert!(row.aliasing.agrees_with(ours.all_actions), "{row:?}: {ours:?}");
        }
    }

    #[test]
    fn the_defensible_figure_is_still_small() {
        let free: Vec<f64> = TABLE_3
            .iter()
            .map(|r| bound(r.levels, r.merged_states, r.actions).unwrap().free_actions)
            .collect();
        for (ours, expected) in free.iter().zip([1.0, 1.882e-3, 9.32e-6, 2.454e-6, 1.063e-4]) {
            assert!((ours / expected - 1.0).abs() < 1e-3, "{ours} is not {expected}");
        }
    }

    #[test]
    fn the_window_equals_the_recursion_of_equation_23() {
        for (q, k) in [(2, 1), (2, 5), (4, 4), (10, 3), (3, 6)] {
            let row = ways(q, k).unwrap().unwrap();
            let literal: Vec<u128> = (0..=k * (q - 1)).map(|n| r(n, q, k)).collect();
            assert_eq!(row, literal);
        }
    }

    #[test]
    fn beyond_128_bits_the_convolution_takes_over_smoothly() {
        assert_eq!(exact_collision(10, 100).unwrap(), None);
        let asymptote = (3.0 / (std::f64::consts::PI * 100.0 * 99.0)).sqrt();
        assert!((collision(10, 100).unwrap() / asymptote - 1.0).abs() < 2e-3);
    }

    #[test]
    fn the_maze_of_equation_14_has_n_squared_states() {
        assert!((num::exp(ln_perceptual_states(4, 2, 1).unwrap()) - 16.0).abs() < 1e-12);
    }

    #[test]
    fn with_the_required_levels_both_spaces_are_equally_large() {
        // A vision agent has 4 features, the infrared agent 8; 10 levels each, 5 motor actions.
        assert!((required_decision_levels(10, 4, 5).unwrap() - 6.3096).abs() < 1e-4);
        assert!((required_decision_levels(10, 8, 5).unwrap() - 39.8107).abs() < 1e-4);
        assert_eq!(ln_perceptual_states(10, 7, 5), ln_decision_states(10, 7, 5));
    }

    #[test]
    fn impossible_questions_are_refused() {
        assert_eq!(collision(1, 4), Err(AliasingError::TooFewLevels(1)));
        assert_eq!(collision(4, 0), Err(AliasingError::NoMergedStates));
        assert_eq!(bound(4, 4, 0), Err(AliasingError::NoActions));
        assert_eq!(
            ln_perceptual_states(4, 0, 2),
            Err(AliasingError::NothingObserved { agents: 0, features: 2 })
        );
        let huge = AliasingError::TooLarge { levels: usize::MAX, merged_states: 2 };
        assert_eq!(collision(usize::MAX, 2), Err(huge));
    }

    #[test]
    fn sums_reach_as_far_as_equation_25_says() {
        assert_eq!(largest_sum(4, [3, 6]), Ok(18));
        assert_eq!(ways(4, 6).unwrap().unwrap().len(), 18 + 1);
    }

    proptest! {
        #[test]
        fn the_exact_and_the_convolved_probability_agree(q in 2..12_usize, k in 1..12_usize) {
            if let Some((numerator, denominator)) = exact_collision(q, k).unwrap() {
                let exact = numerator as f64 / denominator as f64;
                prop_assert!((convolved_collision(q, k) / exact - 1.0).abs() < 1e-13);
                prop_assert!(exact <= 1.0 / q as f64 + 1e-15);
            }
        }

        #[test]
        fn ways_add_up_to_all_placements(q in 2..9_usize, k in 1..10_usize) {
            let total: u128 = ways(q, k).unwrap().unwrap().iter().sum();
            prop_assert_eq!(total, (q as u128).pow(k as u32));
        }

        #[test]
        fn more_merged_states_or_levels_collide_less(q in 2..9_usize, k in 1..9_usize) {
            prop_assert!(collision(q, k + 1).unwrap() < collision(q, k).unwrap());
            prop_assert!(collision(q + 1, k).unwrap() < collision(q, k).unwrap());
        }
    }
}
