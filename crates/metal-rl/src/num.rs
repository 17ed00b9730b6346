//! The one door to transcendental functions.
//!
//! The standard library forwards `exp`, `ln`, `sin` … to the platform's own mathematics library, whose last bit
//! differs between machines. Everything here goes to `libm` instead, so that the same seed gives the same bits
//! everywhere. `sqrt`, `abs`, `floor` and the four operations are exact by IEEE 754 and may be used directly.
//! So is fused multiply-add, where it is asked for by name; without an instruction of its own it is slow, so only loops
//! that are compiled for processors that have one ask for it.

mod abreast;
pub(crate) mod cholesky;

pub(crate) use abreast::{exp_of_each, ln_of_each};

/// e to the power `x`.
#[must_use]
pub fn exp(x: f64) -> f64 {
    libm::exp(x)
}

/// Adding this leaves a whole number, its two's complement in the lowest bits.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// ln 2 in two parts, the first of which is exact times any exponent.
const LN_2_HIGH: f64 = 6.931_471_803_691_238e-1;
const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;

/// a b + c in one rounding, everywhere the same bits. Only for loops that are compiled for processors with an instruction for
/// it (`multiversion`): elsewhere it is slow.
#[inline(always)]
#[allow(clippy::disallowed_methods)]
pub(crate) fn fused(a: f64, b: f64, c: f64) -> f64 {
    a.mul_add(b, c)
}

/// e to the power `x`, −700 ≤ x ≤ 0: [`exp_of_negatives`] of one.
#[inline(always)]
pub(crate) fn exp_of_negative(x: f64) -> f64 {
    exp_of_negatives(&[x])[0]
}

/// e to the power of each `x`, −700 ≤ x ≤ 0, within 2 units of the last place: without branches, so that it becomes
/// vectors, and step by step for all of them, since each step waits for the one before. For the same loops as [`fused`].
///
/// # Formula
/// eˣ = 2ᵏ Σᵢ rⁱ/i!,  i = 0 … 12,  k = x/ln 2 to the nearest whole number,  r = x − k ln 2
#[inline(always)]
pub(crate) fn exp_of_negatives<const N: usize>(x: &[f64; N]) -> [f64; N] {
    /// 1/i! from the last to the first.
    const SERIES: [f64; 13] = [
        1.0 / 479_001_600.0,
        1.0 / 39_916_800.0,
        1.0 / 3_628_800.0,
        1.0 / 362_880.0,
        1.0 / 40_320.0,
        1.0 / 5040.0,
        1.0 / 720.0,
        1.0 / 120.0,
        1.0 / 24.0,
        1.0 / 6.0,
        0.5,
        1.0,
        1.0,
    ];
    let (mut shifted, mut r, mut power) = ([0.0; N], [0.0; N], [SERIES[0]; N]);
    for i in 0..N {
        shifted[i] = fused(x[i], std::f64::consts::LOG2_E, ROUND);
        let k = shifted[i] - ROUND;
        r[i] = fused(k, -LN_2_LOW, fused(k, -LN_2_HIGH, x[i]));
    }
    // Compilers that know the number of steps work one vector out after the other instead.
    let rest = if N > 16 { std::hint::black_box(&SERIES[1..]) } else { &SERIES[1..] };
    for next in rest {
        for i in 0..N {
            power[i] = fused(power[i], r[i], *next);
        }
    }
    for i in 0..N {
        power[i] = f64::from_bits(power[i].to_bits().wrapping_add(shifted[i].to_bits() << 52));
    }
    power
}

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
    for v in values.iter_mut() {
        *v = (*v - top) / temperature;
    }
    exp_of_each(values);
    let mut sum = 0.0;
    for v in values.iter() {
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
    fn the_branchless_exponential_is_right_to_the_last_places() {
        let mut rng = Rng::new(1);
        for range in [1e-9, 1e-8, 0.4, 1.1, 45.0, 700.0] {
            for _ in 0..200_000 {
                let x = -rng.range(0.0, range);
                let (is, should) = (exp_of_negative(x), exp(x));
                assert!(is.to_bits().abs_diff(should.to_bits()) <= 2, "{x}: {is} not {should}");
            }
        }
        assert_eq!([exp_of_negative(0.0), exp_of_negative(-0.0)], [1.0; 2]);
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
