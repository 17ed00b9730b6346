//! Many Gaussians side by side: in groups of eight, one per lane, so that eight distances are computed at once without
//! horizontal sums, and in the same order of additions as the plain scalar code.

use crate::num;
use multiversion::multiversion;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Gaussians per group.
pub(crate) const LANES: usize = 8;

/// One number for each Gaussian of a group.
pub(crate) type Lane = [f64; LANES];

/// Full covariances up to this dimension have short working space.
const SMALL: usize = 8;

/// Largest dimension of full covariances (a query keeps one row per dimension on the stack).
pub(crate) const MAX_FULL: usize = 64;

/// Gaussians of one dimension, diagonal or full.
///
/// Full covariances are kept as their Cholesky factor L (Σ = L Lᵀ), which is symmetric positive definite by
/// construction however often it is updated.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Gaussians {
    dims: usize,
    full: bool,
    len: usize,
    /// Leading dimensions that ln |Σ| is about: all, or all but a value axis.
    counted: usize,
    /// Smallest standard deviation per dimension; for full covariances smallest diagonal entry of L.
    floors: Vec<f64>,
    /// Group × dims.
    means: Vec<Lane>,
    /// Diagonal: group × dims variances. Full: group × dims(dims + 1)/2, lower triangle of L by rows.
    factors: Vec<Lane>,
    /// Group × dims. Diagonal: 1/variance. Full: 1/L[i][i].
    inverses: Vec<Lane>,
    /// Group: ln |Σ| of the counted dimensions.
    log_dets: Vec<Lane>,
}

/// Place of entry (i, j), j ≤ i, in a lower triangle stored by rows.
#[inline(always)]
fn at(i: usize, j: usize) -> usize {
    i * (i + 1) / 2 + j
}

impl Gaussians {
    /// None yet, with these smallest standard deviations (one per dimension).
    pub fn new(full: bool, floors: Vec<f64>) -> Self {
        let (means, factors, inverses, log_dets) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let dims = floors.len();
        Self { dims, full, len: 0, counted: dims, floors, means, factors, inverses, log_dets }
    }

    /// None yet, full, over a state and a value as the last dimension, which determinants leave out.
    pub fn with_value_axis(floors: Vec<f64>) -> Self {
        let counted = floors.len() - 1;
        Self { counted, ..Self::new(true, floors) }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Number of groups, the last one perhaps not full.
    pub fn groups(&self) -> usize {
        self.len.div_ceil(LANES)
    }

    /// Dimensions.
    pub fn dims(&self) -> usize {
        self.dims
    }

    /// Entries of `factors` per group.
    fn rows(&self) -> usize {
        if self.full { at(self.dims, 0) } else { self.dims }
    }

    /// Whether thawed vectors have the lengths that the shape demands.
    pub fn is_sound(&self) -> bool {
        let groups = self.groups();
        self.floors.len() == self.dims
            && self.counted <= self.dims
            && self.means.len() == groups * self.dims
            && self.inverses.len() == groups * self.dims
            && self.factors.len() == groups * self.rows()
            && self.log_dets.len() == groups
    }

    /// Adds a Gaussian with these standard deviations (no correlation) and returns its index.
    pub fn push(&mut self, mean: &[f64], widths: impl Fn(usize) -> f64) -> usize {
        let c = self.len;
        self.len += 1;
        let groups = self.groups();
        self.means.resize(groups * self.dims, [0.0; LANES]);
        self.factors.resize(groups * self.rows(), [0.0; LANES]);
        self.inverses.resize(groups * self.dims, [0.0; LANES]);
        self.log_dets.resize(groups, [0.0; LANES]);
        for (i, &coordinate) in mean.iter().enumerate().take(self.dims) {
            self.set_mean(c, i, coordinate);
            if self.full {
                (0..i).for_each(|j| self.set_factor(c, at(i, j), 0.0));
                self.set_factor(c, at(i, i), widths(i));
            } else {
                self.set_factor(c, i, widths(i) * widths(i));
            }
        }
        self.refresh(c);
        c
    }

    /// Removes a Gaussian; the last one takes its index.
    pub fn swap_remove(&mut self, c: usize) {
        let last = self.len - 1;
        let (dims, rows) = (self.dims, self.rows());
        for (store, per_group) in [
            (&mut self.means, dims),
            (&mut self.factors, rows),
            (&mut self.inverses, dims),
            (&mut self.log_dets, 1),
        ] {
            for r in 0..per_group {
                let moved = &mut store[last / LANES * per_group + r][last % LANES];
                let value = std::mem::take(moved);
                if c != last {
                    store[c / LANES * per_group + r][c % LANES] = value;
                }
            }
            store.truncate(last.div_ceil(LANES) * per_group);
        }
        self.len = last;
    }

    /// Entry i of the mean.
    pub fn mean(&self, c: usize, i: usize) -> f64 {
        self.means[c / LANES * self.dims + i][c % LANES]
    }

    /// Sets entry i of the mean.
    pub fn set_mean(&mut self, c: usize, i: usize, value: f64) {
        self.means[c / LANES * self.dims + i][c % LANES] = value;
    }

    fn factor(&self, c: usize, r: usize) -> f64 {
        self.factors[c / LANES * self.rows() + r][c % LANES]
    }

    fn set_factor(&mut self, c: usize, r: usize, value: f64) {
        let rows = self.rows();
        self.factors[c / LANES * rows + r][c % LANES] = value;
    }

    /// ln |Σ|.
    pub fn log_det(&self, c: usize) -> f64 {
        self.log_dets[c / LANES][c % LANES]
    }

    /// Entry (i, j) of Σ.
    pub fn covariance(&self, c: usize, i: usize, j: usize) -> f64 {
        if self.full {
            (0..=i.min(j)).map(|k| self.factor(c, at(i, k)) * self.factor(c, at(j, k))).sum()
        } else if i == j {
            self.factor(c, i)
        } else {
            0.0
        }
    }

    /// Whether covariances are full.
    pub fn is_full(&self) -> bool {
        self.full
    }

    /// Replaces Σ by `sigma`: its diagonal, or for full covariances its lower triangle by rows (which is used up).
    pub fn set_covariance(&mut self, c: usize, sigma: &mut [f64]) {
        if self.full {
            cholesky(sigma, self.dims);
        }
        for (r, &x) in sigma.iter().enumerate() {
            self.set_factor(c, r, x);
        }
        self.refresh(c);
    }

    /// ln |Σ| of a matrix in the form of [`Self::set_covariance`] (used up).
    pub fn log_det_of(&self, sigma: &mut [f64]) -> f64 {
        if !self.full {
            return log_product(sigma.iter().copied());
        }
        cholesky(sigma, self.dims);
        2.0 * log_product((0..self.dims).map(|i| sigma[at(i, i)]))
    }

    /// Squared Mahalanobis distances of `s` to the Gaussians of a group, over the leading `s.len()` dimensions.
    ///
    /// `rows` receives the whitened differences y = L⁻¹(s − μ) of full covariances (one row per dimension).
    pub fn distances(&self, group: usize, s: &[f64], rows: &mut [Lane]) -> Lane {
        distances(self, group, s, rows)
    }

    /// Squared Mahalanobis distances of `s` to the Gaussians of some groups, over all dimensions. Inlined, so that a caller
    /// compiled for wide vectors has it wide.
    #[inline(always)]
    pub fn distances_of(&self, groups: Range<usize>, s: &[f64], out: &mut [Lane]) {
        match self.dims {
            _ if !self.full => self.diagonal_distances_of(groups, s, out),
            2 => self.few_full_distances_of::<2>(groups, s, out),
            3 => self.few_full_distances_of::<3>(groups, s, out),
            4 => self.few_full_distances_of::<4>(groups, s, out),
            ..=SMALL => self.full_distances_of(groups, s, (&mut [[0.0; LANES]; SMALL], out)),
            _ => self.full_distances_of(groups, s, (&mut [[0.0; LANES]; MAX_FULL], out)),
        }
    }

    /// [`Self::full_distances_of`], compiled for one number of dimensions, so that loops over them are unrolled.
    #[inline(always)]
    fn few_full_distances_of<const DIMS: usize>(&self, groups: Range<usize>, s: &[f64], out: &mut [Lane]) {
        let (s, rows) = (&s[..DIMS], &mut [[0.0; LANES]; DIMS]);
        for (group, out) in groups.zip(out) {
            let range = group * DIMS..(group + 1) * DIMS;
            let factors = &self.factors[group * at(DIMS, 0)..][..at(DIMS, 0)];
            *out = full_distances((&self.means[range.clone()], &self.inverses[range], factors), s, rows);
        }
    }

    #[inline(always)]
    fn diagonal_distances_of(&self, groups: Range<usize>, s: &[f64], out: &mut [Lane]) {
        for (group, out) in groups.zip(out) {
            let range = group * self.dims..(group + 1) * self.dims;
            *out = diagonal_distances(&self.means[range.clone()], &self.inverses[range], s);
        }
    }

    #[inline(always)]
    fn full_distances_of(&self, groups: Range<usize>, s: &[f64], (rows, out): (&mut [Lane], &mut [Lane])) {
        for (group, out) in groups.zip(out) {
            *out = self.full_distances(group, s, rows);
        }
    }

    #[inline(always)]
    fn full_distances(&self, group: usize, s: &[f64], rows: &mut [Lane]) -> Lane {
        let range = group * self.dims..(group + 1) * self.dims;
        let factors = &self.factors[group * self.rows()..];
        full_distances((&self.means[range.clone()], &self.inverses[range], factors), s, rows)
    }

    /// What a Gaussian with a full covariance expects of its last dimension, given the others (whitened: `rows`):
    /// means m = μ + Σⱼ L[last][j] y[j] of a group.
    pub fn expected_last(&self, group: usize, rows: &[Lane]) -> Lane {
        let last = self.dims - 1;
        let factors = &self.factors[group * self.rows() + at(last, 0)..];
        let mut mean = self.means[group * self.dims + last];
        for (l, z) in factors[..last].iter().zip(rows) {
            for lane in 0..LANES {
                mean[lane] += l[lane] * z[lane];
            }
        }
        mean
    }

    /// Standard deviation of the last dimension given the others: L[last][last].
    pub fn last_width(&self, c: usize) -> f64 {
        self.factor(c, at(self.dims - 1, self.dims - 1))
    }

    /// ln |Σ| of all groups.
    #[inline(always)]
    pub fn log_dets(&self) -> &[Lane] {
        &self.log_dets
    }

    /// Moves a Gaussian towards `s` by weight w in (0, 1), `e` being scratch of `dims` numbers.
    ///
    /// # Formula
    /// μ′ = μ + w e,  Σ′ = (1 − w)(Σ + w e eᵀ),  e = s − μ        (the exact weighted recursion)
    pub fn attract(&mut self, c: usize, s: &[f64], w: f64, e: &mut [f64]) {
        for i in 0..self.dims {
            let mean = self.mean(c, i);
            e[i] = s[i] - mean;
            self.set_mean(c, i, mean + w * e[i]);
        }
        if self.full {
            let (shrink, gain) = ((1.0 - w).sqrt(), ((1.0 - w) * w).sqrt());
            for r in 0..self.rows() {
                self.set_factor(c, r, shrink * self.factor(c, r));
            }
            e.iter_mut().for_each(|x| *x *= gain);
            self.rank_one(c, e, 1.0);
        } else {
            for (i, x) in e.iter().enumerate() {
                self.set_factor(c, i, (1.0 - w) * (self.factor(c, i) + w * x * x));
            }
        }
        self.refresh(c);
    }

    /// Shrinks a Gaussian away from `s`: Σ′ = Σ − b e eᵀ, where b D² ≤ 1/2 keeps it positive definite.
    pub fn shrink(&mut self, c: usize, s: &[f64], b: f64, e: &mut [f64]) {
        for i in 0..self.dims {
            e[i] = s[i] - self.mean(c, i);
        }
        if self.full {
            e.iter_mut().for_each(|x| *x *= b.sqrt());
            self.rank_one(c, e, -1.0);
        } else {
            for (i, x) in e.iter().enumerate() {
                self.set_factor(c, i, self.factor(c, i) - b * x * x);
            }
        }
        self.refresh(c);
    }

    /// L of Σ ± x xᵀ from L of Σ; x is used up.
    fn rank_one(&mut self, c: usize, x: &mut [f64], sign: f64) {
        for k in 0..self.dims {
            let old = self.factor(c, at(k, k));
            let squared = old * old + sign * x[k] * x[k];
            let new = squared.max(f64::MIN_POSITIVE).sqrt();
            let (cosine, sine) = (new / old, x[k] / old);
            self.set_factor(c, at(k, k), new);
            for (i, x) in x.iter_mut().enumerate().take(self.dims).skip(k + 1) {
                let l = (self.factor(c, at(i, k)) + sign * sine * *x) / cosine;
                *x = cosine * *x - sine * l;
                self.set_factor(c, at(i, k), l);
            }
        }
    }

    /// Applies the floors and recomputes what is derived from the factor.
    fn refresh(&mut self, c: usize) {
        let power = if self.full { 2.0 } else { 1.0 };
        for i in 0..self.dims {
            let floor = self.floors[i];
            let (row, least) = if self.full { (at(i, i), floor) } else { (i, floor * floor) };
            let value = self.factor(c, row).max(least);
            self.set_factor(c, row, value);
            self.inverses[c / LANES * self.dims + i][c % LANES] = 1.0 / value;
        }
        let diagonal = (0..self.counted).map(|i| self.factor(c, if self.full { at(i, i) } else { i }));
        self.log_dets[c / LANES][c % LANES] = power * log_product(diagonal);
    }
}

/// [`Gaussians::distances`].
#[multiversion(targets("x86_64+avx2+fma"))]
fn distances(of: &Gaussians, group: usize, s: &[f64], rows: &mut [Lane]) -> Lane {
    if of.full {
        return of.full_distances(group, s, rows);
    }
    let mut d2 = [[0.0; LANES]];
    of.diagonal_distances_of(group..group + 1, s, &mut d2);
    d2[0]
}

/// Σ ((s − μ)/σ)² for a group, from means and 1/σ² by dimension.
#[inline(always)]
fn diagonal_distances(means: &[Lane], inverses: &[Lane], s: &[f64]) -> Lane {
    let mut sum = [0.0; LANES];
    for ((mean, inverse), &x) in means.iter().zip(inverses).zip(s) {
        for lane in 0..LANES {
            let e = x - mean[lane];
            sum[lane] = num::fused(e * inverse[lane], e, sum[lane]);
        }
    }
    sum
}

/// |y|², y = L⁻¹(s − μ), for a group, from (means, 1/L\[i\]\[i\], lower triangles by rows); y by dimension goes into `rows`.
#[inline(always)]
fn full_distances(of: (&[Lane], &[Lane], &[Lane]), s: &[f64], rows: &mut [Lane]) -> Lane {
    let (means, inverses, factors) = of;
    let mut sum = [0.0; LANES];
    for (i, &x) in s.iter().enumerate() {
        let mut y = [0.0; LANES];
        for lane in 0..LANES {
            y[lane] = x - means[i][lane];
        }
        for (l, z) in factors[at(i, 0)..at(i, i)].iter().zip(&rows[..i]) {
            for lane in 0..LANES {
                y[lane] = num::fused(-l[lane], z[lane], y[lane]);
            }
        }
        for lane in 0..LANES {
            y[lane] *= inverses[i][lane];
            sum[lane] = num::fused(y[lane], y[lane], sum[lane]);
        }
        rows[i] = y;
    }
    sum
}

/// Σ ln x, with one logarithm for eight factors: widths and variances are far from the ends of the number range.
fn log_product(factors: impl Iterator<Item = f64>) -> f64 {
    let (mut log, mut product) = (0.0, 1.0);
    for (i, x) in factors.enumerate() {
        product *= x;
        if i % LANES == LANES - 1 {
            log += num::ln(product);
            product = 1.0;
        }
    }
    log + num::ln(product)
}

/// Replaces the lower triangle (by rows) of a symmetric positive definite matrix by its Cholesky factor.
fn cholesky(a: &mut [f64], dims: usize) {
    for i in 0..dims {
        for j in 0..=i {
            let inner: f64 = (0..j).map(|k| a[at(i, k)] * a[at(j, k)]).sum();
            let rest = a[at(i, j)] - inner;
            a[at(i, j)] = if i == j { rest.max(f64::MIN_POSITIVE).sqrt() } else { rest / a[at(j, j)] };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Rng;
    use nalgebra::{DMatrix, DVector};

    /// Σ as a dense matrix.
    fn dense(g: &Gaussians, c: usize) -> DMatrix<f64> {
        DMatrix::from_fn(g.dims(), g.dims(), |i, j| g.covariance(c, i, j))
    }

    /// Many updates of one Gaussian among others, beside a dense covariance that follows the plain formula.
    fn follow(dims: usize, updates: usize, weight: impl Fn(&mut Rng) -> f64) {
        let mut rng = Rng::new(dims as u64);
        let mut g = Gaussians::new(true, vec![1e-9; dims]);
        (0..11).for_each(|_| _ = g.push(&vec![0.5; dims], |_| 0.3));
        let (mut mean, mut sigma) =
            (DVector::from_element(dims, 0.5), DMatrix::from_diagonal_element(dims, dims, 0.09));
        let mut e = vec![0.0; dims];
        for _ in 0..updates {
            let s: Vec<f64> = (0..dims).map(|_| rng.uniform()).collect();
            let w = weight(&mut rng);
            let d = DVector::from_column_slice(&s) - &mean;
            mean += w * &d;
            sigma = (1.0 - w) * (sigma + w * &d * d.transpose());
            g.attract(9, &s, w, &mut e);
        }
        let error = (dense(&g, 9) - &sigma).abs().max();
        assert!(error < 1e-8, "covariance off by {error}");
        let chol = sigma.cholesky().expect("positive definite");
        let log_det = 2.0 * chol.l().diagonal().iter().map(|&x| num::ln(x)).sum::<f64>();
        assert!((g.log_det(9) - log_det).abs() < 1e-8, "{} not {log_det}", g.log_det(9));
        assert!((dense(&g, 8) - DMatrix::from_diagonal_element(dims, dims, 0.09)).abs().max() < 1e-12);
    }

    #[test]
    fn the_factor_follows_the_exact_recursion_for_a_hundred_thousand_updates() {
        for dims in [1, 2, 4, 8] {
            follow(dims, 100_000, |_| 0.02);
            follow(dims, 100_000, |rng| rng.range(0.01, 0.5));
        }
    }

    #[test]
    fn shrinking_is_a_rank_one_downdate_and_stays_positive_definite() {
        let mut rng = Rng::new(8);
        let mut g = Gaussians::new(true, vec![1e-9; 4]);
        g.push(&[0.5; 4], |_| 0.3);
        let (mut e, mut rows) = ([0.0; 4], [[0.0; LANES]; 4]);
        for step in 0..20_000 {
            let s: Vec<f64> = (0..4).map(|_| rng.uniform()).collect();
            let d2 = g.distances(0, &s, &mut rows)[0];
            let before = dense(&g, 0);
            let d = DVector::from_fn(4, |i, _| s[i] - g.mean(0, i));
            if step % 2 == 0 {
                let b = 0.5 * rng.uniform() / d2.max(1.0);
                g.shrink(0, &s, b, &mut e);
                assert!((dense(&g, 0) - (before - b * &d * d.transpose())).abs().max() < 1e-12);
            } else {
                g.attract(0, &s, 0.2, &mut e);
            }
            assert!(dense(&g, 0).cholesky().is_some());
        }
    }

    #[test]
    fn distances_are_those_of_the_dense_inverse() {
        let mut rng = Rng::new(6);
        for full in [false, true] {
            let mut g = Gaussians::new(full, vec![0.01; 5]);
            let mut draw = || (0..5).map(|_| rng.uniform()).collect::<Vec<_>>();
            let mut e = [0.0; 5];
            for c in 0..13 {
                g.push(&draw(), |_| 0.2);
                (0..9).for_each(|_| g.attract(c, &draw(), 0.2, &mut e));
            }
            let s = draw();
            for c in 0..13 {
                let inverse = dense(&g, c).try_inverse().expect("positive definite");
                let d = DVector::from_fn(5, |i, _| s[i] - g.mean(c, i));
                let is = g.distances(c / LANES, &s, &mut [[0.0; LANES]; 5])[c % LANES];
                let should = (d.transpose() * inverse * d)[0];
                assert!((is - should).abs() < 1e-9 * should.max(1.0), "{is} not {should}");
            }
        }
    }

    #[test]
    fn removal_moves_the_last_one_into_the_gap() {
        let mut g = Gaussians::new(true, vec![0.01; 2]);
        (0..17).for_each(|c| _ = g.push(&[f64::from(c), 0.0], |_| 0.1 + f64::from(c)));
        g.swap_remove(3);
        assert_eq!((g.len(), g.groups()), (16, 2));
        assert!(g.is_sound());
        assert_eq!(g.mean(3, 0).to_bits(), 16.0_f64.to_bits());
        assert!((g.covariance(3, 1, 1) - 16.1 * 16.1).abs() < 1e-9);
    }
}
