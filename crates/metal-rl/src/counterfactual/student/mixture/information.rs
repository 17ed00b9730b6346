//! The value of information: by how much the best move is expected to be worth more once a reading is known, before it
//! is known which one it will be (preposterior analysis).
//!
//! Readings of a member are sorted into a few kinds, its codewords, so that an expectation is a short sum and needs no
//! samples. A word tells which component it is, and what moves are worth within one; the latter is taken from all moments
//! of the component, as if what is known already told nothing of it.
//!
//! # Formula
//! gain(i) = Σ_w max_a Σ_c r_c P(w | c) (m_c(a) + δ_cw(a)) − max_a Σ_c r_c m_c(a),  Σ_w P(w | c) δ_cw(a) = 0

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
    /// By slot, none if it is never looked at.
    tables: Vec<Option<Table>>,
    words: usize,
}

/// What one member may be expected to show.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct Table {
    /// Component × codeword: P(w | c).
    frequencies: Vec<f64>,
    /// Component × codeword × move: P(w | c) δ_cw(a), in the unit of advantages.
    surprises: Vec<f64>,
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
            codebook.table((density.components(), blocks.targets()), moments, &shares, prior)
        };
        let tables = (0..slots).map(|slot| blocks.reading(slot).map(|range| table(range, rng))).collect();
        Self { tables, words }
    }

    /// Whether this is about so many components, slots and codewords.
    pub fn is_sound(&self, components: usize, slots: usize, words: usize) -> bool {
        let whole = |table: &Table| {
            let (pairs, moves) = (components * words, table.surprises.len() / (components * words).max(1));
            table.frequencies.len() == pairs && table.surprises.len() == pairs * moves
        };
        self.words == words && self.tables.len() == slots && self.tables.iter().flatten().all(whole)
    }

    /// Changes the unit of advantages.
    pub fn rescale(&mut self, gain: f64) {
        self.tables.iter_mut().flatten().flat_map(|t| &mut t.surprises).for_each(|delta| *delta *= gain);
    }

    /// By how much a look at `slot` is expected to raise the worth of the best move. `active` are components with their
    /// shares, each with what it holds the moves to be worth in `opinions`; `worth` is room for a number per move.
    pub fn gain(&self, slot: usize, active: &[(usize, f64)], opinions: &[f64], worth: &mut [f64]) -> f64 {
        let Some(Some(table)) = self.tables.get(slot) else { return 0.0 };
        let (moves, words) = (worth.len(), self.words);
        let largest = |worth: &[f64]| worth.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let opinions = || active.iter().zip(opinions.chunks_exact(moves));
        worth.fill(0.0);
        for (&(_, share), opinion) in opinions() {
            worth.iter_mut().zip(opinion).for_each(|(sum, value)| *sum += share * value);
        }
        let now = largest(worth);
        let mut then = 0.0;
        for word in 0..words {
            worth.fill(0.0);
            for (&(c, share), opinion) in opinions() {
                let at = c * words + word;
                let (frequency, surprise) = (table.frequencies[at], &table.surprises[at * moves..][..moves]);
                for ((sum, value), delta) in worth.iter_mut().zip(opinion).zip(surprise) {
                    *sum += share * (frequency * value + delta);
                }
            }
            then += largest(worth);
        }
        then - now
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

    /// How often each codeword is shown, with one observation of what all components show together; and what the moves
    /// are worth then, with as many observations as the prior's that say: as always.
    fn table(
        &self,
        (components, targets): (usize, std::ops::Range<usize>),
        moments: &Moments,
        shares: &[Vec<(usize, f64)>],
        prior: &Prior,
    ) -> Table {
        let (words, moves) = (self.words.len(), targets.len());
        let mut counts = vec![0.0; components * words];
        let (mut all, mut sums) = (vec![0.0; words], vec![0.0; components * words * moves]);
        for (n, active) in shares.iter().enumerate() {
            let x = moments.row(n).0;
            let word = self.word(&x[self.range.clone()]);
            all[word] += 1.0 / shares.len() as f64;
            for &(c, share) in active {
                let at = c * words + word;
                counts[at] += share;
                let sums = &mut sums[at * moves..(at + 1) * moves];
                sums.iter_mut().zip(&x[targets.clone()]).for_each(|(sum, y)| *sum += share * y);
            }
        }
        let mut table = Table { frequencies: vec![0.0; components * words], surprises: sums };
        for c in 0..components {
            let place = c * words..(c + 1) * words;
            let mass: f64 = counts[place.clone()].iter().sum();
            for (at, all) in place.clone().zip(&all) {
                table.frequencies[at] = (counts[at] + all) / (mass + 1.0);
            }
            let surprises = &mut table.surprises[c * words * moves..(c + 1) * words * moves];
            let frequencies = &table.frequencies[place.clone()];
            centre(surprises, &counts[place], (frequencies, moves), prior.count);
        }
        table
    }
}

/// Turns sums of what moves were worth in one component, codeword × move, into P(w) δ_w.
fn centre(surprises: &mut [f64], counts: &[f64], (frequencies, moves): (&[f64], usize), prior: f64) {
    let mass = counts.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    for a in 0..moves {
        let places = || (a..counts.len() * moves).step_by(moves);
        let mean = places().map(|at| surprises[at]).sum::<f64>() / mass;
        for (word, at) in places().enumerate() {
            let delta = (surprises[at] - counts[word] * mean) / (counts[word] + prior);
            surprises[at] = frequencies[word] * delta;
        }
        let rest = places().map(|at| surprises[at]).sum::<f64>();
        for (word, at) in places().enumerate() {
            surprises[at] -= frequencies[word] * rest;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two components, two codewords, two moves, and nothing to be told within a component.
    fn table(frequencies: &[f64]) -> Option<Table> {
        Some(Table { frequencies: frequencies.to_vec(), surprises: vec![0.0; 8] })
    }

    #[test]
    fn a_word_tells_what_moves_are_worth_within_a_component_too() {
        // Three moments with word 0 and (0, −10), one with word 1 and (−8, 0).
        let (mut surprises, frequencies) = (vec![0.0, -30.0, -8.0, 0.0], [0.75, 0.25]);
        centre(&mut surprises, &[3.0, 1.0], (&frequencies, 2), 1e-9);
        let table = Table { frequencies: frequencies.to_vec(), surprises };
        let information = Information { tables: vec![Some(table)], words: 2 };
        let gain = information.gain(0, &[(0, 1.0)], &[-2.0, -7.5], &mut [0.0; 2]);
        assert!(
            (gain - 2.0).abs() < 1e-6,
            "move 0 is worth −2 without it, and nothing is lost with it: {gain}"
        );
    }

    #[test]
    fn a_reading_that_tells_the_right_move_is_worth_what_it_saves_and_another_nothing() {
        // Slot 0 tells the component, slot 1 shows the same word in half of the cases whatever the component.
        let tables = vec![table(&[1.0, 0.0, 0.0, 1.0]), table(&[0.5; 4]), None];
        let information = Information { tables, words: 2 };
        let (active, opinions) = ([(0, 0.6), (1, 0.4)], [0.0, -10.0, -10.0, 0.0]);
        let mut worth = [0.0; 2];
        let mut gain = |slot: usize| information.gain(slot, &active, &opinions, &mut worth);
        // Without it move 0 is worth −4, with it the right move is worth 0.
        assert!((gain(0) - 4.0).abs() < 1e-12);
        assert!(gain(1).abs() < 1e-12 && gain(2).abs() < 1e-12);
    }

    #[test]
    fn half_a_hint_is_worth_less() {
        let information = Information { tables: vec![table(&[0.8, 0.2, 0.2, 0.8])], words: 2 };
        let gain = information.gain(0, &[(0, 0.5), (1, 0.5)], &[0.0, -10.0, -10.0, 0.0], &mut [0.0; 2]);
        assert!((gain - 3.0).abs() < 1e-12, "8 of 10 times right: −2 instead of −5: {gain}");
    }
}
