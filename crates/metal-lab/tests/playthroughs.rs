//! Golden playthroughs: a dozen motor steps of every kind of run, as text a person can follow. A change of any number
//! that a learner, a sensor or a reward depends on shows up here. To accept a change: `UPDATE_EXPECT=1 cargo test`.
#![allow(clippy::unwrap_used)]

use expect_test::expect_file;
use metal_lab::evaluate::{Candidate, Course, watch};
use metal_lab::experiments;
use metal_lab::mind::Mind;
use metal_lab::plan::{self, Plan};
use metal_lab::progress::Silent;
use metal_lab::registry::Roads;
use metal_lab::train::train_phase;
use metal_rl::num;
use metal_rl::observe::{Observer, Step};
use metal_rl::random::Streams;
use metal_rl::run::{Stage, run};
use std::fmt::Write;

const STEPS: usize = 12;
const SEED: u64 = 20;

/// Writes down the first [`STEPS`] motor steps from episode `from` on.
struct Transcript<'a> {
    plan: &'a Plan,
    from: usize,
    written: usize,
    text: String,
}

impl<'a> Transcript<'a> {
    fn new(plan: &'a Plan, from: usize) -> Self {
        Self { plan, from, written: 0, text: String::new() }
    }
}

/// Six digits each; a minus zero is a zero.
fn numbers(values: &[f64]) -> String {
    let digits: Vec<String> = values.iter().map(|v| format!("{:.6}", v + 0.0)).collect();
    digits.join(" ")
}

impl Observer for Transcript<'_> {
    fn on_step(&mut self, step: &Step<'_>) {
        if step.episode < self.from || self.written == STEPS {
            return;
        }
        self.written += 1;
        let actions = &self.plan.spec.actions;
        let names: Vec<&str> =
            step.state.order().iter().map(|&m| self.plan.members[m].name.as_str()).collect();
        let asked = if names.is_empty() { "nobody".to_owned() } else { names.join(", ") };
        let place = format!("episode {} step {}", step.episode, step.index);
        writeln!(self.text, "{place}: asked {asked} for {}", numbers(&[step.look_price])).unwrap();
        for &m in step.state.order() {
            let opinion = step.state.opinion(m).unwrap();
            let proposal = &actions[num::argmax(opinion.values)];
            let name = &self.plan.members[m].name;
            writeln!(self.text, "  {name:3} reads    {}", numbers(opinion.reading)).unwrap();
            writeln!(self.text, "      supports {}, so {proposal}", numbers(opinion.support)).unwrap();
        }
        let (action, reward) = (&actions[step.action], numbers(&[step.motor_reward]));
        writeln!(self.text, "  does {action}, earns {reward}, {:?}", step.end).unwrap();
    }
}

fn parse(text: &str, assignments: &[&str]) -> Plan {
    let assignments: Vec<String> = assignments.iter().map(|a| (*a).to_owned()).collect();
    plan::parse(text, &assignments).unwrap_or_else(|e| panic!("{e}"))
}

/// The mind after the phases `names`, one after the other.
fn trained(plan: &Plan, names: &[&str]) -> Mind {
    let streams = Streams::new(SEED);
    let newborn = Mind::newborn(plan, &streams).unwrap();
    names.iter().fold(newborn, |mind, name| train_phase(plan, name, mind, &streams, &Silent).unwrap().mind)
}

/// A test drive of the policy `name`, from its first motor step.
fn tested(plan: &Plan, mind: &Mind, name: &str) -> String {
    let row = &plan.file.policy[name];
    let candidate = Candidate { plan, mind, acting: &row.acting, roster: plan.roster(&row.roster), blind: 0 };
    let course =
        Course { scenario: plan.file.environment.training_scenario(), roads: Roads::Training, runs: STEPS };
    let mut transcript = Transcript::new(plan, 0);
    watch(&candidate, &course, &Streams::new(SEED), &mut transcript).unwrap();
    transcript.text
}

#[test]
fn the_demonstration_on_the_highway() {
    let plan = parse(experiments::PAPER, &["phase.demonstration.budget.steps=62"]);
    let streams = Streams::new(SEED);
    let mut mind = Mind::newborn(&plan, &streams).unwrap();
    let mut world = plan.file.environment.build().unwrap();
    let phase = plan.phase("demonstration");
    let mut policy = mind.policy(&plan, &plan.file.phase["demonstration"].acting, phase.roster, 0);
    let (members, scaling) = (&mut mind.members, plan.file.scaling);
    let mut stage = Stage { environment: world.as_mut(), members, policy: policy.as_mut(), scaling };
    // The second episode: in the first one everybody is newborn and has nothing to say.
    let mut transcript = Transcript::new(&plan, 1);
    run(&mut stage, &phase, &streams, &mut transcript).unwrap();
    assert_eq!(transcript.written, STEPS);
    expect_file!["golden/highway-demonstration.txt"].assert_eq(&transcript.text);
}

#[test]
fn attention_on_the_highway() {
    // After so little practice nobody would look at all, if one look were not the least.
    let plan = parse(
        experiments::PAPER,
        &[
            "phase.fusion.budget.episodes=3",
            "phase.attention_phase3.budget.episodes=12",
            "attention.acl_phase3.settings.min_looks=1",
            "attention.acl_phase3.settings.price_ramp=1.0",
        ],
    );
    let mind = trained(&plan, &["demonstration", "fusion", "attention_phase3"]);
    expect_file!["golden/highway-attention.txt"].assert_eq(&tested(&plan, &mind, "acl_phase3"));
}

#[test]
fn attention_on_the_toy() {
    let plan = parse(experiments::TOY, &["phase.attention.budget.episodes=3000"]);
    let mind = trained(&plan, &["attention"]);
    expect_file!["golden/toy.txt"].assert_eq(&tested(&plan, &mind, "acl"));
}

/// Two tiny agents that each see one coordinate find their way together.
const MAZE: &str = r#"
title = "Two tiny agents in the maze of Eq. (14)"
scaling = "linear"
environment = { maze = {} }
learner = { tiny = { tile = {} } }
member = { X = { sensors = ["X"], learner = "tiny" }, Y = { sensors = ["Y"], learner = "tiny" } }

[phase.fusion]
roster = ["X", "Y"]
acting = { fusion = "sum" }
rate = { constant = 0.3 }
exploration = { random = { from = 0.5, to = 0.1, until = 0.8 } }
budget = { episodes = 60 }

[policy.fusion]
after = "fusion"
roster = ["X", "Y"]
acting = { fusion = "sum" }
"#;

#[test]
fn fusion_in_the_maze() {
    let plan = parse(MAZE, &[]);
    let mind = trained(&plan, &["fusion"]);
    expect_file!["golden/maze.txt"].assert_eq(&tested(&plan, &mind, "fusion"));
}
