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

/// [`exp`] of −700 ≤ x ≤ 0, bit for bit: the same steps without branches, so that a loop over it becomes vectors.
///
/// # Formula
/// eˣ = 2ᵏ (1 + r + r c/(2 − c)),  r = x − k ln 2,  c = r − r² P(r²)        (P: that of FreeBSD's and `libm`'s exp)
#[inline(always)]
pub(crate) fn exp_of_negative(x: f64) -> f64 {
    /// Adding this leaves a whole number, its two's complement in the lowest bits.
    const ROUND: f64 = 6_755_399_441_055_744.0;
    const LN_2_HIGH: f64 = 6.931_471_803_691_238e-1;
    const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;
    const P: [f64; 5] = [
        1.666_666_666_666_660_2e-1,
        -2.777_777_777_701_559_3e-3,
        6.613_756_321_437_934e-5,
        -1.653_390_220_546_525_2e-6,
        4.138_136_797_057_238_5e-8,
    ];
    // Where the other one branches, to the bit: about 2⁻²⁸, ln 2 / 2 and 3 ln 2 / 2.
    let [tiny, half, more] =
        [0x3e30_0001_0000_0000, 0x3fd6_2e43_0000_0000, 0x3ff0_a2b2_0000_0000].map(f64::from_bits);
    let halves = x * std::f64::consts::LOG2_E - 0.5;
    let near = (halves + ROUND) - ROUND;
    let cut = if near < halves { near + 1.0 } else { near };
    let one = if -x < more { -1.0 } else { cut };
    let k = if -x < half { 0.0 } else { one };
    let (high, low) = (x - k * LN_2_HIGH, k * LN_2_LOW);
    let r = high - low;
    let r2 = r * r;
    let c = r - r2 * (P[0] + r2 * (P[1] + r2 * (P[2] + r2 * (P[3] + r2 * P[4]))));
    let power = 1.0 + (r * c / (2.0 - c) - low + high);
    let power = if -x < tiny { 1.0 + x } else { power };
    f64::from_bits(power.to_bits().wrapping_add((k + ROUND).to_bits() << 52))
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
    fn the_branchless_exponential_has_the_bits_of_the_other() {
        let mut rng = Rng::new(1);
        for range in [1e-9, 1e-8, 0.4, 1.1, 45.0, 700.0] {
            for _ in 0..200_000 {
                let x = -rng.range(0.0, range);
                assert_eq!(exp_of_negative(x).to_bits(), exp(x).to_bits(), "{x}");
            }
        }
        for word in [0x3e30_0001_u64, 0x3fd6_2e43, 0x3ff0_a2b2] {
            let edge = -f64::from_bits(word << 32);
            for x in [edge, edge.next_up(), edge.next_down(), 0.0, -0.0] {
                assert_eq!(exp_of_negative(x).to_bits(), exp(x).to_bits(), "{x}");
            }
        }
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
