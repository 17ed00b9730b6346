//! `metal prices`.

use crate::args::Printing;
use crate::bar::Bar;
use crate::commands::{keep_clear, listen_to_ctrl_c, say, say_json, use_threads};
use anyhow::Context;
use clap::Args;
use metal_lab::plan;
use metal_lab::prices::{self, PricesOptions, PricesReport};
use metal_lab::reproduce::quick::shrink;
use metal_lab::store::Store;
use std::path::{Path, PathBuf};

pub const EXAMPLES: &str = "\
Examples:
  metal prices experiments/attention.toml --out runs/prices         the highway: some CPU-hours
  metal prices experiments/attention.toml --factors 0.5,2 --rivals RN/2,RN/3,RN/4
  metal prices experiments/attention.toml --quick                   see everything work

Attention is trained at each price, each fixed choice once: it pays the same whatever it does. The
file's [subsets] says by which phase's recipe all learn. The folder gets prices.json, prices.md (the
tables), prices-motor.svg, prices-total.svg and prices-looks.svg.";

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
    /// Folder for tables, numbers and drawings (nothing is written if it is not given)
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace what is in the folder
    #[arg(long, requires = "out")]
    force: bool,
    /// Independent trainings of everybody, the source of every interval
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    seeds: u32,
    /// The one number all randomness comes from; trainings are those of `metal run` with the same
    #[arg(long, default_value_t = 1, value_name = "N")]
    seed: u64,
    /// Test episodes of each training, on validation roads
    #[arg(long, default_value_t = 500, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    runs: u32,
    /// Cut everything so far that the numbers only show that everything works
    #[arg(long)]
    quick: bool,
    /// Override a field of the experiment: dotted key = TOML value; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    #[command(flatten)]
    printing: Printing,
    /// Threads (0: one per core); results do not depend on it
    #[arg(long, default_value_t = 0, value_name = "N", value_parser = clap::value_parser!(u16).range(..=1024))]
    threads: u16,
}

impl Request {
    fn options(&self) -> PricesOptions {
        let options = PricesOptions {
            seeds: self.seeds as usize,
            seed: self.seed,
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
    let mut plan = plan::load(&request.file, &request.set)?;
    if request.quick {
        plan = plan::Plan::check(shrink(plan.file))?;
    }
    let options = request.options();
    let planned =
        prices::planned_steps(&plan, &options).with_context(|| request.file.display().to_string())?;
    if let Some(out) = &request.out {
        keep_clear(&out.join("prices.json"), request.force)?;
    }
    use_threads(request.threads)?;
    listen_to_ctrl_c()?;
    let bar = Bar::new(planned as u64);
    let report = prices::run(&plan, &options, &bar);
    bar.finish();
    let report = report?;
    if let Some(out) = &request.out {
        write(&report, out)?;
    }
    if request.printing.json { say_json(&report) } else { say(&prices::text(&report)) }
}

fn write(report: &PricesReport, out: &Path) -> anyhow::Result<()> {
    let store = Store::create(out)?;
    store.write("prices.md", prices::text(report).as_bytes())?;
    for (name, svg) in prices::draw(report) {
        store.write(&format!("prices-{name}.svg"), svg.as_bytes())?;
    }
    store.write("prices.json", serde_json::to_string_pretty(report)?.as_bytes())?;
    Ok(())
}
