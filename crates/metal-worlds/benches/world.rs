//! World steps, with more and more seen: nobody looks; the red cars look and think; the learner looks, too.

use metal_rl::environment::Environment;
use metal_rl::learners::nn::{Activation, Adam, Network, narrow};
use metal_rl::num;
use metal_rl::random::Rng;
use metal_worlds::highway::{Driver, Highway, HighwayConfig, Steering, VISION};
use std::error::Error;
use std::sync::Arc;

/// Episodes of one round, and steps of each.
const EPISODES: usize = 3;
const STEPS: usize = 50;

/// A red car's mind: a network of the size of the shipped one, that has learned nothing.
struct Mind {
    net: Network,
    /// Whether it is asked each time, or only about what is new: every round but the first drives the same episodes.
    asked_each_time: bool,
}

impl Driver for Mind {
    fn drive(&self, vision: &[f64; VISION]) -> usize {
        let (mut input, mut values) = ([0.0; VISION], [0.0; 5]);
        narrow(vision, &mut input);
        self.net.forward(&input, &mut values);
        num::argmax(&values.map(f64::from))
    }

    fn decides_by_sight(&self) -> bool {
        !self.asked_each_time
    }
}

fn minds(asked_each_time: bool) -> Steering {
    let mut rng = Rng::new(1);
    let net = Network::new(&[VISION, 64, 64, 5], Activation::LeakyRelu, Adam::default(), &mut rng);
    Steering::Mind(Arc::new(Mind { net, asked_each_time }))
}

/// Seeds of episodes with two red cars.
fn crowded(world: &mut Highway) -> Result<Vec<u64>, Box<dyn Error>> {
    let mut seeds = Vec::new();
    for seed in 0.. {
        world.reset(seed)?;
        if world.cars().len() == 2 {
            seeds.push(seed);
        }
        if seeds.len() == EPISODES {
            break;
        }
    }
    Ok(seeds)
}

/// The learner's sensors: six regions, then the ring.
const REGIONS: [usize; 6] = [0, 1, 2, 3, 4, 5];
const RING: usize = 6;

/// Drives all episodes, reading these sensors before every step; the sum of what was read.
fn drive(world: &mut Highway, seeds: &[u64], sensors: &[usize]) -> Result<f64, Box<dyn Error>> {
    let (mut reading, mut sum) = ([0.0; 8], 0.0);
    for &seed in seeds {
        world.reset(seed)?;
        for step in 0..STEPS {
            for &sensor in sensors {
                let features = world.spec().sensors[sensor].features.len();
                world.sense(sensor, &mut reading[..features])?;
                sum += reading[0];
            }
            world.step(step % 5)?;
        }
    }
    Ok(sum)
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut world = Highway::new(HighwayConfig::default(), Steering::Scripted);
    let grounds = world.grounds();
    let seeds = crowded(&mut world)?;
    let ring = [&REGIONS[..], &[RING]].concat();
    // No red car asks its ring; the learner's costs the same.
    let rings = [&REGIONS[..], &[RING; 3]].concat();
    let cases = [
        ("nobody looks, scripted cars", Steering::Scripted, &[][..]),
        ("two cars look and think", minds(true), &[]),
        ("and have seen all that before", minds(false), &[]),
        ("they look and think, and the learner looks at one region", minds(true), &REGIONS[..1]),
        ("and the learner looks at all regions", minds(true), &REGIONS),
        ("and at its infra-red ring: three robots, all they have", minds(true), &ring),
        ("and at three rings, as if each robot asked its own", minds(true), &rings),
        ("only the learner looks, at all regions", Steering::Scripted, &REGIONS),
    ];
    for (name, steering, sensors) in cases {
        let mut world = Highway::on_roads(HighwayConfig::default(), Arc::clone(&grounds), steering);
        let mut work = || {
            std::hint::black_box(
                drive(&mut world, &seeds, sensors).expect("a simulated world does not fail"),
            );
        };
        xtask::measure(("world", name), (EPISODES * STEPS, "step"), &mut work)?;
    }
    Ok(())
}
