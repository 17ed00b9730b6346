//! Every learner crosses puddle world by one-step Q-learning: the regression test of the learners themselves.
//!
//! Return is the undiscounted sum of rewards, greedy, from a 6 × 6 grid of starts; walking at random earns about −700,
//! walking straight to the goal through the puddles about −50, an oracle about −25.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use metal_rl::environment::{End, Environment};
use metal_rl::learner::{Dims, Learner, Rate, Sample};
use metal_rl::learners::absp::{Covariance, MixtureConfig};
use metal_rl::learners::{AbspConfig, BayesMixConfig, IgmnConfig, LearnerConfig, MlpConfig, TileConfig};
use metal_rl::num;
use metal_rl::random::{Rng, Streams};
use metal_rl::returns::{Link, lambda_returns};
use metal_worlds::puddle::{Puddle, PuddleConfig};

const GAMMA: f64 = 0.99;
const EPSILON: f64 = 0.1;
const ALPHA: f64 = 0.5;

/// A learner, and how it practises.
struct Case {
    config: LearnerConfig,
    episodes: usize,
    /// Credit λ: 0 learns every step as it happens, otherwise whole episodes are learned when they end.
    lambda: f64,
    /// The mean return demanded: the mean over ten seeds less slack for a mean over two.
    at_least: f64,
}

/// One-step Q-learning over as many episodes as the anchors were measured with.
fn one_step(config: LearnerConfig, at_least: f64) -> Case {
    Case { config, episodes: 500, lambda: 0.0, at_least }
}

/// The learners. Replayed one-step targets stay as wrong as the network was when they were computed, so the network
/// learns what episodes really earned (λ = 1), through the λ-returns of the library's own loop.
fn cases() -> Vec<Case> {
    let diagonal = MixtureConfig { covariance: Covariance::Diagonal, ..MixtureConfig::default() };
    let mlp = MlpConfig { hidden: vec![32, 32], capacity: 4000, ..MlpConfig::default() };
    vec![
        one_step(LearnerConfig::Absp(AbspConfig::default()), -45.0),
        one_step(LearnerConfig::Absp(AbspConfig { mixture: diagonal, ..AbspConfig::default() }), -45.0),
        one_step(LearnerConfig::BayesMix(BayesMixConfig::default()), -70.0),
        one_step(LearnerConfig::Igmn(IgmnConfig::default()), -50.0),
        one_step(LearnerConfig::Tile(TileConfig::default()), -32.0),
        Case { config: LearnerConfig::Mlp(mlp), episodes: 300, lambda: 1.0, at_least: -110.0 },
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

/// One moment of an episode that is not learned yet.
struct Moment {
    state: [f64; 2],
    choice: usize,
    link: Link,
}

/// One episode of Q-learning from a random start.
fn practise(learner: &mut dyn Learner, world: &mut Puddle, lambda: f64, rng: &mut Rng) {
    world.reset(rng.bits()).unwrap();
    let (mut state, mut next) = ([0.0; 2], [0.0; 2]);
    let mut moments = Vec::new();
    world.sense(0, &mut state).unwrap();
    loop {
        let choice = choose(learner, &state, EPSILON, rng);
        let outcome = world.step(choice).unwrap();
        world.sense(0, &mut next).unwrap();
        let mut values = [0.0; 4];
        learner.values(&next, &mut values);
        let next_value = if outcome.end == End::Terminal { 0.0 } else { num::max(&values) };
        let link = Link { reward: outcome.motor_reward, discount: GAMMA, next_value };
        moments.push(Moment { state, choice, link });
        state = next;
        if lambda == 0.0 || outcome.end != End::Running {
            learn(learner, &moments, lambda);
            moments.clear();
        }
        if outcome.end != End::Running {
            return;
        }
    }
}

/// Learns a chain of moments, the last one first.
fn learn(learner: &mut dyn Learner, moments: &[Moment], lambda: f64) {
    let links: Vec<Link> = moments.iter().map(|m| m.link).collect();
    let mut returns = vec![0.0; links.len()];
    lambda_returns(&links, lambda, &mut returns);
    for (m, &target) in moments.iter().zip(&returns).rev() {
        let sample = Sample { state: &m.state, choice: m.choice, target, demonstrated: false };
        learner.learn(sample, Rate::Constant(ALPHA));
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
fn trained(case: &Case, seed: u64) -> f64 {
    let mut learner = case.config.build(Dims { inputs: 2, choices: 4 }, seed).unwrap();
    let mut world = Puddle::new(&PuddleConfig::default());
    let mut rng = Streams::new(seed).stream("practice");
    for _ in 0..case.episodes {
        practise(learner.as_mut(), &mut world, case.lambda, &mut rng);
    }
    examine(learner.as_ref(), 0.0)
}

/// Prints mean, standard deviation and the returns of every learner over these seeds; returns the means.
fn measure(cases: &[Case], seeds: std::ops::Range<u64>) -> Vec<f64> {
    let means = |case: &Case| {
        let start = std::time::Instant::now();
        let returns: Vec<f64> = seeds.clone().map(|seed| trained(case, seed)).collect();
        let n = returns.len() as f64;
        let mean = returns.iter().sum::<f64>() / n;
        let sd = (returns.iter().map(|r| (r - mean) * (r - mean)).sum::<f64>() / (n - 1.0)).sqrt();
        println!("{}: {mean:.1} sd {sd:.1} {returns:.1?} {:?}", case.config.name(), start.elapsed());
        mean
    };
    std::thread::scope(|scope| {
        let running: Vec<_> = cases.iter().map(|case| scope.spawn(|| means(case))).collect();
        running.into_iter().map(|thread| thread.join().unwrap()).collect()
    })
}

#[test]
fn every_learner_learns_to_walk_around_the_puddles() {
    let cases = cases();
    for (case, mean) in cases.iter().zip(measure(&cases, 0..2)) {
        assert!(mean > case.at_least, "{} earns {mean}, not {}", case.config.name(), case.at_least);
    }
}

#[test]
#[ignore = "the table of docs/results/learners.md; a minute"]
fn table_of_ten_seeds() {
    let means = measure(&cases(), 0..10);
    assert!(means.iter().all(|m| *m > -120.0), "{means:?}");
}

#[test]
fn walking_at_random_earns_little() {
    let idle = LearnerConfig::default().build(Dims { inputs: 2, choices: 4 }, 0).unwrap();
    let earned = examine(idle.as_ref(), 1.0);
    println!("random: {earned:.1}");
    assert!((-1500.0..-300.0).contains(&earned), "{earned}");
}
