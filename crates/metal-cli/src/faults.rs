//! `metal faults`.

use crate::bar::Bar;
use crate::commands::{keep_clear, listen_to_ctrl_c, say, say_json, use_threads};
use clap::Args;
use metal_lab::faults::{self, FaultOptions};
use metal_lab::store::Store;
use metal_lab::{experiments, plan};
use metal_worlds::faulty::Fault;
use std::path::PathBuf;

/// `metal faults`
#[derive(Debug, Args)]
pub struct Broken {
    /// The experiment file (the paper's if nothing is said)
    pub file: Option<PathBuf>,
    /// Policies to try; the looks of the first one that can learn on are followed through a fault
    #[arg(long, num_args = 1.., value_name = "NAME", default_values = ["acl", "acl_phase3", "foa", "fusion"])]
    pub policy: Vec<String>,
    /// Faults of the tests
    #[arg(long, num_args = 1.., value_name = "FAULT", default_values = NAMES, value_parser = NAMES)]
    pub fault: Vec<String>,
    /// Probabilities that a sensor fails in an episode
    #[arg(long, num_args = 1.., value_name = "SHARE", default_values = ["0.1", "0.25", "0.5", "1"])]
    pub rate: Vec<f64>,
    /// Faults of trainings of their own, at a rate of 0.25
    #[arg(long, num_args = 0.., value_name = "FAULT", default_values = ["nan", "noisy"], value_parser = NAMES)]
    pub train_with: Vec<String>,
    /// Faults through which that policy learns on
    #[arg(long, num_args = 0.., value_name = "FAULT", default_values = ["nan", "dead"], value_parser = NAMES)]
    pub follow: Vec<String>,
    /// Episodes of learning before, during and after such a fault, and after a change of the world
    #[arg(long, default_value_t = 300, value_name = "N", value_parser = clap::value_parser!(u32).range(6..=10_000_000))]
    pub lasting: u32,
    /// Test episodes of each training and cell
    #[arg(long, default_value_t = 20, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    pub runs: u32,
    /// Independent trainings
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub seeds: u32,
    /// The one number all randomness comes from
    #[arg(long, default_value_t = 1, value_name = "N")]
    pub seed: u64,
    /// Override a field of the experiment: dotted key = TOML value; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Folder for tables, numbers and drawings (nothing is written if it is not given)
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Replace what is in the folder
    #[arg(long, requires = "out")]
    pub force: bool,
    /// Print JSON instead of the tables
    #[arg(long)]
    pub json: bool,
    /// Threads (0: one per core); results do not depend on it
    #[arg(long, default_value_t = 0, value_name = "N", value_parser = clap::value_parser!(u16).range(..=1024))]
    pub threads: u16,
}

/// Every fault, by name.
const NAMES: [&str; 8] = ["dead", "frozen", "nan", "delayed", "noisy", "blinded", "removed", "added"];

fn named(names: &[String]) -> Vec<Fault> {
    let fault = |name: &String| Fault::ALL.into_iter().find(|f| f.name() == name);
    names.iter().filter_map(fault).collect()
}

/// Tries everything, prints it, writes it.
pub fn run(request: &Broken) -> anyhow::Result<()> {
    use_threads(request.threads)?;
    listen_to_ctrl_c()?;
    let plan = match &request.file {
        Some(file) => plan::load(file, &request.set)?,
        None => plan::parse(experiments::PAPER, &request.set)?,
    };
    let options = FaultOptions {
        seeds: request.seeds as usize,
        seed: request.seed,
        policies: request.policy.clone(),
        faults: named(&request.fault),
        rates: request.rate.clone(),
        runs: request.runs as usize,
        trained_with: named(&request.train_with),
        followed: named(&request.follow),
        lasting: request.lasting as usize,
        ..FaultOptions::default()
    };
    if let Some(out) = &request.out {
        keep_clear(&out.join("faults.json"), request.force)?;
    }
    let bar = Bar::new(faults::planned_steps(&plan, &options)? as u64);
    let report = faults::run(&plan, &options, &bar);
    bar.finish();
    let report = report?;
    if let Some(out) = &request.out {
        let store = Store::create(out)?;
        store.write("faults.md", faults::text(&report).as_bytes())?;
        for (name, svg) in faults::draw(&report) {
            store.write(&format!("faults-{name}.svg"), svg.as_bytes())?;
        }
        store.write("faults.json", serde_json::to_string_pretty(&report)?.as_bytes())?;
    }
    if request.json { say_json(&report) } else { say(&faults::text(&report)) }
}
