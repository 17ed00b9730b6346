//! `metal ceiling`.

use crate::measuring::{Measuring, Shown};
use anyhow::{Context, ensure};
use clap::Args;
use metal_lab::ceiling::{self, CeilingOptions, CeilingReport, Learned};
use metal_lab::plan::{self, Plan};
use metal_lab::store::Store;
use std::path::{Path, PathBuf};

pub const EXAMPLES: &str = "\
Examples:
  metal ceiling experiments/attention.toml            the highway: some CPU-minutes for each driver
  metal ceiling experiments/toy.toml --log-steps 40000
  metal ceiling experiments/attention.toml --learned runs/run --out runs/ceiling
  metal ceiling experiments/attention.toml --quick    see everything work

The folder gets ceiling.json, ceiling.md (the tables), ceiling-all.svg and ceiling-cheap.svg: motor
cost against the price of looks for every subset at every rhythm, looks by need, what was learned.

A ceiling judges one move at a time where a driver goes that sees everything: it is optimistic about
drift and pessimistic about adaptation. \"At the wheel\" are students that were taught where their
looks lead to.";

/// `metal ceiling`
#[derive(Debug, Args)]
pub struct Request {
    /// The experiment file; its world must be one that can be copied
    file: PathBuf,
    /// Phase whose roster and recipe are taken (the first one that learns attention if nothing is said)
    #[arg(long, value_name = "NAME")]
    phase: Option<String>,
    /// A folder that `metal run` wrote: its policies are shown beside the ceilings
    #[arg(long, value_name = "DIR")]
    learned: Option<PathBuf>,
    /// Independent drivers, each with a log of its own
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    seeds: u32,
    /// Motor steps from which a driver learns, and so each universal student
    #[arg(long, default_value_t = 80_000, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000_000))]
    driver_steps: u32,
    /// Motor steps of its log, at each of which all moves are judged
    #[arg(long, default_value_t = 12_000, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000_000))]
    log_steps: u32,
    /// Share of the log's moves that are left to chance
    #[arg(long, default_value_t = 0.1, value_name = "SHARE")]
    chance: f64,
    /// Test episodes of each way of looking at the wheel
    #[arg(long, default_value_t = 200, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    runs: u32,
    /// Cut everything so far that the numbers only show that everything works
    #[arg(long)]
    quick: bool,
    #[command(flatten)]
    measuring: Measuring,
}

impl Request {
    fn options(&self) -> CeilingOptions {
        let options = CeilingOptions {
            seeds: self.seeds as usize,
            seed: self.measuring.seed,
            phase: self.phase.clone(),
            driver_steps: self.driver_steps as usize,
            log_steps: self.log_steps as usize,
            chance: self.chance,
            runs: self.runs as usize,
            ..CeilingOptions::default()
        };
        if self.quick { options.shrunk() } else { options }
    }
}

/// Measures, prints, writes.
pub fn run(request: &Request) -> anyhow::Result<()> {
    let plan = plan::load(&request.file, &request.measuring.set)?;
    let options = request.options();
    let planned =
        ceiling::planned_steps(&plan, &options).with_context(|| request.file.display().to_string())?;
    let learned = request.learned.as_deref().map_or(Ok(Vec::new()), |folder| learned(folder, &plan))?;
    request.measuring.carry_out(&SHOWN, planned, |bar| {
        Ok(CeilingReport { learned, ..ceiling::run(&plan, &options, bar)? })
    })
}

const SHOWN: Shown<CeilingReport> = Shown { name: "ceiling", text: ceiling::text, draw: ceiling::draw };

/// The policies of a run in the scenario of the plan.
fn learned(folder: &Path, plan: &Plan) -> anyhow::Result<Vec<Learned>> {
    let results = Store::open(folder)?.read_results()?;
    let scenario = plan.file.environment.training_scenario();
    let learned = ceiling::learned(&results, &scenario);
    ensure!(
        !learned.is_empty(),
        "--learned {}: nobody was tested in scenario `{scenario}`",
        folder.display()
    );
    Ok(learned)
}
