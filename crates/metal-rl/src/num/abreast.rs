//! Logarithms and exponentials of several numbers side by side, with the bits of one alone: a function of `libm` spends most of
//! its time waiting for its own steps and on branches that were guessed wrongly.

use super::{LN_2_HIGH, LN_2_LOW, ROUND, exp, ln};

/// Numbers taken at a time.
const SEVERAL: usize = 8;

/// [`ln`] of each, with the same bits: several side by side, since one alone waits most of the time.
pub(crate) fn ln_of_each(values: &mut [f64]) {
    for some in values.chunks_mut(SEVERAL) {
        if some.iter().all(|&x| (f64::MIN_POSITIVE..=f64::MAX).contains(&x)) {
            side_by_side(some, 1.0, ln_of_normal);
        } else {
            some.iter_mut().for_each(|x| *x = ln(*x));
        }
    }
}

/// [`exp`] of each, with the same bits: several side by side.
pub(crate) fn exp_of_each(values: &mut [f64]) {
    for some in values.chunks_mut(SEVERAL) {
        if some.iter().all(|x| (-700.0..=0.0).contains(x)) {
            side_by_side(some, 0.0, exp_down_from_1);
        } else {
            some.iter_mut().for_each(|x| *x = exp(*x));
        }
    }
}

/// A function of up to [`SEVERAL`] values; it is worked out for `rest` where there are fewer.
#[inline(always)]
fn side_by_side(values: &mut [f64], rest: f64, of: impl Fn(f64) -> f64) {
    let mut all = [rest; SEVERAL];
    all[..values.len()].copy_from_slice(values);
    for x in &mut all {
        *x = of(*x);
    }
    values.copy_from_slice(&all[..values.len()]);
}

/// `libm`'s logarithm (that of FreeBSD) of a normal positive number, operation by operation, without its branches.
///
/// # Formula
/// x = 2ᵏ (1 + f),  √½ ≤ 1 + f < √2,  s = f/(2 + f),  ln x = k ln 2 + f − f²/2 + s (f²/2 + R(s²))
#[inline(always)]
fn ln_of_normal(x: f64) -> f64 {
    /// High word of √½, and how far below 1 it is, as bits of a number.
    const ROOT_OF_HALF: u64 = 0x3fe6_a09e << 32;
    const TO_ONE: u64 = (0x3ff0_0000 - 0x3fe6_a09e) << 32;
    const FRACTION: u64 = (1 << 52) - 1;
    /// 2⁵²: its lowest bits count ones.
    const ONES: f64 = 4_503_599_627_370_496.0;
    const ODD: [f64; 4] = [
        6.666_666_666_666_735e-1,
        2.857_142_874_366_239e-1,
        1.818_357_216_161_805e-1,
        1.479_819_860_511_658_6e-1,
    ];
    const EVEN: [f64; 3] = [3.999_999_999_940_942e-1, 2.222_219_843_214_978_4e-1, 1.531_383_769_920_937_3e-1];
    let bits = x.to_bits() + TO_ONE;
    let k = f64::from_bits((bits >> 52) | ONES.to_bits()) - (ONES + 1023.0);
    let f = f64::from_bits((bits & FRACTION) + ROOT_OF_HALF) - 1.0;
    let half_square = 0.5 * f * f;
    let s = f / (2.0 + f);
    let z = s * s;
    let w = z * z;
    let even = w * (EVEN[0] + w * (EVEN[1] + w * EVEN[2]));
    let odd = z * (ODD[0] + w * (ODD[1] + w * (ODD[2] + w * ODD[3])));
    s * (half_square + (odd + even)) + k * LN_2_LOW - half_square + f + k * LN_2_HIGH
}

/// `libm`'s exponential (that of FreeBSD) of a number from −700 to 0, operation by operation, without its branches.
///
/// # Formula
/// x = k ln 2 + r,  c = r − r² P(r²),  eˣ = 2ᵏ (1 + r + r c/(2 − c))
#[inline(always)]
fn exp_down_from_1(x: f64) -> f64 {
    /// Numbers whose high word is at most that of ½ ln 2, and those whose is below that of 1½ ln 2.
    const HALF: f64 = f64::from_bits(0x3fd6_2e43 << 32);
    const ONE_AND_A_HALF: f64 = f64::from_bits(0x3ff0_a2b2 << 32);
    /// The same of 2⁻²⁸, below which the sum is 1 + x.
    const TINY: f64 = f64::from_bits(0x3e30_0001 << 32);
    const P: [f64; 5] = [
        1.666_666_666_666_660_2e-1,
        -2.777_777_777_701_559_3e-3,
        6.613_756_321_437_934e-5,
        -1.653_390_220_546_525_2e-6,
        4.138_136_797_057_238_5e-8,
    ];
    let turns = std::f64::consts::LOG2_E * x - 0.5;
    let nearest = (turns + ROUND) - ROUND;
    let towards_zero = if nearest < turns { nearest + 1.0 } else { nearest };
    let k = if -x < ONE_AND_A_HALF { -1.0 } else { towards_zero };
    let k = if -x < HALF { 0.0 } else { k };
    let (high, low) = (x - k * LN_2_HIGH, k * LN_2_LOW);
    let r = high - low;
    let z = r * r;
    let c = r - z * (P[0] + z * (P[1] + z * (P[2] + z * (P[3] + z * P[4]))));
    let y = 1.0 + (r * c / (2.0 - c) - low + high);
    let y = if -x < TINY { 1.0 + x } else { y };
    f64::from_bits(y.to_bits().wrapping_add((k + ROUND).to_bits() << 52))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Rng;

    #[test]
    fn several_side_by_side_have_the_bits_of_one_alone() {
        let mut rng = Rng::new(2);
        let near = |rng: &mut Rng, x: f64| f64::from_bits((x.to_bits() - 1000) + rng.below(2000) as u64);
        let ln_2 = std::f64::consts::LN_2;
        for round in 0..200_000 {
            let far = exp(rng.range(-700.0, 700.0));
            let lns = [far, 1.0, near(&mut rng, 1.0), near(&mut rng, 0.5_f64.sqrt()), rng.uniform() + 0.5];
            let (half, tiny) = (near(&mut rng, 0.5 * ln_2), near(&mut rng, 2.0_f64.powi(-28)));
            let whole = near(&mut rng, f64::from(round % 900 + 1) * 0.5 * ln_2);
            let mut exps =
                [0.0, -tiny, -half, -near(&mut rng, 1.5 * ln_2), -whole, -rng.range(0.0, 700.0), 0.0];
            exps[6] = -exp(rng.range(-40.0, 6.5));
            for (values, each, one) in [
                (&lns[..], ln_of_each as fn(&mut [f64]), ln as fn(f64) -> f64),
                (&exps[..], exp_of_each as fn(&mut [f64]), exp as fn(f64) -> f64),
            ] {
                let mut out = values.to_vec();
                each(&mut out);
                for (x, y) in values.iter().zip(out) {
                    assert_eq!(y.to_bits(), one(*x).to_bits(), "{x}");
                }
            }
        }
    }

    #[test]
    fn what_is_not_usual_is_worked_out_one_by_one() {
        let mut values = [0.0, f64::INFINITY, 1.0, 5e-324, f64::NAN];
        ln_of_each(&mut values);
        assert_eq!(values[..4], [f64::NEG_INFINITY, f64::INFINITY, 0.0, libm::log(5e-324)]);
        let mut values = [f64::NEG_INFINITY, 1.0, 0.0, -720.0, f64::NAN];
        exp_of_each(&mut values);
        assert_eq!(values[..4], [0.0, libm::exp(1.0), 1.0, libm::exp(-720.0)]);
        assert!(values[4].is_nan());
    }
}
