//! Keeping a mixture small: forgetting components nobody needs, and merging the two that differ least (reading R29).

use super::frame::Frame;
use super::gaussians::LANES;
use super::mixture::Mixture;

/// Pairs merged per overflow, as a share of the cap: the pairs are compared once for all of them.
const MERGED_AT_ONCE: usize = 16;

impl Mixture {
    /// Removes components that are old and still light (one always stays), then merges down to the cap.
    pub fn tidy(&mut self, frame: &Frame, error_variance: f64) {
        self.prune(frame);
        if self.len() > frame.cap {
            self.merge_cheapest(1 + frame.cap / MERGED_AT_ONCE, error_variance);
        }
    }

    fn prune(&mut self, frame: &Frame) {
        for c in (0..self.len()).rev() {
            let (facts, lane) = (&self.facts[c / LANES], c % LANES);
            let useless = facts.age[lane] > frame.prune_age && facts.mass[lane] < frame.prune_mass;
            if useless && self.len() > 1 {
                self.swap_remove(c);
            }
        }
    }

    /// Merges up to `wanted` cheapest disjoint pairs.
    fn merge_cheapest(&mut self, wanted: usize, error_variance: f64) {
        let mut costs = Vec::with_capacity(self.len() * (self.len() - 1) / 2);
        let mut sigma = Vec::new();
        for i in 1..self.len() {
            for j in 0..i {
                let cost = self.merge_cost(i, j, error_variance, &mut sigma);
                costs.push((if cost.is_nan() { f64::INFINITY } else { cost }, i, j));
            }
        }
        costs.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let mut taken = vec![false; self.len()];
        let mut gone = Vec::new();
        for &(_, i, j) in &costs {
            if gone.len() < wanted && !taken[i] && !taken[j] {
                (taken[i], taken[j]) = (true, true);
                self.merge(j, i, &mut sigma);
                gone.push(i);
            }
        }
        gone.sort_unstable();
        gone.iter().rev().for_each(|&c| self.swap_remove(c));
    }

    /// What merging two components would lose.
    ///
    /// # Formula
    /// ½[(nᵢ + nⱼ) ln|Σᵢⱼ| − nᵢ ln|Σᵢ| − nⱼ ln|Σⱼ|] + nᵢnⱼ/(nᵢ + nⱼ) (qᵢ − qⱼ)²/σ²
    /// (Runnalls 2007, and a price for the gap between the values in units of their errors)
    fn merge_cost(&self, i: usize, j: usize, error_variance: f64, sigma: &mut Vec<f64>) -> f64 {
        let (ni, nj) = (self.mass(i), self.mass(j));
        self.pooled_covariance(i, j, sigma);
        let g = &self.gaussians;
        let pooled = (ni + nj) * g.log_det_of(sigma);
        let shape = 0.5 * (pooled - ni * g.log_det(i) - nj * g.log_det(j));
        let gap = self.value(i) - self.value(j);
        shape + ni * nj / (ni + nj) * gap * gap / error_variance
    }

    /// Replaces component `i` by the merger of `i` and `j` (which stays, to be removed): moments are conserved.
    pub(super) fn merge(&mut self, i: usize, j: usize, sigma: &mut Vec<f64>) {
        self.pooled_covariance(i, j, sigma);
        let f = self.mass(i) / (self.mass(i) + self.mass(j));
        for k in 0..self.gaussians.dims() {
            let mean = f * self.gaussians.mean(i, k) + (1.0 - f) * self.gaussians.mean(j, k);
            self.gaussians.set_mean(i, k, mean);
        }
        self.gaussians.set_covariance(i, sigma);
        let (b, other) = (j % LANES, self.facts[j / LANES].clone());
        let (a, facts) = (i % LANES, &mut self.facts[i / LANES]);
        let (ki, kj) = (facts.count[a], other.count[b]);
        let gap = facts.value[a] - other.value[b];
        facts.scatter[a] += other.scatter[b] + ki * kj / (ki + kj) * gap * gap;
        facts.value[a] = (ki * facts.value[a] + kj * other.value[b]) / (ki + kj);
        facts.count[a] = ki + kj;
        facts.success[a] = f * facts.success[a] + (1.0 - f) * other.success[b];
        facts.mass[a] += other.mass[b];
        facts.age[a] = facts.age[a].max(other.age[b]);
    }

    /// Lower triangle of Σᵢⱼ = f Σᵢ + (1 − f) Σⱼ + f(1 − f) (μᵢ − μⱼ)(μᵢ − μⱼ)ᵀ,  f = nᵢ/(nᵢ + nⱼ)
    fn pooled_covariance(&self, i: usize, j: usize, sigma: &mut Vec<f64>) {
        let g = &self.gaussians;
        let f = self.mass(i) / (self.mass(i) + self.mass(j));
        sigma.clear();
        for r in 0..g.dims() {
            let row_gap = g.mean(i, r) - g.mean(j, r);
            let first = if g.is_full() { 0 } else { r };
            for c in first..=r {
                let spread = f * (1.0 - f) * row_gap * (g.mean(i, c) - g.mean(j, c));
                sigma.push(f * g.covariance(i, r, c) + (1.0 - f) * g.covariance(j, r, c) + spread);
            }
        }
    }

    /// n of a component.
    pub fn mass(&self, c: usize) -> f64 {
        self.facts[c / LANES].mass[c % LANES]
    }

    /// q of a component.
    pub fn value(&self, c: usize) -> f64 {
        self.facts[c / LANES].value[c % LANES]
    }
}

#[cfg(test)]
mod tests {
    use super::super::MixtureConfig;
    use super::super::bank::Bank;
    use super::super::frame::{Frame, Shape};
    use super::*;
    use crate::learner::{Rate, Sample};
    use crate::random::Rng;

    /// A bank of one action that has seen `n` random samples.
    fn trained(full: bool, cap: usize, n: usize) -> Bank {
        let config = MixtureConfig { cap, shape: Shape::Resp { least: 0.01 }, ..MixtureConfig::default() };
        let frame = Frame { full, ..config.frame("test", 3).unwrap() };
        let mut bank = Bank::new(frame, 1);
        let mut rng = Rng::new(11);
        for _ in 0..n {
            let state: Vec<f64> = (0..3).map(|_| rng.uniform()).collect();
            let target = 10.0 * state[0] + rng.normal();
            let sample = Sample { state: &state, choice: 0, target, demonstrated: false };
            bank.learn(&sample, Rate::Average(0.02));
        }
        bank
    }

    /// Mass, mass-weighted mean and second moment, and count-weighted value of components i and j.
    fn moments(m: &Mixture, which: &[usize]) -> Vec<f64> {
        let dims = m.gaussians.dims();
        let mut sums = vec![0.0; 2 + dims + dims * dims];
        for &c in which {
            let (n, g) = (m.mass(c), &m.gaussians);
            sums[0] += n;
            sums[1] += m.facts[c / LANES].count[c % LANES] * m.value(c);
            for i in 0..dims {
                sums[2 + i] += n * g.mean(c, i);
                for j in 0..dims {
                    let second = g.covariance(c, i, j) + g.mean(c, i) * g.mean(c, j);
                    sums[2 + dims + i * dims + j] += n * second;
                }
            }
        }
        sums
    }

    #[test]
    fn a_merger_conserves_mass_moments_and_value() {
        let mut mixture = trained(true, 100, 400).mixtures()[0].clone();
        let before = moments(&mixture, &[1, 9]);
        mixture.merge(1, 9, &mut Vec::new());
        for (b, a) in before.iter().zip(moments(&mixture, &[1])) {
            assert!((b - a).abs() < 1e-9 * b.abs().max(1.0), "{b} became {a}");
        }
    }

    /// Learns `n` more samples, one in a hundred of them far outside at up to ±1e6, and looks at every covariance now and
    /// then: symmetric, and positive definite once every axis has its own unit.
    fn stays_positive_definite(n: usize, every: usize) {
        for full in [true, false] {
            let (mut bank, mut rng) = (trained(full, 40, 100), Rng::new(23));
            for step in 1..=n {
                let reach = if rng.chance(0.01) { 1e6 } else { 1.0 };
                let state: Vec<f64> = (0..3).map(|_| reach * rng.range(-1.0, 1.0)).collect();
                let target = if rng.chance(0.01) { 1e6 * rng.normal() } else { rng.normal() };
                let sample = Sample { state: &state, choice: 0, target, demonstrated: rng.chance(0.1) };
                assert!(bank.learn(&sample, Rate::Average(0.02)).is_finite());
                if step % every == 0 {
                    bank.mixtures().iter().for_each(assert_positive_definite);
                }
            }
        }
    }

    fn assert_positive_definite(mixture: &Mixture) {
        let g = &mixture.gaussians;
        let n = g.dims();
        for c in 0..mixture.len() {
            let sd: Vec<f64> = (0..n).map(|i| g.covariance(c, i, i).sqrt()).collect();
            assert!(sd.iter().all(|s| s.is_finite() && *s > 0.0), "component {c}: {sd:?}");
            let entry = |i, j| g.covariance(c, i, j) / (sd[i] * sd[j]);
            let sigma = nalgebra::DMatrix::from_fn(n, n, entry);
            assert!((&sigma - sigma.transpose()).amax() < 1e-9, "component {c} is not symmetric: {sigma}");
            assert!(sigma.clone().cholesky().is_some(), "component {c} is not positive definite: {sigma}");
            assert!(mixture.mass(c) > 0.0 && mixture.value(c).is_finite());
        }
    }

    #[test]
    fn covariances_stay_positive_definite() {
        stays_positive_definite(20_000, 500);
    }

    /// `cargo test --release -p metal-rl -- --ignored ten_million`
    #[test]
    #[ignore = "takes minutes"]
    fn covariances_stay_positive_definite_over_ten_million_updates() {
        stays_positive_definite(10_000_000, 100_000);
    }

    #[test]
    fn a_diagonal_merger_conserves_means_and_variances() {
        let mut mixture = trained(false, 100, 400).mixtures()[0].clone();
        let before = moments(&mixture, &[0, 3]);
        mixture.merge(0, 3, &mut Vec::new());
        let after = moments(&mixture, &[0]);
        for k in [0, 1, 2, 3, 4, 5, 9, 13] {
            assert!((before[k] - after[k]).abs() < 1e-9, "{} became {}", before[k], after[k]);
        }
    }

    #[test]
    fn twins_merge_first() {
        let mut mixture = trained(true, 100, 300).mixtures()[0].clone();
        let twin: Vec<f64> = (0..3).map(|i| mixture.gaussians.mean(2, i) + 1e-4).collect();
        let sd: Vec<f64> = (0..3).map(|i| mixture.gaussians.covariance(2, i, i).sqrt()).collect();
        let c = mixture.gaussians.push(&twin, |i| sd[i]);
        mixture.facts.resize_with(mixture.gaussians.groups(), Default::default);
        let value = mixture.value(2);
        let facts = &mut mixture.facts[c / LANES];
        (facts.mass[c % LANES], facts.count[c % LANES], facts.value[c % LANES]) = (1.0, 1.0, value);
        let (before, mass) = (mixture.len(), mixture.mass(2));
        mixture.merge_cheapest(1, 1.0);
        assert_eq!(mixture.len(), before - 1);
        assert!((mixture.mass(2) - mass - 1.0).abs() < 1e-12);
    }

    #[test]
    fn old_light_components_are_pruned_but_never_the_last() {
        let mut mixture = trained(true, 100, 300).mixtures()[0].clone();
        let frame = Frame { prune_age: -1.0, prune_mass: f64::INFINITY, ..trained(true, 9, 0).frame };
        mixture.prune(&frame);
        assert_eq!((mixture.len(), mixture.facts.len()), (1, 1));
    }

    #[test]
    fn responsibilities_sum_to_one() {
        for full in [true, false] {
            let bank = trained(full, 30, 1000);
            assert!(bank.components() <= 30);
            for x in [0.0, 0.3, 0.8, 5.0, 1e6] {
                let sum = bank.expect(0, &[x, 0.5, 0.2], 1.0, |_, _| 1.0);
                assert!((sum - 1.0).abs() < 1e-12, "{sum} at {x}");
            }
        }
    }
}
