//! What classes look like in every cluster of rows.

use super::mixture::{Gauss, Matrix, Moments, moments};
use metal_rl::belief::{Correlation, Whitener};
use metal_rl::num;

/// Belief that there may be rows of a class where none was seen.
const UNSEEN: f64 = 0.05;
/// Smallest variance, in units of the column's own.
const SMALLEST: f64 = 0.02;

/// Rows with classes, sorted into clusters.
#[derive(Clone, Copy)]
pub(super) struct Sample<'a> {
    /// The rows.
    pub matrix: &'a Matrix,
    /// How much each row belongs to each cluster.
    pub shares: &'a [Vec<f64>],
    /// The class of each row.
    pub labels: &'a [usize],
    /// Number of classes.
    pub classes: usize,
}

/// A class in a cluster.
#[derive(Clone, Debug)]
pub(super) struct Class {
    /// Logarithm of its probability.
    pub log_prior: f64,
    /// Means and variances of its columns.
    pub gauss: Gauss,
    /// How they vary together; nothing where they are taken as independent.
    pub correlation: Option<Correlation>,
}

/// The model of a sample: classes by cluster.
#[derive(Clone, Debug)]
pub(super) struct Classes(pub Vec<Vec<Class>>);

/// Sums of products of distances from the means, in full squares: by cluster, then class.
pub(super) struct Scatter(Vec<Vec<(f64, Vec<f64>)>>);

impl Classes {
    /// Columns are independent; a class spreads as all classes of its cluster do by so many rows' worth of `belief`.
    pub fn of(sample: Sample<'_>, belief: f64) -> Self {
        let Sample { matrix, shares, labels, classes } = sample;
        let model = |weights: &Vec<f64>| {
            let whole = moments(matrix, weights);
            let own = |class: usize| {
                let weight = |(w, l): (&f64, &usize)| if *l == class { *w } else { 0.0 };
                let weights: Vec<f64> = weights.iter().zip(labels).map(weight).collect();
                (weights.iter().sum::<f64>(), moments(matrix, &weights))
            };
            let own: Vec<(f64, Moments)> = (0..classes).map(own).collect();
            let common = common(&own, matrix.width);
            let total = matrix.rows() as f64;
            let one = |(n, m): &(f64, Moments)| Class {
                log_prior: num::ln((n + UNSEEN) / total),
                gauss: gauss(m, (&whole.mean, &common), belief),
                correlation: None,
            };
            own.iter().map(one).collect()
        };
        Self(shares.iter().map(model).collect())
    }

    /// How columns of `sample` vary together around these means. An absent cell varies with nothing, so every matrix is of
    /// some sample, and positive semi-definite.
    pub fn scatter(&self, sample: Sample<'_>) -> Scatter {
        let width = sample.matrix.width;
        let mut off = vec![0.0; width];
        let mut of = |(cluster, shares): (&Vec<Class>, &Vec<f64>)| {
            let mut sums = vec![(0.0, vec![0.0; width * width]); cluster.len()];
            for (row, (&share, &label)) in shares.iter().zip(sample.labels).enumerate() {
                let mean = &cluster[label].gauss.mean;
                for ((off, z), mean) in off.iter_mut().zip(sample.matrix.row(row)).zip(mean) {
                    *off = if z.is_nan() { 0.0 } else { z - mean };
                }
                let (weight, products) = &mut sums[label];
                *weight += share;
                for i in 0..width {
                    let scaled = share * off[i];
                    let row = &mut products[i * width..=i * width + i];
                    row.iter_mut().zip(&off).for_each(|(sum, off)| *sum += scaled * off);
                }
            }
            sums
        };
        Scatter(self.0.iter().zip(sample.shares).map(&mut of).collect())
    }

    /// The same classes with columns that vary together like this: each as all classes of its cluster by so many rows' worth
    /// of `belief`, and all correlations less by the share `independence` (1: as they were).
    pub fn correlated(mut self, scatter: &Scatter, (belief, independence): (f64, f64)) -> Self {
        if independence >= 1.0 {
            return self;
        }
        for (cluster, scatter) in self.0.iter_mut().zip(&scatter.0) {
            let cells = scatter.first().map_or(0, |(_, products)| products.len());
            let freedom = scatter.iter().map(|(n, _)| n).sum::<f64>() - scatter.len() as f64;
            let sum = |cell: usize| scatter.iter().map(|(_, products)| products[cell]).sum::<f64>();
            let common: Vec<f64> = (0..cells).map(|cell| sum(cell) / freedom.max(1.0)).collect();
            for (class, (_, products)) in cluster.iter_mut().zip(scatter) {
                let width = class.gauss.mean.len();
                let blend = |i: usize, j: usize| products[i * width + j] + belief * common[i * width + j];
                let scale: Vec<f64> = (0..width).map(|i| blend(i, i).max(f64::MIN_POSITIVE).sqrt()).collect();
                let of = |i: usize, j: usize| (1.0 - independence) * blend(i, j) / (scale[i] * scale[j]);
                class.correlation = Some(Correlation::new(width, of));
            }
        }
        self
    }

    /// Sum of the log-losses of the classes of the rows.
    pub fn loss(&self, matrix: &Matrix, labels: &[usize]) -> f64 {
        let (mut sum, mut whitener) = (0.0, Whitener::default());
        for (i, &label) in labels.iter().enumerate() {
            let row = matrix.row(i);
            let mut joint = |class: usize| {
                let mut log = |cluster: &Vec<Class>| cluster[class].log_joint(row, &mut whitener);
                num::log_sum_exp(&self.0.iter().map(&mut log).collect::<Vec<f64>>())
            };
            let all: Vec<f64> = (0..self.0[0].len()).map(&mut joint).collect();
            sum += num::log_sum_exp(&all) - all[label];
        }
        sum
    }
}

impl Class {
    /// Logarithm of prior and density at what is known of a row, up to a constant per known column.
    fn log_joint(&self, row: &[f64], whitener: &mut Whitener) -> f64 {
        let Some(correlation) = &self.correlation else {
            return self.log_prior + self.gauss.log_density(row);
        };
        let known = row.iter().enumerate().filter(|(_, z)| !z.is_nan()).map(|(j, _)| j);
        correlation.among(known, whitener);
        self.log_prior + self.gauss.log_density_together(row, whitener)
    }
}

/// Variance within classes, column by column.
fn common(own: &[(f64, Moments)], width: usize) -> Vec<f64> {
    let column = |j: usize| {
        let scatter: f64 = own.iter().map(|(_, m)| m.scatter[j]).sum();
        let freedom: f64 = own.iter().map(|(_, m)| m.weight[j]).sum::<f64>() - own.len() as f64;
        scatter / freedom.max(1.0) + SMALLEST
    };
    (0..width).map(column).collect()
}

/// A class in a cluster. Its means are pulled to the cluster's the more, the less they stand out of their own error
/// (James and Stein): most columns tell nothing, and what they seem to tell by chance must not add up.
fn gauss(own: &Moments, (centre, common): (&[f64], &[f64]), belief: f64) -> Gauss {
    let mean = |j: usize| {
        let off = own.mean[j] - centre[j];
        let error = common[j] / own.weight[j].max(1e-9);
        centre[j] + off * (1.0 - error / (off * off).max(1e-12)).max(0.0)
    };
    let variance = |j: usize| (own.scatter[j] + belief * common[j]) / (own.weight[j] + belief);
    let width = 0..centre.len();
    Gauss::new(width.clone().map(mean).collect(), width.map(variance).collect())
}
