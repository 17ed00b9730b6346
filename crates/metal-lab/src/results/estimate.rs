//! A mean with its interval.

use serde::{Deserialize, Serialize};

/// A mean with its 95 % interval and the number of independent values behind it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// The mean.
    pub mean: f64,
    /// Lower end of the 95 % interval; absent (`null`) when fewer than two values are known.
    pub lo: Option<f64>,
    /// Upper end of the 95 % interval; absent (`null`) when fewer than two values are known.
    pub hi: Option<f64>,
    /// Number of independent values.
    pub n: u64,
}

impl Estimate {
    /// A mean without an interval.
    #[must_use]
    pub fn point(mean: f64, n: u64) -> Self {
        Self { mean, lo: None, hi: None, n }
    }

    /// A mean with its interval.
    #[must_use]
    pub fn interval(mean: f64, lo: f64, hi: f64, n: u64) -> Self {
        Self { mean, lo: Some(lo), hi: Some(hi), n }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_known_disjoint_intervals_are_apart() {
        let low = Estimate::interval(1.0, 0.5, 1.5, 5);
        let high = Estimate::interval(2.0, 1.6, 2.4, 5);
        assert!(low.is_apart_from(&high) && high.is_apart_from(&low));
        assert!(!low.is_apart_from(&Estimate::interval(2.0, 1.4, 2.6, 5)));
        assert!(!low.is_apart_from(&Estimate::point(9.0, 1)));
    }
}
