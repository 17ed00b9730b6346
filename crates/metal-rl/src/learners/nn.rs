//! A dense neural network small enough to be read: hidden layers of (leaky) rectifiers, linear outputs, Adam.
//!
//! Numbers are `f32`. Weights lie in blocks of [`LANES`] outputs, so that the inner loop runs over outputs: it needs
//! no horizontal sum, keeps the order of additions of the plain scalar code, and the compiler turns it into vector
//! instructions.

use crate::num;
use crate::random::Rng;
use serde::{Deserialize, Serialize};

/// Outputs that are computed side by side.
pub const LANES: usize = 16;

/// Widest layer whose activations fit on the stack in [`Network::forward`].
const STACK: usize = 256;

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
    weights: Vec<[f32; LANES]>,
    mean_gradient: Vec<[f32; LANES]>,
    mean_square: Vec<[f32; LANES]>,
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
    /// Per layer: samples × padded outputs.
    activations: Vec<Vec<f32>>,
    /// As activations: derivative of the loss with respect to each layer's sums.
    deltas: Vec<Vec<f32>>,
    /// Per layer: as its weights.
    gradients: Vec<Vec<[f32; LANES]>>,
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

    /// Width of a row of outputs, whole blocks.
    fn padded(&self) -> usize {
        self.outputs.div_ceil(LANES) * LANES
    }

    /// out = W input + bias; `out` has the padded width.
    fn affine(&self, input: &[f32], out: &mut [f32]) {
        let (out, _) = out.as_chunks_mut::<LANES>();
        for (block, out) in self.weights.chunks_exact(self.inputs + 1).zip(out) {
            let mut sum = block[self.inputs];
            for (row, &x) in block.iter().zip(&input[..self.inputs]) {
                for lane in 0..LANES {
                    sum[lane] += x * row[lane];
                }
            }
            *out = sum;
        }
    }

    /// Gradient of the loss for all samples: inputs are rows of `stride` numbers, deltas of the padded width.
    fn gradient(&self, inputs: &[f32], stride: usize, deltas: &[f32], out: &mut [[f32; LANES]]) {
        let blocks = self.padded() / LANES;
        let (deltas, _) = deltas.as_chunks::<LANES>();
        for (b, out) in out.chunks_exact_mut(self.inputs + 1).enumerate() {
            for (i, row) in out.iter_mut().enumerate() {
                let mut sum = [0.0; LANES];
                let is_bias = i == self.inputs;
                for (input, delta) in inputs.chunks_exact(stride).zip(deltas.iter().skip(b).step_by(blocks)) {
                    let x = if is_bias { 1.0 } else { input[i] };
                    for lane in 0..LANES {
                        sum[lane] += x * delta[lane];
                    }
                }
                *row = sum;
            }
        }
    }

    /// Carries deltas back to this layer's inputs, given those inputs' activations (rows of `stride`).
    fn carry_back(&self, deltas: &[f32], below: &[f32], slope: f32, out: &mut [f32]) {
        let (rows, blocks) = (self.inputs + 1, self.padded() / LANES);
        let stride = below.len() * blocks * LANES / deltas.len();
        let (deltas, _) = deltas.as_chunks::<LANES>();
        for i in 0..self.inputs {
            for (s, delta) in deltas.chunks_exact(blocks).enumerate() {
                let mut sum = [0.0; LANES];
                for (b, delta) in delta.iter().enumerate() {
                    let row = &self.weights[b * rows + i];
                    for lane in 0..LANES {
                        sum[lane] += row[lane] * delta[lane];
                    }
                }
                let gate = if below[s * stride + i] > 0.0 { 1.0 } else { slope };
                out[s * stride + i] = gate * total(&sum);
            }
        }
    }

    /// One step of Adam; `rate` and `epsilon` already hold the corrections for the start.
    fn step(&mut self, gradient: &[[f32; LANES]], adam: Adam, rate: f32, epsilon: f32) {
        let moments = self.mean_gradient.iter_mut().zip(&mut self.mean_square);
        for ((w, g), (m, v)) in self.weights.iter_mut().zip(gradient).zip(moments) {
            for lane in 0..LANES {
                m[lane] = adam.beta1 * m[lane] + (1.0 - adam.beta1) * g[lane];
                v[lane] = adam.beta2 * v[lane] + (1.0 - adam.beta2) * g[lane] * g[lane];
                w[lane] -= rate * m[lane] / (v[lane].sqrt() + epsilon);
            }
        }
    }

    /// Whether all vectors have the lengths that the shape demands.
    fn is_sound(&self) -> bool {
        let rows = self.outputs.div_ceil(LANES) * (self.inputs + 1);
        [&self.weights, &self.mean_gradient, &self.mean_square].iter().all(|v| v.len() == rows)
    }
}

/// Sum over the lanes, by halves.
fn total(lanes: &[f32; LANES]) -> f32 {
    let mut half: [f32; 8] = std::array::from_fn(|i| lanes[i] + lanes[i + 8]);
    for width in [4, 2, 1] {
        for i in 0..width {
            half[i] += half[i + width];
        }
    }
    half[0]
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
        let widest = self.layers.iter().map(Layer::padded).max().unwrap_or(0);
        if widest <= STACK {
            self.forward_in(input, out, &mut [0.0; STACK], &mut [0.0; STACK]);
        } else {
            self.forward_in(input, out, &mut vec![0.0; widest], &mut vec![0.0; widest]);
        }
    }

    /// Forward pass through two buffers at least as wide as every layer.
    fn forward_in<'a>(
        &self,
        input: &[f32],
        out: &mut [f32],
        mut here: &'a mut [f32],
        mut there: &'a mut [f32],
    ) {
        let (last, hidden) = self.layers.split_last().expect("a network has a layer");
        let slope = self.activation.slope();
        for (l, layer) in hidden.iter().enumerate() {
            let source: &[f32] = if l == 0 { input } else { there };
            layer.affine(source, &mut here[..layer.padded()]);
            rectify(&mut here[..layer.outputs], slope);
            std::mem::swap(&mut here, &mut there);
        }
        last.affine(if hidden.is_empty() { input } else { there }, &mut here[..last.padded()]);
        out.copy_from_slice(&here[..last.outputs]);
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
            layer.step(gradient, self.adam, rate, epsilon);
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
    fn forward_batch(&self, inputs: &[f32], activations: &mut [Vec<f32>]) {
        for (l, layer) in self.layers.iter().enumerate() {
            let (below, here) = activations.split_at_mut(l);
            let (source, stride) = match below.last() {
                None => (inputs, layer.inputs),
                Some(below) => (below.as_slice(), self.layers[l - 1].padded()),
            };
            for (x, y) in source.chunks_exact(stride).zip(here[0].chunks_exact_mut(layer.padded())) {
                layer.affine(x, y);
                if l + 1 < self.layers.len() {
                    rectify(y, self.activation.slope());
                }
            }
        }
    }

    /// Deltas of the outputs, and the mean loss.
    fn output_deltas(&self, batch: &Batch<'_>, work: &mut Workspace) -> f64 {
        let (last, outputs) = (self.layers.len() - 1, self.outputs());
        let stride = self.layers[last].padded();
        let samples = batch.targets.len() / outputs;
        let clip = self.adam.error_clip;
        let mut loss = 0.0;
        for s in 0..samples {
            for o in 0..outputs {
                let weight = batch.weights[s * outputs + o];
                if weight > 0.0 {
                    let error = work.activations[last][s * stride + o] - batch.targets[s * outputs + o];
                    let clipped = error.clamp(-clip, clip);
                    work.deltas[last][s * stride + o] = weight * clipped / samples as f32;
                    loss += f64::from(weight * clipped * (error - 0.5 * clipped));
                }
            }
        }
        loss / samples as f64
    }

    /// Gradients of all layers, from the deltas of the outputs.
    fn backward(&self, inputs: &[f32], work: &mut Workspace) {
        let slope = self.activation.slope();
        for (l, layer) in self.layers.iter().enumerate().rev() {
            let (below, here) = work.deltas.split_at_mut(l);
            let (source, stride) = match l {
                0 => (inputs, layer.inputs),
                _ => (work.activations[l - 1].as_slice(), self.layers[l - 1].padded()),
            };
            layer.gradient(source, stride, &here[0], &mut work.gradients[l]);
            if let Some(below) = below.last_mut() {
                layer.carry_back(&here[0], source, slope, below);
            }
        }
    }
}

impl Workspace {
    /// Makes all buffers fit, with zeros where the backward pass does not write.
    fn fit(&mut self, layers: &[Layer], samples: usize) {
        self.activations.resize(layers.len(), Vec::new());
        self.deltas.resize(layers.len(), Vec::new());
        self.gradients.resize(layers.len(), Vec::new());
        for (l, layer) in layers.iter().enumerate() {
            self.activations[l].resize(samples * layer.padded(), 0.0);
            self.deltas[l].clear();
            self.deltas[l].resize(samples * layer.padded(), 0.0);
            self.gradients[l].resize(layer.weights.len(), [0.0; LANES]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A batch of three samples for a 5-20-18-3 network, with holes in the targets.
    fn example() -> (Network, Vec<f32>, Vec<f32>, Vec<f32>) {
        let mut rng = Rng::new(4);
        let adam = Adam { error_clip: 0.8, ..Adam::default() };
        let net = Network::new(&[5, 20, 18, 3], Activation::LeakyRelu, adam, &mut rng);
        let mut draw = |n: usize| (0..n).map(|_| rng.normal() as f32).collect::<Vec<_>>();
        let (inputs, targets) = (draw(15), draw(9));
        (net, inputs, targets, vec![1.0, 0.0, 0.5, 0.0, 2.0, 1.0, 1.0, 1.0, 0.0])
    }

    #[test]
    #[allow(clippy::needless_range_loop, reason = "the network is changed while its rows are walked")]
    fn the_gradient_is_that_of_finite_differences() {
        let (mut net, inputs, targets, weights) = example();
        let batch = Batch { inputs: &inputs, targets: &targets, weights: &weights };
        net.differentiate(&batch);
        let gradients = net.work.gradients.clone();
        let mut checked = 0;
        for l in 0..net.layers.len() {
            for r in 0..net.layers[l].weights.len() {
                for lane in [0, 1, 2, 9] {
                    let base = net.layers[l].weights[r][lane];
                    let mut loss_at = |w: f32| {
                        net.layers[l].weights[r][lane] = w;
                        net.differentiate(&batch)
                    };
                    let h = 4e-3;
                    let slope = (loss_at(base + h) - loss_at(base - h)) / (2.0 * f64::from(h));
                    loss_at(base);
                    let is = f64::from(gradients[l][r][lane]);
                    assert!((slope - is).abs() < 2e-3, "layer {l} row {r} lane {lane}: {is} not {slope}");
                    checked += usize::from(is.abs() > 1e-3);
                }
            }
        }
        assert!(checked > 50, "only {checked} gradients differ from zero");
    }

    #[test]
    fn wide_and_narrow_networks_compute_the_same_function() {
        let mut rng = Rng::new(1);
        let net = Network::new(&[3, 300, 2], Activation::Relu, Adam::default(), &mut rng);
        let (input, mut out) = ([0.1, 0.7, -0.4], [0.0; 2]);
        net.forward(&input, &mut out);
        let mut layers = vec![vec![0.0; 304], vec![0.0; 16]];
        net.forward_batch(&input, &mut layers);
        assert_eq!(out, layers[1][..2]);
    }

    #[test]
    fn masked_targets_do_not_move_their_outputs_bias() {
        let (mut net, inputs, targets, mut weights) = example();
        weights.iter_mut().skip(1).step_by(3).for_each(|w| *w = 0.0);
        let before = net.layers[2].weights[18];
        net.train_batch(&Batch { inputs: &inputs, targets: &targets, weights: &weights });
        let after = net.layers[2].weights[18];
        assert_eq!(before[1].to_bits(), after[1].to_bits());
        assert!(before[0].to_bits() != after[0].to_bits());
    }

    #[test]
    fn rescaled_outputs_are_rescaled() {
        let (mut net, inputs, ..) = example();
        let (mut before, mut after) = ([0.0; 3], [0.0; 3]);
        net.forward(&inputs[..5], &mut before);
        net.rescale_outputs(0.5, -3.0);
        net.forward(&inputs[..5], &mut after);
        for (b, a) in before.iter().zip(&after) {
            assert!((0.5 * b - 3.0 - a).abs() < 1e-5);
        }
    }

    #[test]
    fn training_fits_a_curve() {
        let mut rng = Rng::new(2);
        let mut net = Network::new(&[1, 32, 32, 1], Activation::LeakyRelu, Adam::default(), &mut rng);
        let mut loss = 1.0;
        for _ in 0..6000 {
            let xs: Vec<f32> = (0..16).map(|_| rng.uniform() as f32).collect();
            let ys: Vec<f32> = xs.iter().map(|&x| num::sin(6.0 * f64::from(x)) as f32).collect();
            loss = 0.99 * loss
                + 0.01 * net.train_batch(&Batch { inputs: &xs, targets: &ys, weights: &[1.0; 16] });
        }
        assert!(loss < 1e-3, "mean loss {loss}");
    }
}
