//! What all mixtures of a learner share: dimension, densities, gate and rules, worked out once from the settings.

use crate::num;
use serde::{Deserialize, Serialize};

/// How components move and stretch; in configurations `shape`. Reading R30.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Shape {
    /// "Parameters adapted by the estimated action value": better than expected attracts and widens, worse than
    /// expected shrinks; the mean is never pushed away.
    Signed {
        /// η: size of a step, in (0, 0.5].
        step: f64,
    },
    /// Follows the states alone, whatever they were worth, as incremental Gaussian networks do.
    Resp {
        /// Smallest share of a sample per unit of responsibility, in \[0, 0.5\].
        least: f64,
    },
}

/// Settings in the form the inner loops want.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Frame {
    pub dims: usize,
    pub full: bool,
    pub first_width: f64,
    pub smallest_width: f64,
    pub most_mass: f64,
    pub background_mass: f64,
    pub background_value: f64,
    pub prior_count: f64,
    pub shape: Shape,
    /// Exponent of every density: effective dimensions / dimensions (reading R26).
    pub sharpness: f64,
    /// Scaled squared distance beyond which a state is new.
    pub gate: f64,
    pub cap: usize,
    pub prune_age: f64,
    pub prune_mass: f64,
}

impl Frame {
    /// ln of a density from ln |Σ| and the squared distance.
    ///
    /// # Formula
    /// l = −f/2 (d ln 2π + ln |Σ| + D²),  f: sharpness
    #[inline]
    pub fn log_density(&self, log_det: f64, d2: f64) -> f64 {
        const LN_TWO_PI: f64 = 1.837_877_066_409_345_5;
        -0.5 * self.sharpness * (self.dims as f64 * LN_TWO_PI + log_det + d2)
    }

    /// Whether a state at this squared distance from its nearest component is new.
    pub fn is_novel(&self, nearest: f64) -> bool {
        let distance = nearest * self.sharpness;
        distance > self.gate || distance.is_nan()
    }
}

/// Quantile of the χ² distribution (Wilson and Hilferty 1931).
pub(crate) fn chi_squared_quantile(dims: f64, probability: f64) -> f64 {
    let spread = 2.0 / (9.0 * dims);
    let root = 1.0 - spread + normal_quantile(probability) * spread.sqrt();
    dims * root * root * root
}

/// Quantile of the standard normal distribution, by bisection: it is needed once per learner.
fn normal_quantile(probability: f64) -> f64 {
    let (mut low, mut high) = (-9.0, 9.0);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        let below = 0.5 * (1.0 + num::erf(middle * std::f64::consts::FRAC_1_SQRT_2));
        if below < probability { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_tables() {
        assert!((normal_quantile(0.9) - 1.281_551_565_5).abs() < 1e-9);
        for (dims, table) in [(2.0, 4.605), (4.0, 7.779), (24.0, 33.196)] {
            let is = chi_squared_quantile(dims, 0.9);
            assert!((is / table - 1.0).abs() < 0.01, "{is} not {table}");
        }
    }
}
