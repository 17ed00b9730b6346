//! How often and in which order the mind looks before it moves. Fig. 9, Table 1.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Looks of one block of training. Fig. 9.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LookBlock {
    /// First motor step of the block.
    pub first_step: usize,
    /// Motor steps in the block.
    pub steps: usize,
    /// Share of motor steps with 0, 1, 2 … looks.
    pub shares: Vec<f64>,
    /// Looks per motor step.
    pub mean: f64,
}

/// Histogram of looks per motor step over consecutive blocks of `block` motor steps. Fig. 9.
///
/// `looks` holds the number of looks of every motor step, `most` the largest possible number (all sensors); bins are
/// 0 … `most`. An incomplete last block counts with what it has.
///
/// # Panics
/// If `block` is 0 or a step has more than `most` looks.
#[must_use]
pub fn histogram(looks: &[usize], block: usize, most: usize) -> Vec<LookBlock> {
    assert!(block > 0, "a block holds at least one motor step");
    looks.chunks(block).enumerate().map(|(i, part)| look_block(i * block, part, most)).collect()
}

fn look_block(first_step: usize, looks: &[usize], most: usize) -> LookBlock {
    let steps = looks.len();
    let mut counts = vec![0_usize; most + 1];
    for &n in looks {
        assert!(n <= most, "{n} looks in one motor step, but at most {most} are possible");
        counts[n] += 1;
    }
    let shares = counts.iter().map(|&c| c as f64 / steps as f64).collect();
    LookBlock { first_step, steps, shares, mean: looks.iter().sum::<usize>() as f64 / steps as f64 }
}

/// Looks per motor step; none without a step. "The final average of perceptions is as low as 2.1 out of 7" (Sec. 4.4).
#[must_use]
pub fn average(looks: &[usize]) -> Option<f64> {
    (!looks.is_empty()).then(|| looks.iter().sum::<usize>() as f64 / looks.len() as f64)
}

/// A sequence of looks and how often it was taken. Table 1.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SequenceCount {
    /// Indices of those consulted, in order of consultation.
    pub sequence: Vec<usize>,
    /// Motor steps that were prepared like this.
    pub count: usize,
}

/// Counts sequences of looks, the most frequent first (equally frequent: in lexical order). Table 1.
#[must_use]
pub fn sequences<'a>(steps: impl IntoIterator<Item = &'a [usize]>) -> Vec<SequenceCount> {
    let mut counts: BTreeMap<&[usize], usize> = BTreeMap::new();
    for sequence in steps {
        *counts.entry(sequence).or_default() += 1;
    }
    let mut all: Vec<_> =
        counts.into_iter().map(|(s, count)| SequenceCount { sequence: s.to_vec(), count }).collect();
    all.sort_by_key(|s| std::cmp::Reverse(s.count));
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_hold_shares() {
        let blocks = histogram(&[0, 2, 2, 1, 2], 4, 2);
        assert_eq!(
            blocks[0],
            LookBlock { first_step: 0, steps: 4, shares: vec![0.25, 0.25, 0.5], mean: 1.25 }
        );
        assert_eq!(blocks[1], LookBlock { first_step: 4, steps: 1, shares: vec![0.0, 0.0, 1.0], mean: 2.0 });
    }

    #[test]
    fn no_step_has_no_average() {
        assert_eq!(average(&[]), None);
        assert_eq!(average(&[2, 3]), Some(2.5));
    }

    #[test]
    fn order_makes_a_sequence() {
        let steps: [&[usize]; 5] = [&[0, 1], &[1, 0], &[], &[0, 1], &[1, 0]];
        let counted = sequences(steps);
        let order: Vec<_> = counted.iter().map(|c| (c.sequence.as_slice(), c.count)).collect();
        assert_eq!(order, [(&[0, 1][..], 2), (&[1, 0][..], 2), (&[][..], 1)]);
    }
}
