//! The laws every learner keeps, walked over all of them. A new learner is added to [`all`] and nowhere else.

use metal_rl::learner::{Dims, Learner, LearnerError, Rate, Sample};
use metal_rl::learners::absp::{Covariance, DosRule, MixtureConfig, Shape};
use metal_rl::learners::{
    AbspConfig, BayesMixConfig, CalibratedConfig, IgmnConfig, LearnerConfig, MlpConfig, TileConfig,
};
use metal_rl::num;
use metal_rl::random::Rng;
use proptest::prelude::*;

const DIMS: Dims = Dims { inputs: 3, choices: 4 };

fn absp(covariance: Covariance, shape: Shape, dos: DosRule) -> LearnerConfig {
    let mixture = MixtureConfig { covariance, shape, cap: 20, ..MixtureConfig::default() };
    LearnerConfig::Absp(AbspConfig { mixture, dos })
}

fn calibrated(of: LearnerConfig) -> LearnerConfig {
    LearnerConfig::Calibrated(CalibratedConfig { of: Box::new(of), memory: 100.0 })
}

/// Every learner, in every variant that runs other code.
fn all() -> Vec<LearnerConfig> {
    let (signed, resp) = (Shape::Signed { step: 0.02 }, Shape::Resp { least: 0.002 });
    let small = MixtureConfig { cap: 20, ..BayesMixConfig::default().mixture };
    vec![
        absp(Covariance::Full, signed, DosRule::SuccessBayes),
        absp(Covariance::Diagonal, signed, DosRule::Softmax { temperature: 1.0 }),
        absp(Covariance::Full, resp, DosRule::Density),
        absp(Covariance::Diagonal, resp, DosRule::Gibbs { temperature: 1.0 }),
        absp(Covariance::Diagonal, resp, DosRule::NormalisedQ),
        LearnerConfig::BayesMix(BayesMixConfig { mixture: small, ..BayesMixConfig::default() }),
        LearnerConfig::Igmn(IgmnConfig { cap: 20, ..IgmnConfig::default() }),
        LearnerConfig::Tile(TileConfig { memory: 512, ..TileConfig::default() }),
        LearnerConfig::Tile(TileConfig { memory: 8192, ..TileConfig::default() }),
        LearnerConfig::Mlp(MlpConfig { hidden: vec![24], capacity: 100, ..MlpConfig::default() }),
        calibrated(LearnerConfig::Tile(TileConfig { memory: 512, ..TileConfig::default() })),
    ]
}

/// Whether learning about one choice leaves the others alone.
fn is_per_action(config: &LearnerConfig) -> bool {
    !matches!(config, LearnerConfig::Mlp(_))
}

fn rate(rng: &mut Rng) -> Rate {
    [Rate::Full, Rate::Constant(0.3), Rate::Average(0.05)][rng.below(3)]
}

/// Learns `n` random samples with values around −100.
fn exercise(learner: &mut dyn Learner, rng: &mut Rng, n: usize) {
    for _ in 0..n {
        let state: Vec<f64> = (0..DIMS.inputs).map(|_| rng.uniform()).collect();
        let choice = rng.below(DIMS.choices);
        let target = -100.0 + 30.0 * state[0] - 20.0 * choice as f64 + rng.normal();
        let demonstrated = rng.chance(0.1);
        let error = learner.learn(Sample { state: &state, choice, target, demonstrated }, rate(rng));
        assert!(error.is_finite());
    }
}

fn exercised(config: &LearnerConfig, seed: u64, n: usize) -> Box<dyn Learner> {
    let mut learner = config.build(DIMS, seed).expect("the settings are sound");
    exercise(learner.as_mut(), &mut Rng::new(seed), n);
    learner
}

fn values(learner: &dyn Learner, state: &[f64]) -> [f64; 4] {
    let mut out = [f64::NAN; 4];
    learner.values(state, &mut out);
    out
}

/// Asserts that values are finite and supports a distribution, and that both roads lead to the same numbers.
fn check_answers(config: &LearnerConfig, learner: &dyn Learner, state: &[f64]) {
    let (mut support, mut both) = ([f64::NAN; 4], ([f64::NAN; 4], [f64::NAN; 4]));
    learner.support(state, &mut support);
    learner.values_and_support(state, &mut both.0, &mut both.1);
    let values = values(learner, state);
    assert!(values.iter().all(|v| v.is_finite()), "{config:?} at {state:?}: {values:?}");
    assert!(support.iter().all(|p| (0.0..=1.0).contains(p)), "{config:?} at {state:?}: {support:?}");
    assert!((support.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{config:?} at {state:?}: {support:?}");
    assert_eq!(both.0.map(f64::to_bits), values.map(f64::to_bits));
    assert_eq!(both.1.map(f64::to_bits), support.map(f64::to_bits));
    let mut sd = [f64::NAN; 4];
    if learner.uncertainty(state, &mut sd) {
        assert!(sd.iter().all(|s| s.is_finite() && *s >= 0.0), "{config:?} at {state:?}: {sd:?}");
    }
}

#[test]
fn answers_are_finite_and_supports_are_distributions_everywhere() {
    for config in all() {
        for n in [0, 1, 300] {
            let learner = exercised(&config, 3, n);
            for x in [0.0, 0.5, 1.0, -3.0, 1e6, -1e6, 1e300, f64::MIN_POSITIVE] {
                check_answers(&config, learner.as_ref(), &[x, 0.5, 0.5]);
                check_answers(&config, learner.as_ref(), &[x, -x, x]);
            }
        }
    }
}

/// `n` samples, one in a hundred far outside the unit cube (up to ±1e6 in state and target); answers are looked at now
/// and then, and in the end the learner goes through its own bytes.
fn endures(config: &LearnerConfig, n: usize) {
    let (mut learner, mut rng) = (config.build(DIMS, 4).expect("the settings are sound"), Rng::new(31));
    for step in 1..=n {
        let reach = if rng.chance(0.01) { 1e6 } else { 1.0 };
        let state: Vec<f64> = (0..DIMS.inputs).map(|_| reach * rng.range(-1.0, 1.0)).collect();
        let target = if rng.chance(0.01) { 1e6 * rng.normal() } else { rng.normal() };
        let (choice, demonstrated) = (rng.below(DIMS.choices), rng.chance(0.1));
        let error = learner.learn(Sample { state: &state, choice, target, demonstrated }, rate(&mut rng));
        assert!(error.is_finite(), "{config:?} after {step} samples");
        if step % (n / 20) == 0 {
            check_answers(config, learner.as_ref(), &state);
            check_answers(config, learner.as_ref(), &[0.1, 0.5, 0.9]);
        }
    }
    for bump in learner.bumps() {
        assert!(bump.deviation.iter().all(|d| d.is_finite() && *d > 0.0), "{config:?}: {bump:?}");
    }
    let thawed = config.thaw(&learner.freeze()).expect("what was frozen thaws");
    assert_eq!(values(thawed.as_ref(), &[0.5; 3]), values(learner.as_ref(), &[0.5; 3]));
}

#[test]
fn wild_samples_leave_every_learner_sound() {
    all().iter().for_each(|config| endures(config, 2_000));
}

/// `cargo test --release -p metal-rl --test learner_laws -- --ignored`
#[test]
#[ignore = "takes minutes"]
fn ten_million_wild_samples_leave_every_learner_sound() {
    all().iter().for_each(|config| endures(config, 10_000_000));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn answers_are_sound_for_any_state(
        which in 0..all().len(), seed in 0_u64..100, state in prop::array::uniform3(-1e6..1e6_f64)
    ) {
        let config = &all()[which];
        check_answers(config, exercised(config, seed, 100).as_ref(), &state);
    }

    #[test]
    fn damaged_bytes_give_an_error(
        which in 0..all().len(), at in any::<prop::sample::Index>(), flip in 1..=255_u8, cut in any::<bool>()
    ) {
        let config = &all()[which];
        let mut bytes = exercised(config, 1, 40).freeze();
        let at = at.index(bytes.len());
        if cut { bytes.truncate(at) } else { bytes[at] ^= flip }
        let refused = matches!(config.thaw(&bytes), Err(LearnerError::Frozen { .. }));
        prop_assert!(refused);
    }

    #[test]
    fn damaged_bytes_with_a_right_checksum_never_panic(
        which in 0..all().len(), at in any::<prop::sample::Index>(), flip in 1..=255_u8
    ) {
        let config = &all()[which];
        let mut bytes = exercised(config, 1, 40).freeze();
        let body = bytes.len() - 8;
        bytes[at.index(body)] ^= flip;
        let sum = bytes[..body].iter().fold(0xcbf2_9ce4_8422_2325, |h: u64, &b| {
            (h ^ u64::from(b)).wrapping_mul(0x0000_0100_0000_01b3)
        });
        bytes[body..].copy_from_slice(&sum.to_le_bytes());
        if let Ok(learner) = config.thaw(&bytes) {
            prop_assert_eq!(learner.dims().choices * learner.dims().inputs > 0, true);
        }
    }
}

#[test]
fn learning_one_choice_leaves_the_values_of_the_others_bitwise_alone() {
    for config in all().into_iter().filter(is_per_action) {
        let mut learner = exercised(&config, 5, 200);
        let state = [0.2, 0.9, 0.4];
        let before = values(learner.as_ref(), &state);
        learner.learn(Sample { state: &state, choice: 2, target: 55.0, demonstrated: false }, Rate::Full);
        let after = values(learner.as_ref(), &state);
        for b in [0, 1, 3] {
            assert_eq!(before[b].to_bits(), after[b].to_bits(), "{config:?}");
        }
        assert!((before[2] - 55.0).abs() > (after[2] - 55.0).abs(), "{config:?}");
    }
}

#[test]
fn a_thawed_learner_goes_on_with_the_same_bits() {
    for config in all() {
        let mut original = exercised(&config, 7, 150);
        let mut thawed = config.thaw(&original.freeze()).unwrap();
        assert_eq!(thawed.dims(), DIMS);
        let (mut first, mut second) = (Rng::new(8), Rng::new(8));
        exercise(original.as_mut(), &mut first, 150);
        exercise(thawed.as_mut(), &mut second, 150);
        assert!(original.freeze() == thawed.freeze(), "{config:?}");
    }
}

#[test]
fn the_same_seed_and_samples_give_the_same_bytes() {
    for config in all() {
        let (a, b) = (exercised(&config, 9, 200), exercised(&config, 9, 200));
        assert!(a.freeze() == b.freeze(), "{config:?}");
        assert!(a.boxed_clone().freeze() == a.freeze(), "{config:?}");
    }
}

#[test]
fn bytes_belong_to_their_settings() {
    let configs = all();
    for (i, config) in configs.iter().enumerate() {
        let bytes = exercised(config, 1, 20).freeze();
        for (j, other) in configs.iter().enumerate() {
            assert_eq!(other.thaw(&bytes).is_ok(), i == j, "{config:?} thawed as {other:?}");
        }
    }
}

#[test]
fn a_two_armed_choice_is_learnt_from_noisy_rewards() {
    let dims = Dims { inputs: 1, choices: 2 };
    for config in all() {
        let mut learner = config.build(dims, 2).unwrap();
        let mut rng = Rng::new(2);
        for _ in 0..1500 {
            let (state, choice) = ([rng.uniform()], rng.below(2));
            let right = (state[0] > 0.5) == (choice == 1);
            let target = if right { -1.0 } else { -3.0 } + 0.5 * rng.normal();
            learner.learn(Sample { state: &state, choice, target, demonstrated: false }, Rate::Average(0.05));
        }
        let (mut q, mut p) = ([0.0; 2], [0.0; 2]);
        for x in [0.1, 0.2, 0.3, 0.7, 0.8, 0.9] {
            learner.values_and_support(&[x], &mut q, &mut p);
            let best = usize::from(x > 0.5);
            assert_eq!(num::argmax(&q), best, "{config:?} at {x}: {q:?}");
            assert!((q[best] + 1.0).abs() < 0.7 && (q[1 - best] + 3.0).abs() < 0.7, "{config:?}: {q:?}");
            if !matches!(config, LearnerConfig::Absp(AbspConfig { dos: DosRule::Density, .. })) {
                assert!(p[best] > 0.5, "{config:?} at {x}: {p:?}");
            }
        }
    }
}

#[test]
fn the_full_rate_drives_a_repeated_sample_to_its_target() {
    for config in all() {
        for target in [7.5, -130.0] {
            let mut learner = config.build(DIMS, 1).unwrap();
            let state = [0.4, 0.6, 0.1];
            let sample = Sample { state: &state, choice: 1, target, demonstrated: true };
            (0..300).for_each(|_| _ = learner.learn(sample, Rate::Full));
            let value = values(learner.as_ref(), &state)[1];
            assert!((value - target).abs() < 0.01 * target.abs(), "{config:?}: {value} not {target}");
        }
    }
}

#[test]
fn caps_hold() {
    for config in all() {
        let (size, unit) = exercised(&config, 4, 2500).size();
        let most = match unit {
            "components" => 20 * DIMS.choices,
            "cells" => 8192 * DIMS.choices,
            _ => 4 * 24 + 25 * 4,
        };
        assert!((1..=most).contains(&size), "{config:?}: {size} {unit}");
    }
}

#[test]
fn demonstrated_choices_are_supported() {
    for dos in [DosRule::SuccessBayes, DosRule::Density] {
        let config = absp(Covariance::Auto, Shape::Signed { step: 0.02 }, dos);
        let mut learner = config.build(DIMS, 1).unwrap();
        let state = [0.5; 3];
        let sample = Sample { state: &state, choice: 3, target: -40.0, demonstrated: true };
        (0..20).for_each(|_| _ = learner.learn(sample, Rate::Full));
        let mut support = [0.0; 4];
        learner.support(&state, &mut support);
        assert!(support[3] > 0.95, "{support:?}");
    }
}

#[test]
fn a_heavy_background_gives_its_value_and_uniform_support() {
    let mixture = MixtureConfig { background_mass: 1e15, background_value: -5.0, ..MixtureConfig::default() };
    let config = LearnerConfig::Absp(AbspConfig { mixture, dos: DosRule::SuccessBayes });
    let learner = exercised(&config, 2, 300);
    let (mut q, mut p) = ([0.0; 4], [0.0; 4]);
    learner.values_and_support(&[0.5; 3], &mut q, &mut p);
    assert!(q.iter().all(|q| (q + 5.0).abs() < 1e-6), "{q:?}");
    assert!(p.iter().all(|p| (p - 0.25).abs() < 1e-6), "{p:?}");
}

#[test]
fn settings_out_of_range_are_refused_by_name() {
    let mixture = MixtureConfig { background_mass: 0.0, ..MixtureConfig::default() };
    let config = LearnerConfig::BayesMix(BayesMixConfig { mixture, ..BayesMixConfig::default() });
    let refused = config.build(DIMS, 0).map(|_| ()).unwrap_err();
    assert!(matches!(refused, LearnerError::Setting { learner: "bayes_mix", field: "background_mass", .. }));
    let mlp = LearnerConfig::Mlp(MlpConfig { temperature: f64::NAN, ..MlpConfig::default() });
    assert!(mlp.validate().is_err());
    assert!(LearnerConfig::default().build(Dims { inputs: 0, choices: 1 }, 0).is_err());
}

#[test]
fn the_full_observers_24_dimensions_work() {
    let dims = Dims { inputs: 24, choices: 5 };
    for config in [
        LearnerConfig::default(),
        LearnerConfig::BayesMix(BayesMixConfig::default()),
        LearnerConfig::Igmn(IgmnConfig::default()),
        LearnerConfig::Tile(TileConfig::default()),
        LearnerConfig::Mlp(MlpConfig::default()),
    ] {
        let mut learner = config.build(dims, 1).unwrap();
        let mut rng = Rng::new(1);
        let (mut early, mut late) = (0.0, 0.0);
        for step in 0..2000 {
            let mut state = [0.0; 24];
            let side = rng.uniform();
            state.iter_mut().for_each(|x| *x = (0.2 + 0.6 * side + 0.05 * rng.normal()).clamp(0.0, 1.0));
            let target = if side > 0.5 { -10.0 } else { -20.0 };
            let sample = Sample { state: &state, choice: 0, target, demonstrated: false };
            let error = learner.learn(sample, Rate::Constant(0.2)).abs();
            if step < 200 {
                early += error / 200.0
            } else if step >= 1800 {
                late += error / 200.0
            }
        }
        let bar = if matches!(config, LearnerConfig::Tile(_)) { early } else { 2.5 };
        assert!(late < bar, "{}: error {early} and then {late}", config.name());
    }
}
