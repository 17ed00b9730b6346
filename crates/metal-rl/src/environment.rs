//! What a mind may know of a world: sensors that are read only when asked, motor actions, and their consequences.

use crate::belief::Belief;
use serde::{Deserialize, Serialize};

/// One number a sensor delivers, with the range that a mind scales to [0, 1].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Feature {
    /// Name, unique within its sensor.
    pub name: String,
    /// Smallest value, in the sensor's own unit.
    pub low: f64,
    /// Largest value, in the sensor's own unit.
    pub high: f64,
}

/// A sensor: what it measures and what one look costs. Fig. 7b.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SensorSpec {
    /// Name, unique within the environment.
    pub name: String,
    /// The numbers it delivers; c_i of Eq. (1).
    pub features: Vec<Feature>,
    /// Price of one look, in units of reward, ≥ 0.
    pub price: f64,
}

/// The contract of an environment: everything that is fixed before the first step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EnvironmentSpec {
    /// Registry name with its version, e.g. `Highway-v0`.
    pub id: String,
    /// Sensors, at most 64.
    pub sensors: Vec<SensorSpec>,
    /// Names of the motor actions. Eq. (12).
    pub actions: Vec<String>,
    /// Motor steps after which an episode is cut ([`End::TimeLimit`]).
    pub horizon: usize,
    /// Names of what [`Environment::measures`] reports after each step.
    pub measures: Vec<String>,
}

impl EnvironmentSpec {
    /// Index of the sensor called `name`.
    #[must_use]
    pub fn sensor(&self, name: &str) -> Option<usize> {
        self.sensors.iter().position(|s| s.name == name)
    }

    /// Index of the measure called `name`.
    #[must_use]
    pub fn measure(&self, name: &str) -> Option<usize> {
        self.measures.iter().position(|m| m == name)
    }
}

/// A colour picture, row by row from the upper left.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Pixels in a row.
    pub columns: usize,
    /// Red, green and blue of each pixel.
    pub pixels: Vec<[u8; 3]>,
}

impl Picture {
    /// Rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.pixels.len() / self.columns.max(1)
    }

    /// The part of `columns` × `rows` pixels whose upper left corner is at (`left`, `top`).
    #[must_use]
    pub fn cropped(&self, [left, top]: [usize; 2], [columns, rows]: [usize; 2]) -> Self {
        let row = |r: usize| &self.pixels[r * self.columns + left..r * self.columns + left + columns];
        Self { columns, pixels: (top..top + rows).flat_map(row).copied().collect() }
    }
}

/// Whether and why an episode is over. A time limit is no fact about the world, so learners bootstrap through it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum End {
    /// The episode goes on.
    Running,
    /// The world is over: the future is worth nothing.
    Terminal,
    /// Somebody stopped the clock: the future is worth what it was.
    TimeLimit,
}

/// What a motor action led to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Reward of the motor action, without the price of looking (a cost is negative). Fig. 7a.
    pub motor_reward: f64,
    /// Whether the episode is over.
    pub end: End,
}

/// What a body, a link or a file may fail with. Simulated worlds never do.
#[derive(Debug, thiserror::Error)]
pub enum EnvironmentError {
    /// A sensor did not answer.
    #[error("sensor `{sensor}` of {environment} did not answer: {reason}")]
    Sensor {
        /// Registry name of the environment.
        environment: String,
        /// Name of the sensor.
        sensor: String,
        /// What the device or link said.
        reason: String,
    },
    /// A motor action could not be carried out.
    #[error("motor action `{action}` of {environment} failed: {reason}")]
    Motor {
        /// Registry name of the environment.
        environment: String,
        /// Name of the action.
        action: String,
        /// What the device or link said.
        reason: String,
    },
}

/// A simulated world, a recording or a real robot.
///
/// Invariants, tested for every registered environment: looking never changes the world (any subset of sensors, in any
/// order, any number of times: the same readings and the same future); the same seed and actions give the same bits;
/// readings are finite and within their declared range.
pub trait Environment: Send {
    /// The contract.
    fn spec(&self) -> &EnvironmentSpec;

    /// Begins an episode. All randomness of the episode comes from `seed`.
    ///
    /// # Errors
    /// If the body or its link fails.
    fn reset(&mut self, seed: u64) -> Result<(), EnvironmentError>;

    /// Reads one sensor into `out` (one entry per feature, in the sensor's own unit). Only this computes anything:
    /// a sensor nobody asks is never rendered, requested or evaluated.
    ///
    /// # Errors
    /// If the sensor does not answer.
    fn sense(&mut self, sensor: usize, out: &mut [f64]) -> Result<(), EnvironmentError>;

    /// Carries out one motor action.
    ///
    /// # Errors
    /// If the body or its link fails.
    fn step(&mut self, action: usize) -> Result<Outcome, EnvironmentError>;

    /// Facts about the last step for records and figures (see [`EnvironmentSpec::measures`]); no mind may use them.
    fn measures(&self) -> &[f64];

    /// What a camera shows now, for records; no mind may use it. To show it must make nobody look: a body shows a picture
    /// that was taken anyway, a simulation paints one.
    fn picture(&self) -> Option<Picture> {
        None
    }

    /// The motor action an expert advisor with ground truth would take now, where the world has one (Phase I).
    fn advise(&mut self) -> Option<usize> {
        None
    }

    /// An independent copy of the world as it stands now, randomness included, where the world can be copied.
    fn fork(&self) -> Option<Box<dyn Environment>> {
        None
    }

    /// A world of the same contract made of situations that this one could bring but did not, where it can imagine any:
    /// a few examples are else learned by heart before looks are learned. Whoever learns in it must be compared in the
    /// real one.
    fn imagine(&self, streams: &crate::random::Streams) -> Option<Box<dyn Environment>> {
        let _ = streams;
        None
    }

    /// The model that this world is drawn from, where it is an imagined one and somebody can say what it believes after
    /// some looks: whoever learns here may be told.
    fn belief(&self) -> Option<Belief> {
        None
    }
}

impl<E: Environment + ?Sized> Environment for Box<E> {
    fn spec(&self) -> &EnvironmentSpec {
        (**self).spec()
    }

    fn reset(&mut self, seed: u64) -> Result<(), EnvironmentError> {
        (**self).reset(seed)
    }

    fn sense(&mut self, sensor: usize, out: &mut [f64]) -> Result<(), EnvironmentError> {
        (**self).sense(sensor, out)
    }

    fn step(&mut self, action: usize) -> Result<Outcome, EnvironmentError> {
        (**self).step(action)
    }

    fn measures(&self) -> &[f64] {
        (**self).measures()
    }

    fn picture(&self) -> Option<Picture> {
        (**self).picture()
    }

    fn advise(&mut self) -> Option<usize> {
        (**self).advise()
    }

    fn fork(&self) -> Option<Box<dyn Environment>> {
        (**self).fork()
    }

    fn imagine(&self, streams: &crate::random::Streams) -> Option<Box<dyn Environment>> {
        (**self).imagine(streams)
    }

    fn belief(&self) -> Option<Belief> {
        (**self).belief()
    }
}
