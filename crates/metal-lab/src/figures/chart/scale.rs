//! From values to pixels, and where to put the ticks.

use metal_rl::num;

/// A linear map from values to pixels; either end may be the larger.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    from: (f64, f64),
    to: (f64, f64),
}

impl Scale {
    /// Maps `from.0` to `to.0` and `from.1` to `to.1`; a domain of no width maps to the middle.
    #[must_use]
    pub fn new(from: (f64, f64), to: (f64, f64)) -> Self {
        Self { from, to }
    }

    /// The pixel of `value`.
    #[must_use]
    pub fn at(&self, value: f64) -> f64 {
        let width = self.from.1 - self.from.0;
        let share = if width.abs() > 0.0 { (value - self.from.0) / width } else { 0.5 };
        self.to.0 + share * (self.to.1 - self.to.0)
    }

    /// The value of the domain that is nearest to `value`.
    #[must_use]
    pub fn inside(&self, value: f64) -> f64 {
        value.clamp(self.from.0.min(self.from.1), self.from.0.max(self.from.1))
    }
}

/// About `count` round numbers that cover the values between `low` and `high`; the first and last enclose them.
#[must_use]
pub fn ticks(low: f64, high: f64, count: usize) -> Vec<f64> {
    let (low, high) = if high > low { (low, high) } else { (low - 0.5, low + 0.5) };
    let step = round_step((high - low) / count.max(1) as f64);
    let first = (low / step + 1e-9).floor();
    let last = (high / step - 1e-9).ceil();
    let steps = (last - first) as usize;
    (0..=steps).map(|i| (first + i as f64) * step).map(|v| if v == 0.0 { 0.0 } else { v }).collect()
}

/// The next of 1, 2, 5 × a power of ten at or above `rough`.
fn round_step(rough: f64) -> f64 {
    let power = num::pow(10.0, (num::ln(rough) / std::f64::consts::LN_10).floor());
    let fine = rough / power;
    let factor = [1.0, 2.0, 5.0].into_iter().find(|&f| fine <= f * (1.0 + 1e-9)).unwrap_or(10.0);
    factor * power
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_falling_axis_is_fine() {
        let scale = Scale::new((0.0, -30.0), (100.0, 400.0));
        assert!((scale.at(-10.0) - 200.0).abs() < 1e-9);
    }

    proptest! {
        #[test]
        fn ticks_enclose_the_values(low in -1e4_f64..1e4, width in 1e-3_f64..1e4) {
            let marks = ticks(low, low + width, 5);
            prop_assert!(marks.len() >= 2 && marks.len() <= 9, "{marks:?}");
            prop_assert!(marks[0] <= low + 1e-6 * width);
            prop_assert!(marks[marks.len() - 1] >= low + width * (1.0 - 1e-6));
        }
    }
}
