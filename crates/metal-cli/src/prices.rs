//! `metal prices`.

use crate::measuring::{Measuring, Shown};
use anyhow::Context;
use clap::Args;
use metal_lab::plan;
use metal_lab::prices::{self, PricesOptions, PricesReport};
use metal_lab::reproduce::quick::shrink;
use std::path::PathBuf;

pub const EXAMPLES: &str = "\
Examples:
  metal prices experiments/attention.toml --out runs/prices         the highway: some CPU-hours
  metal prices experiments/attention.toml --factors 0.5,2 --rivals RN/2,RN/3,RN/4
  metal prices experiments/attention.toml --quick                   see everything work

Attention is trained at each price, each fixed choice once: it pays the same whatever it does. The
file's [subsets] says by which phase's recipe all learn, and trainings are those of `metal run` with
the same --seed. The folder gets prices.json, prices.md (the tables), prices-motor.svg,
prices-total.svg and prices-looks.svg.";

/// `metal prices`
#[derive(Debug, Args)]
pub struct Request {
    /// The experiment file
    file: PathBuf,
    /// What prices of looks are multiplied by, from below to above
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_value = "0,0.25,0.5,1,2,4,8")]
    factors: Vec<f64>,
    /// Fixed choices, as in `MN+MF` or `RN/2` (every second motor step); those of the file if none is given. All sensors
    /// always take part
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    rivals: Vec<String>,
    /// Independent trainings of everybody, the source of every interval
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    seeds: u32,
    /// Test episodes of each training, on validation roads
    #[arg(long, default_value_t = 500, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    runs: u32,
    /// Cut everything so far that the numbers only show that everything works
    #[arg(long)]
    quick: bool,
    #[command(flatten)]
    measuring: Measuring,
}

impl Request {
    fn options(&self) -> PricesOptions {
        let options = PricesOptions {
            seeds: self.seeds as usize,
            seed: self.measuring.seed,
            factors: self.factors.clone(),
            rivals: self.rivals.clone(),
            runs: self.runs as usize,
        };
        if self.quick {
            return PricesOptions { seeds: options.seeds.min(2), runs: options.runs.min(4), ..options };
        }
        options
    }
}

/// Measures, prints, writes.
pub fn run(request: &Request) -> anyhow::Result<()> {
    let mut plan = plan::load(&request.file, &request.measuring.set)?;
    if request.quick {
        plan = plan::Plan::check(shrink(plan.file))?;
    }
    let options = request.options();
    let planned =
        prices::planned_steps(&plan, &options).with_context(|| request.file.display().to_string())?;
    request.measuring.carry_out(&SHOWN, planned, |bar| Ok(prices::run(&plan, &options, bar)?))
}

const SHOWN: Shown<PricesReport> = Shown { name: "prices", text: prices::text, draw: prices::draw };
