//! Attention pays in time: motor steps of the same mind under attention control, fusion and the full observer, on a
//! free road, where nobody else needs the processor.

use metal_lab::evaluate::{Candidate, Course, drive};
use metal_lab::experiments;
use metal_lab::mind::Mind;
use metal_lab::plan::{self, Plan};
use metal_lab::progress::Silent;
use metal_lab::train::train_phase;
use metal_rl::observe::Unobserved;
use metal_rl::random::Streams;
use std::error::Error;

const EPISODES: usize = 4;

/// The paper's experiment with next to no training, and `looks` looks per motor action.
fn plan(looks: usize) -> Result<Plan, Box<dyn Error>> {
    let looks = ["min", "max"].map(|end| format!("attention.acl_phase3.settings.{end}_looks={looks}"));
    let budgets =
        ["phase.fusion.budget.episodes=2", "phase.attention_phase3.budget.episodes=2"].map(str::to_owned);
    Ok(plan::parse(experiments::PAPER, &[looks, budgets].concat())?)
}

fn trained(plan: &Plan) -> Result<Mind, Box<dyn Error>> {
    let streams = Streams::new(1);
    let mut mind = Mind::newborn(plan, &streams)?;
    for phase in ["demonstration", "fusion", "attention_phase3"] {
        mind = train_phase(plan, phase, mind, &streams, &Silent)?.mind;
    }
    Ok(mind)
}

/// Time per motor step of a policy of the plan.
fn measure(name: &str, policy: &str, plan: &Plan, mind: &Mind) -> Result<(), Box<dyn Error>> {
    let row = &plan.file.policy[policy];
    let candidate = Candidate { plan, mind, acting: &row.acting, roster: plan.roster(&row.roster), blind: 0 };
    let roads = plan.file.environment.road_sets()[0].clone();
    let course = Course { scenario: "free_road".into(), roads, runs: EPISODES };
    let mut world = plan.environment(&course.scenario, Some(&course.roads)).build()?;
    let steps = EPISODES * plan.spec.horizon;
    let work = || {
        let streams = Streams::new(7);
        drive(&candidate, world.as_mut(), (EPISODES, &streams), &mut Unobserved)
            .expect("a world does not fail");
    };
    xtask::measure(("decisions", name), (steps, "motor step"), work)?;
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let (one, two) = (plan(1)?, plan(2)?);
    let (one_mind, two_mind) = (trained(&one)?, trained(&two)?);
    measure("attention, one look", "acl_phase3", &one, &one_mind)?;
    measure("attention, two looks", "acl_phase3", &two, &two_mind)?;
    measure("the full observer of six regions", "foa", &two, &two_mind)?;
    measure("fusion of seven tiny agents and the full observer", "fusion", &two, &two_mind)?;
    measure("nobody is asked: the world and the loop alone", "blind", &two, &two_mind)
}
