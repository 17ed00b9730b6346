//! Debug and release give the same bits: what drives and learners come to is written down once (`golden/bits.txt`), and
//! `./test` compares both with it.

use expect_test::expect_file;
use metal_rl::environment::{End, Environment};
use metal_rl::learner::{Dims, Rate, Sample};
use metal_rl::learners::absp::{Covariance, DosRule, MixtureConfig};
use metal_rl::learners::{AbspConfig, BayesMixConfig, IgmnConfig, LearnerConfig, MlpConfig, TileConfig};
use metal_rl::random::Rng;
use metal_worlds::highway::truth::Told;
use metal_worlds::highway::{Highway, HighwayConfig, RoadSet, Senses, Steering};
use metal_worlds::miniature::{Miniature, MiniatureConfig, ground};
use std::fmt::Write;

/// Fowler, Noll and Vo's hash, 64 bits, variant 1a: any changed bit changes it.
struct Hash(u64);

impl Hash {
    fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    fn eat(&mut self, values: &[f64]) {
        for byte in values.iter().flat_map(|v| v.to_le_bytes()) {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
}

/// Readings and rewards of 600 random motor steps.
fn driven(world: &mut dyn Environment) -> u64 {
    let (mut rng, mut hash) = (Rng::new(7), Hash::new());
    let spec = world.spec().clone();
    world.reset(1).expect("a simulated world begins");
    for step in 0..600 {
        for (sensor, row) in spec.sensors.iter().enumerate() {
            let mut seen = vec![0.0; row.features.len()];
            world.sense(sensor, &mut seen).expect("simulated sensors answer");
            hash.eat(&seen);
        }
        let outcome = world.step(rng.below(spec.actions.len())).expect("a simulated world goes on");
        hash.eat(&[outcome.motor_reward]);
        if outcome.end != End::Running {
            world.reset(step).expect("a simulated world begins");
        }
    }
    hash.0
}

const DIMS: Dims = Dims { inputs: 4, choices: 5 };

/// Errors, values and supports while 2000 samples are learned.
fn learned(config: &LearnerConfig) -> u64 {
    let (mut rng, mut hash) = (Rng::new(11), Hash::new());
    let mut learner = config.build(DIMS, 3).expect("the settings are sound");
    for _ in 0..2000 {
        let state: [f64; 4] = std::array::from_fn(|_| rng.uniform());
        let choice = rng.below(DIMS.choices);
        let target = -10.0 + 30.0 * state[0] * state[1] - 5.0 * choice as f64 + rng.normal();
        let demonstrated = rng.chance(0.1);
        let sample = Sample { state: &state, choice, target, demonstrated };
        let error = learner.learn(sample, Rate::Constant(0.2));
        let (mut values, mut support) = ([0.0; 5], [0.0; 5]);
        learner.values_and_support(&state, &mut values, &mut support);
        hash.eat(&[error]);
        hash.eat(&values);
        hash.eat(&support);
    }
    hash.0
}

fn learners() -> Vec<(&'static str, LearnerConfig)> {
    let absp = |covariance| {
        let mixture = MixtureConfig { covariance, cap: 40, ..MixtureConfig::default() };
        LearnerConfig::Absp(AbspConfig { mixture, dos: DosRule::SuccessBayes })
    };
    let few = MixtureConfig { cap: 40, ..BayesMixConfig::default().mixture };
    vec![
        ("absp, full", absp(Covariance::Full)),
        ("absp, diagonal", absp(Covariance::Diagonal)),
        ("bayes_mix", LearnerConfig::BayesMix(BayesMixConfig { mixture: few, ..BayesMixConfig::default() })),
        ("igmn", LearnerConfig::Igmn(IgmnConfig { cap: 20, ..IgmnConfig::default() })),
        ("tile", LearnerConfig::Tile(TileConfig::default())),
        ("mlp", LearnerConfig::Mlp(MlpConfig { hidden: vec![24, 16], ..MlpConfig::default() })),
    ]
}

#[test]
fn worlds_and_learners_come_to_the_bits_that_were_written_down() {
    let mut text = String::new();
    let roads = RoadSet::Training.build();
    for senses in [Senses::Regions, Senses::Truth { price: 2.0, tells: Told::Everything }] {
        let name = format!("{senses:?}");
        let config = HighwayConfig { senses, ..HighwayConfig::default() };
        let hash = driven(&mut Highway::on_roads(config, roads.clone(), Steering::Scripted));
        writeln!(text, "highway, {name}: {hash:016x}").expect("a text takes everything");
    }
    let config = MiniatureConfig::default();
    let road = ground(config.road_seed);
    writeln!(text, "miniature: {:016x}", driven(&mut Miniature::on(config, road))).expect("likewise");
    for (name, config) in learners() {
        writeln!(text, "{name}: {:016x}", learned(&config)).expect("likewise");
    }
    expect_file!["golden/bits.txt"].assert_eq(&text);
}
