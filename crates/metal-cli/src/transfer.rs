//! `metal transfer`: trained minds in another world.

use crate::args::Printing;
use crate::bar::Bar;
use crate::commands::{keep_clear, listen_to_ctrl_c, say, say_json, typed, use_threads};
use anyhow::{Context, ensure};
use clap::Args;
use metal_lab::plan::{self, Plan};
use metal_lab::store::{MOST_SEEDS, Store};
use metal_lab::transfer::{self, Transfer, TransferOptions, TransferResults};
use metal_lab::{experiments, figures};
use std::fmt::Write;
use std::path::PathBuf;

pub const EXAMPLES: &str = "\
Examples:
  metal transfer                             train by the plan, then send the minds to the other road
  metal transfer --run runs/reproduce        the minds of a finished run
  metal transfer --quick --seeds 1           see everything work

The folder gets report.html (Fig. 11, and what transfers and what does not) and results.json.";

/// `metal transfer`
#[derive(Debug, Args)]
pub struct Request {
    /// The experiment, as experiments/transfer.toml (which is taken if nothing is said)
    #[arg(long, value_name = "FILE")]
    experiment: Option<PathBuf>,
    /// Minds of a folder that `metal reproduce` or `metal run` wrote; without it they are trained by the paper's plan
    #[arg(long, value_name = "DIR")]
    run: Option<PathBuf>,
    /// Folder for report and results
    #[arg(long, default_value = "runs/transfer")]
    out: PathBuf,
    /// Replace what is in the folder
    #[arg(long)]
    force: bool,
    /// Independent trainings (with --quick at most 2, with --run at most those of the run)
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=MOST_SEEDS as i64))]
    seeds: u32,
    /// The one number all randomness comes from
    #[arg(long, default_value_t = 1, value_name = "N")]
    seed: u64,
    /// Cut every budget so far that the numbers only show that everything works
    #[arg(long)]
    quick: bool,
    #[command(flatten)]
    printing: Printing,
    /// Threads (0: one per core); results do not depend on it
    #[arg(long, default_value_t = 0, value_name = "N", value_parser = clap::value_parser!(u16).range(..=1024))]
    threads: u16,
}

pub fn run(request: &Request) -> anyhow::Result<()> {
    keep_clear(&request.out.join("report.html"), request.force)?;
    let store = request.run.as_deref().map(Store::open).transpose()?;
    let (source, trained) = source(store.as_ref())?;
    let mut seeds = request.seeds as usize;
    if request.quick {
        seeds = seeds.min(2);
    }
    if let Some(trained) = trained {
        ensure!(seeds <= trained, "--seeds {seeds}: the run has {trained} trainings");
    }
    let experiment = experiment(request)?;
    let experiment = if request.quick {
        Transfer::new(experiment, &source)?.shrunk()?
    } else {
        Transfer::new(experiment, &source)?
    };
    let options = TransferOptions { seeds, seed: request.seed, quick: request.quick };
    use_threads(request.threads)?;
    listen_to_ctrl_c()?;
    let bar = Bar::new(transfer::planned_steps(&experiment, options, trained.is_some()) as u64);
    let results = transfer::execute(&experiment, options, store.as_ref(), &bar);
    bar.finish();
    let results = results?;
    let out = Store::create(&request.out)?;
    out.write("results.json", serde_json::to_string_pretty(&results)?.as_bytes())?;
    out.write("report.html", transfer::render(&results, &typed())?.as_bytes())?;
    if request.printing.json {
        return say_json(&results);
    }
    say(&format!("{}\nreport:  {}\n", table(&results), out.path("report.html").display()))
}

/// The plan the minds come from, and how many trainings there are.
fn source(store: Option<&Store>) -> anyhow::Result<(Plan, Option<usize>)> {
    let Some(store) = store else { return Ok((plan::parse(experiments::PAPER, &[])?, None)) };
    let (plan, card) = store.read_run()?;
    Ok((plan, Some(card.seeds)))
}

fn experiment(request: &Request) -> anyhow::Result<transfer::TransferFile> {
    let Some(path) = &request.experiment else { return Ok(transfer::parse(transfer::TRANSFER)?) };
    let text = std::fs::read_to_string(path).with_context(|| path.display().to_string())?;
    Ok(transfer::parse(&text).map_err(|e| e.located(path, &text))?)
}

fn table(results: &TransferResults) -> String {
    let mut text = String::from("total per motor step in the other world, nobody learns\n\n");
    for arm in results.experiment.arms() {
        let Some(policies) = results.tests.get(&arm.name()) else { continue };
        for policy in &results.experiment.policies {
            let Some(total) = policies.get(policy).and_then(|m| m.get("total")) else { continue };
            let label = format!("{policy}, {}", arm.label());
            let _ = writeln!(text, "{label:48} {}", figures::number::estimate(total, 1));
        }
    }
    text
}
