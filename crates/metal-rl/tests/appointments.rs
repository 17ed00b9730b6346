//! A bell tower: whoever knows when something new is to be seen appoints its looks, and need not look in between.
#![allow(clippy::unwrap_used)]

use metal_rl::counterfactual::iterate::{School, iterate};
use metal_rl::counterfactual::{Alone, CounterfactualConfig, FitConfig, Iterate, LookRule, MemoryConfig};
use metal_rl::environment::{
    End, Environment, EnvironmentError, EnvironmentSpec, Feature, Outcome, SensorSpec,
};
use metal_rl::explore::Schedule;
use metal_rl::learner::Dims;
use metal_rl::learners::{LearnerConfig, TileConfig};
use metal_rl::member::Member;
use metal_rl::observe::{Observer, Step};
use metal_rl::phase::{Budget, Phase};
use metal_rl::random::Streams;
use metal_rl::set::IndexSet;
use metal_rl::view::{Scaling, View};

/// Motor steps from one toll to the next.
const TOLL: usize = 3;
/// What the wrong action costs, and a look.
const WRONG: f64 = 10.0;
const PRICE: f64 = 2.0;

/// A flag that is hoisted or struck anew at every third step and stays for three. The right action is the flag.
#[derive(Clone)]
struct Tower {
    spec: EnvironmentSpec,
    streams: Streams,
    time: usize,
}

impl Tower {
    fn new() -> Self {
        let sensor = SensorSpec {
            name: "flag".into(),
            features: vec![Feature { name: "up".into(), low: 0.0, high: 1.0 }],
            price: PRICE,
        };
        let spec = EnvironmentSpec {
            id: "Tower-v0".into(),
            sensors: vec![sensor],
            actions: vec!["down".into(), "up".into()],
            horizon: 12,
            measures: vec![],
        };
        Self { spec, streams: Streams::new(0), time: 0 }
    }

    fn flag(&self) -> usize {
        self.streams.nth((self.time / TOLL) as u64).stream("flag").below(2)
    }
}

impl Environment for Tower {
    fn spec(&self) -> &EnvironmentSpec {
        &self.spec
    }
    fn reset(&mut self, seed: u64) -> Result<(), EnvironmentError> {
        (self.streams, self.time) = (Streams::new(seed), 0);
        Ok(())
    }
    fn sense(&mut self, _sensor: usize, out: &mut [f64]) -> Result<(), EnvironmentError> {
        out[0] = self.flag() as f64;
        Ok(())
    }
    fn step(&mut self, action: usize) -> Result<Outcome, EnvironmentError> {
        let motor_reward = if action == self.flag() { 0.0 } else { -WRONG };
        self.time += 1;
        let end = if self.time == self.spec.horizon { End::TimeLimit } else { End::Running };
        Ok(Outcome { motor_reward, end })
    }
    fn measures(&self) -> &[f64] {
        &[]
    }
    fn fork(&self) -> Option<Box<dyn Environment>> {
        Some(Box::new(self.clone()))
    }
}

struct Nobody;
impl Observer for Nobody {
    fn on_step(&mut self, _step: &Step<'_>) {}
}

/// The best iterate of a student that remembers by recollection alone.
fn learned() -> Iterate {
    let (mut world, mut other) = (Tower::new(), Tower::new());
    let learner =
        LearnerConfig::Tile(TileConfig::default()).build(Dims { inputs: 1, choices: 2 }, 0).unwrap();
    let mut members = [Member { name: "flag".into(), view: View::new(&Tower::new().spec, &[0]), learner }];
    let config = CounterfactualConfig {
        looks: LookRule::Appointed { max_looks: 1, ahead: 4 },
        memory: MemoryConfig { recurrent: 16, ..MemoryConfig::default() },
        iterations: 12,
        wide_eyed: 2,
        price_ramp: 3,
        horizon: 9,
        judged: 1.0,
        validation_runs: 100,
        fit: FitConfig { batches: 1000, ..FitConfig::default() },
        ..CounterfactualConfig::default()
    };
    let mut school = School {
        environment: &mut world,
        validation: &mut other,
        members: &mut members,
        roster: vec![0],
        scaling: Scaling::Linear,
        workers: &Alone,
        interrupted: &|| false,
        ear: &mut |_| {},
    };
    let phase = Phase {
        exploration: Schedule::Random { from: 0.5, to: 0.1, until: 0.6 },
        budget: Budget::Steps(12_000),
        ..Phase::evaluation("tower", IndexSet::first(1), 0)
    };
    let graduate = iterate(&mut school, &config, &phase, &Streams::new(1), &mut Nobody).unwrap();
    graduate.diary[graduate.best]
}

#[test]
fn looks_are_appointed_for_when_something_new_is_to_be_seen() {
    let best = learned();
    // One look per toll costs 2 / 3 per step; looking always costs 2, and never 5.
    assert!(best.total >= -0.85, "{} per step with {} looks", best.total, best.looks);
    assert!((0.28..=0.42).contains(&best.looks), "{} looks per step", best.looks);
}
