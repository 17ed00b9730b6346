//! How the numbers of readings vary together around the means of a hypothesis.

use crate::num::{self, cholesky};
use serde::{Deserialize, Serialize};

/// What is left of the variance of a number that others tell completely.
const LEAST_LEFT: f64 = 1e-6;

/// The correlation matrix of a hypothesis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Correlation {
    numbers: usize,
    lower: Vec<f64>,
}

impl Correlation {
    /// The correlations `of(i, j)`, j < i, of so many numbers. The matrix should be positive definite; where it is not
    /// quite, its factors are those of one nearby that is.
    #[must_use]
    pub fn new(numbers: usize, of: impl Fn(usize, usize) -> f64) -> Self {
        let row = |i: usize| (0..=i).map(move |j| (i, j));
        let cell = |(i, j): (usize, usize)| if i == j { 1.0 } else { of(i, j) };
        Self { numbers, lower: (0..numbers).flat_map(row).map(cell).collect() }
    }

    /// The correlation of two numbers.
    #[must_use]
    pub fn between(&self, i: usize, j: usize) -> f64 {
        self.lower[cholesky::at(i.max(j), i.min(j))]
    }

    /// Whether it is of so many numbers.
    #[must_use]
    pub fn fits(&self, numbers: usize) -> bool {
        self.numbers == numbers && self.lower.len() == cholesky::size(numbers)
    }

    /// Makes `whitener` that of the numbers `known`.
    pub fn among(&self, known: impl Iterator<Item = usize>, whitener: &mut Whitener) {
        let Whitener { places, factor } = whitener;
        places.clear();
        factor.clear();
        for i in known {
            places.push(i);
            factor.extend(places.iter().map(|&j| self.between(i, j)));
        }
        cholesky::factor(factor, places.len());
    }
}

/// Makes what is known of some numbers independent: the Cholesky factor L of their correlations.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Whitener {
    places: Vec<usize>,
    factor: Vec<f64>,
}

impl Whitener {
    /// Distances from the means, in standard deviations and in the order of the known numbers, become independent and
    /// normal of variance 1: L⁻¹ e.
    pub fn whiten(&self, distances: &mut [f64]) {
        cholesky::solve_lower(&self.factor, self.places.len(), distances);
    }

    /// Logarithm of the determinant of the correlations among the known numbers.
    #[must_use]
    pub fn log_determinant(&self) -> f64 {
        let pivot = |i: usize| self.factor[cholesky::at(i, i)];
        2.0 * (0..self.places.len()).map(|i| num::ln(pivot(i))).sum::<f64>()
    }

    /// Independent distances become such as occur together: L e.
    pub fn colour(&self, distances: &mut [f64]) {
        cholesky::multiply_lower(&self.factor, self.places.len(), distances);
    }

    /// What the known numbers foretell of number `j`: appends its weights u on their whitened distances, and returns the
    /// share of its variance that is left.
    ///
    /// # Formula
    /// u = L⁻¹ R(known, j),  left = 1 − u·u
    pub fn foretell(&self, correlation: &Correlation, j: usize, weights: &mut Vec<f64>) -> f64 {
        let start = weights.len();
        weights.extend(self.places.iter().map(|&i| correlation.between(i, j)));
        self.whiten(&mut weights[start..]);
        (1.0 - weights[start..].iter().map(|u| u * u).sum::<f64>()).max(LEAST_LEFT)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn three() -> Correlation {
        Correlation::new(3, |i, j| if i + j == 1 { 0.8 } else { -0.3 })
    }

    #[test]
    fn what_is_foretold_is_regression() {
        let mut whitener = Whitener::default();
        three().among([2, 0].into_iter(), &mut whitener);
        let mut weights = Vec::new();
        let left = whitener.foretell(&three(), 1, &mut weights);
        let mut seen = [0.5, -1.0];
        whitener.whiten(&mut seen);
        let foretold: f64 = weights.iter().zip(seen).map(|(u, t)| u * t).sum();
        // Regression of number 1 on numbers 2 and 0: R⁻¹ (−0.3, 0.8) with R = ((1, −0.3), (−0.3, 1)).
        let slopes = [(-0.3 + 0.3 * 0.8) / 0.91, (0.8 - 0.09) / 0.91];
        assert!((foretold - (0.5 * slopes[0] - slopes[1])).abs() < 1e-12);
        assert!((left - (1.0 + 0.3 * slopes[0] - 0.8 * slopes[1])).abs() < 1e-12);
        assert_eq!(whitener.foretell(&three(), 0, &mut weights), LEAST_LEFT, "it is known");
    }

    #[test]
    fn colour_is_undone_by_whitening() {
        let mut whitener = Whitener::default();
        three().among(0..3, &mut whitener);
        let mut distances = [0.2, -0.7, 1.1];
        whitener.colour(&mut distances);
        assert!((distances[1] - (0.8 * 0.2 - 0.6 * 0.7)).abs() < 1e-12, "{distances:?}");
        let determinant = 1.0 + 2.0 * 0.8 * 0.3 * 0.3 - 0.64 - 0.09 - 0.09;
        assert!((whitener.log_determinant() - num::ln(determinant)).abs() < 1e-12);
        whitener.whiten(&mut distances);
        assert!(distances.iter().zip([0.2, -0.7, 1.1]).all(|(a, b)| (a - b).abs() < 1e-12));
    }
}
