//! The value of information: by how much the best move is expected to be worth more once a reading is known, before it
//! is known which one it will be (preposterior analysis).
//!
//! Readings of a member are sorted into a few kinds, its codewords, so that an expectation is a short sum and needs no
//! samples. A sorted reading tells no more than the reading itself, so this is a lower bound.
//!
//! # Formula
//! gain(i) = Σ_w max_a Σ_c r_c P(w | c) m_c(a) − max_a Σ_c r_c m_c(a)

use super::blocks::Blocks;
use super::density::{Belief, Density};
use super::em::{Moments, Prior};
use crate::random::Rng;
use serde::{Deserialize, Serialize};

/// Rounds in which codewords find their places.
const ROUNDS: usize = 8;

/// Moments that codewords are made from, at most.
const MOMENTS: usize = 3000;

/// What each member may be expected to show.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Information {
    /// By slot, none if it is never looked at: component × codeword, P(codeword | component).
    tables: Vec<Option<Vec<f64>>>,
    words: usize,
}

impl Information {
    /// The codewords of every slot and how often each component shows them.
    pub fn of(
        (blocks, words, slots): (&Blocks, usize, usize),
        density: &Density,
        (moments, prior): (&Moments, &Prior),
        rng: &mut Rng,
    ) -> Self {
        let shares = shares(density, moments);
        let table = |range: std::ops::Range<usize>, rng: &mut Rng| {
            let codebook = Codebook::new(range, words, moments, prior, rng);
            codebook.frequencies(density.components(), moments, &shares)
        };
        let tables = (0..slots).map(|slot| blocks.reading(slot).map(|range| table(range, rng))).collect();
        Self { tables, words }
    }

    /// Whether this is about so many components, slots and codewords.
    pub fn is_sound(&self, components: usize, slots: usize, words: usize) -> bool {
        let whole = |table: &Vec<f64>| table.len() == components * words;
        self.words == words && self.tables.len() == slots && self.tables.iter().flatten().all(whole)
    }

    /// By how much a look at `slot` is expected to raise the worth of the best move. `active` are components with their
    /// shares, each with what it holds the moves to be worth in `opinions`; `worth` is room for a number per move.
    pub fn gain(&self, slot: usize, active: &[(usize, f64)], opinions: &[f64], worth: &mut [f64]) -> f64 {
        let Some(Some(table)) = self.tables.get(slot) else { return 0.0 };
        let moves = worth.len();
        let best = |worth: &mut [f64], factor: &dyn Fn(usize) -> f64| {
            worth.fill(0.0);
            for (&(c, share), opinion) in active.iter().zip(opinions.chunks_exact(moves)) {
                let weight = share * factor(c);
                worth.iter_mut().zip(opinion).for_each(|(sum, value)| *sum += weight * value);
            }
            worth.iter().copied().fold(f64::NEG_INFINITY, f64::max)
        };
        let now = best(worth, &|_| 1.0);
        let then = |word: usize| best(worth, &|c| table[c * self.words + word]);
        (0..self.words).map(then).sum::<f64>() - now
    }
}

/// Shares of components in every moment, by what is known without the targets.
fn shares(density: &Density, moments: &Moments) -> Vec<Vec<(usize, f64)>> {
    let mut belief = Belief::default();
    let mut known = vec![false; density.blocks().len()];
    (0..moments.count)
        .map(|n| {
            let (x, seen) = moments.row(n);
            known.copy_from_slice(seen);
            known[seen.len() - 1] = false;
            density.infer(x, &known, &mut belief);
            belief.active.clone()
        })
        .collect()
}

/// Typical readings.
struct Codebook {
    range: std::ops::Range<usize>,
    gains: Vec<f64>,
    words: Vec<Vec<f64>>,
}

impl Codebook {
    /// Codewords by k-means, in standard deviations.
    fn new(
        range: std::ops::Range<usize>,
        words: usize,
        moments: &Moments,
        prior: &Prior,
        rng: &mut Rng,
    ) -> Self {
        let gains = prior.variances[range.clone()].iter().map(|v| 1.0 / v).collect();
        let any = |rng: &mut Rng| moments.row(rng.below(moments.count)).0[range.clone()].to_vec();
        let first = (0..words).map(|_| any(rng)).collect();
        let mut codebook = Self { range, gains, words: first };
        let compared = moments.count.min(MOMENTS);
        for _ in 0..ROUNDS {
            let mut sums = vec![vec![0.0; codebook.range.len()]; words];
            let mut counts = vec![0.0; words];
            for n in (0..compared).map(|i| i * moments.count / compared) {
                let x = &moments.row(n).0[codebook.range.clone()];
                let word = codebook.word(x);
                counts[word] += 1.0;
                sums[word].iter_mut().zip(x).for_each(|(sum, x)| *sum += x);
            }
            for word in (0..words).filter(|&word| counts[word] > 0.0) {
                codebook.words[word] = sums[word].iter().map(|sum| sum / counts[word]).collect();
            }
        }
        codebook
    }

    /// The codeword of a reading.
    fn word(&self, x: &[f64]) -> usize {
        let distance = |word: &[f64]| {
            let gaps = word.iter().zip(x).zip(&self.gains);
            gaps.map(|((w, x), gain)| gain * (w - x) * (w - x)).sum::<f64>()
        };
        let distances = self.words.iter().map(|word| distance(word)).enumerate();
        distances.fold((0, f64::INFINITY), |best, next| if next.1 < best.1 { next } else { best }).0
    }

    /// Component × codeword: how often it is shown, with one observation of what all show together.
    fn frequencies(&self, components: usize, moments: &Moments, shares: &[Vec<(usize, f64)>]) -> Vec<f64> {
        let (words, mut counts) = (self.words.len(), vec![0.0; components * self.words.len()]);
        let (mut masses, mut all) = (vec![0.0; components], vec![0.0; words]);
        for (n, active) in shares.iter().enumerate() {
            let word = self.word(&moments.row(n).0[self.range.clone()]);
            all[word] += 1.0 / shares.len() as f64;
            for &(c, share) in active {
                counts[c * words + word] += share;
                masses[c] += share;
            }
        }
        for c in 0..components {
            for word in 0..words {
                counts[c * words + word] = (counts[c * words + word] + all[word]) / (masses[c] + 1.0);
            }
        }
        counts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reading_that_tells_the_right_move_is_worth_what_it_saves_and_another_nothing() {
        // Slot 0 tells the component, slot 1 shows the same word in half of the cases whatever the component.
        let information =
            Information { tables: vec![Some(vec![1.0, 0.0, 0.0, 1.0]), Some(vec![0.5; 4]), None], words: 2 };
        let (active, opinions) = ([(0, 0.6), (1, 0.4)], [0.0, -10.0, -10.0, 0.0]);
        let mut worth = [0.0; 2];
        let mut gain = |slot: usize| information.gain(slot, &active, &opinions, &mut worth);
        // Without it move 0 is worth −4, with it the right move is worth 0.
        assert!((gain(0) - 4.0).abs() < 1e-12);
        assert!(gain(1).abs() < 1e-12 && gain(2).abs() < 1e-12);
    }

    #[test]
    fn half_a_hint_is_worth_less() {
        let hint = vec![0.8, 0.2, 0.2, 0.8];
        let information = Information { tables: vec![Some(hint)], words: 2 };
        let gain = information.gain(0, &[(0, 0.5), (1, 0.5)], &[0.0, -10.0, -10.0, 0.0], &mut [0.0; 2]);
        assert!((gain - 3.0).abs() < 1e-12, "8 of 10 times right: −2 instead of −5: {gain}");
    }
}
