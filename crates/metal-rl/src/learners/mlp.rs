//! A neural network over replayed samples: the modern stand-in for the paper's learner
//! ("can be replaced by any other continuous RL approach", Sec. 3.2.1).

use super::frozen;
use super::nn::{Activation, Adam, Batch, Network, narrow};
use super::settings::{POSITIVE, Settings};
use crate::learner::{Dims, Learner, LearnerError, Rate, Sample};
use crate::num;
use crate::random::Streams;
use serde::{Deserialize, Serialize};

/// Name in configurations and frozen bytes.
pub(super) const NAME: &str = "mlp";

/// Settings of [`Mlp`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MlpConfig {
    /// Widths of the hidden layers.
    pub hidden: Vec<usize>,
    /// What hidden units do.
    pub activation: Activation,
    /// Optimiser; its step and clip are in units of the targets' running standard deviation.
    pub adam: Adam,
    /// Samples kept for replay.
    pub capacity: usize,
    /// Samples per training step; the newest one is always among them.
    pub batch: usize,
    /// Training steps per sample learned; fractions accumulate.
    pub batches_per_sample: f64,
    /// Temperature of the degrees of support, in units of value: softmax(Q/temperature).
    pub temperature: f64,
}

impl Default for MlpConfig {
    fn default() -> Self {
        Self {
            hidden: vec![64, 64],
            activation: Activation::LeakyRelu,
            adam: Adam::default(),
            capacity: 6000,
            batch: 16,
            batches_per_sample: 1.0,
            temperature: 3.0,
        }
    }
}

impl MlpConfig {
    /// Refuses settings outside their range.
    ///
    /// # Errors
    /// Names the first field that is out of range.
    pub fn validate(&self) -> Result<(), LearnerError> {
        let s = Settings(NAME);
        for &width in &self.hidden {
            s.within("hidden", width as f64, 1.0..=4096.0, "layers are 1 to 4096 wide")?;
        }
        s.check("adam.learning_rate", f64::from(self.adam.learning_rate), POSITIVE)?;
        s.check("adam.error_clip", f64::from(self.adam.error_clip), POSITIVE)?;
        s.within("adam.beta1", f64::from(self.adam.beta1), 0.0..=0.999_99, "must be in [0, 1)")?;
        s.within("adam.beta2", f64::from(self.adam.beta2), 0.0..=0.999_999_9, "must be in [0, 1)")?;
        s.within("capacity", self.capacity as f64, 1.0..=1e8, "must be 1 to 100 million")?;
        s.within("batch", self.batch as f64, 1.0..=65536.0, "must be 1 to 65536")?;
        s.within("batches_per_sample", self.batches_per_sample, 0.0..=1000.0, "must be 0 to 1000")?;
        s.check("temperature", self.temperature, POSITIVE)
    }

    /// Widths of the whole network.
    fn widths(&self, dims: Dims) -> Vec<usize> {
        let ends = (std::iter::once(dims.inputs), std::iter::once(dims.choices));
        ends.0.chain(self.hidden.iter().copied()).chain(ends.1).collect()
    }
}

/// The last samples, oldest overwritten first.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Replay {
    states: Vec<f32>,
    choices: Vec<u32>,
    targets: Vec<f64>,
    next: usize,
}

impl Replay {
    /// Stores a sample and returns its place.
    fn push(&mut self, sample: &Sample<'_>, capacity: usize) -> usize {
        let (place, width) = (self.next, sample.state.len());
        if self.targets.len() < capacity {
            self.states.resize(self.states.len() + width, 0.0);
            self.choices.push(0);
            self.targets.push(0.0);
        }
        narrow(sample.state, &mut self.states[place * width..(place + 1) * width]);
        self.choices[place] = sample.choice as u32;
        self.targets[place] = sample.target;
        self.next = (place + 1) % capacity;
        place
    }

    /// Whether thawed vectors fit together.
    fn is_sound(&self, dims: Dims, capacity: usize) -> bool {
        let n = self.targets.len();
        self.choices.len() == n
            && n <= capacity
            && self.states.len() == n * dims.inputs
            && self.next < capacity.min(n + 1)
            && self.choices.iter().all(|&c| (c as usize) < dims.choices)
    }
}

/// Running mean and spread of the targets, and the unit the network computes in.
///
/// Adam steps by about its learning rate whatever the size of the errors, so targets near −100 would take a hundred
/// times longer than targets near −1. The unit follows the running moments in steps of a tenth.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct TargetScale {
    count: f64,
    mean: f64,
    variance: f64,
    centre: f64,
    unit: f64,
}

impl TargetScale {
    /// Slowest rate at which the moments follow the targets.
    const FLOOR: f64 = 1e-3;
    /// Smallest unit, against constant targets.
    const SMALLEST: f64 = 1e-3;

    fn new() -> Self {
        Self { count: 0.0, mean: 0.0, variance: 0.0, centre: 0.0, unit: 1.0 }
    }

    /// Takes in a target; if the unit had to change, the (gain, shift) that keeps the network's values.
    fn observe(&mut self, target: f64) -> Option<(f64, f64)> {
        self.count += 1.0;
        let rate = (1.0 / self.count).max(Self::FLOOR);
        let error = target - self.mean;
        self.mean += rate * error;
        self.variance = (1.0 - rate) * (self.variance + rate * error * error);
        if self.count < 1.5 {
            // Nothing is learned yet: starting at the first target saves the way there from 0.
            (self.centre, self.unit) = (target, (0.1 * target.abs()).max(1.0));
            return None;
        }
        let unit = self.variance.sqrt().max(Self::SMALLEST).max(0.1 * self.mean.abs());
        let grown = (unit / self.unit - 1.0).abs() > 0.1;
        if !grown && (self.mean - self.centre).abs() < 0.1 * self.unit {
            return None;
        }
        let change = (self.unit / unit, (self.centre - self.mean) / unit);
        (self.centre, self.unit) = (self.mean, unit);
        Some(change)
    }
}

/// Buffers of one training step; they carry nothing from step to step.
#[derive(Clone, Debug, Default)]
struct Rows {
    inputs: Vec<f32>,
    targets: Vec<f32>,
    weights: Vec<f32>,
    values: Vec<f64>,
}

/// A neural network that learns all values at once from replayed samples; see [`MlpConfig`].
///
/// The `rate` of a sample is not used: regression over the replay averages targets, and Adam sets the step
/// (reading R33).
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Mlp {
    config: MlpConfig,
    dims: Dims,
    network: Network,
    replay: Replay,
    scale: TargetScale,
    /// Training steps owed, a fraction below 1 between samples.
    owed: f64,
    rng: crate::random::Rng,
    #[serde(skip)]
    rows: Rows,
}

impl Mlp {
    /// A fresh network; its weights and replay draws come from `seed`.
    ///
    /// # Errors
    /// If a setting is outside its range.
    pub fn new(config: &MlpConfig, dims: Dims, seed: u64) -> Result<Self, LearnerError> {
        config.validate()?;
        let streams = Streams::new(seed);
        let widths = config.widths(dims);
        let network =
            Network::new(&widths, config.activation, config.adam, &mut streams.stream("mlp/weights"));
        Ok(Self {
            config: config.clone(),
            dims,
            network,
            replay: Replay { states: Vec::new(), choices: Vec::new(), targets: Vec::new(), next: 0 },
            scale: TargetScale::new(),
            owed: 0.0,
            rng: streams.stream("mlp/replay"),
            rows: Rows::default(),
        })
    }

    /// The learner frozen in `bytes`.
    ///
    /// # Errors
    /// If the bytes are damaged or were frozen under other settings.
    pub fn thaw(config: &MlpConfig, bytes: &[u8]) -> Result<Self, LearnerError> {
        let mlp: Self = frozen::open(NAME, bytes)?;
        let sound =
            mlp.network.fits(&config.widths(mlp.dims)) && mlp.replay.is_sound(mlp.dims, config.capacity);
        if mlp.config == *config && sound { Ok(mlp) } else { Err(frozen::foreign(NAME)) }
    }

    /// One training step on the sample at `newest` and others drawn at random.
    fn train(&mut self, newest: usize) {
        let (inputs, choices) = (self.dims.inputs, self.dims.choices);
        let rows = self.config.batch.min(self.replay.targets.len());
        self.rows.inputs.clear();
        self.rows.targets.clear();
        self.rows.targets.resize(rows * choices, 0.0);
        self.rows.weights.clear();
        self.rows.weights.resize(rows * choices, 0.0);
        for row in 0..rows {
            let from = if row == 0 { newest } else { self.rng.below(self.replay.targets.len()) };
            let at = row * choices + self.replay.choices[from] as usize;
            self.rows.inputs.extend_from_slice(&self.replay.states[from * inputs..(from + 1) * inputs]);
            self.rows.targets[at] =
                ((self.replay.targets[from] - self.scale.centre) / self.scale.unit) as f32;
            self.rows.weights[at] = 1.0;
        }
        let Rows { inputs, targets, weights, .. } = &self.rows;
        self.network.train_batch(&Batch { inputs, targets, weights });
    }
}

/// Runs `body` with `state` as `f32` on the stack where it fits.
fn with_narrow<T>(state: &[f64], body: impl FnOnce(&[f32]) -> T) -> T {
    const STACK: usize = 128;
    if state.len() <= STACK {
        let mut buffer = [0.0; STACK];
        narrow(state, &mut buffer);
        body(&buffer[..state.len()])
    } else {
        let mut buffer = vec![0.0; state.len()];
        narrow(state, &mut buffer);
        body(&buffer)
    }
}

impl Learner for Mlp {
    fn dims(&self) -> Dims {
        self.dims
    }

    fn values(&self, state: &[f64], out: &mut [f64]) {
        const STACK: usize = 64;
        assert_eq!(state.len(), self.dims.inputs, "length of the state");
        let (mut stack, mut heap);
        let outputs: &mut [f32] = if out.len() <= STACK {
            stack = [0.0; STACK];
            &mut stack[..out.len()]
        } else {
            heap = vec![0.0; out.len()];
            &mut heap
        };
        with_narrow(state, |state| self.network.forward(state, outputs));
        for (out, &z) in out.iter_mut().zip(outputs.iter()) {
            *out = self.scale.centre + self.scale.unit * f64::from(z);
        }
    }

    fn support(&self, state: &[f64], out: &mut [f64]) {
        self.values(state, out);
        num::soft_max(out, self.config.temperature);
    }

    fn values_and_support(&self, state: &[f64], values: &mut [f64], support: &mut [f64]) {
        self.values(state, values);
        support.copy_from_slice(values);
        num::soft_max(support, self.config.temperature);
    }

    fn learn(&mut self, sample: Sample<'_>, _rate: Rate) -> f64 {
        let mut values = std::mem::take(&mut self.rows.values);
        values.resize(self.dims.choices, 0.0);
        self.values(sample.state, &mut values);
        let error = sample.target - values[sample.choice];
        self.rows.values = values;
        let place = self.replay.push(&sample, self.config.capacity);
        if let Some((gain, shift)) = self.scale.observe(sample.target) {
            self.network.rescale_outputs(gain as f32, shift as f32);
        }
        self.owed += self.config.batches_per_sample;
        while self.owed >= 1.0 {
            self.owed -= 1.0;
            self.train(place);
        }
        error
    }

    fn size(&self) -> (usize, &'static str) {
        (self.network.weights(), "weights")
    }

    fn freeze(&self) -> Vec<u8> {
        frozen::seal(NAME, self)
    }

    fn boxed_clone(&self) -> Box<dyn Learner> {
        Box::new(self.clone())
    }
}
