//! No allocation per motor step: what a phase allocates does not grow with its steps once its buffers have their size.
#![allow(clippy::unwrap_used)]

use allocation_counter::measure;
use metal_lab::experiments;
use metal_lab::mind::Mind;
use metal_lab::plan::{self, Plan};
use metal_lab::progress::Silent;
use metal_lab::train::train_phase;
use metal_rl::observe::Unobserved;
use metal_rl::phase::{Budget, Phase};
use metal_rl::policy::Policy;
use metal_rl::random::Streams;
use metal_rl::run::{Stage, run};

/// Replay of a few samples, so that it is full before anybody counts.
fn paper() -> Plan {
    let sets = ["tiny", "observer", "acl"].map(|l| format!("learner.{l}.mlp.capacity=64"));
    let budgets = ["fusion", "attention_phase3"].map(|phase| format!("phase.{phase}.budget.episodes=3"));
    plan::parse(experiments::PAPER, &[sets.as_slice(), budgets.as_slice()].concat()).unwrap()
}

/// Allocations of `episodes` more episodes of the phase `name`.
fn allocations(
    plan: &Plan,
    mind: &mut Mind,
    (name, policy): (&str, &mut dyn Policy),
    phase: &Phase,
) -> [u64; 2] {
    let mut world = plan.file.environment.build().unwrap();
    [4, 12].map(|episodes| {
        let phase = Phase { budget: Budget::Episodes(episodes), ..phase.clone() };
        let (members, scaling) = (&mut mind.members, plan.file.scaling);
        let mut stage = Stage { environment: world.as_mut(), members, policy: &mut *policy, scaling };
        let streams = Streams::new(3).child(name);
        measure(|| run(&mut stage, &phase, &streams, &mut Unobserved).unwrap()).count_total
    })
}

#[test]
fn neither_training_nor_testing_allocates_per_step() {
    let plan = paper();
    let streams = Streams::new(1);
    let mut mind = Mind::newborn(&plan, &streams).unwrap();
    for phase in ["demonstration", "fusion", "attention_phase3"] {
        mind = train_phase(&plan, phase, mind, &streams, &Silent).unwrap().mind;
    }
    let attention = plan.phase("attention_phase3");
    let mut acl = mind.take_attention(&plan, "acl_phase3", attention.roster, &streams).unwrap();
    let test = Phase::evaluation("test", attention.roster, 1);
    for (name, phase) in [("attention", &attention), ("test", &test)] {
        let [few, many] = allocations(&plan, &mut mind, (name, &mut acl), phase);
        // The shorter run lets every buffer grow; eight episodes more are 400 steps.
        assert!(many <= few + 8, "{name}: {few} allocations in 4 episodes, {many} in 12");
    }
    let fusion = plan.phase("fusion");
    let mut fuser = mind.policy(&plan, &plan.file.phase["fusion"].acting, fusion.roster, 0);
    let [few, many] = allocations(&plan, &mut mind, ("fusion", fuser.as_mut()), &fusion);
    assert!(many <= few + 8, "fusion: {few} allocations in 4 episodes, {many} in 12");
}
