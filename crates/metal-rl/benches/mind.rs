//! What a mind does between two motor actions, and what it learns from one.

use metal_rl::decision::{Content, DecisionDims, DecisionState, Encoding};
use metal_rl::explore::Exploration;
use metal_rl::learner::{Dims, Learner, LearnerError, Rate, Sample};
use metal_rl::learners::absp::{Covariance, MixtureConfig};
use metal_rl::learners::{AbspConfig, LearnerConfig, MlpConfig};
use metal_rl::policies::Attention;
use metal_rl::policies::attention::{AttentionConfig, Consultable, learner_dims};
use metal_rl::policy::{Choice, Policy, Situation};
use metal_rl::random::Rng;
use std::error::Error;
use std::hint::black_box;

const ACTIONS: usize = 5;
const COMPONENTS: usize = 100;
const ROUND: usize = 200;

/// Random states, row by row.
fn states(inputs: usize, rng: &mut Rng) -> Vec<f64> {
    (0..ROUND * inputs).map(|_| rng.uniform()).collect()
}

/// A random target: what is learned from and what is learned while the clock runs.
fn target(rng: &mut Rng) -> f64 {
    -10.0 * rng.uniform()
}

/// A learner that has learned `samples` random samples.
fn learned(config: &LearnerConfig, dims: Dims, samples: usize) -> Result<Box<dyn Learner>, LearnerError> {
    let (mut learner, mut rng) = (config.build(dims, 1)?, Rng::new(2));
    for _ in 0..samples {
        let state: Vec<f64> = (0..dims.inputs).map(|_| rng.uniform()).collect();
        let (choice, target) = (rng.below(dims.choices), target(&mut rng));
        learner.learn(Sample { state: &state, choice, target, demonstrated: false }, Rate::Constant(0.1));
    }
    Ok(learner)
}

/// Values and supports, and learning, of one learner.
fn measure(group: &str, name: &str, mut learner: Box<dyn Learner>) -> Result<(), Box<dyn Error>> {
    let dims = learner.dims();
    let states = states(dims.inputs, &mut Rng::new(3));
    let (mut values, mut support) = (vec![0.0; dims.choices], vec![0.0; dims.choices]);
    let ask = || {
        for state in states.chunks_exact(dims.inputs) {
            learner.values_and_support(black_box(state), &mut values, &mut support);
        }
    };
    xtask::measure((group, &format!("{name}: Q and support")), (ROUND, "state"), ask)?;
    let mut rng = Rng::new(5);
    let targets: Vec<f64> = (0..ROUND).map(|_| target(&mut rng)).collect();
    let learn = || {
        for ((k, state), &target) in states.chunks_exact(dims.inputs).enumerate().zip(&targets) {
            let sample = Sample { state, choice: k % dims.choices, target, demonstrated: false };
            black_box(learner.learn(sample, Rate::Constant(0.1)));
        }
    };
    xtask::measure((group, &format!("{name}: learning")), (ROUND, "sample"), learn)?;
    Ok(())
}

/// Gaussians with many components: narrow enough that random states fill the cap.
fn absp(covariance: Covariance) -> LearnerConfig {
    let mixture =
        MixtureConfig { covariance, first_width: 0.05, cap: COMPONENTS, ..MixtureConfig::default() };
    LearnerConfig::Absp(AbspConfig { mixture, ..AbspConfig::default() })
}

/// A whole decision of attention control: two consultations of four inputs each, then a move.
fn decision() -> Result<(), Box<dyn Error>> {
    let mlp = LearnerConfig::Mlp(MlpConfig::default());
    let dims = DecisionDims { member_inputs: vec![4, 4, 4, 4, 4, 4, 8], actions: ACTIONS };
    let members: Vec<usize> = (0..7).collect();
    let encoding = Encoding { content: Content::Readings, ..Encoding::default() };
    let config = AttentionConfig { encoding, min_looks: 2, max_looks: 2, ..AttentionConfig::default() };
    let learner = mlp.build(learner_dims(&config, &dims, &members), 1)?;
    let mut attention = Attention::new(config, learner, &dims, Consultable { members, prices: vec![1.0; 7] });
    let agents: Result<Vec<_>, _> =
        dims.member_inputs.iter().map(|&inputs| mlp.build(Dims { inputs, choices: ACTIONS }, 2)).collect();
    let (agents, mut state, mut rng) = (agents?, DecisionState::new(&dims), Rng::new(4));
    let decide = || {
        for _ in 0..ROUND {
            state.clear();
            loop {
                let exploration = Exploration::Greedy;
                let situation = Situation { state: &state, advice: None, exploration, progress: 1.0 };
                match attention.choose(&situation, &mut rng) {
                    Choice::Move(action) => {
                        black_box(action);
                        break;
                    }
                    Choice::Consult(m) => {
                        let (reading, values, support) = state.attend(m);
                        reading.fill(0.3);
                        agents[m].values_and_support(reading, values, support);
                    }
                }
            }
        }
    };
    xtask::measure(("attention", "two looks, then a move"), (ROUND, "decision"), decide)?;
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let dims = |inputs: usize| Dims { inputs, choices: ACTIONS };
    let mlp = LearnerConfig::Mlp(MlpConfig::default());
    measure("mlp", "mlp 24-64-64-5", learned(&mlp, dims(24), 500)?)?;
    measure("mlp", "mlp 4-64-64-5", learned(&mlp, dims(4), 500)?)?;
    for (name, covariance, inputs) in [
        ("absp, 4 dimensions, full", Covariance::Full, 4),
        ("absp, 4 dimensions, diagonal", Covariance::Diagonal, 4),
        ("absp, 24 dimensions, diagonal", Covariance::Diagonal, 24),
    ] {
        let learner = learned(&absp(covariance), dims(inputs), 6000)?;
        let name = format!("{name}, {} components in all", learner.size().0);
        measure("absp", &name, learner)?;
    }
    decision()
}
