//! The one loop keeps its promises: nobody reads an unattended sensor, looks are paid, phases are only data.
#![allow(clippy::unwrap_used)]

use metal_rl::environment::{
    End, Environment, EnvironmentError, EnvironmentSpec, Feature, Outcome, SensorSpec,
};
use metal_rl::explore::Schedule;
use metal_rl::learner::{Dims, Learner, Rate, Sample};
use metal_rl::member::{Member, decision_dims};
use metal_rl::observe::{Observer, Step};
use metal_rl::phase::{Budget, Lessons, Phase, Sensing, Teaching};
use metal_rl::policies::attention::{Consultable, MotorTarget, learner_dims};
use metal_rl::policies::{Advisor, Attention, AttentionConfig, Blind, Solo};
use metal_rl::policy::Policy;
use metal_rl::random::Streams;
use metal_rl::returns::Credit;
use metal_rl::run::{Decided, Stage, decide, run};
use metal_rl::set::IndexSet;
use metal_rl::view::{Scaling, View};
use std::sync::{Arc, Mutex};

/// Two sensors with prices 1 and 2; reward −(action); every reading of a sensor is written down.
struct Ledger {
    spec: EnvironmentSpec,
    time: usize,
    terminal_at: usize,
    reads: Arc<Mutex<Vec<(usize, usize)>>>,
}

impl Ledger {
    fn new(horizon: usize, terminal_at: usize) -> Self {
        let sensor = |name: &str, price| SensorSpec {
            name: name.into(),
            features: vec![Feature { name: "x".into(), low: 0.0, high: 1.0 }],
            price,
        };
        let spec = EnvironmentSpec {
            id: "Ledger-v0".into(),
            sensors: vec![sensor("a", 1.0), sensor("b", 2.0)],
            actions: vec!["zero".into(), "one".into()],
            horizon,
            measures: vec!["time".into()],
        };
        Self { spec, time: 0, terminal_at, reads: Arc::default() }
    }
}

impl Environment for Ledger {
    fn spec(&self) -> &EnvironmentSpec {
        &self.spec
    }
    fn reset(&mut self, _seed: u64) -> Result<(), EnvironmentError> {
        self.time = 0;
        Ok(())
    }
    fn sense(&mut self, sensor: usize, out: &mut [f64]) -> Result<(), EnvironmentError> {
        self.reads.lock().unwrap().push((self.time, sensor));
        out[0] = 0.1 * sensor as f64 + 0.01 * self.time as f64;
        Ok(())
    }
    fn step(&mut self, action: usize) -> Result<Outcome, EnvironmentError> {
        self.time += 1;
        let end = match self.time {
            t if t == self.terminal_at => End::Terminal,
            t if t == self.spec.horizon => End::TimeLimit,
            _ => End::Running,
        };
        Ok(Outcome { motor_reward: -(action as f64), end })
    }
    fn measures(&self) -> &[f64] {
        &[7.0]
    }
    fn advise(&mut self) -> Option<usize> {
        Some(1)
    }
}

/// What a learner was taught: first input, choice, target.
type Taught = Arc<Mutex<Vec<(f64, usize, f64)>>>;

/// Prefers low choices, and writes down what it is taught.
#[derive(Clone)]
struct Notebook {
    dims: Dims,
    taught: Taught,
}

impl Notebook {
    fn boxed(inputs: usize, choices: usize) -> (Box<dyn Learner>, Taught) {
        let taught = Taught::default();
        (Box::new(Self { dims: Dims { inputs, choices }, taught: taught.clone() }), taught)
    }
}

impl Learner for Notebook {
    fn dims(&self) -> Dims {
        self.dims
    }
    fn values(&self, state: &[f64], out: &mut [f64]) {
        for (i, o) in out.iter_mut().enumerate() {
            *o = -(i as f64) - state[0];
        }
    }
    fn support(&self, _state: &[f64], out: &mut [f64]) {
        out.fill(1.0 / self.dims.choices as f64);
    }
    fn learn(&mut self, s: Sample<'_>, _rate: Rate) -> f64 {
        self.taught.lock().unwrap().push((s.state[0], s.choice, s.target));
        0.0
    }
    fn size(&self) -> (usize, &'static str) {
        (0, "entries")
    }
    fn freeze(&self) -> Vec<u8> {
        Vec::new()
    }
    fn boxed_clone(&self) -> Box<dyn Learner> {
        Box::new(self.clone())
    }
}

fn members(spec: &EnvironmentSpec) -> (Vec<Member>, Vec<Taught>) {
    (0..2)
        .map(|i| {
            let (learner, taught) = Notebook::boxed(1, 2);
            (Member { name: format!("m{i}"), view: View::new(spec, &[i]), learner }, taught)
        })
        .unzip()
}

fn phase(sensing: Sensing, budget: Budget) -> Phase {
    Phase {
        name: "test".into(),
        roster: IndexSet::first(2),
        sensing,
        lessons: Lessons {
            teaching: Teaching::Attended,
            rate: Rate::Full,
            credit: Credit { gamma: 0.5, lambda: 0.0 },
            bootstrap: None,
            demonstrated: false,
        },
        policy_learns: true,
        exploration: Schedule::Greedy,
        budget,
    }
}

#[derive(Default)]
struct Bill {
    prices: Vec<f64>,
    ends: Vec<End>,
}

impl Observer for Bill {
    fn on_step(&mut self, step: &Step<'_>) {
        assert_eq!(step.measures, [7.0]);
        self.prices.push(step.look_price);
        self.ends.push(step.end);
    }
}

fn go(world: &mut Ledger, members: &mut [Member], policy: &mut dyn Policy, phase: &Phase) -> Bill {
    let mut bill = Bill::default();
    let mut stage = Stage { environment: world, members, policy, scaling: Scaling::Linear };
    run(&mut stage, phase, &Streams::new(1), &mut bill).unwrap();
    bill
}

#[test]
fn only_the_consulted_sensor_is_ever_read_not_even_to_bootstrap() {
    let mut world = Ledger::new(4, 99);
    let (mut members, taught) = members(&world.spec);
    let phase = phase(Sensing::OnDemand, Budget::Episodes(2));
    let bill = go(&mut world, &mut members, &mut Solo::new(1, 2), &phase);
    let reads = world.reads.lock().unwrap().clone();
    assert!(reads.iter().all(|&(_, sensor)| sensor == 1), "sensor a was never attended: {reads:?}");
    assert_eq!(reads.len(), 2 * 5, "once per motor step and once behind the time limit");
    assert_eq!(bill.prices, [2.0; 8]);
    assert!(taught[0].lock().unwrap().is_empty() && taught[1].lock().unwrap().len() == 8);
}

#[test]
fn everyone_watches_the_advisor_and_learns_from_the_same_steps() {
    let mut world = Ledger::new(3, 99);
    let (mut members, taught) = members(&world.spec);
    let bill = go(&mut world, &mut members, &mut Advisor, &phase(Sensing::Everyone, Budget::Steps(7)));
    assert_eq!(bill.prices, [3.0; 7]);
    assert_eq!(bill.ends[2], End::TimeLimit);
    assert_eq!(bill.ends[6], End::TimeLimit, "a budget in steps cuts the last episode like a time limit");
    // One tiny agent more never changes the number of trials: both learned all 7 steps of action 1.
    for member in &taught {
        let notes = member.lock().unwrap();
        assert_eq!(notes.len(), 7);
        assert!(notes.iter().all(|n| n.1 == 1));
    }
}

#[test]
fn time_limits_bootstrap_and_terminal_states_do_not() {
    for (terminal_at, expected) in [(99, -1.0 + 0.5 * -0.11), (1, -1.0)] {
        let mut world = Ledger::new(1, terminal_at);
        let (mut members, taught) = members(&world.spec);
        go(&mut world, &mut members, &mut Advisor, &phase(Sensing::Everyone, Budget::Episodes(1)));
        assert!((taught[1].lock().unwrap()[0].2 - expected).abs() < 1e-12);
    }
}

fn attention(config: AttentionConfig, members: &[Member], spec: &EnvironmentSpec) -> (Attention, Taught) {
    let dims = decision_dims(members, spec);
    let shape = learner_dims(&config, &dims, &[0, 1]);
    let (learner, taught) = Notebook::boxed(shape.inputs, shape.choices);
    (
        Attention::new(config, learner, &dims, Consultable { members: vec![0, 1], prices: vec![1.0, 2.0] }),
        taught,
    )
}

#[test]
fn attention_pays_for_what_it_asks_and_members_it_never_asked_learn_nothing() {
    let mut world = Ledger::new(3, 99);
    let (mut members, taught) = members(&world.spec);
    let config =
        AttentionConfig { min_looks: 1, max_looks: 1, price_ramp: 0.0, ..AttentionConfig::default() };
    let (mut policy, lessons) = attention(config, &members, &world.spec);
    let bill = go(&mut world, &mut members, &mut policy, &phase(Sensing::OnDemand, Budget::Episodes(1)));
    // The notebook prefers low indices: the first look is member 0 (choice 2), then action 0.
    assert_eq!(bill.prices, [1.0; 3]);
    assert!(world.reads.lock().unwrap().iter().all(|&(_, s)| s == 0));
    assert!(taught[1].lock().unwrap().is_empty());
    let choices: Vec<usize> = lessons.lock().unwrap().iter().map(|l| l.1).collect();
    // Seven: the look behind the time limit was taken and led somewhere; the move after it was not made.
    assert_eq!(choices, [2, 0, 2, 0, 2, 0, 2]);
}

#[test]
fn the_literal_rule_learns_at_once_and_looks_into_the_null_state() {
    let mut world = Ledger::new(2, 99);
    let (mut members, _) = members(&world.spec);
    let config = AttentionConfig { min_looks: 1, max_looks: 1, ..AttentionConfig::paper_literal() };
    assert_eq!(config.motor_target, MotorTarget::Literal);
    let gamma = config.credit.gamma;
    let (mut policy, lessons) = attention(config, &members, &world.spec);
    go(&mut world, &mut members, &mut policy, &phase(Sensing::OnDemand, Budget::Episodes(1)));
    let lessons = lessons.lock().unwrap();
    // First lesson: the look, worth −price + best move after it (support 0.5 in the first input).
    assert_eq!(lessons[0].1, 2);
    assert!((lessons[0].2 - (-1.0 - 0.5)).abs() < 1e-12);
    // Second: the move, worth r + γ max Q(null); with one look compulsory that is the look's value there, −2.
    assert_eq!(lessons[1].1, 0);
    assert!((lessons[1].2 - gamma * -2.0).abs() < 1e-12);
}

#[test]
fn blind_driving_reads_nothing() {
    let mut world = Ledger::new(5, 99);
    let (mut members, _) = members(&world.spec);
    let blind = Phase::evaluation("blind", IndexSet::EMPTY, 3);
    let bill = go(&mut world, &mut members, &mut Blind { action: 1 }, &blind);
    assert!(world.reads.lock().unwrap().is_empty());
    assert_eq!(bill.prices, [0.0; 15]);
}

#[test]
#[should_panic(expected = "not on the roster")]
fn benched_members_cannot_be_consulted() {
    let mut world = Ledger::new(5, 99);
    let (mut members, _) = members(&world.spec);
    let benched = Phase { roster: IndexSet::first(1), ..phase(Sensing::OnDemand, Budget::Episodes(1)) };
    go(&mut world, &mut members, &mut Solo::new(1, 2), &benched);
}

#[test]
fn a_decision_reads_what_it_asks_for_and_moves_nothing() {
    let mut world = Ledger::new(5, usize::MAX);
    let reads = world.reads.clone();
    let (mut members, taught) = members(&world.spec);
    let mut policy = Solo::new(1, 2);
    let mut stage = Stage {
        environment: &mut world,
        members: &mut members,
        policy: &mut policy,
        scaling: Scaling::Linear,
    };
    let phase = phase(Sensing::OnDemand, Budget::Episodes(1));
    let decided = decide(&mut stage, &phase, &Streams::new(1)).unwrap();
    assert_eq!(decided, Decided { order: vec![1], action: 0, look_price: 2.0 });
    assert_eq!(decide(&mut stage, &phase, &Streams::new(1)).unwrap(), decided);
    assert_eq!((reads.lock().unwrap().as_slice(), world.time), (&[(0, 1), (0, 1)][..], 0));
    assert!(taught.iter().all(|t| t.lock().unwrap().is_empty()));
}
