//! The same world at other prices: a front of return against cost needs one task at several.

use metal_rl::belief::Belief;
use metal_rl::environment::{Environment, EnvironmentError, EnvironmentSpec, Outcome, Picture};
use metal_rl::random::Streams;

/// A world whose looks cost `factor` times as much; nothing else changes.
pub struct Priced {
    inner: Box<dyn Environment>,
    spec: EnvironmentSpec,
}

impl Priced {
    /// `inner` with every price multiplied by `factor` (finite, ≥ 0).
    #[must_use]
    pub fn new(inner: Box<dyn Environment>, factor: f64) -> Self {
        let mut spec = inner.spec().clone();
        for sensor in &mut spec.sensors {
            sensor.price *= factor;
        }
        Self { inner, spec }
    }
}

impl Environment for Priced {
    fn spec(&self) -> &EnvironmentSpec {
        &self.spec
    }

    fn reset(&mut self, seed: u64) -> Result<(), EnvironmentError> {
        self.inner.reset(seed)
    }

    fn sense(&mut self, sensor: usize, out: &mut [f64]) -> Result<(), EnvironmentError> {
        self.inner.sense(sensor, out)
    }

    fn step(&mut self, action: usize) -> Result<Outcome, EnvironmentError> {
        self.inner.step(action)
    }

    fn measures(&self) -> &[f64] {
        self.inner.measures()
    }

    fn picture(&self) -> Option<Picture> {
        self.inner.picture()
    }

    fn advise(&mut self) -> Option<usize> {
        self.inner.advise()
    }

    fn belief(&self) -> Option<Belief> {
        self.inner.belief()
    }

    fn imagine(&self, streams: &Streams) -> Option<Box<dyn Environment>> {
        let inner = self.inner.imagine(streams)?;
        Some(Box::new(Self { inner, spec: self.spec.clone() }))
    }

    fn fork(&self) -> Option<Box<dyn Environment>> {
        let inner = self.inner.fork()?;
        Some(Box::new(Self { inner, spec: self.spec.clone() }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::maze::{Maze, MazeConfig};

    #[test]
    fn only_prices_change() {
        let maze = Maze::new(MazeConfig::default()).unwrap();
        let mut dear = Priced::new(Box::new(maze.clone()), 3.0);
        assert!((dear.spec().sensors[1].price - 0.3).abs() < 1e-12);
        let mut plain: Box<dyn Environment> = Box::new(maze);
        let mut fork = dear.fork().unwrap();
        let mut x = [0.0; 2];
        for world in [&mut plain, &mut fork] {
            world.reset(3).unwrap();
        }
        dear.reset(3).unwrap();
        for step in 0..4 {
            plain.sense(0, &mut x[..1]).unwrap();
            dear.sense(0, &mut x[1..]).unwrap();
            assert_eq!(x[0], x[1]);
            assert_eq!(plain.advise(), fork.advise());
            let outcome = plain.step(step).unwrap();
            assert_eq!(outcome, dear.step(step).unwrap());
            assert_eq!(outcome, fork.step(step).unwrap());
            assert_eq!(plain.measures(), dear.measures());
        }
    }
}
