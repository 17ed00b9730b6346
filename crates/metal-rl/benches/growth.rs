//! How the time of one answer grows with components, features and sensors.

use metal_rl::decision::{Content, DecisionDims, DecisionState, Encoding};
use metal_rl::explore::Exploration;
use metal_rl::learner::{Dims, Learner, LearnerError, Rate, Sample};
use metal_rl::learners::absp::{Covariance, MixtureConfig};
use metal_rl::learners::{AbspConfig, LearnerConfig, MlpConfig};
use metal_rl::policies::Attention;
use metal_rl::policies::attention::{AttentionConfig, Consultable, learner_dims};
use metal_rl::policy::{Policy, Situation};
use metal_rl::random::Rng;
use std::error::Error;
use std::hint::black_box;

const ACTIONS: usize = 5;
const ROUND: usize = 100;

/// Gaussians that have filled `cap`, `inputs` wide.
fn gaussians(covariance: Covariance, cap: usize, inputs: usize) -> Result<Box<dyn Learner>, LearnerError> {
    let mixture = MixtureConfig { covariance, first_width: 0.03, cap, ..MixtureConfig::default() };
    let config = LearnerConfig::Absp(AbspConfig { mixture, ..AbspConfig::default() });
    let mut learner = config.build(Dims { inputs, choices: ACTIONS }, 1)?;
    let mut rng = Rng::new(2);
    for k in 0..cap * ACTIONS * 4 {
        let state: Vec<f64> = (0..inputs).map(|_| rng.uniform()).collect();
        let sample = Sample { state: &state, choice: k % ACTIONS, target: -1.0, demonstrated: false };
        learner.learn(sample, Rate::Constant(0.1));
    }
    Ok(learner)
}

/// Values and supports of one learner, whose components or features grow.
fn ask(group: &str, learner: &dyn Learner) -> std::io::Result<()> {
    let (dims, mut rng) = (learner.dims(), Rng::new(3));
    let states: Vec<f64> = (0..ROUND * dims.inputs).map(|_| rng.uniform()).collect();
    let (mut values, mut support) = (vec![0.0; dims.choices], vec![0.0; dims.choices]);
    let (size, of) = learner.size();
    let name = format!("{} features, {size} {of}", dims.inputs);
    let amount = if group == "components" { size } else { dims.inputs };
    xtask::measure_growth((group, &name, amount as f64), (ROUND, "state"), || {
        for state in states.chunks_exact(dims.inputs) {
            learner.values_and_support(black_box(state), &mut values, &mut support);
        }
    })
}

/// The first choice of an attention control that may ask so many sensors.
fn first_choice(sensors: usize) -> Result<(), Box<dyn Error>> {
    let dims = DecisionDims { member_inputs: vec![4; sensors], actions: ACTIONS };
    let members: Vec<usize> = (0..sensors).collect();
    let encoding = Encoding { content: Content::Readings, ..Encoding::default() };
    let config = AttentionConfig { encoding, min_looks: 2, max_looks: 2, ..AttentionConfig::default() };
    let learner =
        LearnerConfig::Mlp(MlpConfig::default()).build(learner_dims(&config, &dims, &members), 1)?;
    let consultable = Consultable { members, prices: vec![1.0; sensors] };
    let mut attention = Attention::new(config, learner, &dims, consultable);
    let (state, mut rng) = (DecisionState::new(&dims), Rng::new(4));
    let row = ("sensors", &*format!("{sensors} sensors"), sensors as f64);
    xtask::measure_growth(row, (ROUND, "choice"), || {
        for _ in 0..ROUND {
            let situation =
                Situation { state: &state, advice: None, exploration: Exploration::Greedy, progress: 1.0 };
            black_box(attention.choose(&situation, &mut rng));
        }
    })?;
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    for cap in [25, 50, 100, 200, 400] {
        ask("components", &*gaussians(Covariance::Diagonal, cap, 4)?)?;
    }
    for inputs in [4, 8, 16, 32, 64] {
        ask("features, diagonal", &*gaussians(Covariance::Diagonal, 100, inputs)?)?;
    }
    for inputs in [4, 8, 16, 32] {
        ask("features, full", &*gaussians(Covariance::Full, 100, inputs)?)?;
    }
    [7, 14, 28, 64].into_iter().try_for_each(first_choice)
}
