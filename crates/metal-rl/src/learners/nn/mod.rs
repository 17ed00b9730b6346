//! A dense neural network small enough to be read: hidden layers of (leaky) rectifiers, linear outputs, Adam.
//!
//! Numbers are `f32`. Weights lie in blocks of [`LANES`] outputs, so that the inner loop runs over outputs: it needs
//! no horizontal sum, keeps the order of additions of the plain scalar code, and the compiler turns it into vector
//! instructions.

mod kernels;
pub mod recurrent;

use crate::num;
use crate::random::Rng;
use kernels::{Backward, Moments, Row};
use serde::{Deserialize, Serialize};

pub use kernels::LANES;

/// Blocks of the widest layer whose activations fit on the stack in [`Network::forward`].
const STACK: usize = 256 / LANES;

/// What a hidden unit does to its sum.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Activation {
    /// max(x, 0).
    Relu,
    /// max(x, x/100): no unit can die.
    #[default]
    LeakyRelu,
}

impl Activation {
    /// Slope for negative sums.
    fn slope(self) -> f32 {
        match self {
            Self::Relu => 0.0,
            Self::LeakyRelu => 0.01,
        }
    }
}

/// Settings of the optimiser (Kingma and Ba 2015) and the loss.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Adam {
    /// Step size, > 0.
    pub learning_rate: f32,
    /// Decay of the mean gradient, in [0, 1).
    pub beta1: f32,
    /// Decay of the mean squared gradient, in [0, 1).
    pub beta2: f32,
    /// Errors beyond this count linearly (Huber's loss), in units of the network's outputs, > 0.
    pub error_clip: f32,
}

impl Default for Adam {
    fn default() -> Self {
        Self { learning_rate: 1e-3, beta1: 0.9, beta2: 0.999, error_clip: 10.0 }
    }
}

/// Samples to train on, row by row.
#[derive(Clone, Copy, Debug)]
pub struct Batch<'a> {
    /// Inputs: samples × inputs.
    pub inputs: &'a [f32],
    /// Targets: samples × outputs (entries of weight 0 are never looked at).
    pub targets: &'a [f32],
    /// Weight of each target: samples × outputs; 0 where there is none.
    pub weights: &'a [f32],
}

/// One dense layer. Row `inputs` of each block is the bias.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Layer {
    inputs: usize,
    outputs: usize,
    /// Blocks × (inputs + 1) rows.
    weights: Vec<Row>,
    mean_gradient: Vec<Row>,
    mean_square: Vec<Row>,
}

/// A dense network with its optimiser's memory.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Network {
    layers: Vec<Layer>,
    activation: Activation,
    adam: Adam,
    steps: u32,
    #[serde(skip)]
    work: Workspace,
}

/// Buffers of training; they carry nothing from batch to batch.
#[derive(Clone, Debug, Default)]
struct Workspace {
    /// Per layer: samples × blocks.
    activations: Vec<Vec<Row>>,
    /// As activations: derivative of the loss with respect to each layer's sums.
    deltas: Vec<Vec<Row>>,
    /// Per layer: as its weights.
    gradients: Vec<Vec<Row>>,
    /// Weights of the layer on its way back, inputs side by side.
    transposed: Vec<Row>,
}

impl Layer {
    /// Normal weights of the given standard deviation, no bias.
    fn new(inputs: usize, outputs: usize, sd: f64, rng: &mut Rng) -> Self {
        let rows = outputs.div_ceil(LANES) * (inputs + 1);
        let mut weights = vec![[0.0; LANES]; rows];
        for o in 0..outputs {
            for i in 0..inputs {
                weights[o / LANES * (inputs + 1) + i][o % LANES] = (sd * rng.normal()) as f32;
            }
        }
        let zeros = vec![[0.0; LANES]; rows];
        Self { inputs, outputs, weights, mean_gradient: zeros.clone(), mean_square: zeros }
    }

    /// Blocks of outputs.
    fn blocks(&self) -> usize {
        self.outputs.div_ceil(LANES)
    }

    /// Carries deltas back to this layer's inputs, given those inputs' activations.
    fn carry_back(&self, deltas: &[Row], below: &[Row], slope: f32, buffers: (&mut Vec<Row>, &mut [Row])) {
        let (transposed, out) = buffers;
        let blocks = self.blocks();
        transposed.clear();
        transposed.resize(self.inputs.div_ceil(LANES) * blocks * LANES, [0.0; LANES]);
        kernels::transpose(&self.weights, self.inputs, transposed);
        kernels::carry_back(&Backward { transposed, blocks, slope }, deltas, below, out);
    }

    /// One step of Adam; `rate` holds the step size and the least divisor, corrected for the start.
    fn step(&mut self, gradient: &[Row], adam: Adam, rate: [f32; 2]) {
        let (mean, square) = (&mut self.mean_gradient, &mut self.mean_square);
        let moments = Moments { mean, square, betas: [adam.beta1, adam.beta2], rate };
        kernels::adam(&mut self.weights, gradient, moments);
    }

    /// Whether all vectors have the lengths that the shape demands.
    fn is_sound(&self) -> bool {
        let rows = self.outputs.div_ceil(LANES) * (self.inputs + 1);
        [&self.weights, &self.mean_gradient, &self.mean_square].iter().all(|v| v.len() == rows)
    }
}

/// Applies the activation in place.
fn rectify(sums: &mut [f32], slope: f32) {
    for x in sums {
        *x = if *x > 0.0 { *x } else { slope * *x };
    }
}

/// Copies `from` into `to` as `f32`, limited to ±10⁶ so that no finite state can overflow a sum.
///
/// # Panics
/// If `to` is shorter than `from`.
pub fn narrow(from: &[f64], to: &mut [f32]) {
    for (to, &from) in to[..from.len()].iter_mut().zip(from) {
        *to = from.clamp(-1e6, 1e6) as f32;
    }
}

impl Network {
    /// A network of the given widths (inputs, hidden …, outputs); outputs start near 0.
    ///
    /// # Panics
    /// If there are fewer than two widths or one is 0.
    #[must_use]
    pub fn new(widths: &[usize], activation: Activation, adam: Adam, rng: &mut Rng) -> Self {
        assert!(widths.len() >= 2 && !widths.contains(&0), "widths {widths:?} make no network");
        let last = widths.len() - 2;
        let layers = widths.windows(2).enumerate().map(|(l, pair)| {
            let gain: f64 = if l == last { 0.01 } else { 2.0 };
            Layer::new(pair[0], pair[1], (gain / pair[0] as f64).sqrt(), rng)
        });
        Self { layers: layers.collect(), activation, adam, steps: 0, work: Workspace::default() }
    }

    /// Number of inputs.
    #[must_use]
    pub fn inputs(&self) -> usize {
        self.layers[0].inputs
    }

    /// Number of outputs.
    #[must_use]
    pub fn outputs(&self) -> usize {
        self.layers[self.layers.len() - 1].outputs
    }

    /// Number of weights, biases included.
    #[must_use]
    pub fn weights(&self) -> usize {
        self.layers.iter().map(|l| (l.inputs + 1) * l.outputs).sum()
    }

    /// Whether a thawed network fits the given widths.
    #[must_use]
    pub(crate) fn fits(&self, widths: &[usize]) -> bool {
        self.layers.len() + 1 == widths.len()
            && self.layers.iter().zip(widths.windows(2)).all(|(l, w)| [l.inputs, l.outputs] == *w)
            && self.layers.iter().all(Layer::is_sound)
    }

    /// Outputs for one input. Nothing is allocated while every layer is at most 256 wide.
    ///
    /// # Panics
    /// If the lengths are not those of the network.
    pub fn forward(&self, input: &[f32], out: &mut [f32]) {
        assert_eq!((input.len(), out.len()), (self.inputs(), self.outputs()), "shape of the network");
        let widest = self.layers.iter().map(Layer::blocks).max().unwrap_or(0);
        if widest <= STACK {
            self.forward_in(input, out, &mut [[0.0; LANES]; STACK], &mut [[0.0; LANES]; STACK]);
        } else {
            self.forward_in(input, out, &mut vec![[0.0; LANES]; widest], &mut vec![[0.0; LANES]; widest]);
        }
    }

    /// Forward pass through two buffers at least as wide as every layer.
    fn forward_in<'a>(
        &self,
        input: &[f32],
        out: &mut [f32],
        mut here: &'a mut [Row],
        mut there: &'a mut [Row],
    ) {
        let (last, hidden) = self.layers.split_last().expect("a network has a layer");
        let slope = self.activation.slope();
        for (l, layer) in hidden.iter().enumerate() {
            let source: &[f32] = if l == 0 { input } else { there.as_flattened() };
            let sums = &mut here[..layer.blocks()];
            kernels::affine(&layer.weights, &source[..layer.inputs], sums);
            rectify(sums.as_flattened_mut(), slope);
            std::mem::swap(&mut here, &mut there);
        }
        let source: &[f32] = if hidden.is_empty() { input } else { there.as_flattened() };
        let sums = &mut here[..last.blocks()];
        kernels::affine(&last.weights, &source[..last.inputs], sums);
        out.copy_from_slice(&sums.as_flattened()[..last.outputs]);
    }

    /// Changes the step size of the optimiser.
    pub fn set_learning_rate(&mut self, rate: f32) {
        self.adam.learning_rate = rate;
    }

    /// Moves every weight towards that of `other` by `share`: a running average of weights, if `other` is being trained.
    ///
    /// # Panics
    /// If the networks differ in shape.
    pub fn blend(&mut self, other: &Self, share: f32) {
        assert_eq!(self.layers.len(), other.layers.len(), "networks of one shape");
        for (mine, theirs) in self.layers.iter_mut().zip(&other.layers) {
            assert_eq!(mine.weights.len(), theirs.weights.len(), "layers of one shape");
            for (row, other) in mine.weights.iter_mut().zip(&theirs.weights) {
                for lane in 0..LANES {
                    row[lane] += share * (other[lane] - row[lane]);
                }
            }
        }
    }

    /// Shrinks every weight but the biases by `share`.
    pub fn decay(&mut self, share: f32) {
        for layer in &mut self.layers {
            for block in layer.weights.chunks_exact_mut(layer.inputs + 1) {
                for row in &mut block[..layer.inputs] {
                    row.iter_mut().for_each(|w| *w -= share * *w);
                }
            }
        }
    }

    /// Turns every output z into gain·z + shift, exactly up to rounding, so that a change of the targets' unit keeps
    /// what was learned (van Hasselt et al. 2016).
    ///
    /// # Panics
    /// Never: a network has at least one layer.
    pub fn rescale_outputs(&mut self, gain: f32, shift: f32) {
        let layer = self.layers.last_mut().expect("a network has a layer");
        let rows = layer.inputs + 1;
        for row in &mut layer.weights {
            row.iter_mut().for_each(|w| *w *= gain);
        }
        for o in 0..layer.outputs {
            layer.weights[o / LANES * rows + layer.inputs][o % LANES] += shift;
        }
    }

    /// One step of Adam on the mean loss of a batch; returns that loss before the step.
    ///
    /// # Formula
    /// loss = 1/samples Σ weight · H(output − target),  H(e) = e²/2 up to the clip, linear beyond
    ///
    /// # Panics
    /// If the lengths do not fit the network.
    pub fn train_batch(&mut self, batch: &Batch<'_>) -> f64 {
        let loss = self.differentiate(batch);
        self.steps = self.steps.saturating_add(1);
        let t = f64::from(self.steps);
        let unbias = (1.0 - num::pow(f64::from(self.adam.beta2), t)).sqrt();
        let first = 1.0 - num::pow(f64::from(self.adam.beta1), t);
        let rate = (f64::from(self.adam.learning_rate) * unbias / first) as f32;
        let epsilon = (1e-8 * unbias) as f32;
        for (layer, gradient) in self.layers.iter_mut().zip(&self.work.gradients) {
            layer.step(gradient, self.adam, [rate, epsilon]);
        }
        loss
    }

    /// Leaves the gradient of the mean loss in the workspace and returns the loss.
    fn differentiate(&mut self, batch: &Batch<'_>) -> f64 {
        let samples = batch.inputs.len() / self.inputs();
        assert_eq!(batch.inputs.len(), samples * self.inputs(), "whole rows of inputs");
        assert_eq!(batch.targets.len(), samples * self.outputs(), "one target per output");
        assert_eq!(batch.weights.len(), samples * self.outputs(), "one weight per target");
        let mut work = std::mem::take(&mut self.work);
        work.fit(&self.layers, samples);
        self.forward_batch(batch.inputs, &mut work.activations);
        let loss = self.output_deltas(batch, &mut work);
        self.backward(batch.inputs, &mut work);
        self.work = work;
        loss
    }

    /// Activations of every layer for every sample.
    fn forward_batch(&self, inputs: &[f32], activations: &mut [Vec<Row>]) {
        let slope = self.activation.slope();
        for (l, layer) in self.layers.iter().enumerate() {
            let (below, here) = activations.split_at_mut(l);
            let (source, stride) = self.source(l, inputs, below);
            kernels::affine_batch(&layer.weights, layer.inputs, source, stride, &mut here[0]);
            if l + 1 < self.layers.len() {
                rectify(here[0].as_flattened_mut(), slope);
            }
        }
    }

    /// What layer `l` takes in, row by row, and the length of a row; `activations` are those of the layers below.
    fn source<'a>(&self, l: usize, inputs: &'a [f32], activations: &'a [Vec<Row>]) -> (&'a [f32], usize) {
        match l.checked_sub(1) {
            None => (inputs, self.layers[0].inputs),
            Some(below) => (activations[below].as_flattened(), self.layers[below].blocks() * LANES),
        }
    }

    /// Deltas of the outputs, and the mean loss.
    fn output_deltas(&self, batch: &Batch<'_>, work: &mut Workspace) -> f64 {
        let (last, outputs) = (self.layers.len() - 1, self.outputs());
        let stride = self.layers[last].blocks() * LANES;
        let samples = batch.targets.len() / outputs;
        let clip = self.adam.error_clip;
        let (values, deltas) = (work.activations[last].as_flattened(), work.deltas[last].as_flattened_mut());
        deltas.fill(0.0);
        let mut loss = 0.0;
        for s in 0..samples {
            for o in 0..outputs {
                let weight = batch.weights[s * outputs + o];
                if weight > 0.0 {
                    let error = values[s * stride + o] - batch.targets[s * outputs + o];
                    let clipped = error.clamp(-clip, clip);
                    deltas[s * stride + o] = weight * clipped / samples as f32;
                    loss += f64::from(weight * clipped * (error - 0.5 * clipped));
                }
            }
        }
        loss / samples as f64
    }

    /// Gradients of all layers, from the deltas of the outputs.
    fn backward(&self, inputs: &[f32], work: &mut Workspace) {
        let slope = self.activation.slope();
        let Workspace { activations, deltas, gradients, transposed } = work;
        for (l, layer) in self.layers.iter().enumerate().rev() {
            let (below, here) = deltas.split_at_mut(l);
            let (source, stride) = self.source(l, inputs, activations);
            kernels::gradient(layer.inputs, (source, stride), &here[0], &mut gradients[l]);
            if let Some(below) = below.last_mut() {
                layer.carry_back(&here[0], &activations[l - 1], slope, (transposed, below));
            }
        }
    }
}

impl Workspace {
    /// Makes all buffers fit.
    fn fit(&mut self, layers: &[Layer], samples: usize) {
        self.activations.resize(layers.len(), Vec::new());
        self.deltas.resize(layers.len(), Vec::new());
        self.gradients.resize(layers.len(), Vec::new());
        for (l, layer) in layers.iter().enumerate() {
            self.activations[l].resize(samples * layer.blocks(), [0.0; LANES]);
            self.deltas[l].resize(samples * layer.blocks(), [0.0; LANES]);
            self.gradients[l].resize(layer.weights.len(), [0.0; LANES]);
        }
    }
}

#[cfg(test)]
mod tests;
