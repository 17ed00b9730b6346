//! What a student's values are made of: networks, or a mixture of Gaussians.

use crate::counterfactual::config::{CounterfactualConfig, NetworkConfig};
use crate::counterfactual::student::Scale;
use crate::counterfactual::student::gaze::Layout;
use crate::counterfactual::student::mixture::{self, Mixture};
use crate::learners::nn::Network;
use crate::random::Streams;
use serde::{Deserialize, Serialize};

/// Values of moves, looks and moving now, in the unit of advantages; and of states, in theirs.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(in crate::counterfactual) enum Approximator {
    /// Networks over masked readings.
    Networks(Networks),
    /// A mixture that marginalises what was not seen.
    Mixture(Box<Mixture>),
}

/// The networks of a student.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(in crate::counterfactual) struct Networks {
    /// Moves, looks and moving now: their outputs are averaged.
    pub choices: Vec<Network>,
    /// Values of states.
    pub value: Network,
}

/// Working memory.
#[derive(Clone, Debug)]
pub(in crate::counterfactual) struct Recall {
    raw: Vec<f32>,
    squares: Vec<f64>,
    mixture: mixture::Work,
}

impl Recall {
    /// Working memory for so many outputs.
    pub fn new(outputs: usize) -> Self {
        Self { raw: vec![0.0; outputs], squares: vec![0.0; outputs], mixture: mixture::Work::default() }
    }
}

/// Whose values these are: motor actions, and the layout of the input.
#[derive(Clone, Copy)]
pub(in crate::counterfactual) struct Shape<'a> {
    pub actions: usize,
    pub layout: &'a Layout,
    /// Looks that are valued.
    pub looks: usize,
}

impl Shape<'_> {
    /// Moves, looks, and moving now.
    pub fn outputs(self) -> usize {
        self.actions + self.looks + 1
    }

    fn widths(self, config: &NetworkConfig, outputs: usize) -> Vec<usize> {
        let hidden = config.hidden.iter().copied();
        std::iter::once(self.layout.width()).chain(hidden).chain([outputs]).collect()
    }
}

impl Approximator {
    /// What a newborn student has; weights come from `streams`.
    pub fn new(config: &CounterfactualConfig, shape: Shape<'_>, streams: &Streams) -> Self {
        if let Some(mixture) = &config.mixture {
            return Self::Mixture(Box::new(Mixture::new(mixture, shape.actions, shape.layout.slots())));
        }
        let net = &config.network;
        let network = |outputs: usize, streams: &Streams| {
            let mut rng = streams.stream("weights");
            Network::new(&shape.widths(net, outputs), net.activation, net.adam, &mut rng)
        };
        let nth = |i: usize| network(shape.outputs(), &streams.nth(i as u64));
        Self::Networks(Networks {
            choices: (0..net.ensemble).map(nth).collect(),
            value: network(1, &streams.child("value")),
        })
    }

    /// Whether it was thawed whole, for these settings and this shape.
    pub fn fits(&self, config: &CounterfactualConfig, shape: Shape<'_>) -> bool {
        match (self, &config.mixture) {
            (Self::Networks(own), None) => {
                let widths = |outputs| shape.widths(&config.network, outputs);
                own.choices.len() == config.network.ensemble
                    && own.choices.iter().all(|n| n.fits(&widths(shape.outputs())))
                    && own.value.fits(&widths(1))
            }
            (Self::Mixture(own), Some(config)) => own.fits(config, shape.layout, shape.actions),
            _ => false,
        }
    }

    /// How many numbers were learned.
    pub fn weights(&self) -> usize {
        match self {
            Self::Networks(own) => own.choices.iter().chain([&own.value]).map(Network::weights).sum(),
            Self::Mixture(own) => own.numbers(),
        }
    }

    /// Changes units from `old` to `new`; what was learned stays the same.
    pub fn rescale(&mut self, old: Scale, new: Scale) {
        let gain = old.advantage / new.advantage;
        let (value, shift) = (old.value / new.value, (old.centre - new.centre) / new.value);
        match self {
            Self::Networks(own) => {
                own.choices.iter_mut().for_each(|network| network.rescale_outputs(gain as f32, 0.0));
                own.value.rescale_outputs(value as f32, shift as f32);
            }
            Self::Mixture(own) => own.rescale(gain, (value, shift)),
        }
    }

    /// Values for an input, in the unit of advantages. Standard deviations among networks are taken off the first
    /// `moves` and the last one, `caution` times.
    pub fn evaluate(
        &self,
        input: &[f32],
        (moves, caution): (usize, f64),
        values: &mut [f64],
        recall: &mut Recall,
    ) {
        match self {
            Self::Networks(own) => own.evaluate(input, (moves, caution), values, recall),
            Self::Mixture(own) => own.evaluate(input, values, &mut recall.mixture),
        }
    }

    /// The value of the state whose `input` was evaluated last, in its unit.
    pub fn value(&self, input: &[f32], recall: &Recall) -> f64 {
        match self {
            Self::Networks(own) => {
                let mut value = [0.0];
                own.value.forward(input, &mut value);
                f64::from(value[0])
            }
            Self::Mixture(_) => recall.mixture.value,
        }
    }
}

impl Networks {
    fn evaluate(
        &self,
        input: &[f32],
        (moves, caution): (usize, f64),
        values: &mut [f64],
        recall: &mut Recall,
    ) {
        let n = self.choices.len() as f64;
        values.fill(0.0);
        recall.squares.fill(0.0);
        for network in &self.choices {
            network.forward(input, &mut recall.raw);
            for (sum, &z) in values.iter_mut().zip(&recall.raw) {
                *sum += f64::from(z) / n;
            }
            for (sum, &z) in recall.squares.iter_mut().zip(&recall.raw) {
                *sum += f64::from(z) * f64::from(z) / n;
            }
        }
        if caution > 0.0 {
            for output in (0..moves).chain([values.len() - 1]) {
                let (mean, square) = (values[output], recall.squares[output]);
                values[output] -= caution * (square - mean * mean).max(0.0).sqrt();
            }
        }
    }
}
