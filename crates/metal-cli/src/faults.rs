//! `metal faults`.

use crate::measuring::{Measuring, Shown};
use clap::Args;
use metal_lab::faults::{self, FaultOptions, FaultReport};
use metal_lab::{experiments, plan};
use metal_worlds::faulty::Fault;
use std::path::PathBuf;

/// `metal faults`
#[derive(Debug, Args)]
pub struct Broken {
    /// The experiment file (the paper's if nothing is said)
    pub file: Option<PathBuf>,
    /// Policies to try; the looks of those that choose them are followed through faults
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
    /// Faults through which looks are followed, within episodes and while a mind learns on
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
    #[command(flatten)]
    measuring: Measuring,
}

/// Every fault, by name.
const NAMES: [&str; 8] = ["dead", "frozen", "nan", "delayed", "noisy", "blinded", "removed", "added"];

fn named(names: &[String]) -> Vec<Fault> {
    let fault = |name: &String| Fault::ALL.into_iter().find(|f| f.name() == name);
    names.iter().filter_map(fault).collect()
}

/// Tries everything, prints it, writes it.
pub fn run(request: &Broken) -> anyhow::Result<()> {
    let set = &request.measuring.set;
    let plan = match &request.file {
        Some(file) => plan::load(file, set)?,
        None => plan::parse(experiments::PAPER, set)?,
    };
    let options = FaultOptions {
        seeds: request.seeds as usize,
        seed: request.measuring.seed,
        policies: request.policy.clone(),
        faults: named(&request.fault),
        rates: request.rate.clone(),
        runs: request.runs as usize,
        trained_with: named(&request.train_with),
        followed: named(&request.follow),
        lasting: request.lasting as usize,
        ..FaultOptions::default()
    };
    let planned = faults::planned_steps(&plan, &options)?;
    request.measuring.carry_out(&SHOWN, planned, |bar| Ok(faults::run(&plan, &options, bar)?))
}

const SHOWN: Shown<FaultReport> = Shown { name: "faults", text: faults::text, draw: faults::draw };
