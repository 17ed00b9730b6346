//! What can be typed.

use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;

/// Learn to act, and what to look at before acting.
///
/// METAL trains tiny agents that each see one sensor, and an attention controller that decides before every motor
/// action whom to consult, paying for every look. Start with `metal reproduce`.
#[derive(Debug, Parser)]
#[command(name = "metal", version, propagate_version = true)]
pub struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Reproduce the paper: train, test, and write the report with every figure and table beside the paper's.
    Reproduce(Reproduce),
    /// Run an experiment file, e.g. `metal run experiments/paper.toml --set phase.fusion.budget.episodes=100`.
    Run(Run),
    /// Test trained minds on any road, also one nobody has seen, e.g. `metal eval --run runs/reproduce --roads test`.
    Eval(Eval),
    /// Largest probability of aliasing in the decision space (Sec. 6.1, Eqs 22-26, Table 3).
    Aliasing(Aliasing),
    /// List environments, learners, fusers and the fields of an experiment file.
    List,
    /// Print shell completions, e.g. `metal completions bash > /etc/bash_completion.d/metal`.
    Completions {
        /// The shell.
        shell: clap_complete::Shell,
    },
    /// Train the minds of the red cars again (`Highway-v0` ships them) and write them to a file.
    TrainTraffic {
        /// Where to write.
        #[arg(long)]
        out: PathBuf,
    },
}

/// Options common to everything that trains.
#[derive(Debug, Args)]
pub struct Training {
    /// Independent trainings.
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..))]
    pub seeds: u32,
    /// The one number all randomness comes from.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Under a minute, with budgets so small that the numbers only show that everything works.
    #[arg(long)]
    pub quick: bool,
    /// Train and test every subset of sensors, not only singles, pairs and the grown ones.
    #[arg(long)]
    pub all_subsets: bool,
    /// Override a field of the experiment: dotted key = TOML value. May be repeated.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Print the results as JSON instead of a table.
    #[arg(long)]
    pub json: bool,
    /// Threads (0: one per core). Results do not depend on it.
    #[arg(long, default_value_t = 0)]
    pub threads: usize,
}

/// `metal reproduce`
#[derive(Debug, Args)]
pub struct Reproduce {
    /// Folder for report, results, records and minds.
    #[arg(long, default_value = "runs/reproduce")]
    pub out: PathBuf,
    #[command(flatten)]
    pub training: Training,
}

/// `metal run`
#[derive(Debug, Args)]
pub struct Run {
    /// The experiment file (TOML).
    pub file: PathBuf,
    /// Folder for results, records and minds.
    #[arg(long, default_value = "runs/run")]
    pub out: PathBuf,
    #[command(flatten)]
    pub training: Training,
}

/// `metal eval`
#[derive(Debug, Args)]
pub struct Eval {
    /// A folder that `reproduce` or `run` wrote.
    #[arg(long)]
    pub run: PathBuf,
    /// Roads: training, validation or test.
    #[arg(long, default_value = "test", conflicts_with = "road_seed")]
    pub roads: String,
    /// Roads grown from these seeds instead.
    #[arg(long, num_args = 1.., value_name = "N")]
    pub road_seed: Vec<u64>,
    /// Runs per scenario and seed.
    #[arg(long, default_value_t = 100)]
    pub runs: usize,
    /// Print JSON instead of a table.
    #[arg(long)]
    pub json: bool,
}

/// `metal aliasing`
#[derive(Debug, Args)]
pub struct Aliasing {
    /// Quantisation level of the decision space, q.
    #[arg(long)]
    pub q: usize,
    /// Number of physical states that a tiny agent cannot tell apart, k.
    #[arg(long)]
    pub k: usize,
    /// Number of motor actions, |A|.
    #[arg(long)]
    pub actions: usize,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}
