//! Puddle world: a walk across the unit square around two deep puddles to a corner; a proving ground for learners
//! (Boyan and Moore 1995; the puddles, steps and noise are those of Sutton 1996).

use metal_rl::environment::{
    End, Environment, EnvironmentError, EnvironmentSpec, Feature, Outcome, SensorSpec,
};
use metal_rl::num;
use metal_rl::random::Streams;
use serde::{Deserialize, Serialize};

/// Length of a step.
const STEP: f64 = 0.05;

/// Standard deviation of the noise on each coordinate of a step.
const NOISE: f64 = 0.01;

/// Radius of the puddles around their axes.
const RADIUS: f64 = 0.1;

/// Reward per unit of depth.
const DEPTH_REWARD: f64 = -400.0;

/// The puddles' axes, from one point to another.
const PUDDLES: [[(f64, f64); 2]; 2] = [[(0.1, 0.75), (0.45, 0.75)], [(0.45, 0.4), (0.45, 0.8)]];

/// Settings of [`Puddle`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PuddleConfig {
    /// Motor steps after which an episode is cut.
    pub horizon: usize,
    /// Price of one look at the whole position.
    pub position_price: f64,
    /// Price of one look at a single coordinate.
    pub coordinate_price: f64,
}

impl Default for PuddleConfig {
    fn default() -> Self {
        Self { horizon: 300, position_price: 2.0, coordinate_price: 1.0 }
    }
}

/// The walker in its square.
#[derive(Clone, Debug)]
pub struct Puddle {
    spec: EnvironmentSpec,
    rng: metal_rl::random::Rng,
    x: f64,
    y: f64,
    steps: usize,
    measures: [f64; 1],
}

/// A sensor that delivers these coordinates.
fn sensor(name: &str, coordinates: &[&str], price: f64) -> SensorSpec {
    let feature = |&c: &&str| Feature { name: c.into(), low: 0.0, high: 1.0 };
    SensorSpec { name: name.into(), features: coordinates.iter().map(feature).collect(), price }
}

impl Puddle {
    /// A world whose first episode begins with `reset`.
    #[must_use]
    pub fn new(config: &PuddleConfig) -> Self {
        let spec = EnvironmentSpec {
            id: "Puddle-v0".into(),
            sensors: vec![
                sensor("position", &["x", "y"], config.position_price),
                sensor("x", &["x"], config.coordinate_price),
                sensor("y", &["y"], config.coordinate_price),
            ],
            actions: ["left", "right", "down", "up"].map(String::from).to_vec(),
            horizon: config.horizon,
            measures: vec!["depth".into()],
        };
        let rng = Streams::new(0).stream("puddle");
        Self { spec, rng, x: 0.0, y: 0.0, steps: 0, measures: [0.0] }
    }

    /// Begins an episode at a given place instead of a random one.
    pub fn reset_at(&mut self, x: f64, y: f64, seed: u64) {
        self.rng = Streams::new(seed).stream("puddle");
        (self.x, self.y) = (x.clamp(0.0, 1.0), y.clamp(0.0, 1.0));
        self.steps = 0;
        self.measures = [depth(self.x, self.y)];
    }

    /// Whether the walker has reached the goal, the corner beyond x + y = 1.9.
    fn at_goal(&self) -> bool {
        self.x + self.y >= 1.9
    }
}

/// How deep a place lies in the puddles: distance to the nearest edge, summed over puddles.
#[must_use]
pub fn depth(x: f64, y: f64) -> f64 {
    PUDDLES.iter().map(|&[a, b]| (RADIUS - distance((x, y), a, b)).max(0.0)).sum()
}

/// Distance of a point to the segment from `a` to `b`.
fn distance(p: (f64, f64), a: (f64, f64), b: (f64, f64)) -> f64 {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let along = ((p.0 - a.0) * dx + (p.1 - a.1) * dy) / (dx * dx + dy * dy);
    let t = along.clamp(0.0, 1.0);
    num::hypot(p.0 - a.0 - t * dx, p.1 - a.1 - t * dy)
}

impl Environment for Puddle {
    fn spec(&self) -> &EnvironmentSpec {
        &self.spec
    }

    fn reset(&mut self, seed: u64) -> Result<(), EnvironmentError> {
        let mut starts = Streams::new(seed).stream("puddle/start");
        loop {
            let (x, y) = (starts.uniform(), starts.uniform());
            self.reset_at(x, y, seed);
            if !self.at_goal() {
                return Ok(());
            }
        }
    }

    fn sense(&mut self, sensor: usize, out: &mut [f64]) -> Result<(), EnvironmentError> {
        match sensor {
            0 => out.copy_from_slice(&[self.x, self.y]),
            1 => out[0] = self.x,
            _ => out[0] = self.y,
        }
        Ok(())
    }

    fn step(&mut self, action: usize) -> Result<Outcome, EnvironmentError> {
        assert!(action < 4, "puddle world has 4 actions, not {}", action + 1);
        let (dx, dy) = [(-STEP, 0.0), (STEP, 0.0), (0.0, -STEP), (0.0, STEP)][action];
        self.x = (self.x + dx + NOISE * self.rng.normal()).clamp(0.0, 1.0);
        self.y = (self.y + dy + NOISE * self.rng.normal()).clamp(0.0, 1.0);
        self.steps += 1;
        self.measures = [depth(self.x, self.y)];
        let end = match (self.at_goal(), self.steps >= self.spec.horizon) {
            (true, _) => End::Terminal,
            (false, true) => End::TimeLimit,
            (false, false) => End::Running,
        };
        Ok(Outcome { motor_reward: -1.0 + DEPTH_REWARD * self.measures[0], end })
    }

    fn measures(&self) -> &[f64] {
        &self.measures
    }

    fn fork(&self) -> Option<Box<dyn Environment>> {
        Some(Box::new(self.clone()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn puddles_are_deepest_on_their_axes() {
        assert!((depth(0.2, 0.75) - 0.1).abs() < 1e-12);
        assert!((depth(0.45, 0.75) - 0.2).abs() < 1e-12, "both puddles");
        assert!((depth(0.0, 0.75)).abs() < 1e-12, "the rounded end");
        assert!(depth(0.9, 0.9).abs() < 1e-12);
    }

    #[test]
    fn the_corner_ends_an_episode_and_the_clock_cuts_one() {
        let mut world = Puddle::new(&PuddleConfig { horizon: 40, ..PuddleConfig::default() });
        world.reset_at(0.97, 0.6, 1);
        let ends: Vec<End> = (0..10).map(|_| world.step(3).unwrap().end).collect();
        assert!(ends.contains(&End::Terminal));
        world.reset_at(0.0, 0.0, 1);
        let ends: Vec<End> = (0..40).map(|_| world.step(0).unwrap().end).collect();
        assert_eq!((ends[38], ends[39]), (End::Running, End::TimeLimit));
    }

    #[test]
    fn looking_changes_nothing_and_the_seed_everything() {
        let walk = |seed, looks: usize| {
            let mut world = Puddle::new(&PuddleConfig::default());
            world.reset(seed).unwrap();
            let mut position = [0.0; 2];
            for action in [3, 1, 1, 0, 2] {
                (0..looks).for_each(|_| world.sense(0, &mut position).unwrap());
                world.step(action).unwrap();
            }
            world.sense(0, &mut position).unwrap();
            position.map(f64::to_bits)
        };
        assert_eq!(walk(5, 0), walk(5, 3));
        assert_ne!(walk(5, 0), walk(6, 0));
    }
}
