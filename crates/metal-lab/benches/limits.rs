//! How far the camera, the Gaussians and a network's updates are from what this machine can do: its multiplications with
//! additions, and the bytes it can read from its caches and its memory, measured in the same run. Within a group the
//! first row is the limit, so that the last column is the distance from it.

use metal_rl::environment::Environment;
use metal_rl::learner::{Dims, Learner, Rate, Sample};
use metal_rl::learners::absp::{Covariance, MixtureConfig};
use metal_rl::learners::nn::{Activation, Adam, Batch, Network};
use metal_rl::learners::{AbspConfig, LearnerConfig};
use metal_rl::random::Rng;
use metal_worlds::highway::{Highway, HighwayConfig, Steering};
use multiversion::multiversion;
use std::error::Error;
use std::hint::black_box;
use xtask::{measure, shortest_round_secs, tell};

/// Numbers side by side that fit into the registers of 256 bits, with some to spare for constants.
const SIDE_BY_SIDE: usize = 48;
/// Multiplications with additions of one round.
const ROUND: usize = 20_000 * SIDE_BY_SIDE;

/// Pixels of a frame.
const PIXELS: f64 = 52.0 * 39.0;
/// A ray turned and moved: x + a cos − b sin, y + a sin + b cos.
const ADDS_PER_RAY: f64 = 4.0;
/// Two numbers of a ray, the cell it meets, what it found written and read again.
const BYTES_PER_RAY: f64 = 2.0 * 8.0 + 3.0;

/// Dimensions and components of the Gaussians.
const DIMS: usize = 4;
const CAP: usize = 100;
const ACTIONS: usize = 5;
/// Of a component: two for each dimension (x − μ, squared, times 1/σ², added), two for the density, 17 for the
/// exponential, four for the three sums.
const ADDS_PER_COMPONENT: f64 = 2.0 * DIMS as f64 + 2.0 + 17.0 + 4.0;
/// Mean and 1/σ² for each dimension, ln |Σ|, mass, value and success.
const BYTES_PER_COMPONENT: f64 = 8.0 * (2.0 * DIMS as f64 + 4.0);

/// Widths of a network, and samples of one update.
const WIDTHS: [usize; 4] = [24, 64, 64, 5];
const SAMPLES: usize = 16;

/// x ← a x + b, many times, for many x side by side; multiplied and added apart, as all our loops do but those of Gaussians.
#[multiversion(targets("x86_64+avx2"))]
fn multiply_and_add(xs: &mut [f64; SIDE_BY_SIDE], a: f64, b: f64) {
    let mut own = *xs;
    for _ in 0..ROUND / SIDE_BY_SIDE {
        for x in &mut own {
            *x = *x * a + b;
        }
    }
    *xs = own;
}

/// Sum of all numbers, which reads them all.
#[multiversion(targets("x86_64+avx2"))]
fn read(numbers: &[u64]) -> u64 {
    let mut sums = [0_u64; 32];
    for chunk in numbers.chunks_exact(32) {
        for (sum, x) in sums.iter_mut().zip(chunk) {
            *sum = sum.wrapping_add(*x);
        }
    }
    sums.iter().fold(0, |sum, x| sum.wrapping_add(*x))
}

/// Seconds to read a byte of so many KiB that are read again and again.
fn byte_secs(name: &str, kib: usize) -> Result<f64, Box<dyn Error>> {
    let numbers = vec![1_u64; kib * 128];
    let rounds = 2048_usize.div_ceil(kib);
    let secs = shortest_round_secs(|| {
        for _ in 0..rounds {
            black_box(read(black_box(&numbers)));
        }
    });
    let each = secs / (rounds * kib * 1024) as f64;
    tell(("machine", &format!("reading {name} ({kib} KiB)")), 1024.0 * each, "KiB")?;
    Ok(each)
}

/// Seconds of one multiplication with an addition among many.
fn add_secs() -> Result<f64, Box<dyn Error>> {
    let mut xs = [1.0; SIDE_BY_SIDE];
    let each = shortest_round_secs(|| multiply_and_add(black_box(&mut xs), black_box(0.5), black_box(1.0)))
        / ROUND as f64;
    tell(("machine", "1000 × multiply and add, 64 bits"), 1000.0 * each, "thousand")?;
    Ok(each)
}

/// The learner in many places: copies of a world after some steps of some episodes.
fn places() -> Result<Vec<Highway>, Box<dyn Error>> {
    let mut world = Highway::new(HighwayConfig::default(), Steering::Scripted);
    let mut places = Vec::new();
    for seed in 0..25 {
        world.reset(seed)?;
        for step in 0..20 {
            world.step(step % 5)?;
            if step % 4 == 0 {
                places.push(world.clone());
            }
        }
    }
    Ok(places)
}

/// What one machine can do at best.
struct Limits {
    add: f64,
    first_level: f64,
    second_level: f64,
}

impl Limits {
    /// Seconds below which so many operations on so many bytes cannot be done, and what would bound them.
    fn least(&self, adds: f64, bytes: f64) -> (f64, &'static str) {
        let reading = if bytes < 30_000.0 { self.first_level } else { self.second_level };
        let (by_adds, by_bytes) = (adds * self.add, bytes * reading);
        if by_adds > by_bytes { (by_adds, "arithmetic") } else { (by_bytes, "reading") }
    }
}

/// A frame: six regions' shares of colours.
fn camera(limits: &Limits) -> Result<(), Box<dyn Error>> {
    let mut places = places()?;
    let (adds, bytes) = (PIXELS * ADDS_PER_RAY, PIXELS * BYTES_PER_RAY);
    let (least, by) = limits.least(adds, bytes);
    tell(("camera", &format!("limit of {by}: {adds:.0} operations, {bytes:.0} bytes")), least, "frame")?;
    let (count, mut out) = (places.len(), [0.0; 4]);
    measure(("camera", "six regions of 52×39 pixels"), (count, "frame"), || {
        for place in &mut places {
            for region in 0..6 {
                place.sense(region, &mut out).expect("a simulated camera does not fail");
                black_box(&out);
            }
        }
    })?;
    Ok(())
}

/// Values and supports of Gaussians, per component.
fn gaussians(limits: &Limits) -> Result<(), Box<dyn Error>> {
    let mixture = MixtureConfig {
        covariance: Covariance::Diagonal,
        first_width: 0.05,
        cap: CAP,
        ..MixtureConfig::default()
    };
    let config = LearnerConfig::Absp(AbspConfig { mixture, ..AbspConfig::default() });
    let mut learner: Box<dyn Learner> = config.build(Dims { inputs: DIMS, choices: ACTIONS }, 1)?;
    let mut rng = Rng::new(2);
    for k in 0..20 * CAP {
        let state: [f64; DIMS] = std::array::from_fn(|_| rng.uniform());
        let sample = Sample { state: &state, choice: k % ACTIONS, target: -1.0, demonstrated: false };
        learner.learn(sample, Rate::Constant(0.1));
    }
    let components = learner.size().0 as f64;
    let (least, by) = limits.least(ADDS_PER_COMPONENT * components, BYTES_PER_COMPONENT * components);
    let name =
        format!("limit of {by}: {ADDS_PER_COMPONENT} operations, {BYTES_PER_COMPONENT} bytes a component");
    tell(("gaussians", &name), least / components, "component")?;
    let states: Vec<[f64; DIMS]> = (0..200).map(|_| std::array::from_fn(|_| rng.uniform())).collect();
    let (mut values, mut support) = ([0.0; ACTIONS], [0.0; ACTIONS]);
    let secs = shortest_round_secs(|| {
        for state in &states {
            learner.values_and_support(black_box(state), &mut values, &mut support);
        }
    });
    let name = format!("values and supports, {components} components in all");
    tell(("gaussians", &name), secs / (200.0 * components), "component")?;
    Ok(())
}

/// An update of a network: each sample forward, back to every layer but the first, and into the gradient. The limit leaves out
/// the optimiser, its roots and divisions, and the width to which outputs are filled up.
fn network(limits: &Limits) -> Result<(), Box<dyn Error>> {
    let weights = |from: usize| WIDTHS[from..].windows(2).map(|pair| pair[0] * pair[1]).sum::<usize>();
    let adds = SAMPLES * (2 * weights(0) + weights(1));
    // Two numbers of 32 bits lie where one of 64 does.
    let (least, by) = limits.least(adds as f64 / 2.0, 4.0 * (3 * weights(0)) as f64);
    tell(("network", &format!("limit of {by}: {adds} operations, 32 bits")), least, "update")?;
    let mut rng = Rng::new(3);
    let mut network = Network::new(&WIDTHS, Activation::default(), Adam::default(), &mut rng);
    let mut numbers = |width: usize| (0..SAMPLES * width).map(|_| rng.uniform() as f32).collect::<Vec<f32>>();
    let (inputs, targets) = (numbers(WIDTHS[0]), numbers(WIDTHS[3]));
    let weights = vec![1.0; targets.len()];
    let batch = Batch { inputs: &inputs, targets: &targets, weights: &weights };
    measure(("network", "24-64-64-5, batch of 16"), (1, "update"), || {
        black_box(network.train_batch(black_box(&batch)));
    })?;
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let add = add_secs()?;
    let first_level = byte_secs("the first cache", 16)?;
    let second_level = byte_secs("the second cache", 512)?;
    byte_secs("the third cache", 8 << 10)?;
    byte_secs("memory", 256 << 10)?;
    let limits = Limits { add, first_level, second_level };
    camera(&limits)?;
    gaussians(&limits)?;
    network(&limits)
}
