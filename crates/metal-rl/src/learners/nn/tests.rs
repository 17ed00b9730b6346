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
    let mut layers = vec![vec![[0.0; LANES]; 19], vec![[0.0; LANES]]];
    net.forward_batch(&input, &mut layers);
    assert_eq!(out, layers[1][0][..2]);
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
        loss =
            0.99 * loss + 0.01 * net.train_batch(&Batch { inputs: &xs, targets: &ys, weights: &[1.0; 16] });
    }
    assert!(loss < 1e-3, "mean loss {loss}");
}

/// Deltas of the layer below by plain loops in the documented order: a sum per lane over blocks, then by halves.
fn carried_back(layer: &Layer, deltas: &[Row], i: usize) -> f32 {
    let mut lanes = [0.0; LANES];
    for (b, delta) in deltas.iter().enumerate() {
        for lane in 0..LANES {
            lanes[lane] += layer.weights[b * (layer.inputs + 1) + i][lane] * delta[lane];
        }
    }
    let mut half: Vec<f32> = (0..LANES / 2).map(|k| lanes[k] + lanes[k + LANES / 2]).collect();
    while half.len() > 1 {
        half = (0..half.len() / 2).map(|k| half[k] + half[k + half.len() / 2]).collect();
    }
    half[0]
}

#[test]
fn side_by_side_means_the_same_bits_as_one_after_the_other() {
    let mut rng = Rng::new(9);
    let widths = [7, 70, 33, 3];
    let mut net = Network::new(&widths, Activation::LeakyRelu, Adam::default(), &mut rng);
    let samples = 6;
    let inputs: Vec<f32> = (0..samples * 7).map(|_| rng.normal() as f32).collect();
    let targets: Vec<f32> = (0..samples * 3).map(|_| rng.normal() as f32).collect();
    net.differentiate(&Batch { inputs: &inputs, targets: &targets, weights: &[1.0; 18] });
    let work = &net.work;
    for (l, layer) in net.layers.iter().enumerate() {
        let (source, stride) = net.source(l, &inputs, &work.activations);
        let blocks = layer.blocks();
        for o in 0..layer.outputs {
            let weight = |i: usize| layer.weights[o / LANES * (layer.inputs + 1) + i][o % LANES];
            for s in 0..samples {
                let x = &source[s * stride..][..layer.inputs];
                let sum = x.iter().enumerate().fold(weight(layer.inputs), |sum, (i, x)| sum + x * weight(i));
                let hidden = l < 2 && sum <= 0.0;
                let should = if hidden { 0.01 * sum } else { sum };
                assert_eq!(
                    work.activations[l][s * blocks + o / LANES][o % LANES].to_bits(),
                    should.to_bits()
                );
            }
            for i in 0..=layer.inputs {
                let terms = (0..samples).map(|s| {
                    let x = if i == layer.inputs { 1.0 } else { source[s * stride + i] };
                    x * work.deltas[l][s * blocks + o / LANES][o % LANES]
                });
                let should = terms.fold(0.0, |sum, term| sum + term);
                let is = work.gradients[l][o / LANES * (layer.inputs + 1) + i][o % LANES];
                assert_eq!(is.to_bits(), should.to_bits(), "gradient of layer {l}");
            }
        }
        for (s, i) in (0..samples).flat_map(|s| (0..layer.inputs).map(move |i| (s, i))).filter(|_| l > 0) {
            let gate = if source[s * stride + i] > 0.0 { 1.0 } else { 0.01 };
            let should = gate * carried_back(layer, &work.deltas[l][s * blocks..][..blocks], i);
            let below = net.layers[l - 1].blocks();
            let is = work.deltas[l - 1][s * below + i / LANES][i % LANES];
            assert_eq!(is.to_bits(), should.to_bits(), "delta below layer {l}");
        }
    }
}
