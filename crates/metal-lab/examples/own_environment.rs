//! A world of your own, and attention control in it.
//!
//! A pedestrian crossing: `light` tells red from green, `kerb` whether somebody is about to walk. Waiting always costs
//! 3; going costs nothing if it is safe and 10 if it is not. Looking at everything is a waste: nobody who sees a red
//! light needs the kerb.
//!
//! `cargo run --release -p metal-lab --example own_environment`

use metal_rl::environment::{
    End, Environment, EnvironmentError, EnvironmentSpec, Feature, Outcome, SensorSpec,
};
use metal_rl::explore::Schedule;
use metal_rl::fuse::Fuser;
use metal_rl::learner::{Dims, Rate};
use metal_rl::learners::{LearnerConfig, MlpConfig};
use metal_rl::member::{Member, decision_dims};
use metal_rl::observe::{Observer, Step, Unobserved};
use metal_rl::phase::{Budget, Lessons, Phase, Sensing, Teaching};
use metal_rl::policies::attention::{Consultable, MotorTarget, learner_dims};
use metal_rl::policies::{Attention, AttentionConfig, Fusion};
use metal_rl::policy::Policy;
use metal_rl::random::{Rng, Streams};
use metal_rl::returns::Credit;
use metal_rl::run::{Stage, run};
use metal_rl::set::IndexSet;
use metal_rl::view::{Scaling, View};
use std::io::Write;

/// Index of the action that drives on; the other one waits.
const GO: usize = 0;

/// The crossing.
struct Crossing {
    spec: EnvironmentSpec,
    rng: Rng,
    steps: usize,
    green: bool,
    pedestrian: bool,
}

impl Crossing {
    fn new() -> Self {
        let sensor = |name: &str, feature: &str, price| SensorSpec {
            name: name.to_owned(),
            features: vec![Feature { name: feature.to_owned(), low: 0.0, high: 1.0 }],
            price,
        };
        let spec = EnvironmentSpec {
            id: "Crossing-v0".to_owned(),
            sensors: vec![sensor("light", "green", 0.2), sensor("kerb", "pedestrian", 0.5)],
            actions: vec!["go".to_owned(), "wait".to_owned()],
            horizon: 20,
            measures: vec!["safe".to_owned()],
        };
        Self { spec, rng: Rng::new(0), steps: 0, green: false, pedestrian: false }
    }

    /// Only time changes the world; looking never does.
    fn next_moment(&mut self) {
        self.green = self.rng.chance(0.5);
        self.pedestrian = self.rng.chance(0.2);
    }
}

impl Environment for Crossing {
    fn spec(&self) -> &EnvironmentSpec {
        &self.spec
    }

    fn reset(&mut self, seed: u64) -> Result<(), EnvironmentError> {
        self.rng = Streams::new(seed).stream("crossing");
        self.steps = 0;
        self.next_moment();
        Ok(())
    }

    fn sense(&mut self, sensor: usize, out: &mut [f64]) -> Result<(), EnvironmentError> {
        out[0] = f64::from(u8::from([self.green, self.pedestrian][sensor]));
        Ok(())
    }

    fn step(&mut self, action: usize) -> Result<Outcome, EnvironmentError> {
        let safe = self.green && !self.pedestrian;
        let motor_reward = match action {
            GO if safe => 0.0,
            GO => -10.0,
            _ => -3.0,
        };
        self.steps += 1;
        self.next_moment();
        let end = if self.steps == self.spec.horizon { End::TimeLimit } else { End::Running };
        Ok(Outcome { motor_reward, end })
    }

    fn measures(&self) -> &[f64] {
        if self.green && !self.pedestrian { &[1.0] } else { &[0.0] }
    }
}

/// Adds up what a policy pays.
#[derive(Default)]
struct Bill {
    steps: f64,
    looks: f64,
    cost: f64,
}

impl Observer for Bill {
    fn on_step(&mut self, step: &Step<'_>) {
        self.steps += 1.0;
        self.looks += step.state.order().len() as f64;
        self.cost += step.look_price - step.motor_reward;
    }
}

/// One tiny agent per sensor.
fn newborn(spec: &EnvironmentSpec) -> Result<Vec<Member>, Box<dyn std::error::Error>> {
    let agent = |(index, sensor): (usize, &SensorSpec)| {
        let view = View::new(spec, &[index]);
        let dims = Dims { inputs: view.dims(), choices: spec.actions.len() };
        let learner = LearnerConfig::default().build(dims, index as u64)?;
        Ok(Member { name: sensor.name.clone(), view, learner })
    };
    spec.sensors.iter().enumerate().map(agent).collect()
}

/// Attention control over all members.
fn newborn_attention(
    members: &[Member],
    spec: &EnvironmentSpec,
) -> Result<Attention, Box<dyn std::error::Error>> {
    let config = AttentionConfig { motor_target: MotorTarget::Myopic, ..AttentionConfig::default() };
    let everybody: Vec<usize> = (0..members.len()).collect();
    let decision = decision_dims(members, spec);
    let network = MlpConfig { hidden: vec![24], ..MlpConfig::default() };
    let learner = LearnerConfig::Mlp(network).build(learner_dims(&config, &decision, &everybody), 1)?;
    let prices = members.iter().map(|m| m.price(spec)).collect();
    Ok(Attention::new(config, learner, &decision, Consultable { members: everybody, prices }))
}

/// A phase in which both agents may be consulted and learn from every step that they saw.
fn phase(name: &str, episodes: usize, exploration: Schedule) -> Phase {
    let credit = Credit { gamma: 0.0, lambda: 0.0 };
    Phase {
        name: name.to_owned(),
        roster: IndexSet::first(2),
        sensing: Sensing::OnDemand,
        lessons: Lessons {
            teaching: Teaching::Attended,
            rate: Rate::Average(0.01),
            credit,
            bootstrap: None,
            demonstrated: false,
        },
        policy_learns: false,
        exploration,
        budget: Budget::Episodes(episodes),
    }
}

/// Mean cost and mean looks per motor step of fusion and of attention control, after learning.
fn experiment(seed: u64) -> Result<[Bill; 2], Box<dyn std::error::Error>> {
    let (mut world, streams) = (Crossing::new(), Streams::new(seed));
    let mut members = newborn(world.spec())?;
    let mut fusion = Fusion::new(Fuser::LogOpinionPool, IndexSet::first(2), world.spec().actions.len());
    let mut attention = newborn_attention(&members, world.spec())?;
    let mut go = |policy: &mut dyn Policy, phase: &Phase, bill: &mut dyn Observer| {
        let mut stage =
            Stage { environment: &mut world, members: &mut members, policy, scaling: Scaling::Linear };
        run(&mut stage, phase, &streams.child(&phase.name), bill)
    };
    let trying = Schedule::Random { from: 0.5, to: 0.1, until: 0.8 };
    go(&mut fusion, &phase("fusion", 100, trying), &mut Unobserved)?;
    let cooling = Schedule::SoftMax { from: 3.0, to: 0.1, until: 0.7 };
    let attending = Phase { policy_learns: true, ..phase("attention", 500, cooling) };
    go(&mut attention, &attending, &mut Unobserved)?;

    let test = Phase::evaluation("test", IndexSet::first(2), 200);
    let mut bills = [Bill::default(), Bill::default()];
    go(&mut fusion, &test, &mut bills[0])?;
    go(&mut attention, &test, &mut bills[1])?;
    Ok(bills)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut out = std::io::stdout().lock();
    for (name, bill) in ["fusion", "attention"].iter().zip(experiment(1)?) {
        let (cost, looks) = (bill.cost / bill.steps, bill.looks / bill.steps);
        writeln!(out, "{name:9} costs {cost:.2} per step with {looks:.2} looks")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Seeing everything costs 2.50 at best; looking at the kerb only when the light is green, 2.25.
    #[test]
    fn attention_is_cheaper_than_seeing_everything() {
        let [fusion, attention] = experiment(1).unwrap();
        assert!(fusion.cost / fusion.steps >= 2.4, "nobody can do better with every look paid");
        assert!(attention.cost / attention.steps < 2.4);
        assert!(attention.looks / attention.steps < 1.7);
    }
}
