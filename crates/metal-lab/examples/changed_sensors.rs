//! Sensors of another make after training: who can go on? The mind whose attention lives in the decision space keeps it
//! and lets its tiny agents learn Phases I and II anew; the mind whose attention reads what its members read must learn
//! attention anew, from as many motor steps.
//!
//! `cargo run --release -p metal-lab --example changed_sensors -- experiments/attention.toml 31/0`
//!
//! The seed is that of `diary`. Every sensor shows its highest for its lowest. Validation roads.
#![expect(clippy::print_stdout, reason = "a program that prints")]

use metal_lab::evaluate::{Candidate, Course, measures, test};
use metal_lab::mind::Mind;
use metal_lab::plan::{self, Plan};
use metal_lab::progress::Silent;
use metal_lab::registry::Roads;
use metal_lab::reproduce::seed_streams;
use metal_lab::train::train_up_to;
use metal_rl::random::Streams;
use metal_worlds::faulty::Faults;
use std::error::Error;
use std::path::Path;

const RUNS: usize = 1000;
/// What turns attention over readings into attention over supports, of members that learned before.
const SUPPORTS: [&str; 2] =
    ["attention.acl.counterfactual.content=\"support\"", "phase.attention.after=\"fusion\""];
/// Own motor steps of an iteration.
const ITERATION: usize = 5000;

fn main() -> Result<(), Box<dyn Error>> {
    let mut words = std::env::args().skip(1);
    let file = words.next().ok_or("which experiment file?")?;
    let seed = words.next().ok_or("which seed, as 31/0?")?;
    let (run, training) = seed.split_once('/').ok_or("which training, as 31/0?")?;
    let streams = seed_streams(run.parse()?, training.parse()?);
    let settings: Vec<String> = words.collect();
    let load = |more: &[&str]| {
        let all: Vec<String> = settings.iter().cloned().chain(more.iter().map(|&s| s.to_owned())).collect();
        plan::load(Path::new(&file), &all)
    };
    let (readings, supports) = (load(&[])?, load(&SUPPORTS)?);

    let decision_space = train_up_to(&supports, "attention", &streams, &Silent)?.mind;
    let there = inverted(&supports)?;
    tell("supports, as trained", &supports, &decision_space, &streams)?;
    tell("supports, sensors changed", &there, &decision_space, &streams)?;
    let mut relearned = train_up_to(&there, "fusion", &streams.child("again"), &Silent)?.mind;
    relearned.students = decision_space.students.clone();
    tell("supports, tiny agents learned anew", &there, &relearned, &streams)?;

    let reader = train_up_to(&readings, "attention", &streams, &Silent)?.mind;
    let there = inverted(&readings)?;
    tell("readings, as trained", &readings, &reader, &streams)?;
    tell("readings, sensors changed", &there, &reader, &streams)?;
    for iterations in [6, 12, 24] {
        let steps = format!("phase.attention.budget.steps={}", iterations * ITERATION);
        let rounds = format!("attention.acl.counterfactual.iterations={iterations}");
        let there = inverted(&load(&[&steps, &rounds])?)?;
        let again = train_up_to(&there, "attention", &streams.child("again"), &Silent)?.mind;
        tell(
            &format!("readings, attention learned anew, {iterations} iterations"),
            &there,
            &again,
            &streams,
        )?;
    }
    Ok(())
}

/// The same experiment with all sensors of another make.
fn inverted(plan: &Plan) -> Result<Plan, Box<dyn Error>> {
    let mut file = plan.file.clone();
    let inverted = plan.spec.sensors.iter().map(|s| s.name.clone()).collect();
    file.environment = file.environment.with_faults(Faults { inverted, ..Faults::default() });
    Ok(Plan::check(file)?)
}

fn tell(what: &str, plan: &Plan, mind: &Mind, streams: &Streams) -> Result<(), Box<dyn Error>> {
    let phase = plan.file.phase.get("attention").ok_or("the file has no phase `attention`")?;
    let roster = plan.roster(&phase.roster);
    let candidate = Candidate { plan, mind, acting: &phase.acting, roster, blind: 0 };
    let course = Course { scenario: "mix".to_owned(), roads: Roads::Validation, runs: RUNS };
    let episodes = test(&candidate, &course, &streams.child("changed"), &Silent)?;
    let all = measures(&episodes);
    let of = |name: &str| all.iter().find(|(n, _)| *n == name).map_or(f64::NAN, |(_, value)| *value);
    println!("{what:55} {:8.3} (motor {:.3}, {:.3} looks)", of("total"), of("motor"), of("looks"));
    Ok(())
}
