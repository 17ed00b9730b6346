//! Laws of every environment. To put a new one under them, add one line to [`environments`].

use metal_rl::environment::{End, Environment};
use metal_rl::random::Rng;
use metal_worlds::highway::truth::Told;
use metal_worlds::highway::{Grid, Ground, Highway, HighwayConfig, RoadSet, Senses, Steering};
use metal_worlds::maze::{Maze, MazeConfig};
use metal_worlds::miniature::{Miniature, MiniatureConfig};
use metal_worlds::puddle::{Puddle, PuddleConfig};
use metal_worlds::tabular::{CubeConfig, CubeNmConfig, Data, Tabular, Verdict, cube, cube_nm};
use metal_worlds::toy::Toy;
use std::collections::BTreeSet;
use std::sync::{Arc, OnceLock};

type World = Box<dyn Environment>;

/// Every environment there is.
fn environments() -> Vec<World> {
    vec![
        Box::new(Toy::new()),
        Box::new(Maze::new(MazeConfig::default()).expect("the default maze is possible")),
        Box::new(Puddle::new(&PuddleConfig::default())),
        table(cube(&CubeConfig::default())),
        table(cube_nm(&CubeNmConfig::default())),
        highway(Senses::Regions),
        highway(Senses::Cells(Grid::default())),
        highway(Senses::Truth { price: 2.0, tells: Told::Everything }),
        highway(Senses::Truth { price: 2.0, tells: Told::Pose }),
        miniature(),
    ]
}

fn table(data: Data) -> World {
    let rows = (0..data.labels.len()).collect();
    Box::new(Tabular::new(Arc::new(data), rows, Verdict::default()))
}

/// The highway among scripted cars; its roads take a while to paint and are shared.
fn highway(senses: Senses) -> World {
    static ROADS: OnceLock<Arc<[Ground]>> = OnceLock::new();
    let roads = ROADS.get_or_init(|| RoadSet::Training.build()).clone();
    let config = HighwayConfig { senses, ..HighwayConfig::default() };
    Box::new(Highway::on_roads(config, roads, Steering::Scripted))
}

/// The miniature road with every deviation.
fn miniature() -> World {
    static ROAD: OnceLock<Arc<Ground>> = OnceLock::new();
    let config = MiniatureConfig::default();
    let road = ROAD.get_or_init(|| metal_worlds::miniature::ground(config.road_seed)).clone();
    Box::new(Miniature::on(config, road))
}

/// Episodes played per law; each is cut after this many motor steps.
const SEEDS: std::ops::Range<u64> = 0..12;
const STEPS: usize = 40;

/// All sensors' readings now, one after the other.
fn readings(world: &mut dyn Environment) -> Vec<f64> {
    (0..world.spec().sensors.len()).flat_map(|sensor| reading(world, sensor)).collect()
}

fn reading(world: &mut dyn Environment, sensor: usize) -> Vec<f64> {
    // NaN, so that an entry that is not written is found out.
    let mut out = vec![f64::NAN; world.spec().sensors[sensor].features.len()];
    world.sense(sensor, &mut out).expect("simulated sensors answer");
    out
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|v| v.to_bits()).collect()
}

/// Everything that can be seen of one motor step: readings before it, measures, reward, end.
type Trace = Vec<(Vec<u64>, Vec<u64>, u64, End)>;

/// Plays on with actions of `rng` until the end. `look` is called before every step and may look as it likes.
fn play(world: &mut dyn Environment, rng: &mut Rng, look: &mut dyn FnMut(&mut dyn Environment)) -> Trace {
    let mut trace = Vec::new();
    for _ in 0..STEPS {
        look(world);
        let seen = bits(&readings(world));
        let outcome = world.step(rng.below(world.spec().actions.len())).expect("simulated motors obey");
        trace.push((seen, bits(world.measures()), outcome.motor_reward.to_bits(), outcome.end));
        if outcome.end != End::Running {
            break;
        }
    }
    trace
}

fn episode(world: &mut dyn Environment, seed: u64, look: &mut dyn FnMut(&mut dyn Environment)) -> Trace {
    world.reset(seed).expect("simulated worlds begin");
    play(world, &mut Rng::new(seed), look)
}

#[test]
fn specs_are_sound() {
    let mut ids = BTreeSet::new();
    for world in environments() {
        let spec = world.spec();
        let unique = |names: Vec<&str>| names.iter().collect::<BTreeSet<_>>().len() == names.len();
        assert!(ids.insert(spec.id.clone()), "{}: two environments of one name", spec.id);
        assert!(unique(spec.sensors.iter().map(|s| s.name.as_str()).collect()), "{}: sensors", spec.id);
        assert!(unique(spec.actions.iter().map(String::as_str).collect()), "{}: actions", spec.id);
        assert!(unique(spec.measures.iter().map(String::as_str).collect()), "{}: measures", spec.id);
        assert!(
            spec.sensors.len() <= 64 && !spec.sensors.is_empty() && spec.actions.len() > 1,
            "{}",
            spec.id
        );
        assert!(spec.horizon > 0, "{}: an episode has at least one motor step", spec.id);
        for sensor in &spec.sensors {
            assert!(sensor.price.is_finite() && sensor.price >= 0.0, "{}.{}: price", spec.id, sensor.name);
            assert!(!sensor.features.is_empty(), "{}.{} delivers nothing", spec.id, sensor.name);
            assert!(unique(sensor.features.iter().map(|f| f.name.as_str()).collect()), "{}", sensor.name);
            assert!(sensor.features.iter().all(|f| f.low < f.high), "{}.{}: range", spec.id, sensor.name);
        }
    }
}

#[test]
fn readings_are_finite_and_in_range_and_measures_complete() {
    for mut world in environments() {
        let spec = world.spec().clone();
        let ranges: Vec<_> = spec.sensors.iter().flat_map(|s| &s.features).collect();
        let mut check = |world: &mut dyn Environment| {
            for (value, f) in readings(world).iter().zip(&ranges) {
                assert!((f.low..=f.high).contains(value), "{}: {} reads {value}", spec.id, f.name);
            }
            assert_eq!(world.measures().len(), spec.measures.len(), "{}", spec.id);
            assert!(world.measures().iter().all(|m| m.is_finite()), "{}: measures", spec.id);
        };
        for seed in SEEDS {
            let trace = episode(&mut *world, seed, &mut check);
            assert!(trace.iter().all(|t| f64::from_bits(t.2).is_finite()), "{}: rewards", spec.id);
        }
    }
}

#[test]
fn the_same_seed_and_actions_give_the_same_bits() {
    for (mut one, mut other) in environments().into_iter().zip(environments()) {
        for seed in SEEDS {
            // The other world has another past, which a reset must wipe out.
            episode(&mut *other, seed + 1000, &mut |_| {});
            let same = episode(&mut *one, seed, &mut |_| {}) == episode(&mut *other, seed, &mut |_| {});
            assert!(same, "{}, seed {seed}", one.spec().id);
        }
    }
}

#[test]
fn looking_never_changes_the_world() {
    for mut world in environments() {
        for seed in SEEDS {
            let calm = episode(&mut *world, seed, &mut |_| {});
            let mut rng = Rng::new(seed + 77);
            let nervous = episode(&mut *world, seed, &mut |w: &mut dyn Environment| {
                for _ in 0..rng.below(10) {
                    let sensor = rng.below(w.spec().sensors.len());
                    reading(w, sensor);
                }
                w.advise();
            });
            assert!(calm == nervous, "{}, seed {seed}", world.spec().id);
        }
    }
}

#[test]
fn not_looking_never_changes_the_world() {
    for mut world in environments() {
        for seed in SEEDS {
            let seen = episode(&mut *world, seed, &mut |_| {});
            world.reset(seed).expect("simulated worlds begin");
            let mut rng = Rng::new(seed);
            for step in seen {
                let outcome = world.step(rng.below(world.spec().actions.len())).expect("motors obey");
                let blind = (bits(world.measures()), outcome.motor_reward.to_bits(), outcome.end);
                assert!(blind == (step.1, step.2, step.3), "{}, seed {seed}", world.spec().id);
            }
        }
    }
}

#[test]
fn no_feature_is_constant() {
    for mut world in environments() {
        let (mut low, mut high) = (readings(&mut *world), readings(&mut *world));
        for seed in 0..60 {
            episode(&mut *world, seed, &mut |w: &mut dyn Environment| {
                for (i, value) in readings(w).into_iter().enumerate() {
                    low[i] = low[i].min(value);
                    high[i] = high[i].max(value);
                }
            });
        }
        let still = low.iter().zip(&high).position(|(l, h)| l >= h);
        assert_eq!(still, None, "{}: this feature never changes in random play", world.spec().id);
    }
}

#[test]
fn starts_differ_between_seeds() {
    for mut world in environments() {
        let starts: BTreeSet<Vec<u64>> = (0..20)
            .map(|seed| {
                world.reset(seed).expect("simulated worlds begin");
                bits(&readings(&mut *world))
            })
            .collect();
        assert!(starts.len() > 4, "{}: 20 seeds, {} starts", world.spec().id, starts.len());
    }
}

/// Begins an episode and takes one motor step if that does not end it; false if it did.
fn begin_and_move(world: &mut dyn Environment, seed: u64) -> bool {
    world.reset(seed).expect("simulated worlds begin");
    let action = seed as usize % world.spec().actions.len();
    world.spec().horizon == 1 || world.step(action).expect("simulated motors obey").end == End::Running
}

#[test]
fn a_fork_goes_on_bit_for_bit_and_on_its_own() {
    let run = |w: &mut dyn Environment, seed| play(w, &mut Rng::new(seed), &mut |_| {});
    for mut world in environments() {
        for seed in SEEDS {
            if !begin_and_move(&mut *world, seed) {
                continue;
            }
            let (Some(mut fork), Some(mut idle)) = (world.fork(), world.fork()) else { continue };
            let original = run(&mut *world, seed);
            assert!(original == run(&mut *fork, seed), "{}, seed {seed}", world.spec().id);
            // Neither the original nor the other fork may have moved this one.
            assert!(original == run(&mut *idle, seed), "{}, seed {seed}", world.spec().id);
        }
    }
}

#[test]
fn advice_is_a_motor_action() {
    for mut world in environments() {
        let actions = world.spec().actions.len();
        for seed in SEEDS {
            episode(&mut *world, seed, &mut |w: &mut dyn Environment| {
                assert!(w.advise().is_none_or(|a| a < actions), "{}", w.spec().id);
            });
        }
    }
}
