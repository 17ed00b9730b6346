//! Perceptual partition: who sees which sensors, and how readings become a state. Eqs. (1, 2).

use crate::environment::{Environment, EnvironmentError, EnvironmentSpec};
use crate::set::IndexSet;
use serde::{Deserialize, Serialize};

/// How a reading is brought to [0, 1]; reading R1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Scaling {
    /// (x − low) / (high − low).
    Linear,
    /// Square root of the linear value: small shares of the picture, such as a far car, become visible.
    #[default]
    SquareRoot,
}

impl Scaling {
    /// The scaled value of `x` in [0, 1]; out-of-range readings are clamped.
    #[must_use]
    pub fn apply(self, x: f64, low: f64, high: f64) -> f64 {
        let linear = ((x - low) / (high - low)).clamp(0.0, 1.0);
        match self {
            Self::Linear => linear,
            Self::SquareRoot => linear.sqrt(),
        }
    }

    /// The linear value, in [0, 1] of the range, of what was scaled to `x`.
    #[must_use]
    pub fn linear(self, x: f64) -> f64 {
        match self {
            Self::Linear => x,
            Self::SquareRoot => x * x,
        }
    }
}

/// What one agent sees: s_TA of Eq. (1) for one sensor, s_FOA of Eq. (2) for several.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct View {
    sensors: Vec<usize>,
    dims: usize,
}

impl View {
    /// The view of `sensors` (indices into the spec), their features concatenated in this order.
    ///
    /// # Panics
    /// If a sensor does not exist.
    #[must_use]
    pub fn new(spec: &EnvironmentSpec, sensors: &[usize]) -> Self {
        let dims = sensors.iter().map(|&s| spec.sensors[s].features.len()).sum();
        Self { sensors: sensors.to_vec(), dims }
    }

    /// Sensors seen, in order of concatenation.
    #[must_use]
    pub fn sensors(&self) -> &[usize] {
        &self.sensors
    }

    /// Sensors seen, as a set.
    #[must_use]
    pub fn set(&self) -> IndexSet {
        self.sensors.iter().copied().collect()
    }

    /// Length of the state.
    #[must_use]
    pub fn dims(&self) -> usize {
        self.dims
    }

    /// Writes the state into `out` (length [`Self::dims`]). A silent sensor's numbers are 0, as if it saw nothing: they
    /// are used only beside those of a sensor that answered (reading R109).
    ///
    /// # Panics
    /// If a sensor of the view was not read in this step: nobody peeks.
    pub fn state(&self, percept: &Percept, out: &mut [f64]) {
        let mut at = 0;
        for &sensor in &self.sensors {
            assert!(percept.read.contains(sensor), "a view is asked only after its sensors were read");
            let reading = percept.scaled(sensor);
            out[at..at + reading.len()].copy_from_slice(reading);
            at += reading.len();
        }
    }
}

/// The readings of one motor step: present where somebody looked, absent elsewhere.
///
/// A sensor that delivers anything but finite numbers is *silent* for the motor step (reading R109): the look is paid,
/// and there is no reading.
#[derive(Clone, Debug, PartialEq)]
pub struct Percept {
    offsets: Vec<usize>,
    values: Vec<f64>,
    read: IndexSet,
    silent: IndexSet,
    scaling: Scaling,
}

impl Percept {
    /// An empty percept for an environment.
    ///
    /// # Panics
    /// If the environment has more than 64 sensors.
    #[must_use]
    pub fn new(spec: &EnvironmentSpec, scaling: Scaling) -> Self {
        assert!(spec.sensors.len() <= IndexSet::CAPACITY, "at most {} sensors", IndexSet::CAPACITY);
        let mut offsets = vec![0];
        for sensor in &spec.sensors {
            offsets.push(offsets[offsets.len() - 1] + sensor.features.len());
        }
        let values = vec![0.0; offsets[offsets.len() - 1]];
        Self { offsets, values, read: IndexSet::EMPTY, silent: IndexSet::EMPTY, scaling }
    }

    /// Forgets everything: a new motor step begins.
    pub fn clear(&mut self) {
        (self.read, self.silent) = (IndexSet::EMPTY, IndexSet::EMPTY);
    }

    /// Reads `sensor` if nobody did in this step, and says whether it was read now (and is therefore to be paid).
    ///
    /// # Errors
    /// If the sensor does not answer.
    pub fn look(
        &mut self,
        environment: &mut dyn Environment,
        sensor: usize,
    ) -> Result<bool, EnvironmentError> {
        if self.read.contains(sensor) {
            return Ok(false);
        }
        let range = self.offsets[sensor]..self.offsets[sensor + 1];
        environment.sense(sensor, &mut self.values[range.clone()])?;
        self.read = self.read.with(sensor);
        let values = &mut self.values[range];
        if values.iter().any(|value| !value.is_finite()) {
            values.fill(0.0);
            self.silent = self.silent.with(sensor);
            return Ok(true);
        }
        let features = &environment.spec().sensors[sensor].features;
        for (value, feature) in values.iter_mut().zip(features) {
            *value = self.scaling.apply(*value, feature.low, feature.high);
        }
        Ok(true)
    }

    fn scaled(&self, sensor: usize) -> &[f64] {
        &self.values[self.offsets[sensor]..self.offsets[sensor + 1]]
    }

    /// The scaled reading of `sensor`, if somebody looked and it answered.
    #[must_use]
    pub fn reading(&self, sensor: usize) -> Option<&[f64]> {
        (self.read.contains(sensor) && !self.silent.contains(sensor)).then(|| self.scaled(sensor))
    }

    /// Which of the sensors that were read did not deliver finite numbers.
    #[must_use]
    pub fn silent(&self) -> IndexSet {
        self.silent
    }

    /// Which sensors were read in this step.
    #[must_use]
    pub fn read(&self) -> IndexSet {
        self.read
    }
}
