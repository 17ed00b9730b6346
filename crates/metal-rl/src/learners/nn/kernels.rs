//! The inner loops of a network, compiled once for any processor and once for those with 256-bit vectors.
//!
//! Which of the two runs is decided when the program starts, and makes no difference to a single bit: every sum adds
//! the same terms in the same order, however many of them lie side by side, and nothing is fused.

use multiversion::multiversion;

/// Outputs that are computed side by side.
pub const LANES: usize = 16;

/// Numbers of a layer's outputs (or inputs) that lie side by side.
pub(super) type Row = [f32; LANES];

/// Half a row: the first step of a sum over its lanes.
const HALF: usize = LANES / 2;

/// bias + Σ weight · input for `S` samples and `B` neighbouring blocks at once, so that sums stay in registers.
/// Blocks have a row for each input and then the bias.
#[inline(always)]
fn sums<const S: usize, const B: usize>(blocks: [&[Row]; B], inputs: [&[f32]; S]) -> [[Row; B]; S] {
    let n = inputs[0].len();
    let (blocks, inputs) = (blocks.map(|block| &block[..=n]), inputs.map(|input| &input[..n]));
    let mut sum = [blocks.map(|block| block[n]); S];
    for i in 0..n {
        for b in 0..B {
            let row = blocks[b][i];
            for s in 0..S {
                let x = inputs[s][i];
                for lane in 0..LANES {
                    sum[s][b][lane] += x * row[lane];
                }
            }
        }
    }
    sum
}

/// out = W input + bias for one sample.
#[multiversion(targets("x86_64+avx2"))]
pub(super) fn affine(weights: &[Row], input: &[f32], out: &mut [Row]) {
    const B: usize = 4;
    let rows = input.len() + 1;
    let (fours, rest) = out.as_chunks_mut::<B>();
    let (at_once, alone) = weights.split_at(fours.len() * B * rows);
    for (blocks, out) in at_once.chunks_exact(B * rows).zip(fours) {
        let blocks = std::array::from_fn(|b| &blocks[b * rows..(b + 1) * rows]);
        *out = sums::<1, B>(blocks, [input])[0];
    }
    for (block, out) in alone.chunks_exact(rows).zip(rest) {
        *out = sums::<1, 1>([block], [input])[0][0];
    }
}

/// As [`affine`] for many samples, whose inputs are rows of `stride` numbers of which the first `n` count.
#[multiversion(targets("x86_64+avx2"))]
pub(super) fn affine_batch(weights: &[Row], n: usize, inputs: &[f32], stride: usize, out: &mut [Row]) {
    const S: usize = 4;
    let blocks = weights.len() / (n + 1);
    for (b, block) in weights.chunks_exact(n + 1).enumerate() {
        for (inputs, out) in inputs.chunks(S * stride).zip(out.chunks_mut(S * blocks)) {
            if inputs.len() == S * stride {
                let x = std::array::from_fn(|s| &inputs[s * stride..s * stride + n]);
                for (s, sum) in sums::<S, 1>([block], x).iter().enumerate() {
                    out[s * blocks + b] = sum[0];
                }
            } else {
                for (x, out) in inputs.chunks_exact(stride).zip(out.chunks_exact_mut(blocks)) {
                    out[b] = sums::<1, 1>([block], [&x[..n]])[0][0];
                }
            }
        }
    }
}

/// Σ over samples of input · delta for `I` neighbouring inputs from `i` on; `deltas` yields one row per sample.
#[inline(always)]
fn products<'a, const I: usize>(
    inputs: &[f32],
    stride: usize,
    i: usize,
    deltas: impl Iterator<Item = &'a Row>,
) -> [Row; I] {
    let mut sum = [[0.0; LANES]; I];
    for (input, delta) in inputs.chunks_exact(stride).zip(deltas) {
        let x = &input[i..i + I];
        for k in 0..I {
            for lane in 0..LANES {
                sum[k][lane] += x[k] * delta[lane];
            }
        }
    }
    sum
}

/// Gradient of the loss with respect to a layer's weights: inputs are rows of `stride` numbers of which the first `n`
/// count, deltas one row per sample and block.
#[multiversion(targets("x86_64+avx2"))]
pub(super) fn gradient(n: usize, (inputs, stride): (&[f32], usize), deltas: &[Row], out: &mut [Row]) {
    const I: usize = 4;
    let blocks = out.len() / (n + 1);
    for (b, out) in out.chunks_exact_mut(n + 1).enumerate() {
        let deltas = || deltas.iter().skip(b).step_by(blocks);
        let (fours, rest) = out[..n].as_chunks_mut::<I>();
        let alone = fours.len() * I;
        for (k, out) in fours.iter_mut().enumerate() {
            *out = products::<I>(inputs, stride, k * I, deltas());
        }
        for (k, out) in rest.iter_mut().enumerate() {
            *out = products::<1>(inputs, stride, alone + k, deltas())[0];
        }
        let mut bias = [0.0; LANES];
        for delta in deltas() {
            for lane in 0..LANES {
                bias[lane] += delta[lane];
            }
        }
        out[n] = bias;
    }
}

/// The weights (without bias) with inputs side by side: for every [`LANES`] inputs a row per padded output.
#[multiversion(targets("x86_64+avx2"))]
pub(super) fn transpose(weights: &[Row], n: usize, out: &mut [Row]) {
    let outputs = weights.len() / (n + 1) * LANES;
    for (b, block) in weights.chunks_exact(n + 1).enumerate() {
        for (i, row) in block[..n].iter().enumerate() {
            let out = &mut out[i / LANES * outputs + b * LANES..][..LANES];
            for (out, weight) in out.iter_mut().zip(row) {
                out[i % LANES] = *weight;
            }
        }
    }
}

/// Σ over outputs of weight · delta for [`LANES`] inputs side by side. The order of additions is that of one sum per
/// lane of outputs over the blocks, and of these sums by halves.
#[inline(always)]
fn column_sums(transposed: &[[Row; LANES]], deltas: &[Row]) -> Row {
    let mut half = [[0.0; LANES]; HALF];
    for (k, half) in half.iter_mut().enumerate() {
        let (mut low, mut high) = ([0.0; LANES], [0.0; LANES]);
        for (delta, rows) in deltas.iter().zip(transposed) {
            for lane in 0..LANES {
                low[lane] += rows[k][lane] * delta[k];
            }
            for lane in 0..LANES {
                high[lane] += rows[k + HALF][lane] * delta[k + HALF];
            }
        }
        *half = std::array::from_fn(|lane| low[lane] + high[lane]);
    }
    for width in [4, 2, 1] {
        let (near, far) = half.split_at_mut(width);
        for (near, far) in near.iter_mut().zip(far) {
            for lane in 0..LANES {
                near[lane] += far[lane];
            }
        }
    }
    half[0]
}

/// A layer on the way back.
pub(super) struct Backward<'a> {
    /// Its weights as [`transpose`] leaves them.
    pub transposed: &'a [Row],
    /// Blocks of its outputs.
    pub blocks: usize,
    /// Slope of the layer below for negative sums.
    pub slope: f32,
}

/// Carries deltas back to a layer's inputs, given those inputs' activations (whole rows, as `out`).
#[multiversion(targets("x86_64+avx2"))]
pub(super) fn carry_back(layer: &Backward<'_>, deltas: &[Row], below: &[Row], out: &mut [Row]) {
    let outputs = layer.blocks * LANES;
    let chunks = layer.transposed.len() / outputs;
    let samples = deltas.chunks_exact(layer.blocks).zip(below.chunks_exact(chunks));
    for ((deltas, below), out) in samples.zip(out.chunks_exact_mut(chunks)) {
        let chunks = layer.transposed.chunks_exact(outputs).zip(below);
        for ((transposed, below), out) in chunks.zip(out) {
            let sum = column_sums(transposed.as_chunks().0, deltas);
            for lane in 0..LANES {
                let gate = if below[lane] > 0.0 { 1.0 } else { layer.slope };
                out[lane] = gate * sum[lane];
            }
        }
    }
}

/// The optimiser's memory of a layer, and its numbers for this step.
pub(super) struct Moments<'a> {
    /// Running mean of the gradient.
    pub mean: &'a mut [Row],
    /// Running mean of its square.
    pub square: &'a mut [Row],
    /// Decay of the mean, decay of the square.
    pub betas: [f32; 2],
    /// Step size and least divisor, both with the corrections for the start.
    pub rate: [f32; 2],
}

/// One step of Adam.
#[multiversion(targets("x86_64+avx2"))]
pub(super) fn adam(weights: &mut [Row], gradient: &[Row], moments: Moments<'_>) {
    let ([beta1, beta2], [rate, epsilon]) = (moments.betas, moments.rate);
    let memory = moments.mean.iter_mut().zip(moments.square);
    for ((w, g), (m, v)) in weights.iter_mut().zip(gradient).zip(memory) {
        for lane in 0..LANES {
            m[lane] = beta1 * m[lane] + (1.0 - beta1) * g[lane];
            v[lane] = beta2 * v[lane] + (1.0 - beta2) * g[lane] * g[lane];
            w[lane] -= rate * m[lane] / (v[lane].sqrt() + epsilon);
        }
    }
}
