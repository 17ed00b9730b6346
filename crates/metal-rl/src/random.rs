//! Named streams of random numbers, all from one seed.
//!
//! Each consumer asks for a stream by name, so a new consumer never shifts the numbers another one sees.
//! The generator is PCG-64 (`rand_pcg::Pcg64`), whose output is fixed by its authors; the first draws are pinned
//! by a test. Samplers are our own, on [`crate::num`], because those of the usual crate change bits with the
//! features other crates switch on.

use crate::num;
use rand_core::Rng as _;
use rand_pcg::Pcg64;
use serde::{Deserialize, Serialize};

/// A family of random streams grown from one seed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Streams {
    seed: u64,
}

impl Streams {
    /// The family of `seed`.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self { seed }
    }

    /// The family below `name`: its streams are independent of those of every other name.
    #[must_use]
    #[inline]
    pub fn child(&self, name: &str) -> Self {
        Self { seed: mix(self.seed ^ hash(name.as_bytes())) }
    }

    /// The family of the `index`-th sibling, e.g. an episode.
    #[must_use]
    #[inline]
    pub fn nth(&self, index: u64) -> Self {
        Self { seed: mix(self.seed.wrapping_add(mix(index.wrapping_add(0x9e37_79b9_7f4a_7c15)))) }
    }

    /// A generator of its own for the consumer `name`.
    #[must_use]
    #[inline]
    pub fn stream(&self, name: &str) -> Rng {
        Rng::new(self.child(name).seed)
    }

    /// The first [normal](Rng::normal) of the stream `name` of each sibling 0, 1, … N − 1: the same bits as one by one, in less
    /// time, because the draws don't wait for each other.
    #[inline]
    #[must_use]
    pub fn normals<const N: usize>(&self, name: &str) -> [f64; N] {
        let (mut normals, mut squares) = ([0.0; N], [0.0; N]);
        for (i, (normal, square)) in normals.iter_mut().zip(&mut squares).enumerate() {
            (*normal, _, *square) = self.nth(i as u64).stream(name).in_disc();
        }
        let logs = squares.map(num::ln);
        for ((normal, square), log) in normals.iter_mut().zip(squares).zip(logs) {
            *normal *= polar_factor(square, log);
        }
        normals
    }

    /// The seed of this family.
    #[must_use]
    pub fn seed(&self) -> u64 {
        self.seed
    }
}

/// FNV-1a, 64 bits: stable names to numbers.
#[inline]
fn hash(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |h, &b| (h ^ u64::from(b)).wrapping_mul(0x0000_0100_0000_01b3))
}

/// The finalizer of SplitMix64: every input bit reaches every output bit.
#[inline]
fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// One stream of random numbers (PCG-64).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rng {
    core: Pcg64,
    spare_normal: Option<f64>,
}

impl Rng {
    /// The stream of `seed`.
    #[must_use]
    #[inline]
    pub fn new(seed: u64) -> Self {
        let state = (u128::from(mix(seed)) << 64) | u128::from(mix(seed ^ 0xdead_beef_cafe_f00d));
        Self { core: Pcg64::new(state, u128::from(mix(seed.wrapping_add(1)))), spare_normal: None }
    }

    /// 64 random bits.
    #[inline]
    pub fn bits(&mut self) -> u64 {
        self.core.next_u64()
    }

    /// Uniform in [0, 1), 53 random bits.
    #[inline]
    pub fn uniform(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * (1.0 / 9_007_199_254_740_992.0)
    }

    /// Uniform in [`low`, `high`).
    #[inline]
    pub fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// Uniform in 0, 1, … `n` − 1 (without bias).
    ///
    /// # Panics
    /// If `n` is 0.
    pub fn below(&mut self, n: usize) -> usize {
        assert!(n > 0, "there is no number below 0");
        let n = n as u64;
        let zone = u64::MAX - u64::MAX % n;
        loop {
            let bits = self.bits();
            if bits < zone {
                return (bits % n) as usize;
            }
        }
    }

    /// True with probability `p`.
    pub fn chance(&mut self, p: f64) -> bool {
        self.uniform() < p
    }

    /// Standard normal (Marsaglia's polar method).
    pub fn normal(&mut self) -> f64 {
        if let Some(z) = self.spare_normal.take() {
            return z;
        }
        let (u, v, s) = self.in_disc();
        let factor = polar_factor(s, num::ln(s));
        self.spare_normal = Some(v * factor);
        u * factor
    }

    /// A point (u, v) of the open unit disc but its middle, and u² + v².
    #[inline]
    fn in_disc(&mut self) -> (f64, f64, f64) {
        loop {
            let (u, v) = (self.range(-1.0, 1.0), self.range(-1.0, 1.0));
            let s = u * u + v * v;
            if s > 0.0 && s < 1.0 {
                return (u, v, s);
            }
        }
    }

    /// Gamma with the given shape and scale 1 (Marsaglia and Tsang 2000).
    pub fn gamma(&mut self, shape: f64) -> f64 {
        if shape < 1.0 {
            let boost = num::pow(1.0 - self.uniform(), 1.0 / shape);
            return self.gamma(shape + 1.0) * boost;
        }
        let d = shape - 1.0 / 3.0;
        let c = 1.0 / (9.0 * d).sqrt();
        loop {
            let x = self.normal();
            let t = 1.0 + c * x;
            if t <= 0.0 {
                continue;
            }
            let v = t * t * t;
            let u = 1.0 - self.uniform();
            if num::ln(u) < 0.5 * x * x + d - d * v + d * num::ln(v) {
                return d * v;
            }
        }
    }

    /// Fills `out` with a Dirichlet sample of concentrations `alpha` (same length).
    ///
    /// # Panics
    /// If the lengths differ.
    pub fn dirichlet(&mut self, alpha: &[f64], out: &mut [f64]) {
        assert_eq!(alpha.len(), out.len(), "one concentration per entry");
        let mut sum = 0.0;
        for (o, &a) in out.iter_mut().zip(alpha) {
            *o = self.gamma(a);
            sum += *o;
        }
        for o in out {
            *o /= sum;
        }
    }

    /// Index drawn with the given probabilities, which should sum to 1 (the last non-zero entry takes the rounding).
    pub fn pick(&mut self, probabilities: &[f64]) -> usize {
        let mut left = self.uniform();
        let mut last = 0;
        for (i, &p) in probabilities.iter().enumerate() {
            if p > 0.0 {
                last = i;
                if left < p {
                    return i;
                }
                left -= p;
            }
        }
        last
    }

    /// Puts `items` into random order (Fisher and Yates).
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, self.below(i + 1));
        }
    }
}

/// What Marsaglia's method multiplies a point of the disc by; `s` is the squared distance of that point, `ln_s` its logarithm.
#[inline]
fn polar_factor(s: f64, ln_s: f64) -> f64 {
    (-2.0 * ln_s / s).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_draws_never_change() {
        let mut rng = Streams::new(1).stream("attention");
        let draws = [rng.bits(), rng.bits(), rng.bits()];
        assert_eq!(draws, PINNED, "a changed generator changes every result ever published");
    }
    const PINNED: [u64; 3] =
        [9_850_537_613_020_147_668, 1_785_057_832_490_280_293, 16_904_394_843_081_602_073];

    #[test]
    fn names_and_indices_give_unrelated_streams() {
        let streams = Streams::new(7);
        let mut seen = std::collections::BTreeSet::new();
        for name in ["a", "b", "world"] {
            for i in 0..100 {
                assert!(seen.insert(streams.nth(i).stream(name).bits()));
            }
        }
    }

    #[test]
    fn normals_side_by_side_are_the_first_of_each_sibling() {
        for seed in 0..2000 {
            let streams = Streams::new(seed);
            let alone = std::array::from_fn(|i| streams.nth(i as u64).stream("noise").normal());
            assert_eq!(streams.normals::<5>("noise").map(f64::to_bits), alone.map(f64::to_bits));
        }
    }

    #[test]
    fn moments_of_the_samplers_are_right() {
        let mut rng = Rng::new(3);
        let n = 200_000;
        let mean = |f: &mut dyn FnMut() -> f64| (0..n).map(|_| f()).sum::<f64>() / f64::from(n);
        assert!((mean(&mut || rng.uniform()) - 0.5).abs() < 0.003);
        assert!(mean(&mut || rng.normal()).abs() < 0.01);
        assert!((mean(&mut || num::pow(rng.normal(), 2.0)) - 1.0).abs() < 0.02);
        assert!((mean(&mut || rng.gamma(0.3)) - 0.3).abs() < 0.01);
        assert!((mean(&mut || rng.gamma(4.5)) - 4.5).abs() < 0.03);
        assert!((mean(&mut || rng.below(5) as f64) - 2.0).abs() < 0.02);
    }

    #[test]
    fn a_pick_follows_its_probabilities() {
        let mut rng = Rng::new(5);
        let mut counts = [0.0_f64; 3];
        for _ in 0..100_000 {
            counts[rng.pick(&[0.2, 0.0, 0.8])] += 1e-5;
        }
        assert!((counts[0] - 0.2).abs() < 0.01 && counts[1] == 0.0);
    }
}
