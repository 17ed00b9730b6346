//! Learning from demonstrations on disk: the same lessons from a file and from the advisor give the same mind.
#![allow(clippy::unwrap_used, reason = "helpers of tests may fail loudly")]

use metal_lab::demonstrations::{Demonstrations, Header, Moment};
use metal_lab::experiments;
use metal_lab::mind::Mind;
use metal_lab::plan::{self, Plan};
use metal_lab::progress::Silent;
use metal_lab::train::train_phase;
use metal_rl::environment::{End, Environment};
use metal_rl::random::Streams;
use std::collections::BTreeMap;

const PHASE: &str = "demonstration";

fn plan() -> Plan {
    plan::parse(experiments::PAPER, &[]).unwrap()
}

fn readings(world: &mut dyn Environment) -> Vec<Vec<f64>> {
    let shapes: Vec<usize> = world.spec().sensors.iter().map(|s| s.features.len()).collect();
    let mut read = |(sensor, n): (usize, usize)| {
        let mut out = vec![0.0; n];
        world.sense(sensor, &mut out).unwrap();
        out
    };
    shapes.into_iter().enumerate().map(&mut read).collect()
}

/// What the advisor does in the episodes that the lab would show.
fn shown_by_the_advisor(plan: &Plan, streams: &Streams) -> Demonstrations {
    let mut world = plan.file.environment.build().unwrap();
    let mut moments = Vec::new();
    for episode in 0..4 {
        let lessons = streams.child("phase").child(PHASE).nth(episode as u64);
        world.reset(lessons.child("world").seed()).unwrap();
        for step in 0.. {
            let seen = readings(world.as_mut());
            let action = world.advise();
            let outcome = world.step(action.unwrap()).unwrap();
            let motor_reward = outcome.motor_reward;
            let (advice, accident, end) = (action, false, outcome.end);
            let at = |readings, action| Moment {
                episode,
                step,
                readings,
                action,
                advice,
                motor_reward,
                accident,
                end,
            };
            moments.push(at(seen, action));
            if end != End::Running {
                moments.push(at(readings(world.as_mut()), None));
                break;
            }
        }
    }
    Demonstrations { header: Header::new(&plan.spec), moments }
}

fn frozen(plan: &Plan, streams: &Streams) -> metal_lab::mind::FrozenMind {
    let newborn = Mind::newborn(plan, streams).unwrap();
    train_phase(plan, PHASE, newborn, streams, &Silent).unwrap().mind.freeze(&BTreeMap::new())
}

#[test]
fn a_file_teaches_what_the_advisor_teaches() {
    let (plan, streams) = (plan(), Streams::new(7));
    let set = shown_by_the_advisor(&plan, &streams);
    assert_eq!((set.quality().steps, set.quality().disagreement), (200, 0.0));
    let path = std::env::temp_dir().join(format!("metal-taught-{}.jsonl", std::process::id()));
    std::fs::write(&path, set.to_lines().unwrap()).unwrap();
    let mut file = plan.file.clone();
    file.watch_demonstrations(&path);
    let taught = Plan::check(file).unwrap();
    assert!(taught.phase(PHASE).lessons.demonstrated, "a person counts as flawless, too");
    let (by_file, by_advisor) = (frozen(&taught, &streams), frozen(&plan, &streams));
    std::fs::remove_file(&path).unwrap();
    assert!(by_file == by_advisor, "the file teaches something else than the advisor");
    let text = toml::to_string(&taught.file).unwrap();
    assert_eq!(
        plan::parse(&text, &[]).unwrap().file,
        taught.file,
        "the plan of such a run can be read again"
    );
}

#[test]
fn a_missing_set_and_an_impossible_part_are_refused() {
    let mut file = plan().file;
    file.watch_demonstrations(std::path::Path::new("/nowhere/at-all.jsonl"));
    let plan = Plan::check(file).unwrap();
    let streams = Streams::new(1);
    let newborn = Mind::newborn(&plan, &streams).unwrap();
    let error = train_phase(&plan, PHASE, newborn, &streams, &Silent).err().unwrap().to_string();
    assert!(error.contains("/nowhere/at-all.jsonl"), "{error}");
    let set = "policy.oracle.acting={ demonstrations = \"x.jsonl\" }".to_owned();
    let error = plan::parse(experiments::PAPER, &[set]).unwrap_err().to_string();
    assert!(error.contains("policy.oracle.acting") && error.contains("recording"), "{error}");
    let set = "phase.demonstration.sensing=on_demand".to_owned();
    assert!(plan::parse(experiments::PAPER, &[set]).is_err());
}
