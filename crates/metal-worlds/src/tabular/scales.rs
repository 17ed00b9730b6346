//! Units in which columns are modelled.

use metal_rl::num;

/// Kinds of units.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Units {
    /// Distance from the mean in standard deviations.
    Spread,
    /// Normal scores: which share of the column lies below, as a quantile of the normal distribution. Skewed columns
    /// become symmetric, and nothing outside the column's range can be imagined.
    Ranks,
}

/// The units of one column.
#[derive(Clone, Debug)]
pub(super) struct Scale {
    units: Units,
    mean: f64,
    spread: f64,
    sorted: Vec<f64>,
    scores: Vec<f64>,
    distinct: Vec<f64>,
}

impl Scale {
    /// Units of a column with these known values.
    pub fn of(mut values: Vec<f64>, units: Units) -> Self {
        values.sort_by(f64::total_cmp);
        let n = values.len().max(1) as f64;
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / n;
        let spread = if variance > 0.0 { variance.sqrt() } else { 1.0 };
        let scores = match units {
            Units::Spread => Vec::new(),
            Units::Ranks => (0..values.len()).map(|i| normal_quantile((i as f64 + 0.5) / n)).collect(),
        };
        let mut distinct = values.clone();
        distinct.dedup();
        Self { units, mean, spread, sorted: values, scores, distinct }
    }

    /// A value in these units.
    pub fn there(&self, x: f64) -> f64 {
        match self.units {
            Units::Spread => (x - self.mean) / self.spread,
            Units::Ranks => interpolate(&self.sorted, &self.scores, x),
        }
    }

    /// How to get from a value in [0, 1] of the range `low` to `high` to these units: knots of a piecewise linear line.
    pub fn ruler(&self, low: f64, high: f64) -> Vec<[f64; 2]> {
        let knot = |x: f64| [(x - low) / (high - low), self.there(x)];
        match self.units {
            Units::Spread => vec![knot(low), knot(high)],
            Units::Ranks => self.distinct.iter().map(|&x| knot(x)).collect(),
        }
    }

    /// The value that is `z` in these units.
    pub fn back(&self, z: f64) -> f64 {
        match self.units {
            Units::Spread => self.mean + self.spread * z,
            Units::Ranks => interpolate(&self.scores, &self.sorted, z),
        }
    }

    /// The nearest value of a column that has at most `few` different ones; `x` itself elsewhere.
    pub fn nearest(&self, x: f64, few: usize) -> f64 {
        if self.distinct.len() > few {
            return x;
        }
        let nearer = |best: f64, &next: &f64| if (next - x).abs() < (best - x).abs() { next } else { best };
        self.distinct.iter().fold(f64::INFINITY, nearer)
    }
}

/// Piecewise linear through (xs, ys), xs rising, flat outside; among equal xs the middle one counts.
fn interpolate(xs: &[f64], ys: &[f64], x: f64) -> f64 {
    let below = xs.partition_point(|&known| known < x);
    let up_to = xs.partition_point(|&known| known <= x);
    if xs.is_empty() {
        return 0.0;
    }
    if up_to > below {
        return ys[(below + up_to - 1) / 2];
    }
    if below == 0 || below == xs.len() {
        return ys[below.min(xs.len() - 1)];
    }
    let part = (x - xs[below - 1]) / (xs[below] - xs[below - 1]);
    ys[below - 1] + part * (ys[below] - ys[below - 1])
}

/// The number below which a normal variable falls with probability `p`, by halving.
fn normal_quantile(p: f64) -> f64 {
    let (mut low, mut high) = (-9.0, 9.0);
    for _ in 0..60 {
        let middle: f64 = (low + high) / 2.0;
        if 0.5 * (1.0 + num::erf(middle / std::f64::consts::SQRT_2)) < p {
            low = middle
        } else {
            high = middle
        }
    }
    (low + high) / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_and_back_again() {
        let values: Vec<f64> = (0..50).map(|i| f64::from(i * i)).collect();
        for units in [Units::Spread, Units::Ranks] {
            let scale = Scale::of(values.clone(), units);
            for x in [0.0, 9.0, 700.0, 2401.0] {
                assert!((scale.back(scale.there(x)) - x).abs() < 1e-9, "{units:?} {x}");
            }
        }
        let ranks = Scale::of(values, Units::Ranks);
        assert!(ranks.back(99.0) <= 2401.0 && ranks.there(600.3).abs() < 0.1, "the middle is 0");
    }

    #[test]
    fn quantiles_are_those_of_the_normal_distribution() {
        assert!((normal_quantile(0.975) - 1.959_964).abs() < 1e-5);
        assert!(normal_quantile(0.5).abs() < 1e-9);
    }

    #[test]
    fn few_values_stay_few() {
        let bits = Scale::of(vec![0.0, 1.0, 1.0], Units::Spread);
        assert_eq!((bits.nearest(0.4, 16), bits.nearest(0.7, 16), bits.nearest(0.7, 1)), (0.0, 1.0, 0.7));
    }
}
