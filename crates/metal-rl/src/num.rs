//! The one door to transcendental functions.
//!
//! The standard library forwards `exp`, `ln`, `sin` … to the platform's own mathematics library, whose last bit
//! differs between machines. Everything here goes to `libm` instead, so that the same seed gives the same bits
//! everywhere. `sqrt`, `abs`, `floor` and the four operations are exact by IEEE 754 and may be used directly.
//! Fused multiply-add is not used anywhere, for the same reason.

/// e to the power `x`.
#[must_use]
pub fn exp(x: f64) -> f64 {
    libm::exp(x)
}

/// e to the power `x`, |x| ≤ 700, within one unit in the last place: without branches or tables, so that a loop over it
/// becomes vectors, each lane with the bits of the scalar.
///
/// # Formula
/// eˣ = 2ⁿ eʳ,  n = round(x / ln 2),  eʳ = Σₖ rᵏ/k!, k ≤ 13
#[inline(always)]
pub(crate) fn exp_branchless(x: f64) -> f64 {
    /// Adding this leaves a whole number, its two's complement in the lowest bits.
    const ROUND: f64 = 6_755_399_441_055_744.0;
    /// The leading bits of ln 2: times a small whole number without rounding.
    const LN_2_HIGH: f64 = 6.931_471_803_691_238e-1;
    const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;
    let shifted = x * std::f64::consts::LOG2_E + ROUND;
    let n = shifted - ROUND;
    let r = (x - n * LN_2_HIGH) - n * LN_2_LOW;
    let (r2, pair) = (r * r, |k: usize| INVERSE_FACTORIALS[k] + r * INVERSE_FACTORIALS[k + 1]);
    let r4 = r2 * r2;
    let (low, middle, high) = (pair(2) + r2 * pair(4), pair(6) + r2 * pair(8), pair(10) + r2 * pair(12));
    let power = 1.0 + (r + r2 * (low + r4 * (middle + r4 * high)));
    f64::from_bits(power.to_bits().wrapping_add(shifted.to_bits() << 52))
}

/// 1/k!
const INVERSE_FACTORIALS: [f64; 14] = {
    let (mut inverses, mut factorial, mut k) = ([1.0; 14], 1.0, 1);
    while k < 14 {
        factorial *= k as f64;
        inverses[k] = 1.0 / factorial;
        k += 1;
    }
    inverses
};

/// Natural logarithm.
#[must_use]
pub fn ln(x: f64) -> f64 {
    libm::log(x)
}

/// `x` to the power `y`.
#[must_use]
pub fn pow(x: f64, y: f64) -> f64 {
    libm::pow(x, y)
}

/// Sine of an angle in radians.
#[must_use]
pub fn sin(x: f64) -> f64 {
    libm::sin(x)
}

/// Cosine of an angle in radians.
#[must_use]
pub fn cos(x: f64) -> f64 {
    libm::cos(x)
}

/// Sine and cosine of an angle in radians.
#[must_use]
pub fn sin_cos(x: f64) -> (f64, f64) {
    libm::sincos(x)
}

/// Tangent of an angle in radians.
#[must_use]
pub fn tan(x: f64) -> f64 {
    libm::tan(x)
}

/// Angle in radians of the vector (`x`, `y`), in (−π, π].
#[must_use]
pub fn atan2(y: f64, x: f64) -> f64 {
    libm::atan2(y, x)
}

/// Length of the vector (`x`, `y`).
#[must_use]
pub fn hypot(x: f64, y: f64) -> f64 {
    libm::hypot(x, y)
}

/// Hyperbolic tangent.
#[must_use]
pub fn tanh(x: f64) -> f64 {
    libm::tanh(x)
}

/// Natural logarithm of the gamma function.
#[must_use]
pub fn ln_gamma(x: f64) -> f64 {
    libm::lgamma(x)
}

/// Error function.
#[must_use]
pub fn erf(x: f64) -> f64 {
    libm::erf(x)
}

/// The angle `x` in radians, brought into (−π, π].
#[must_use]
pub fn wrap_angle(x: f64) -> f64 {
    let turn = 2.0 * std::f64::consts::PI;
    let wrapped = x - turn * ((x + std::f64::consts::PI) / turn).floor();
    if wrapped <= -std::f64::consts::PI { wrapped + turn } else { wrapped }
}

/// Index of the largest entry; the lowest index wins a tie, and an empty or all-NaN slice gives 0.
#[must_use]
pub fn argmax(values: &[f64]) -> usize {
    let mut best = 0;
    for (i, &v) in values.iter().enumerate().skip(1) {
        if v > values[best] || values[best].is_nan() {
            best = i;
        }
    }
    best
}

/// Largest entry (−∞ for an empty slice).
#[must_use]
pub fn max(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

/// Smallest entry (∞ for an empty slice).
#[must_use]
pub fn min(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::INFINITY, f64::min)
}

/// ln Σ exp(x), without overflow.
#[must_use]
pub fn log_sum_exp(values: &[f64]) -> f64 {
    let top = max(values);
    if !top.is_finite() {
        return top;
    }
    top + ln(values.iter().map(|&v| exp(v - top)).sum())
}

/// Turns `values` into soft-max probabilities in place.
///
/// # Formula
/// p\[j\] = exp(v\[j\]/T) / Σₖ exp(v\[k\]/T),  T: temperature, same unit as the values, > 0
pub fn soft_max(values: &mut [f64], temperature: f64) {
    let top = max(values);
    let mut sum = 0.0;
    for v in values.iter_mut() {
        *v = exp((*v - top) / temperature);
        sum += *v;
    }
    for v in values.iter_mut() {
        *v /= sum;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Rng;

    #[test]
    fn the_branchless_exponential_is_within_one_unit_of_the_other() {
        let mut rng = Rng::new(1);
        for range in [1e-9, 1.0, 40.0, 700.0] {
            for _ in 0..200_000 {
                let x = rng.range(-range, range);
                let apart = exp_branchless(x).to_bits().abs_diff(exp(x).to_bits());
                assert!(apart <= 1, "{x}: {apart} units");
            }
        }
        assert_eq!((exp_branchless(0.0), exp_branchless(-0.0)), (1.0, 1.0));
    }

    #[test]
    fn angles_wrap_into_the_half_open_circle() {
        let pi = std::f64::consts::PI;
        for k in -3..=3 {
            let turns = f64::from(k) * 2.0 * pi;
            assert!((wrap_angle(0.3 + turns) - 0.3).abs() < 1e-12);
            assert!((wrap_angle(-3.0 + turns) + 3.0).abs() < 1e-12);
        }
        assert_eq!(wrap_angle(-pi), pi);
    }

    #[test]
    fn soft_max_survives_large_values() {
        let mut v = [1e6, 1e6 - 1.0];
        soft_max(&mut v, 1.0);
        assert!((v[0] + v[1] - 1.0).abs() < 1e-15);
        assert!((v[0] / v[1] - std::f64::consts::E).abs() < 1e-9);
    }

    #[test]
    fn the_lowest_index_wins_a_tie() {
        assert_eq!(argmax(&[1.0, 2.0, 2.0]), 1);
        assert_eq!(argmax(&[]), 0);
    }
}
