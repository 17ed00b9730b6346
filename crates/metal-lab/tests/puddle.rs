//! Every learner crosses puddle world by one-step Q-learning: the regression test of the learners themselves.
//!
//! Return is the undiscounted sum of rewards, greedy, from a 6 × 6 grid of starts; walking at random earns about −700,
//! walking straight to the goal through the puddles about −50, an oracle about −25.
#![allow(clippy::unwrap_used)]

use metal_rl::environment::{End, Environment};
use metal_rl::learner::{Dims, Learner, Rate, Sample};
use metal_rl::learners::{
    AbspConfig, BayesMixConfig, IgmnConfig, LearnerConfig, MlpConfig, TileConfig, nn::Adam,
};
use metal_rl::num;
use metal_rl::random::{Rng, Streams};
use metal_worlds::puddle::{Puddle, PuddleConfig};

const GAMMA: f64 = 0.99;
const EPSILON: f64 = 0.1;

/// The learners, with the rate and number of episodes that suit them.
fn learners() -> Vec<(LearnerConfig, Rate, usize)> {
    let half = Rate::Constant(0.5);
    let mlp = MlpConfig {
        capacity: 4000,
        batch: 32,
        adam: Adam { learning_rate: 2e-3, ..Adam::default() },
        ..MlpConfig::default()
    };
    vec![
        (LearnerConfig::Absp(AbspConfig::default()), half, 500),
        (LearnerConfig::BayesMix(BayesMixConfig::default()), half, 500),
        (LearnerConfig::Igmn(IgmnConfig::default()), half, 500),
        (LearnerConfig::Tile(TileConfig::default()), half, 500),
        (LearnerConfig::Mlp(mlp), half, 300),
    ]
}

/// The best action, or any one with probability `epsilon`.
fn choose(learner: &dyn Learner, state: &[f64], epsilon: f64, rng: &mut Rng) -> usize {
    if rng.chance(epsilon) {
        return rng.below(4);
    }
    let mut values = [0.0; 4];
    learner.values(state, &mut values);
    num::argmax(&values)
}

/// One episode of Q-learning from a random start.
fn practise(learner: &mut dyn Learner, world: &mut Puddle, rate: Rate, rng: &mut Rng) {
    world.reset(rng.bits()).unwrap();
    let (mut state, mut next) = ([0.0; 2], [0.0; 2]);
    world.sense(0, &mut state).unwrap();
    loop {
        let choice = choose(learner, &state, EPSILON, rng);
        let outcome = world.step(choice).unwrap();
        world.sense(0, &mut next).unwrap();
        let mut values = [0.0; 4];
        learner.values(&next, &mut values);
        let future = if outcome.end == End::Terminal { 0.0 } else { GAMMA * num::max(&values) };
        let target = outcome.motor_reward + future;
        learner.learn(Sample { state: &state, choice, target, demonstrated: false }, rate);
        state = next;
        if outcome.end != End::Running {
            return;
        }
    }
}

/// Mean return over a grid of starts.
fn examine(learner: &dyn Learner, epsilon: f64) -> f64 {
    let mut world = Puddle::new(&PuddleConfig::default());
    let mut rng = Rng::new(17);
    let mut sum = 0.0;
    for start in 0..36_u32 {
        let (column, row) = (f64::from(start % 6), f64::from(start / 6));
        world.reset_at((column + 0.5) / 6.0, (row + 0.5) / 6.0, u64::from(start));
        let mut state = [0.0; 2];
        loop {
            world.sense(0, &mut state).unwrap();
            let outcome = world.step(choose(learner, &state, epsilon, &mut rng)).unwrap();
            sum += outcome.motor_reward;
            if outcome.end != End::Running {
                break;
            }
        }
    }
    sum / 36.0
}

/// Greedy return after practice.
fn trained(config: &LearnerConfig, rate: Rate, episodes: usize, seed: u64) -> f64 {
    let mut learner = config.build(Dims { inputs: 2, choices: 4 }, seed).unwrap();
    let mut world = Puddle::new(&PuddleConfig::default());
    let mut rng = Streams::new(seed).stream("practice");
    for _ in 0..episodes {
        practise(learner.as_mut(), &mut world, rate, &mut rng);
    }
    examine(learner.as_ref(), 0.0)
}

#[test]
fn every_learner_learns_to_walk_around_the_puddles() {
    const SEEDS: u64 = 2;
    let learners = learners();
    std::thread::scope(|scope| {
        for (config, rate, episodes) in &learners {
            scope.spawn(move || {
                let start = std::time::Instant::now();
                let returns: Vec<f64> =
                    (0..SEEDS).map(|seed| trained(config, *rate, *episodes, seed)).collect();
                let mean = returns.iter().sum::<f64>() / SEEDS as f64;
                println!("{}: {mean:.1} {returns:.1?} {:?}", config.name(), start.elapsed());
                assert!(mean > -80.0, "{} earns only {mean} ({returns:?})", config.name());
            });
        }
    });
}

#[test]
fn walking_at_random_earns_little() {
    let idle = LearnerConfig::default().build(Dims { inputs: 2, choices: 4 }, 0).unwrap();
    let earned = examine(idle.as_ref(), 1.0);
    println!("random: {earned:.1}");
    assert!((-1500.0..-300.0).contains(&earned), "{earned}");
}
