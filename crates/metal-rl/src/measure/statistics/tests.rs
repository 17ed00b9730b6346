//! Reference values were computed with scipy 1.17.1 and numpy.
use super::*;
use proptest::prelude::*;

const X: [f64; 7] = [-15.6, -12.3, -20.9, -13.0, -15.4, -17.1, -28.5];
const Y: [f64; 7] = [-14.6, -12.9, -22.9, -13.5, -16.4, -18.0, -27.5];

fn close(a: f64, b: f64) {
    assert!((a - b).abs() <= 1e-10 * b.abs().max(1.0), "{a} is not {b}");
}

fn interval(estimate: Estimate) -> (f64, f64) {
    (estimate.lo.unwrap(), estimate.hi.unwrap())
}

#[test]
fn the_t_distribution_is_that_of_scipy() {
    for (freedom, t) in [
        (1.0, 12.706_204_736_174_694),
        (2.0, 4.302_652_729_749_462),
        (4.0, 2.776_445_105_197_793_4),
        (9.0, 2.262_157_162_798_205),
        (29.0, 2.045_229_642_132_703),
        (199.0, 1.971_956_544_251_753_3),
    ] {
        close(student_t_quantile(0.975, freedom), t);
        close(student_t_quantile(0.025, freedom), -t);
    }
    close(student_t_cdf(0.5, 3.0), 0.674_276_017_575_924_5);
    close(student_t_cdf(-1.3, 7.0), 0.117_383_917_696_188_62);
    close(student_t_cdf(2.2, 1.0), 0.864_200_251_219_908_1);
    close(student_t_cdf(10.0, 4.5), 0.999_847_359_712_158_3);
    assert!((student_t_cdf(1e-5, 10.0) - 0.5 - 3.891_083_84e-6).abs() < 1e-14, "small t keep their digits");
}

#[test]
fn moments_and_their_intervals_are_those_of_scipy() {
    close(mean(&X).unwrap(), -17.542_857_142_857_144);
    close(sample_sd(&X).unwrap(), 5.597_873_746_003_073);
    close(interquartile_mean(&X).unwrap(), -16.4);
    let (lo, hi) = interval(student(&X).unwrap());
    close(lo, -22.720_026_876_469_29);
    close(hi, -12.365_687_409_244_998);
    let pairs = paired_difference(&X, &Y).unwrap();
    let (lo, hi) = interval(pairs);
    close(pairs.mean, 0.428_571_428_571_428);
    close(lo, -0.579_912_375_977_890_2);
    close(hi, 1.437_055_233_120_746_7);
    close(quantile(&[1.0, 2.0, 4.0, 8.0], 0.3).unwrap(), 1.9);
}

#[test]
fn wilson_is_that_of_scipy() {
    for (k, n, lo, hi) in [
        (3, 10, 0.107_791_267_406_301_02, 0.603_221_852_538_854_6),
        (0, 10, 0.0, 0.277_532_799_862_889_26),
        (10, 10, 0.722_467_200_137_110_9, 1.0),
        (7, 20, 0.181_191_824_101_082_1, 0.567_145_723_314_763_7),
    ] {
        let ours = interval(wilson(k, n).unwrap());
        close(ours.0, lo);
        close(ours.1, hi);
    }
    assert_eq!(wilson(0, 0), None);
}

#[test]
fn one_observation_has_no_interval_and_none_has_no_mean() {
    let alone = Estimate { mean: 2.0, lo: None, hi: None, n: 1 };
    assert_eq!(student(&[2.0]), Some(alone));
    assert_eq!(Bootstrap::default().estimate(&[&[2.0]], |v| v[0]), Some(alone));
    assert_eq!((student(&[]), interquartile_mean(&[]), sample_sd(&[2.0])), (None, None, None));
    assert_eq!(Bootstrap::default().estimate(&[], |v| v[0]), None);
}

#[test]
fn a_bootstrap_of_the_mean_is_nearly_normal() {
    let values: Vec<f64> = (0..100).map(f64::from).collect();
    let mean_of = |v: &[f64]| mean(v).unwrap();
    let (lo, hi) = interval(Bootstrap { resamples: 4000, seed: 1 }.estimate(&[&values], mean_of).unwrap());
    let margin = 1.96 * (9999.0_f64 / 12.0 / 100.0).sqrt();
    assert!((lo - (49.5 - margin)).abs() < 0.4 && (hi - (49.5 + margin)).abs() < 0.4, "{lo} {hi}");
}

#[test]
fn strata_take_the_difference_between_seeds_out() {
    let (low, high) = ([0.0, 1.0, 2.0, 1.0], [100.0, 101.0, 102.0, 101.0]);
    let width = |strata: &[&[f64]]| {
        let (lo, hi) = interval(Bootstrap::default().estimate(strata, |v| mean(v).unwrap()).unwrap());
        hi - lo
    };
    assert!(width(&[&low, &high]) < 2.0);
    assert!(width(&[&[low, high].concat()]) > 40.0);
}

#[test]
fn the_same_seed_gives_the_same_bootstrap() {
    let of = |seed| Bootstrap { resamples: 200, seed }.estimate(&[&X], |v| mean(v).unwrap());
    assert_eq!(of(3), of(3));
    assert_ne!(of(3), of(4));
}

#[test]
fn a_missing_interval_is_stored_as_nothing() {
    let bytes = postcard::to_stdvec(&student(&[2.0]).unwrap()).unwrap();
    assert_eq!(postcard::from_bytes::<Estimate>(&bytes).unwrap(), student(&[2.0]).unwrap());
}

proptest! {
    #[test]
    fn wilson_contains_the_proportion_and_narrows(k in 0..50_u64, more in 0..50_u64) {
        let n = k + more + 1;
        let (small, large) = (wilson(k, n).unwrap(), wilson(10 * k, 10 * n).unwrap());
        let ((a, b), (c, d)) = (interval(small), interval(large));
        prop_assert!((0.0..=small.mean).contains(&a) && (small.mean..=1.0).contains(&b));
        prop_assert!(d - c < b - a);
    }

    #[test]
    fn estimates_move_with_the_values(
        values in prop::collection::vec(-100.0..100.0_f64, 2..20), shift in -10.0..10.0_f64
    ) {
        let moved: Vec<f64> = values.iter().map(|v| v + shift).collect();
        let ((a, b), (c, d)) = (interval(student(&values).unwrap()), interval(student(&moved).unwrap()));
        prop_assert!((c - a - shift).abs() < 1e-9 && (d - b - shift).abs() < 1e-9);
        let (p, q) = (interquartile_mean(&values).unwrap(), interquartile_mean(&moved).unwrap());
        prop_assert!((q - p - shift).abs() < 1e-9);
    }

    #[test]
    fn the_quantile_inverts_the_distribution(p in 0.01..0.99_f64, freedom in 1..60_u32) {
        let t = student_t_quantile(p, f64::from(freedom));
        prop_assert!((student_t_cdf(t, f64::from(freedom)) - p).abs() < 1e-12);
    }
}

#[test]
fn only_known_disjoint_intervals_are_apart() {
    let low = Estimate::interval(1.0, 0.5, 1.5, 5);
    let high = Estimate::interval(2.0, 1.6, 2.4, 5);
    assert!(low.is_apart_from(&high) && high.is_apart_from(&low));
    assert!(!low.is_apart_from(&Estimate::interval(2.0, 1.4, 2.6, 5)));
    assert!(!low.is_apart_from(&Estimate::point(9.0, 1)));
}
