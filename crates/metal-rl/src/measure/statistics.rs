//! Means with honest uncertainty over seeds and runs. All intervals are two-sided at 95 % (reading R69).

use crate::random::Streams;
use serde::{Deserialize, Serialize};

mod student;
pub use student::{student_t_cdf, student_t_quantile};

/// A number and its 95 % interval. A single observation has no interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// The estimated number.
    pub mean: f64,
    /// Lower end of the interval.
    pub lo: Option<f64>,
    /// Upper end of the interval.
    pub hi: Option<f64>,
    /// Number of independent observations behind it.
    pub n: usize,
}

impl Estimate {
    /// A mean without an interval.
    #[must_use]
    pub fn point(mean: f64, n: usize) -> Self {
        Self { mean, lo: None, hi: None, n }
    }

    /// A mean with its interval.
    #[must_use]
    pub fn interval(mean: f64, lo: f64, hi: f64, n: usize) -> Self {
        Self { mean, lo: Some(lo), hi: Some(hi), n }
    }

    fn around(mean: f64, margin: f64, n: usize) -> Self {
        Self::interval(mean, mean - margin, mean + margin, n)
    }

    /// Both ends of the interval, if it is known.
    #[must_use]
    pub fn band(&self) -> Option<(f64, f64)> {
        self.lo.zip(self.hi)
    }

    /// Whether the two intervals are known and have no value in common.
    #[must_use]
    pub fn is_apart_from(&self, other: &Self) -> bool {
        match (self.band(), other.band()) {
            (Some((lo, hi)), Some((other_lo, other_hi))) => hi < other_lo || other_hi < lo,
            _ => false,
        }
    }
}

/// Half of what is left out of a 95 % interval.
const TAIL: f64 = 0.025;
/// Standard normal quantile of 97.5 %.
const NORMAL_QUANTILE: f64 = 1.959_963_984_540_054;

/// Arithmetic mean; none without values.
#[must_use]
pub fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// Standard deviation of a sample (divisor n − 1); none for fewer than two values.
#[must_use]
pub fn sample_sd(values: &[f64]) -> Option<f64> {
    let centre = mean(values)?;
    let squares: f64 = values.iter().map(|v| (v - centre) * (v - centre)).sum();
    (values.len() > 1).then(|| (squares / (values.len() - 1) as f64).sqrt())
}

/// Mean of the middle half: a quarter of the values (rounded down) is cut off at either end.
#[must_use]
pub fn interquartile_mean(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let cut = sorted.len() / 4;
    mean(&sorted[cut..sorted.len() - cut])
}

/// The value below which the share `p` of `sorted` lies, linear between neighbours (numpy's default).
#[must_use]
pub fn quantile(sorted: &[f64], p: f64) -> Option<f64> {
    let last = sorted.len().checked_sub(1)?;
    let place = p.clamp(0.0, 1.0) * last as f64;
    let below = place.floor() as usize;
    let above = (below + 1).min(last);
    Some(sorted[below] + (place - below as f64) * (sorted[above] - sorted[below]))
}

/// Mean over independent seeds with Student's t interval; none without values.
///
/// # Formula
/// mean ± t(0.975, n − 1) sd / √n
#[must_use]
pub fn student(values: &[f64]) -> Option<Estimate> {
    let (centre, n) = (mean(values)?, values.len());
    Some(match sample_sd(values) {
        None => Estimate::point(centre, n),
        Some(sd) => {
            let t = student_t_quantile(1.0 - TAIL, (n - 1) as f64);
            Estimate::around(centre, t * sd / (n as f64).sqrt(), n)
        }
    })
}

/// Mean difference `first` − `second` of paired observations (same seed, same start) with Student's t interval.
///
/// # Panics
/// If the lengths differ: then they are no pairs.
#[must_use]
pub fn paired_difference(first: &[f64], second: &[f64]) -> Option<Estimate> {
    assert_eq!(first.len(), second.len(), "paired observations come in pairs");
    student(&first.iter().zip(second).map(|(a, b)| a - b).collect::<Vec<_>>())
}

/// Proportion `successes` / `trials` with Wilson's score interval, which stays honest at 0 and 1; none without trials.
///
/// # Formula
/// (p + z²/2n ± z √(p(1−p)/n + z²/4n²)) / (1 + z²/n),  z = 1.96
#[must_use]
pub fn wilson(successes: u64, trials: u64) -> Option<Estimate> {
    if trials == 0 {
        return None;
    }
    let (n, z) = (trials as f64, NORMAL_QUANTILE);
    let p = successes as f64 / n;
    let centre = p + z * z / (2.0 * n);
    let margin = z * (p * (1.0 - p) / n + z * z / (4.0 * n * n)).sqrt();
    let scale = 1.0 + z * z / n;
    let bounded = |x: f64| Some(x.clamp(0.0, 1.0));
    // The ends are exact where all or nothing succeeded; rounding must not say otherwise.
    let lo = if successes == 0 { Some(0.0) } else { bounded((centre - margin) / scale) };
    let hi = if successes == trials { Some(1.0) } else { bounded((centre + margin) / scale) };
    Some(Estimate { mean: p, lo, hi, n: usize::try_from(trials).unwrap_or(usize::MAX) })
}

/// How to resample.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bootstrap {
    /// Number of resamples.
    pub resamples: usize,
    /// Seed of the resampling.
    pub seed: u64,
}

impl Default for Bootstrap {
    fn default() -> Self {
        Self { resamples: 2000, seed: 0 }
    }
}

impl Bootstrap {
    /// `statistic` of all values with its percentile interval; none without values.
    ///
    /// Every stratum (e.g. the episodes of one seed) is resampled within itself; one stratum is the plain bootstrap.
    /// With fewer than two values, no resamples, or strata of one value each, there is no interval. For few seeds the
    /// percentile interval is too narrow: prefer [`student`] below about ten.
    #[must_use]
    pub fn estimate(&self, strata: &[&[f64]], statistic: impl Fn(&[f64]) -> f64) -> Option<Estimate> {
        let all: Vec<f64> = strata.concat();
        if all.is_empty() {
            return None;
        }
        let centre = statistic(&all);
        if self.resamples == 0 || strata.iter().all(|s| s.len() < 2) {
            return Some(Estimate::point(centre, all.len()));
        }
        let mut replicas = self.replicas(strata, all.len(), statistic);
        replicas.sort_by(f64::total_cmp);
        let (lo, hi) = (quantile(&replicas, TAIL), quantile(&replicas, 1.0 - TAIL));
        Some(Estimate { mean: centre, lo, hi, n: all.len() })
    }

    fn replicas(&self, strata: &[&[f64]], n: usize, statistic: impl Fn(&[f64]) -> f64) -> Vec<f64> {
        let mut rng = Streams::new(self.seed).stream("bootstrap");
        let mut sample = Vec::with_capacity(n);
        (0..self.resamples)
            .map(|_| {
                sample.clear();
                for stratum in strata {
                    sample.extend((0..stratum.len()).map(|_| stratum[rng.below(stratum.len())]));
                }
                statistic(&sample)
            })
            .collect()
    }
}

#[cfg(test)]
mod tests;
