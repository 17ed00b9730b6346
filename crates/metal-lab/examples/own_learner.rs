//! A learner of your own, driven through the one loop.
//!
//! It remembers every state it was told about and answers with the average of what lies near (Nadaraya and Watson's
//! regression). Here it learns the maze of Fig. 12 and is compared with the exact optimum.
//!
//! `cargo run --release -p metal-lab --example own_learner`

use metal_rl::environment::Environment;
use metal_rl::explore::Schedule;
use metal_rl::learner::{Dims, Learner, Rate, Sample};
use metal_rl::member::Member;
use metal_rl::num;
use metal_rl::observe::{Observer, Step, Unobserved};
use metal_rl::phase::{Budget, Lessons, Phase, Sensing, Teaching};
use metal_rl::policies::Solo;
use metal_rl::random::Streams;
use metal_rl::returns::Credit;
use metal_rl::run::{Stage, run};
use metal_rl::set::IndexSet;
use metal_rl::view::{Scaling, View};
use metal_worlds::maze::{Maze, MazeConfig, optimal_values};
use std::io::Write;

/// Distance within which something is near; states are in [0, 1].
const WIDTH: f64 = 0.1;
/// Weight of the opinion that everything is worth 0, which makes untried actions attractive.
const DOUBT: f64 = 0.01;

/// A state that was told about, what it is worth, and how often it was.
#[derive(Clone)]
struct Memory {
    state: Vec<f64>,
    value: f64,
    count: f64,
}

/// The learner: one list of memories per action.
#[derive(Clone)]
struct Neighbours {
    dims: Dims,
    memories: Vec<Vec<Memory>>,
}

impl Neighbours {
    fn new(dims: Dims) -> Self {
        Self { dims, memories: vec![Vec::new(); dims.choices] }
    }

    /// Q(s, a): the average of the memories, weighted by nearness.
    fn value(&self, choice: usize, state: &[f64]) -> f64 {
        let (mut sum, mut weights) = (0.0, DOUBT);
        for memory in &self.memories[choice] {
            let weight = num::exp(-0.5 * distance2(&memory.state, state) / (WIDTH * WIDTH));
            sum += weight * memory.value;
            weights += weight;
        }
        sum / weights
    }
}

fn distance2(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum()
}

impl Learner for Neighbours {
    fn dims(&self) -> Dims {
        self.dims
    }

    fn values(&self, state: &[f64], out: &mut [f64]) {
        for (choice, out) in out.iter_mut().enumerate() {
            *out = self.value(choice, state);
        }
    }

    fn support(&self, state: &[f64], out: &mut [f64]) {
        self.values(state, out);
        num::soft_max(out, 1.0);
    }

    fn learn(&mut self, sample: Sample<'_>, rate: Rate) -> f64 {
        let error = sample.target - self.value(sample.choice, sample.state);
        let memories = &mut self.memories[sample.choice];
        let known = memories.iter_mut().find(|m| distance2(&m.state, sample.state) < 1e-6);
        let Some(memory) = known else {
            memories.push(Memory { state: sample.state.to_vec(), value: sample.target, count: 1.0 });
            return error;
        };
        memory.count += 1.0;
        let step = match rate {
            Rate::Full => 1.0,
            Rate::Constant(alpha) => alpha,
            Rate::Average(floor) => (1.0 / memory.count).max(floor),
        };
        memory.value += step * (sample.target - memory.value);
        error
    }

    fn size(&self) -> (usize, &'static str) {
        (self.memories.iter().map(Vec::len).sum(), "memories")
    }

    fn freeze(&self) -> Vec<u8> {
        let numbers = |m: &Memory| [&m.state[..], &[m.value, m.count]].concat();
        let action = |memories: &Vec<Memory>| {
            let count = (memories.len() as u64).to_le_bytes();
            count
                .into_iter()
                .chain(memories.iter().flat_map(numbers).flat_map(f64::to_le_bytes))
                .collect::<Vec<u8>>()
        };
        self.memories.iter().flat_map(action).collect()
    }

    fn boxed_clone(&self) -> Box<dyn Learner> {
        Box::new(self.clone())
    }
}

/// Adds up motor rewards.
#[derive(Default)]
struct Walks {
    reward: f64,
    episodes: f64,
}

impl Observer for Walks {
    fn on_step(&mut self, step: &Step<'_>) {
        self.reward += step.motor_reward;
    }

    fn on_episode(&mut self, _episode: usize, _progress: f64) {
        self.episodes += 1.0;
    }
}

/// Mean reward of an episode after learning, and the best possible one.
fn experiment(seed: u64) -> Result<(f64, f64), Box<dyn std::error::Error>> {
    let config = MazeConfig::default();
    let best = optimal_values(&config, 1.0);
    let mut world = Maze::new(config)?;
    let view = View::new(world.spec(), &[0, 1]);
    let dims = Dims { inputs: view.dims(), choices: world.spec().actions.len() };
    let mut members = [Member { name: "XY".to_owned(), view, learner: Box::new(Neighbours::new(dims)) }];
    let mut policy = Solo::new(0, dims.choices);
    let mut stage = Stage {
        environment: &mut world,
        members: &mut members,
        policy: &mut policy,
        scaling: Scaling::Linear,
    };
    let learning = Phase {
        name: "learning".to_owned(),
        roster: IndexSet::first(1),
        sensing: Sensing::OnDemand,
        lessons: Lessons {
            teaching: Teaching::Attended,
            rate: Rate::Constant(0.3),
            credit: Credit { gamma: 0.95, lambda: 0.7 },
            bootstrap: None,
            demonstrated: false,
        },
        policy_learns: false,
        exploration: Schedule::Random { from: 0.5, to: 0.02, until: 0.8 },
        budget: Budget::Episodes(400),
    };
    let streams = Streams::new(seed);
    run(&mut stage, &learning, &streams.child("learning"), &mut Unobserved)?;
    let mut walks = Walks::default();
    run(&mut stage, &Phase::evaluation("test", IndexSet::first(1), 300), &streams.child("test"), &mut walks)?;
    // Episodes begin anywhere but at the goal, whose own value is 0.
    Ok((walks.reward / walks.episodes, best.iter().sum::<f64>() / (best.len() - 1) as f64))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (learned, best) = experiment(1)?;
    writeln!(std::io::stdout().lock(), "learned: {learned:.2} per episode; the best possible: {best:.2}")?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_maze_is_learned() {
        let (learned, best) = experiment(1).unwrap();
        assert!((learned - best).abs() < 0.3, "{learned} against {best}");
    }
}
