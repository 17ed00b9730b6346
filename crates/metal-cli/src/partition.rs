//! `metal partition`.

use crate::args::Printing;
use crate::bar::Bar;
use crate::commands::{keep_clear, listen_to_ctrl_c, say, say_json};
use anyhow::{Context, ensure};
use clap::{Args, ValueEnum};
use metal_lab::partition::{self, Criterion, PartitionOptions, Proposal};
use metal_lab::plan;
use std::path::{Path, PathBuf};

pub const EXAMPLES: &str = "\
Examples:
  metal partition experiments/partition.toml                  how the cells of the eye would be grouped
  metal partition experiments/partition.toml --out mine.toml  and the experiment with these members
  metal run mine.toml
  metal partition experiments/partition.toml --by alike --groups 7 --out clusters.toml

The expert drives as in Phase I and every sensor is read. Of all sensors that the members of the
phase see, groups are made; the file has them as members in the places of those, at the summed
price. Beside it is a picture (.svg) of the eye in the colours of the groups, if there is an eye.";

/// What makes sensors belong together.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum By {
    /// They say the same: agglomerative clustering
    Alike,
    /// Together they tell the expert's action for their price: optimisation
    Worth,
    /// Nothing, to compare with
    Random,
}

/// `metal partition`
#[derive(Debug, Args)]
pub struct Request {
    /// The experiment file, its world cut into raw sensors
    file: PathBuf,
    /// What makes sensors belong together
    #[arg(long, value_enum, default_value_t = By::Worth)]
    by: By,
    /// Groups wanted (`worth` may need fewer); else as many as the criterion says
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=64))]
    groups: Option<u32>,
    /// Most groups where the criterion chooses how many, and the number of random ones
    #[arg(long, default_value_t = 12, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=64))]
    most: u32,
    /// Motor steps of the demonstration
    #[arg(long, default_value_t = 4000, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    steps: u32,
    /// Share of its moves left to chance, so that the expert is also watched where it would never go
    #[arg(long, default_value_t = 0.0, value_name = "SHARE")]
    chance: f64,
    /// Parts into which each number is cut to compare sensors
    #[arg(long, default_value_t = 4, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=64))]
    levels: u32,
    /// How much a price counts against what a group tells (0: not at all)
    #[arg(long, default_value_t = 1.0, value_name = "FACTOR")]
    thrift: f64,
    /// Phase whose members are replaced (the first one that learns attention if nothing is said)
    #[arg(long, value_name = "NAME")]
    phase: Option<String>,
    /// The one number all randomness comes from
    #[arg(long, default_value_t = 1, value_name = "N")]
    seed: u64,
    /// Where to write the experiment (nothing is written if it is not given)
    #[arg(long, value_name = "FILE.toml")]
    out: Option<PathBuf>,
    /// Replace what is there
    #[arg(long, requires = "out")]
    force: bool,
    /// Override a field of the experiment: dotted key = TOML value; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    #[command(flatten)]
    printing: Printing,
}

impl Request {
    fn options(&self) -> PartitionOptions {
        PartitionOptions {
            by: match self.by {
                By::Alike => Criterion::Alike,
                By::Worth => Criterion::Worth,
                By::Random => Criterion::Random,
            },
            groups: self.groups.map(|groups| groups as usize),
            most: self.most as usize,
            steps: self.steps as usize,
            chance: self.chance,
            levels: self.levels as usize,
            thrift: self.thrift,
            phase: self.phase.clone(),
            seed: self.seed,
        }
    }
}

/// Proposes, prints, writes.
pub fn run(request: &Request) -> anyhow::Result<()> {
    if let Some(out) = &request.out {
        let is_toml = out.extension().is_some_and(|end| end == "toml");
        ensure!(is_toml, "--out {}: the name of an experiment file ends in .toml", out.display());
        keep_clear(out, request.force)?;
        keep_clear(&picture(out), request.force)?;
    }
    let plan = plan::load(&request.file, &request.set)?;
    let options = request.options();
    listen_to_ctrl_c()?;
    let bar = Bar::new(options.steps as u64);
    let proposal = partition::run(&plan, &options, &bar);
    bar.finish();
    let proposal = proposal.with_context(|| request.file.display().to_string())?;
    if let Some(out) = &request.out {
        write(&proposal, out)?;
    }
    if request.printing.json { say_json(&proposal) } else { say(&partition::text(&proposal)) }
}

/// Where the picture goes.
fn picture(out: &Path) -> PathBuf {
    out.with_extension("svg")
}

fn write(proposal: &Proposal, out: &Path) -> anyhow::Result<()> {
    let save = |path: &Path, text: String| {
        std::fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))
    };
    save(out, proposal.experiment()?)?;
    partition::draw(proposal).map_or(Ok(()), |svg| save(&picture(out), svg))
}
