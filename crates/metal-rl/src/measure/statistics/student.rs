//! Student's t distribution, by the regularised incomplete beta function.

use crate::num;

/// Probability that Student's t with `freedom` > 0 degrees of freedom is at most `t`.
///
/// # Formula
/// F(t) = 1 − I(ν/(ν + t²); ν/2, 1/2) / 2 for t ≥ 0,  ν: `freedom`, I: regularised incomplete beta function
#[must_use]
pub fn student_t_cdf(t: f64, freedom: f64) -> f64 {
    let whole = freedom + t * t;
    let tail = 0.5 * incomplete_beta((freedom / whole, t * t / whole), freedom / 2.0, 0.5);
    if t >= 0.0 { 1.0 - tail } else { tail }
}

/// The t below which Student's distribution with `freedom` > 0 degrees of freedom has probability `p` in (0, 1).
#[must_use]
pub fn student_t_quantile(p: f64, freedom: f64) -> f64 {
    if p < 0.5 {
        return -student_t_quantile(1.0 - p, freedom);
    }
    let (mut low, mut high) = (0.0, 1.0);
    while student_t_cdf(high, freedom) < p && high < f64::MAX / 4.0 {
        high *= 2.0;
    }
    // Bisection: slow but it cannot fail, and nobody asks often. Halving 200 times exhausts every f64.
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if student_t_cdf(middle, freedom) < p {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// Regularised incomplete beta function I(x; a, b) for x in [0, 1]. `rest` is 1 − x, which the caller knows without
/// the rounding of a subtraction.
fn incomplete_beta((x, rest): (f64, f64), a: f64, b: f64) -> f64 {
    if x <= 0.0 || rest <= 0.0 {
        return if x <= 0.0 { 0.0 } else { 1.0 };
    }
    let ln_beta = num::ln_gamma(a) + num::ln_gamma(b) - num::ln_gamma(a + b);
    let front = num::exp(a * num::ln(x) + b * num::ln(rest) - ln_beta);
    // The fraction converges quickly only left of the mean; I(x; a, b) = 1 − I(1 − x; b, a) turns the right side over.
    if x < (a + 1.0) / (a + b + 2.0) {
        front * beta_fraction(x, a, b) / a
    } else {
        1.0 - front * beta_fraction(rest, b, a) / b
    }
}

/// Continued fraction of the incomplete beta function (Lentz's method).
fn beta_fraction(x: f64, a: f64, b: f64) -> f64 {
    let not_zero = |v: f64| if v.abs() < 1e-300 { 1e-300 } else { v };
    let mut c = 1.0;
    let mut d = 1.0 / not_zero(1.0 - (a + b) * x / (a + 1.0));
    let mut fraction = d;
    for m in 1..500 {
        let m = f64::from(m);
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        for term in [even, odd] {
            d = 1.0 / not_zero(1.0 + term * d);
            c = not_zero(1.0 + term / c);
            fraction *= c * d;
        }
        if (c * d - 1.0).abs() < 1e-15 {
            break;
        }
    }
    fraction
}
