//! A decision-space toy with a known optimum: seven experts of unequal price, five motor actions, one decision.
//!
//! The road is straight or bends (the curve), and something may be in the way (the obstacle). Each of seven experts
//! sees one coarse feature of that, errs one time in twenty, and says how much it supports every motor action. One
//! look is one sensor reading: the expert's degree of support itself (Eq. (11)). So the toy is Phase III with nothing
//! below it, and [`optimum`] is an exact upper bound for every attention learner.

use metal_rl::environment::{
    End, Environment, EnvironmentError, EnvironmentSpec, Feature, Outcome, SensorSpec,
};
use metal_rl::random::Streams;

mod model;
mod optimum;
pub use optimum::{Optimum, optimum};

use model::{ACTIONS, EXPERTS, Situation};

/// What random streams of this world are called.
const WORLD: &str = "toy";

/// The toy as an environment of one motor step per episode.
///
/// A sensor's noise is a function of the episode's seed and the sensor alone, so looking twice shows the same thing
/// and looking never changes the world.
#[derive(Clone, Debug)]
pub struct Toy {
    spec: EnvironmentSpec,
    streams: Streams,
    situation: Situation,
    measures: [f64; 3],
}

impl Toy {
    /// The toy, standing at the beginning of the episode of seed 0.
    #[must_use]
    pub fn new() -> Self {
        let mut toy =
            Self { spec: spec(), streams: Streams::new(0), situation: Situation::FIRST, measures: [0.0; 3] };
        toy.begin(0);
        toy
    }

    fn begin(&mut self, seed: u64) {
        self.streams = Streams::new(seed).child(WORLD);
        self.situation = Situation::draw(&mut self.streams.stream("situation"));
        self.measures = [0.0, self.situation.curve as f64, self.situation.obstacle as f64];
    }
}

impl Default for Toy {
    fn default() -> Self {
        Self::new()
    }
}

fn spec() -> EnvironmentSpec {
    let feature = |action: &&str| Feature { name: format!("support_{action}"), low: 0.0, high: 1.0 };
    let sensor = |expert: &model::Expert| SensorSpec {
        name: expert.name.to_owned(),
        features: ACTIONS.iter().map(feature).collect(),
        price: expert.price,
    };
    EnvironmentSpec {
        id: "Toy-v0".to_owned(),
        sensors: EXPERTS.iter().map(sensor).collect(),
        actions: ACTIONS.iter().map(|&a| a.to_owned()).collect(),
        horizon: 1,
        measures: ["right_decision", "curve", "obstacle"].map(str::to_owned).to_vec(),
    }
}

impl Environment for Toy {
    fn spec(&self) -> &EnvironmentSpec {
        &self.spec
    }

    fn reset(&mut self, seed: u64) -> Result<(), EnvironmentError> {
        self.begin(seed);
        Ok(())
    }

    fn sense(&mut self, sensor: usize, out: &mut [f64]) -> Result<(), EnvironmentError> {
        let expert = &EXPERTS[sensor];
        let mut rng = self.streams.stream(expert.name);
        let group = expert.report(self.situation, &mut rng);
        rng.dirichlet(&expert.concentrations(group), out);
        Ok(())
    }

    fn step(&mut self, action: usize) -> Result<Outcome, EnvironmentError> {
        let motor_reward = self.situation.reward(action);
        self.measures[0] = f64::from(u8::from(action == self.situation.right_action()));
        Ok(Outcome { motor_reward, end: End::Terminal })
    }

    fn measures(&self) -> &[f64] {
        &self.measures
    }

    fn advise(&mut self) -> Option<usize> {
        Some(self.situation.right_action())
    }

    fn fork(&self) -> Option<Box<dyn Environment>> {
        Some(Box::new(self.clone()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use metal_rl::num;

    #[test]
    fn the_advisor_earns_nothing_but_no_punishment_either() {
        let mut toy = Toy::new();
        for seed in 0..200 {
            toy.reset(seed).unwrap();
            let action = toy.advise().unwrap();
            assert_eq!(toy.step(action).unwrap(), Outcome { motor_reward: 0.0, end: End::Terminal });
            assert_eq!(toy.measures()[..1], [1.0]);
        }
    }

    #[test]
    fn never_looking_and_slowing_down_earns_what_the_arithmetic_says() {
        // Slow is right for P(ahead) of straights, two obstacles of four on left bends, two on right bends.
        let mut toy = Toy::new();
        let n = 40_000;
        let total: f64 = (0..n)
            .map(|seed| {
                toy.reset(seed).unwrap();
                toy.step(2).unwrap().motor_reward
            })
            .sum();
        assert!((total / n as f64 + 12.25).abs() < 0.2, "{}", total / n as f64);
    }

    #[test]
    fn a_reading_is_a_distribution_that_mostly_points_the_right_way() {
        let mut toy = Toy::new();
        let (mut support, mut right) = ([0.0; 5], 0);
        for seed in 0..2000 {
            toy.reset(seed).unwrap();
            toy.sense(0, &mut support).unwrap();
            assert!((support.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            right += usize::from(num::argmax(&support) == toy.advise().unwrap());
        }
        // MN alone tells ahead, straight and curve apart: far better than the 1 in 5 of chance.
        assert!(right > 900, "{right}");
    }
}
