//! Sensors that fail: switched off, covered, or noisy, so that one can watch a mind cope.

use metal_rl::environment::{Environment, EnvironmentError, EnvironmentSpec, Feature, Outcome};
use metal_rl::random::Streams;
use metal_worlds::highway::Highway;
use serde::{Deserialize, Serialize};

/// What is wrong with a sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Fault {
    /// Nothing.
    #[default]
    Fine,
    /// Switched off: every number is the lowest it can be.
    Off,
    /// Covered: a camera region is black all over, a proximity sensor meets nothing.
    Blind,
    /// Readings jump around by [`SPREAD`] of their range.
    Noisy,
}

/// Standard deviation of a noisy sensor's readings, as a share of their range.
pub const SPREAD: f64 = 0.15;

/// The highway with faults in front of the learner's sensors. The world itself is untouched.
#[derive(Clone, Debug)]
pub struct Faulty {
    /// The world behind the sensors.
    pub world: Highway,
    /// One entry per sensor.
    pub faults: Vec<Fault>,
    seed: u64,
    steps: u64,
}

impl Faulty {
    /// A world whose sensors are all fine.
    #[must_use]
    pub fn new(world: Highway) -> Self {
        let faults = vec![Fault::Fine; world.spec().sensors.len()];
        Self { world, faults, seed: 0, steps: 0 }
    }
}

/// A reading as a failing sensor gives it. The noise belongs to the step and the sensor, so looking twice sees the same.
fn spoil(fault: Fault, features: &[Feature], noise: &Streams, out: &mut [f64]) {
    for (i, (value, feature)) in out.iter_mut().zip(features).enumerate() {
        let range = feature.high - feature.low;
        *value = match fault {
            Fault::Fine => *value,
            Fault::Blind if feature.name == "black" => feature.high,
            Fault::Off | Fault::Blind => feature.low,
            Fault::Noisy => {
                let error = SPREAD * range * noise.nth(i as u64).stream("fault").normal();
                (*value + error).clamp(feature.low, feature.high)
            }
        };
    }
}

impl Environment for Faulty {
    fn spec(&self) -> &EnvironmentSpec {
        self.world.spec()
    }

    fn reset(&mut self, seed: u64) -> Result<(), EnvironmentError> {
        (self.seed, self.steps) = (seed, 0);
        self.world.reset(seed)
    }

    fn sense(&mut self, sensor: usize, out: &mut [f64]) -> Result<(), EnvironmentError> {
        self.world.sense(sensor, out)?;
        let noise = Streams::new(self.seed).child("faults").nth(self.steps).nth(sensor as u64);
        spoil(self.faults[sensor], &self.world.spec().sensors[sensor].features, &noise, out);
        Ok(())
    }

    fn step(&mut self, action: usize) -> Result<Outcome, EnvironmentError> {
        self.steps += 1;
        self.world.step(action)
    }

    fn measures(&self) -> &[f64] {
        self.world.measures()
    }

    fn advise(&mut self) -> Option<usize> {
        self.world.advise()
    }

    fn fork(&self) -> Option<Box<dyn Environment>> {
        Some(Box::new(self.clone()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use metal_worlds::highway::{HighwayConfig, Situation, Steering};

    #[test]
    fn faults_change_what_is_read_and_never_the_world() {
        let mut plain = Highway::new(HighwayConfig::default(), Steering::Scripted);
        plain.reset_to(0, Situation::Blocked);
        let mut faulty = Faulty::new(plain.clone());
        faulty.faults[0] = Fault::Blind;
        faulty.faults[1] = Fault::Off;
        faulty.faults[2] = Fault::Noisy;
        let read = |world: &mut dyn Environment, sensor: usize| {
            let mut out = [0.0; 4];
            world.sense(sensor, &mut out).unwrap();
            out
        };
        assert_eq!(read(&mut faulty, 0), [1.0, 0.0, 0.0, 0.0]);
        assert_eq!(read(&mut faulty, 1), [0.0; 4]);
        let noisy = read(&mut faulty, 2);
        assert!(noisy != read(&mut plain, 2) && noisy.iter().all(|x| (0.0..=1.0).contains(x)));
        assert_eq!(noisy, read(&mut faulty, 2), "looking twice sees the same");
        assert_eq!(read(&mut faulty, 3), read(&mut plain, 3));
        for action in [0, 3, 4, 1] {
            assert_eq!(faulty.step(action).unwrap(), plain.step(action).unwrap());
        }
        assert_eq!(faulty.measures(), plain.measures());
    }
}
