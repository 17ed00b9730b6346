//! How a student was taught, iteration by iteration: itself, or a rival with fixed sensors by the same recipe.
//!
//! `cargo run --release -p metal-lab --example diary -- experiments/attention.toml 1 adaptive MF+RF/2`
//!
//! The seed is followed by whom to teach: `adaptive`, or the sensors to look at, with `/k` at every k-th motor step only.
//! Costs are those on validation roads.
#![allow(clippy::print_stdout)]
#![expect(clippy::print_stdout, reason = "a program that prints")]

use metal_lab::plan::{self, Plan};
use metal_lab::progress::Silent;
use metal_lab::reproduce::subsets::{Rival, train_subset};
use metal_lab::train::{Trained, train_seed};
use metal_rl::random::Streams;
use metal_rl::set::IndexSet;
use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let mut words = std::env::args().skip(1);
    let file = words.next().ok_or("which experiment file?")?;
    let seed: u64 = words.next().ok_or("which seed?")?.parse()?;
    let (settings, pupils): (Vec<String>, Vec<String>) = words.partition(|w| w.contains('='));
    let plan = plan::load(Path::new(&file), &settings)?;
    for pupil in pupils {
        println!("{pupil}, seed {seed}");
        print(&taught(&plan, &pupil, &Streams::new(seed))?);
    }
    Ok(())
}

fn taught(plan: &Plan, pupil: &str, streams: &Streams) -> Result<Trained, Box<dyn Error>> {
    if pupil == "adaptive" {
        let mut trained = train_seed(plan, streams, &Silent)?;
        return Ok(trained.remove("attention").ok_or("the file has no phase `attention`")?);
    }
    let rows = plan.file.subsets.as_ref().ok_or("the file has no [subsets]")?;
    let rival = rival(plan, pupil)?;
    Ok(train_subset(plan, rows, (rival, 1.0), streams, &Silent)?.trained)
}

/// `MF+RF/2`: the sensors MF and RF at every second motor step.
fn rival(plan: &Plan, words: &str) -> Result<Rival, Box<dyn Error>> {
    let (names, every) = words.split_once('/').unwrap_or((words, "1"));
    let mut sensors = IndexSet::EMPTY;
    for name in names.split('+') {
        let index = plan.spec.sensors.iter().position(|s| s.name == name);
        sensors = sensors.with(index.ok_or_else(|| format!("there is no sensor `{name}`"))?);
    }
    Ok(Rival { sensors, every: every.parse()? })
}

fn print(trained: &Trained) {
    println!("   share   idle   loss    total    motor  looks  rolled");
    for i in &trained.diary {
        println!(
            "  {:6.2} {:6.2} {:6.3} {:8.2} {:8.2} {:6.2} {:7}",
            i.price_share, i.idle, i.loss, i.total, i.motor, i.looks, i.rolled_steps
        );
    }
    let best = trained.diary.iter().max_by(|a, b| a.total.total_cmp(&b.total));
    if let Some(best) = best {
        println!("best: {:.2} (motor {:.2}, {:.2} looks)", best.total, best.motor, best.looks);
    }
}
