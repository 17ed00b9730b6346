//! A gated recurrent network (Cho et al. 2014): a state that is carried along and changed by every input, and linear
//! outputs that say what the state foretells.
//!
//! Gates are soft signs instead of logistic functions: as smooth, and exact to the last bit on any machine.

use super::kernels::{self, LANES, Row};
use super::{Adam, Layer};
use crate::num;
use crate::random::Rng;
use serde::{Deserialize, Serialize};

/// Most units of a state; a step's sums lie on the stack.
pub const MOST_UNITS: usize = 128;
/// Rows of the three gates of the largest state.
const STACK: usize = 3 * MOST_UNITS / LANES;
/// How far closed the gate is at birth that lets a state be overwritten: what was seen should be kept for some steps.
const FIRST_UPDATE: f32 = -1.5;

/// The network with its optimiser's memory. For inputs x and the state h:
///
/// # Formula
/// z = σ(Wz x + Uz h), r = σ(Wr x + Ur h), c = s(Wc x + r · Uc h), h ← h + z (c − h), with s(a) = a / (1 + |a|) and
/// σ = (1 + s) / 2; outputs V h
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Recurrent {
    units: usize,
    /// x → gates z, r, c.
    input: Layer,
    /// h → gates z, r, c.
    state: Layer,
    /// h → outputs.
    head: Layer,
    adam: Adam,
    steps: u32,
    #[serde(skip)]
    work: Work,
}

/// Sequences to learn from, side by side; all numbers by time, then by sequence.
#[derive(Clone, Copy, Debug)]
pub struct Sequences<'a> {
    /// How many.
    pub count: usize,
    /// Inputs: times × sequences × inputs. The state is all zeros before the first one.
    pub inputs: &'a [f32],
    /// What the state should foretell just before each input: times × sequences × outputs.
    pub targets: &'a [f32],
    /// Weight of each target, as they lie; 0 where there is none.
    pub weights: &'a [f32],
}

/// Buffers of training; they carry nothing from batch to batch.
#[derive(Clone, Debug, Default)]
struct Work {
    /// States, by time: before each input, and after the last.
    states: Vec<Row>,
    /// Gates z, r, c and Uc h of each sample.
    gates: Vec<Gates>,
    input_sums: Vec<Row>,
    state_sums: Vec<Row>,
    outputs: Vec<Row>,
    input_deltas: Vec<Row>,
    state_deltas: Vec<Row>,
    output_deltas: Vec<Row>,
    /// Derivative of the loss with respect to the states of one time, and to those before.
    carried: Vec<Row>,
    below: Vec<Row>,
    transposed: Vec<Row>,
}

/// The gates of one row of units.
#[derive(Clone, Copy, Debug)]
struct Gates {
    update: Row,
    reset: Row,
    candidate: Row,
    recalled: Row,
}

fn soft_sign(a: f32) -> f32 {
    a / (1.0 + a.abs())
}

/// Slope of [`soft_sign`] where it is `s`.
fn soft_slope(s: f32) -> f32 {
    (1.0 - s.abs()) * (1.0 - s.abs())
}

fn gate(a: f32) -> f32 {
    0.5 + 0.5 * soft_sign(a)
}

/// Slope of [`gate`] where it is `g`.
fn gate_slope(g: f32) -> f32 {
    0.5 * soft_slope(2.0 * g - 1.0)
}

/// The gates of block `u` of `width` from the sums of input and state.
fn gates(input: &[Row], state: &[Row], (u, width): (usize, usize)) -> Gates {
    let lanes = |f: &dyn Fn(usize) -> f32| -> Row { std::array::from_fn(f) };
    let update = lanes(&|l| gate(input[u][l] + state[u][l]));
    let reset = lanes(&|l| gate(input[width + u][l] + state[width + u][l]));
    let recalled = state[2 * width + u];
    let candidate = lanes(&|l| soft_sign(input[2 * width + u][l] + reset[l] * recalled[l]));
    Gates { update, reset, candidate, recalled }
}

impl Gates {
    /// The state after an input.
    fn turn(&self, state: &[f32], out: &mut [f32]) {
        for lane in 0..LANES {
            out[lane] = state[lane] + self.update[lane] * (self.candidate[lane] - state[lane]);
        }
    }
}

impl Recurrent {
    /// A network with a state of `units`, a multiple of [`LANES`] up to [`MOST_UNITS`].
    ///
    /// # Panics
    /// If `units` is anything else, or there are no inputs or outputs.
    #[must_use]
    pub fn new((inputs, units, outputs): (usize, usize, usize), adam: Adam, rng: &mut Rng) -> Self {
        assert!(units > 0 && units.is_multiple_of(LANES) && units <= MOST_UNITS, "{units} units");
        assert!(inputs > 0 && outputs > 0, "{inputs} inputs, {outputs} outputs");
        let sd = |n: usize| (1.0 / n as f64).sqrt();
        let mut input = Layer::new(inputs, 3 * units, sd(inputs), rng);
        for block in input.weights.chunks_exact_mut(inputs + 1).take(units / LANES) {
            block[inputs] = [FIRST_UPDATE; LANES];
        }
        let state = Layer::new(units, 3 * units, sd(units), rng);
        let head = Layer::new(units, outputs, 0.1 * sd(units), rng);
        Self { units, input, state, head, adam, steps: 0, work: Work::default() }
    }

    /// Units of the state.
    #[must_use]
    pub fn units(&self) -> usize {
        self.units
    }

    /// Number of weights, biases included.
    #[must_use]
    pub fn weights(&self) -> usize {
        [&self.input, &self.state, &self.head].iter().map(|l| (l.inputs + 1) * l.outputs).sum()
    }

    /// Whether a thawed network has this shape.
    #[must_use]
    pub(crate) fn fits(&self, (inputs, units, outputs): (usize, usize, usize)) -> bool {
        let shapes =
            [(&self.input, inputs, 3 * units), (&self.state, units, 3 * units), (&self.head, units, outputs)];
        self.units == units
            && shapes.iter().all(|(l, n, m)| (l.inputs, l.outputs) == (*n, *m) && l.is_sound())
    }

    /// Changes the step size of the optimiser.
    pub fn set_learning_rate(&mut self, rate: f32) {
        self.adam.learning_rate = rate;
    }

    /// The state after `input`, in place. Nothing is allocated.
    ///
    /// # Panics
    /// If the lengths are not those of the network.
    pub fn step(&self, input: &[f32], state: &mut [f32]) {
        assert_eq!((input.len(), state.len()), (self.input.inputs, self.units), "shape of the network");
        let (mut sums, mut recalled) = ([[0.0; LANES]; STACK], [[0.0; LANES]; STACK]);
        let (blocks, width) = (self.input.blocks(), self.units / LANES);
        kernels::affine(&self.input.weights, input, &mut sums[..blocks]);
        kernels::affine(&self.state.weights, state, &mut recalled[..blocks]);
        for (u, state) in state.chunks_exact_mut(LANES).enumerate() {
            let old: Row = std::array::from_fn(|lane| state[lane]);
            gates(&sums, &recalled, (u, width)).turn(&old, state);
        }
    }

    /// What `state` foretells.
    ///
    /// # Panics
    /// If the lengths are not those of the network.
    pub fn foretell(&self, state: &[f32], out: &mut [f32]) {
        let mut sums = vec![[0.0; LANES]; self.head.blocks()];
        kernels::affine(&self.head.weights, state, &mut sums);
        out.copy_from_slice(&sums.as_flattened()[..self.head.outputs]);
    }

    /// One step of Adam on the mean loss of some sequences, differentiated through all their times; returns that loss
    /// before the step.
    ///
    /// # Formula
    /// loss = 1/Σ weight · Σ weight · H(output − target), H as in [`super::Network::train_batch`]
    ///
    /// # Panics
    /// If the lengths do not fit the network.
    pub fn train(&mut self, batch: &Sequences<'_>) -> f64 {
        let mut work = std::mem::take(&mut self.work);
        let samples = batch.inputs.len() / self.input.inputs;
        assert_eq!(batch.inputs.len(), samples * self.input.inputs, "whole rows of inputs");
        assert_eq!(batch.targets.len(), samples * self.head.outputs, "one target per output");
        assert_eq!(batch.weights.len(), batch.targets.len(), "one weight per target");
        assert!(batch.count > 0 && samples.is_multiple_of(batch.count), "sequences of one length");
        work.fit(self, samples, batch.count);
        self.forward(batch, &mut work);
        let loss = self.differ(batch, &mut work);
        self.backward(batch, &mut work);
        self.update(batch, &work, samples);
        self.work = work;
        loss
    }

    fn forward(&self, batch: &Sequences<'_>, work: &mut Work) {
        let (n, width, blocks) = (self.input.inputs, self.units / LANES, self.input.blocks());
        work.states[..batch.count * width].fill([0.0; LANES]);
        kernels::affine_batch(&self.input.weights, n, batch.inputs, n, &mut work.input_sums);
        let times = work.input_sums.chunks_exact(batch.count * blocks).enumerate();
        for (t, input) in times {
            let (before, after) = work.states.split_at_mut((t + 1) * batch.count * width);
            let before = &before[t * batch.count * width..];
            let recalled = &mut work.state_sums[..batch.count * blocks];
            kernels::affine_batch(
                &self.state.weights,
                self.units,
                before.as_flattened(),
                self.units,
                recalled,
            );
            for s in 0..batch.count {
                let place = s * blocks..(s + 1) * blocks;
                let (input, recalled) = (&input[place.clone()], &recalled[place]);
                for u in 0..width {
                    let here = s * width + u;
                    let gates = gates(input, recalled, (u, width));
                    gates.turn(&before[here], &mut after[here]);
                    work.gates[t * batch.count * width + here] = gates;
                }
            }
        }
        let rows = samples(batch, n) * self.units;
        let states = &work.states.as_flattened()[..rows];
        kernels::affine_batch(&self.head.weights, self.units, states, self.units, &mut work.outputs);
    }

    /// Deltas of the outputs, and the mean loss.
    fn differ(&self, batch: &Sequences<'_>, work: &mut Work) -> f64 {
        let (outputs, stride) = (self.head.outputs, self.head.blocks() * LANES);
        let total = batch.weights.iter().map(|&w| f64::from(w)).sum::<f64>().max(1e-9);
        let (values, deltas) = (work.outputs.as_flattened(), work.output_deltas.as_flattened_mut());
        let clip = self.adam.error_clip;
        deltas.fill(0.0);
        let mut loss = 0.0;
        for (s, (targets, weights)) in
            batch.targets.chunks_exact(outputs).zip(batch.weights.chunks_exact(outputs)).enumerate()
        {
            for (o, (target, &weight)) in targets.iter().zip(weights).enumerate() {
                let error = if weight > 0.0 { values[s * stride + o] - target } else { 0.0 };
                let clipped = error.clamp(-clip, clip);
                deltas[s * stride + o] = weight * clipped / total as f32;
                loss += f64::from(weight * clipped * (error - 0.5 * clipped));
            }
        }
        loss / total
    }

    /// Deltas of all gates, from the last time to the first.
    fn backward(&self, batch: &Sequences<'_>, work: &mut Work) {
        let (width, blocks) = (self.units / LANES, self.input.blocks());
        let (rows, head_rows) = (batch.count * width, batch.count * self.head.blocks());
        let times = samples(batch, self.input.inputs) / batch.count;
        work.carried.fill([0.0; LANES]);
        for t in (0..times).rev() {
            let place = t * rows..(t + 1) * rows;
            let gate_rows = t * batch.count * blocks..(t + 1) * batch.count * blocks;
            let input = &mut work.input_deltas[gate_rows.clone()];
            let state = &mut work.state_deltas[gate_rows];
            let (gates, states) = (&work.gates[place.clone()], &work.states[place]);
            for s in 0..batch.count {
                for u in 0..width {
                    let here = s * width + u;
                    let deltas = Deltas::of(&gates[here], &states[here], &work.carried[here]);
                    deltas.write(s * blocks + u, width, (input, state));
                    work.carried[here] = deltas.kept;
                }
            }
            self.state.carry_back(state, states, 1.0, (&mut work.transposed, &mut work.below));
            add(&mut work.carried, &work.below);
            let outputs = &work.output_deltas[t * head_rows..(t + 1) * head_rows];
            self.head.carry_back(outputs, states, 1.0, (&mut work.transposed, &mut work.below));
            add(&mut work.carried, &work.below);
        }
    }

    fn update(&mut self, batch: &Sequences<'_>, work: &Work, samples: usize) {
        self.steps = self.steps.saturating_add(1);
        let t = f64::from(self.steps);
        let unbias = (1.0 - num::pow(f64::from(self.adam.beta2), t)).sqrt();
        let first = 1.0 - num::pow(f64::from(self.adam.beta1), t);
        let rate = [(f64::from(self.adam.learning_rate) * unbias / first) as f32, (1e-8 * unbias) as f32];
        let (n, units, adam) = (self.input.inputs, self.units, self.adam);
        let states = &work.states.as_flattened()[..samples * units];
        let learn = |layer: &mut Layer, inputs: (&[f32], usize), deltas: &[Row]| {
            let mut gradient = vec![[0.0; LANES]; layer.weights.len()];
            kernels::gradient(layer.inputs, inputs, deltas, &mut gradient);
            layer.step(&gradient, adam, rate);
        };
        learn(&mut self.input, (batch.inputs, n), &work.input_deltas);
        learn(&mut self.state, (states, units), &work.state_deltas);
        learn(&mut self.head, (states, units), &work.output_deltas);
    }
}

fn samples(batch: &Sequences<'_>, inputs: usize) -> usize {
    batch.inputs.len() / inputs
}

fn add(to: &mut [Row], what: &[Row]) {
    for (to, what) in to.iter_mut().zip(what) {
        for lane in 0..LANES {
            to[lane] += what[lane];
        }
    }
}

/// Derivatives of the loss with respect to the sums behind one row of gates, and to the state that was kept.
struct Deltas {
    update: Row,
    reset: Row,
    candidate: Row,
    recalled: Row,
    kept: Row,
}

impl Deltas {
    /// From the derivative `carried` with respect to the state after.
    fn of(g: &Gates, state: &Row, carried: &Row) -> Self {
        let lanes = |f: &dyn Fn(usize) -> f32| -> Row { std::array::from_fn(f) };
        let update = lanes(&|l| carried[l] * (g.candidate[l] - state[l]) * gate_slope(g.update[l]));
        let candidate = lanes(&|l| carried[l] * g.update[l] * soft_slope(g.candidate[l]));
        let reset = lanes(&|l| candidate[l] * g.recalled[l] * gate_slope(g.reset[l]));
        let recalled = lanes(&|l| candidate[l] * g.reset[l]);
        let kept = lanes(&|l| carried[l] * (1.0 - g.update[l]));
        Self { update, reset, candidate, recalled, kept }
    }

    fn write(&self, at: usize, width: usize, (input, state): (&mut [Row], &mut [Row])) {
        let first = [self.update, self.reset];
        for (k, row) in first.into_iter().enumerate() {
            input[at + k * width] = row;
            state[at + k * width] = row;
        }
        input[at + 2 * width] = self.candidate;
        state[at + 2 * width] = self.recalled;
    }
}

impl Work {
    /// Makes all buffers fit.
    fn fit(&mut self, network: &Recurrent, samples: usize, count: usize) {
        let (width, blocks, head) = (network.units / LANES, network.input.blocks(), network.head.blocks());
        let zeros = [0.0; LANES];
        self.states.resize((samples + count) * width, zeros);
        let shut = Gates { update: zeros, reset: zeros, candidate: zeros, recalled: zeros };
        self.gates.resize(samples * width, shut);
        self.state_sums.resize(count * blocks, zeros);
        for rows in [&mut self.input_sums, &mut self.input_deltas, &mut self.state_deltas] {
            rows.resize(samples * blocks, zeros);
        }
        for rows in [&mut self.outputs, &mut self.output_deltas] {
            rows.resize(samples * head, zeros);
        }
        for rows in [&mut self.carried, &mut self.below] {
            rows.resize(count * width, zeros);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Streams;

    fn network(adam: Adam) -> Recurrent {
        Recurrent::new((3, 16, 2), adam, &mut Streams::new(5).stream("weights"))
    }

    /// Four times, two sequences, and a target wherever the weight is not 0.
    fn numbers(n: usize, salt: u64) -> Vec<f32> {
        let mut rng = Streams::new(salt).stream("numbers");
        (0..n).map(|_| rng.normal() as f32).collect()
    }

    /// The loss by steps of the state one by one.
    fn loss_of(network: &Recurrent, batch: &Sequences<'_>) -> f64 {
        let (mut loss, mut weight) = (0.0, 0.0);
        for s in 0..batch.count {
            let mut state = vec![0.0; 16];
            for t in 0..batch.inputs.len() / 3 / batch.count {
                let row = t * batch.count + s;
                let mut out = [0.0; 2];
                network.foretell(&state, &mut out);
                let told = batch.targets[row * 2..].iter().zip(&batch.weights[row * 2..]);
                for (out, (target, w)) in out.iter().zip(told) {
                    let error = out - target;
                    loss += f64::from(w * 0.5 * error * error);
                    weight += f64::from(*w);
                }
                network.step(&batch.inputs[row * 3..row * 3 + 3], &mut state);
            }
        }
        loss / weight
    }

    #[test]
    fn gradients_are_those_of_the_loss_by_differences() {
        let (inputs, targets) = (numbers(24, 1), numbers(16, 2));
        let mut weights = vec![1.0; 16];
        weights[5] = 0.0;
        let batch = Sequences { count: 2, inputs: &inputs, targets: &targets, weights: &weights };
        let mut network = network(Adam { error_clip: 1e6, ..Adam::default() });
        let mut work = Work::default();
        work.fit(&network, 8, 2);
        network.forward(&batch, &mut work);
        let loss = network.differ(&batch, &mut work);
        assert!((loss - loss_of(&network, &batch)).abs() < 1e-6);
        network.backward(&batch, &mut work);
        let states = work.states.as_flattened()[..8 * 16].to_vec();
        type Pick = fn(&mut Recurrent) -> &mut Layer;
        let layers: [(Pick, &[f32], usize, &[Row]); 3] = [
            (|n| &mut n.input, &inputs, 3, &work.input_deltas),
            (|n| &mut n.state, &states, 16, &work.state_deltas),
            (|n| &mut n.head, &states, 16, &work.output_deltas),
        ];
        for (l, (pick, below, n, deltas)) in layers.into_iter().enumerate() {
            let mut gradient = vec![[0.0; LANES]; pick(&mut network).weights.len()];
            kernels::gradient(n, (below, n), deltas, &mut gradient);
            for (row, lane) in [(0, 0), (1, 1), (n, 0), (n, 1)] {
                let mut at = |by: f32| {
                    pick(&mut network).weights[row][lane] += by;
                    let loss = loss_of(&network, &batch);
                    pick(&mut network).weights[row][lane] -= by;
                    loss
                };
                let difference = (at(1e-2) - at(-1e-2)) / 2e-2;
                let slope = f64::from(gradient[row][lane]);
                assert!(
                    (difference - slope).abs() < 2e-4 + 0.02 * slope.abs(),
                    "layer {l}: {difference} {slope}"
                );
            }
        }
    }

    /// The first input has to be remembered for five steps in which other things are seen.
    #[test]
    fn what_was_seen_is_kept() {
        let mut network = network(Adam { learning_rate: 5e-3, ..Adam::default() });
        let mut rng = Streams::new(9).stream("lessons");
        let (count, times) = (16, 6);
        let mut losses = Vec::new();
        for _ in 0..1500 {
            let mut inputs: Vec<f32> = (0..count * times * 3).map(|_| 0.3 * rng.normal() as f32).collect();
            let (mut targets, mut weights) = (vec![0.0; count * times * 2], vec![0.0; count * times * 2]);
            for s in 0..count {
                let told = if rng.chance(0.5) { 1.0 } else { -1.0 };
                inputs[s * 3] = told;
                let last = ((times - 1) * count + s) * 2;
                (targets[last], weights[last]) = (told, 1.0);
            }
            losses.push(network.train(&Sequences {
                count,
                inputs: &inputs,
                targets: &targets,
                weights: &weights,
            }));
        }
        let mean = |losses: &[f64]| losses.iter().sum::<f64>() / losses.len() as f64;
        assert!(mean(&losses[..20]) > 0.4, "a guess is off by half: {}", mean(&losses[..20]));
        assert!(mean(&losses[1400..]) < 0.05, "{}", mean(&losses[1400..]));
    }
}
