//! Clusters of rows: a mixture of Gaussians without correlations, fitted by expectation and maximisation. Absent cells
//! are skipped, so a row may be looked at through any set of columns.

use metal_rl::belief::Whitener;
use metal_rl::num;
use metal_rl::random::Rng;

/// Rows of numbers in units of each column's spread; NaN where nobody knows.
#[derive(Clone, Debug)]
pub(super) struct Matrix {
    /// Row after row.
    pub values: Vec<f64>,
    /// Number of columns.
    pub width: usize,
}

impl Matrix {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.values.len() / self.width
    }

    /// One row.
    pub fn row(&self, row: usize) -> &[f64] {
        &self.values[row * self.width..(row + 1) * self.width]
    }
}

/// A Gaussian without correlations.
#[derive(Clone, Debug)]
pub(super) struct Gauss {
    /// Mean of each column.
    pub mean: Vec<f64>,
    /// Variance of each column.
    pub variance: Vec<f64>,
    log_variance: Vec<f64>,
}

impl Gauss {
    /// With these moments.
    pub fn new(mean: Vec<f64>, variance: Vec<f64>) -> Self {
        let log_variance = variance.iter().map(|&v| num::ln(v)).collect();
        Self { mean, variance, log_variance }
    }

    /// Logarithm of the density at what is known of a row, up to a constant per known column.
    pub fn log_density(&self, row: &[f64]) -> f64 {
        let mut sum = 0.0;
        for (j, &z) in row.iter().enumerate() {
            if !z.is_nan() {
                let off = z - self.mean[j];
                sum += off * off / self.variance[j] + self.log_variance[j];
            }
        }
        -0.5 * sum
    }

    /// The same where columns are correlated; `whitener` is that of what is known of the row.
    pub fn log_density_together(&self, row: &[f64], whitener: &Whitener) -> f64 {
        let known = || row.iter().enumerate().filter(|(_, z)| !z.is_nan());
        let distance = |(j, z): (usize, &f64)| (z - self.mean[j]) / self.variance[j].sqrt();
        let mut distances: Vec<f64> = known().map(distance).collect();
        whitener.whiten(&mut distances);
        let logs: f64 = known().map(|(j, _)| self.log_variance[j]).sum();
        -0.5 * (distances.iter().map(|t| t * t).sum::<f64>() + logs + whitener.log_determinant())
    }
}

/// Moments of weighted rows, column by column.
pub(super) struct Moments {
    /// Weight of the known cells.
    pub weight: Vec<f64>,
    /// Their mean (0 where there are none).
    pub mean: Vec<f64>,
    /// Their weighted sum of squared distances from it.
    pub scatter: Vec<f64>,
}

/// Moments of the rows of `matrix` with these weights.
pub(super) fn moments(matrix: &Matrix, weights: &[f64]) -> Moments {
    let width = matrix.width;
    let (mut weight, mut mean, mut scatter) = (vec![0.0; width], vec![0.0; width], vec![0.0; width]);
    for (i, &w) in weights.iter().enumerate().filter(|(_, w)| **w > 0.0) {
        for (j, &z) in matrix.row(i).iter().enumerate().filter(|(_, z)| !z.is_nan()) {
            weight[j] += w;
            let off = z - mean[j];
            mean[j] += off * w / weight[j];
            scatter[j] += w * off * (z - mean[j]);
        }
    }
    Moments { weight, mean, scatter }
}

/// What is known of a cluster before any row: rows' worth of belief in the mean 0, and in a variance of 0.3.
const MEAN_ROWS: f64 = 0.5;
const VARIANCE_ROWS: f64 = 3.0;
const VARIANCE: f64 = 0.3;
/// Beginnings that are tried, and rounds in each of them.
const TRIES: usize = 8;
const FIRST_ROUNDS: usize = 12;
/// Rounds of the most promising one.
const MORE_ROUNDS: usize = 30;
/// Columns by which a beginning sorts the rows.
const FIRST_COLUMNS: usize = 5;

/// How much each row belongs to each cluster: one list of weights per cluster.
pub(super) type Shares = Vec<Vec<f64>>;

/// The most likely of several ways to sort the rows into `count` clusters.
pub(super) fn clusters(matrix: &Matrix, count: usize, rng: &mut Rng) -> Shares {
    if count == 1 {
        return vec![vec![1.0; matrix.rows()]];
    }
    let mut best: Option<(f64, Shares)> = None;
    for _ in 0..TRIES {
        let mut shares = beginning(matrix, count, rng);
        let likelihood = refine(matrix, &mut shares, FIRST_ROUNDS);
        if best.as_ref().is_none_or(|(record, _)| likelihood > *record) {
            best = Some((likelihood, shares));
        }
    }
    let (_, mut shares) = best.unwrap_or_default();
    refine(matrix, &mut shares, MORE_ROUNDS);
    shares
}

/// Rows sorted by the nearest of some of them, in some of the columns.
fn beginning(matrix: &Matrix, count: usize, rng: &mut Rng) -> Shares {
    let columns: Vec<usize> = (0..FIRST_COLUMNS).map(|_| rng.below(matrix.width)).collect();
    let centres: Vec<usize> = (0..count).map(|_| rng.below(matrix.rows())).collect();
    let nearest = |i: usize| {
        let nearness = |&centre: &usize| {
            let (a, b) = (matrix.row(i), matrix.row(centre));
            -columns.iter().map(|&j| (a[j] - b[j]) * (a[j] - b[j])).filter(|d| !d.is_nan()).sum::<f64>()
        };
        num::argmax(&centres.iter().map(nearness).collect::<Vec<f64>>())
    };
    let owners: Vec<usize> = (0..matrix.rows()).map(nearest).collect();
    let share = |cluster: usize| owners.iter().map(|&o| f64::from(u8::from(o == cluster))).collect();
    (0..count).map(share).collect()
}

/// Rounds of expectation and maximisation; returns the logarithm of the likelihood.
fn refine(matrix: &Matrix, shares: &mut Shares, rounds: usize) -> f64 {
    let mut likelihood = f64::NEG_INFINITY;
    for _ in 0..rounds {
        let fitted: Vec<(f64, Gauss)> = shares.iter().map(|weights| cluster(matrix, weights)).collect();
        likelihood = 0.0;
        let mut logs = vec![0.0; fitted.len()];
        for i in 0..matrix.rows() {
            for (log, (prior, gauss)) in logs.iter_mut().zip(&fitted) {
                *log = prior + gauss.log_density(matrix.row(i));
            }
            let all = num::log_sum_exp(&logs);
            likelihood += all;
            for (weights, log) in shares.iter_mut().zip(&logs) {
                weights[i] = num::exp(log - all);
            }
        }
    }
    likelihood
}

fn cluster(matrix: &Matrix, weights: &[f64]) -> (f64, Gauss) {
    let found = moments(matrix, weights);
    let columns = || found.weight.iter().zip(&found.mean).zip(&found.scatter);
    let mean = columns().map(|((w, m), _)| w * m / (w + MEAN_ROWS)).collect();
    let variance = columns()
        .map(|((w, m), s)| {
            let pulled = MEAN_ROWS / (w + MEAN_ROWS) * m;
            (s + w * pulled * pulled + VARIANCE_ROWS * VARIANCE) / (w + VARIANCE_ROWS)
        })
        .collect();
    let size = weights.iter().sum::<f64>() + 1.0;
    (num::ln(size / matrix.rows() as f64), Gauss::new(mean, variance))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_heaps_are_told_apart_though_most_columns_are_noise() {
        let mut rng = Rng::new(3);
        let width = 12;
        let mut values = Vec::new();
        for i in 0..200 {
            for j in 0..width {
                let centre = if j < 3 && i % 2 == 0 { 3.0 } else { 0.0 };
                let hole = rng.chance(0.05);
                let z = centre + 0.5 * rng.normal() * if j < 3 { 1.0 } else { 2.0 };
                values.push(if hole { f64::NAN } else { z });
            }
        }
        let shares = clusters(&Matrix { values, width }, 2, &mut rng);
        let first = usize::from(shares[1][0] > 0.5);
        let right = (0..200).filter(|i| (shares[first][*i] > 0.5) == (i % 2 == 0)).count();
        assert!(right > 195, "{right}");
    }

    #[test]
    fn what_is_not_known_does_not_count() {
        let gauss = Gauss::new(vec![1.0, 2.0], vec![1.0, 4.0]);
        assert_eq!(gauss.log_density(&[f64::NAN, f64::NAN]), 0.0);
        assert_eq!(gauss.log_density(&[2.0, f64::NAN]), -0.5);
    }
}
