//! What can be typed.

use crate::{robots, transfer};
use clap::{Args, Parser, Subcommand};
use metal_lab::checkpoint::Start;
use metal_lab::recorded::Wish;
use metal_lab::store::MOST_SEEDS;
use std::path::PathBuf;

/// Learn to act, and what to look at before acting.
///
/// METAL trains tiny agents that each see one sensor, and an attention controller that decides before every motor
/// action whom to consult, paying for every look.
#[derive(Debug, Parser)]
#[command(name = "metal", version, propagate_version = true, after_help = START)]
pub struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Reproduce the paper: train, test, and write the report with every figure and table beside the paper's
    #[command(after_help = REPRODUCE)]
    Reproduce(Reproduce),
    /// Run an experiment file
    #[command(after_help = RUN)]
    Run(Run),
    /// Test trained minds again, on any road, also one nobody has seen
    #[command(after_help = EVAL)]
    Eval(Eval),
    /// Send trained minds to another road, eye and body, with a few demonstrations there (Sec. 5, Fig. 11)
    #[command(after_help = transfer::EXAMPLES)]
    Transfer(transfer::Request),
    /// Watch a mind learn and attend in a browser, drive yourself, demonstrate
    #[command(after_help = STUDIO)]
    Studio(Studio),
    /// Say whether a task is well posed: what blindness costs, what each sensor tells, how prices compare
    #[command(after_help = CHECK)]
    Check(Check),
    /// Compare blind, random and best fixed subsets, all sensors, fusion and METAL on a task, with equal budgets
    #[command(after_help = BENCH)]
    Bench(Bench),
    /// The same for a table: classification with columns that cost
    #[command(after_help = TABULAR)]
    Tabular(Tabular),
    /// Say what the sensors of an experiment allow: the cost of every fixed choice of looks and of looks by need
    #[command(after_help = crate::ceiling::EXAMPLES)]
    Ceiling(crate::ceiling::Request),
    /// Train attention at other prices of looking, against every fixed choice of sensors
    #[command(after_help = crate::prices::EXAMPLES)]
    Prices(crate::prices::Request),
    /// Propose tiny agents: group the raw sensors of an experiment by what a demonstration says about them
    #[command(after_help = crate::partition::EXAMPLES)]
    Partition(crate::partition::Request),
    /// Break sensors and change the world: what it costs every policy, and whether a mind that learns on copes
    #[command(after_help = FAULTS)]
    Faults(crate::faults::Broken),
    /// Largest probability of aliasing in the decision space (Sec. 6.1, Eqs 22-26, Table 3)
    #[command(after_help = ALIASING)]
    Aliasing(Aliasing),
    /// Play a robot or Webots from our own simulator, for other people's programs
    #[command(after_help = robots::SERVE)]
    Serve(robots::Serve),
    /// Check a robot: link, firmware, sensors, camera. The wheels do not turn
    Doctor(robots::Found),
    /// Learn a robot's colours and infra-red levels from a few frames, and write them to a file
    Calibrate(robots::Calibrate),
    /// Write the highway as a world for Webots: road texture, cars, world file
    World(robots::Write),
    /// Let a trained mind drive a robot
    #[command(after_help = robots::DRIVE)]
    Drive(robots::Drive),
    /// Show what is on a recording
    Replay(robots::Replayed),
    /// List environments, learners, drivers, fusers and experiments, as an experiment file names them
    List,
    /// Print shell completions
    #[command(after_help = COMPLETIONS)]
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// Train the minds of the red cars again (`Highway-v0` ships them) and write them to a file
    TrainTraffic {
        /// Where to write
        #[arg(long)]
        out: PathBuf,
        /// Replace the file, if it is there
        #[arg(long)]
        force: bool,
    },
}

const START: &str = "\
Examples:
  metal reproduce --quick --seeds 1          see everything work, in about a minute
  metal reproduce                            the paper, five trainings
  metal run experiments/toy.toml             an experiment of one's own
  metal eval --run runs/reproduce            the same minds on other roads
  metal studio                               watch it think, drive it yourself
  metal list                                 what there is to choose from";

const REPRODUCE: &str = "\
Examples:
  metal reproduce --quick --seeds 1
  metal reproduce --seeds 10 --out runs/ten
  metal reproduce --set phase.attention.budget.steps=360000 --set attention.acl.counterfactual.iterations=72

The folder gets report.html (open it first), results.json, records.csv (one row per test run),
plan.toml (the experiment as it was run), run.json and the trained minds. The same seed gives the
same numbers on any number of threads. Until the run is finished, every finished piece of it is in
checkpoint/, and --resume goes on from there.";

const FAULTS: &str = "\
Examples:
  metal faults                                       the paper's policies, every fault, 5 trainings
  metal faults --fault nan dead --rate 0.5 1         two faults at two rates
  metal faults experiments/paper.toml --policy acl_decision foa --out runs/faults

The folder gets faults.json, faults.md (the tables) and drawings. Faults are data in an experiment, too:
  [environment.faulty]
  world = { highway = { scenario = \"mix\" } }
  faults = { fault = { noisy = 0.15 }, rate = 0.25, sensors = [\"MN\", \"IR\"] }";

const RUN: &str = "\
Examples:
  metal run experiments/toy.toml
  metal run experiments/paper.toml --set phase.fusion.budget.episodes=100 --out runs/short
  metal run my.toml --set 'phase.fusion.acting={ fusion = \"log_opinion_pool\" }'
  metal run my.toml --record policy.acl=tests.mcap --record phase.fusion=learning.mcap
  metal run my.toml --demonstrations robot.mcap

Start from a copy of experiments/paper.toml; `metal list` names what can stand in it. A mistake is
answered with file, line, field and what is allowed. With --set, a table that holds one choice, such
as budget or acting, is replaced as a whole.";

const EVAL: &str = "\
Examples:
  metal eval --run runs/reproduce
  metal eval --run runs/reproduce --roads validation --runs 20
  metal eval --run runs/reproduce --road-seed 7 --road-seed 8

Nothing is learned and nothing is written.";

const STUDIO: &str = "\
Examples:
  metal studio --open                        the paper's experiment: watch, demonstrate, train
  metal studio --run runs/reproduce          the trained minds of a run
  metal studio --experiment my.toml --out runs/mine
  metal studio --run runs/reproduce --robot epuck2://192.168.1.10
  ssh -L 8471:localhost:8471 robot metal studio --port 8471

Prints an address with a secret token; open it in any browser. What is demonstrated or learned goes
to the run folder and nowhere else, to be learned from:
  metal run my.toml --demonstrations runs/mine/demonstrations/0001.jsonl
Ctrl-C saves what was demonstrated and ends.";

const BENCH: &str = "\
Examples:
  metal bench maze
  metal bench cube --steps 30000 --seeds 10 --json > cube.json
  metal bench maze --settings '{\"side\": 6}'

Tasks: highway, maze, puddle, toy, cube, cube_nm. Every row learns from as many motor steps, on the
same seeds, and is tested on the same episodes.";

const CHECK: &str = "\
Examples:
  metal check maze
  metal check maze --settings '{\"look_price\": 5.0}'
  metal check patients.csv --target ill --prices prices.toml

Drives the task blindly and at random, and learns it once with every sensor alone and once with all.
Nothing is written.";

const TABULAR: &str = "\
Examples:
  metal tabular patients.csv --target ill
  metal tabular patients.csv --target ill --prices prices.toml --steps 30000

prices.toml (everything may be left out):
  default = 0.02                       # price of a column that is in no group
  test_share = 0.25                    # rows kept for the test
  verdict = { right = 0.0, wrong = -1.0 }
  [group.blood]
  columns = [\"iron\", \"sugar\"]
  price = 0.2

An empty cell, NA, NaN, null or ? is a missing value, and is told apart from every number.";

const ALIASING: &str = "\
Examples:
  metal aliasing --q 4 --k 4 --actions 4     the second row of Table 3
  metal aliasing --q 10 --k 2 --actions 5 --json";

const COMPLETIONS: &str = "\
Examples:
  metal completions bash > ~/.local/share/bash-completion/completions/metal
  metal completions zsh > ~/.zfunc/_metal
  metal completions fish > ~/.config/fish/completions/metal.fish";

/// How results are printed.
#[derive(Debug, Args)]
pub struct Printing {
    /// Print the results as JSON instead of a table
    #[arg(long)]
    pub json: bool,
}

/// What becomes of a run that is in the folder already.
#[derive(Debug, Args)]
pub struct Keeping {
    /// Go on with the run in the folder that was stopped or killed; the numbers are those of a run in one go
    #[arg(long)]
    pub resume: bool,
    /// Replace the run in the folder
    #[arg(long, conflicts_with = "resume")]
    pub force: bool,
    /// While a phase is learned, save it this often (0: after every episode)
    #[arg(long, default_value_t = 30, value_name = "SECONDS")]
    pub save_every: u32,
}

impl Keeping {
    /// The wish in the lab's words.
    pub fn start(&self) -> Start {
        match (self.resume, self.force) {
            (true, _) => Start::Resume,
            (_, true) => Start::Force,
            _ => Start::Fresh,
        }
    }
}

/// Options common to everything that trains.
#[derive(Debug, Args)]
pub struct Training {
    /// Independent trainings, the source of every interval (with --quick at most 2)
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=MOST_SEEDS as i64))]
    pub seeds: u32,
    /// The one number all randomness comes from
    #[arg(long, default_value_t = 1, value_name = "N")]
    pub seed: u64,
    /// Cut every budget so far that the numbers only show that everything works
    #[arg(long)]
    pub quick: bool,
    /// Train and test every subset of sensors, not only those that the experiment names or grows
    #[arg(long)]
    pub all_subsets: bool,
    /// Override a field of the experiment: dotted key = TOML value; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    #[command(flatten)]
    pub keeping: Keeping,
    /// When the run is finished, write what its first training saw, attended to, believed, did and paid to FILE.mcap: all
    /// phases, or phase.NAME=FILE.mcap, or the tests of policy.NAME=FILE.mcap; N.phase.NAME=… is training N's, and
    /// run=FILE.mcap is all of all trainings; may be repeated
    #[arg(long, value_name = "FILE")]
    pub record: Vec<Wish>,
    /// Episodes of each phase or policy to record (0: all)
    #[arg(long, default_value_t = 100, value_name = "N", requires = "record")]
    pub record_episodes: u32,
    #[command(flatten)]
    pub printing: Printing,
    /// Threads (0: one per core); results do not depend on it
    #[arg(long, default_value_t = 0, value_name = "N", value_parser = clap::value_parser!(u16).range(..=1024))]
    pub threads: u16,
}

/// `metal reproduce`
#[derive(Debug, Args)]
pub struct Reproduce {
    /// Folder for report, results, records and minds
    #[arg(long, default_value = "runs/reproduce")]
    pub out: PathBuf,
    #[command(flatten)]
    pub training: Training,
}

/// `metal run`
#[derive(Debug, Args)]
pub struct Run {
    /// The experiment file (TOML)
    pub file: PathBuf,
    /// What somebody showed (in `metal studio`, or a recording by `metal drive --demonstrate`) instead of the expert in
    /// Phase I
    #[arg(long, value_name = "FILE")]
    pub demonstrations: Option<PathBuf>,
    /// Folder for report, results, records and minds
    #[arg(long, default_value = "runs/run")]
    pub out: PathBuf,
    #[command(flatten)]
    pub training: Training,
}

/// `metal studio`
#[derive(Debug, Args)]
pub struct Studio {
    /// The experiment file to open (the paper's if nothing is said)
    #[arg(long, value_name = "FILE")]
    pub experiment: Option<PathBuf>,
    /// The folder of a finished run: its trained minds can drive
    #[arg(long, value_name = "DIR", conflicts_with_all = ["experiment", "out"])]
    pub run: Option<PathBuf>,
    /// Folder for demonstrations and minds of an experiment
    #[arg(long, value_name = "DIR", default_value = "runs/studio")]
    pub out: PathBuf,
    /// Override a field of the experiment, as in `metal run`; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE", conflicts_with = "run")]
    pub set: Vec<String>,
    /// Record every step of a training that is started from the page (MCAP; a new file)
    #[arg(long, value_name = "FILE", conflicts_with = "robot")]
    pub record: Option<PathBuf>,
    /// Watch a body that the run's minds drive: epuck:///dev/rfcomm0, epuck2://HOST:PORT or webots://HOST:PORT/NAME
    #[arg(long, value_name = "ADDRESS", requires = "run")]
    pub robot: Option<metal_robots::Address>,
    /// A file that `metal calibrate` wrote
    #[arg(long, value_name = "FILE", requires = "robot")]
    pub calibration: Option<PathBuf>,
    /// The body is on the road grown from this seed, and a supervisor may place and judge it
    #[arg(long, value_name = "N", requires = "robot")]
    pub road_seed: Option<u64>,
    /// Port (0: one that is free)
    #[arg(long, default_value_t = 0, value_name = "N")]
    pub port: u16,
    /// Address to listen on; anything but this machine lets others in who have the token
    #[arg(long, default_value = "127.0.0.1", value_name = "ADDRESS")]
    pub bind: std::net::IpAddr,
    /// The one number all randomness of the stage comes from
    #[arg(long, default_value_t = 1, value_name = "N")]
    pub seed: u64,
    /// Keep the address from session to session, so that open pages find a restarted studio (token in the folder)
    #[arg(long)]
    pub keep_token: bool,
    /// Open the page in the browser of this desktop
    #[arg(long)]
    pub open: bool,
}

/// `metal eval`
#[derive(Debug, Args)]
pub struct Eval {
    /// A folder that `metal reproduce` or `metal run` wrote
    #[arg(long)]
    pub run: PathBuf,
    /// Roads to drive on (test roads if nothing is said)
    #[arg(long, value_parser = ["training", "validation", "test"], conflicts_with = "road_seed")]
    pub roads: Option<String>,
    /// Roads grown from these seeds instead; may be repeated
    #[arg(long, num_args = 1.., value_name = "N")]
    pub road_seed: Vec<u64>,
    /// Runs per scenario and training
    #[arg(long, default_value_t = 100, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000_000))]
    pub runs: u32,
    /// Print JSON instead of a table
    #[arg(long)]
    pub json: bool,
}

/// How much is compared.
#[derive(Debug, Args)]
pub struct Comparing {
    /// Motor steps of learning of every row; of METAL's a third is fusion if attention asks what members support
    #[arg(long, default_value_t = 60_000, value_name = "N", value_parser = clap::value_parser!(u32).range(3..=100_000_000))]
    pub steps: u32,
    /// Independent trainings of every row
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=MOST_SEEDS as i64))]
    pub seeds: u32,
    /// The one number all randomness comes from
    #[arg(long, default_value_t = 1, value_name = "N")]
    pub seed: u64,
    /// Test episodes per training
    #[arg(long, default_value_t = 100, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    pub episodes: u32,
    /// Screen every subset of up to this many sensors; beyond, the best subset grows by one sensor at a time
    #[arg(long, default_value_t = 6, value_name = "SENSORS", value_parser = clap::value_parser!(u8).range(0..=12))]
    pub exhaustive: u8,
    /// How to learn, in JSON: fields of a recipe that differ from its defaults
    #[arg(long, default_value = "{}", value_name = "JSON")]
    pub recipe: String,
    /// Threads (0: one per core); results do not depend on it
    #[arg(long, default_value_t = 0, value_name = "N", value_parser = clap::value_parser!(u16).range(..=1024))]
    pub threads: u16,
    /// Print JSON instead of the table
    #[arg(long)]
    pub json: bool,
}

/// `metal check`
#[derive(Debug, Args)]
pub struct Check {
    /// Name of the task; with --target, a table: CSV with a header
    pub task: String,
    /// Settings of its world in JSON, as in an experiment file
    #[arg(long, default_value = "{}", value_name = "JSON")]
    pub settings: String,
    /// Name of the column to be named, in a table
    #[arg(long, value_name = "COLUMN", conflicts_with = "settings")]
    pub target: Option<String>,
    /// What columns and groups of columns of the table cost (TOML)
    #[arg(long, value_name = "FILE", requires = "target")]
    pub prices: Option<PathBuf>,
    /// Motor steps from which everybody who sees something learns
    #[arg(long, default_value_t = 10_000, value_name = "N", value_parser = clap::value_parser!(u32).range(3..=100_000_000))]
    pub steps: u32,
    /// Episodes of every drive
    #[arg(long, default_value_t = 100, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    pub episodes: u32,
    /// The one number all randomness comes from
    #[arg(long, default_value_t = 1, value_name = "N")]
    pub seed: u64,
    /// Print JSON instead of text
    #[arg(long)]
    pub json: bool,
}

/// `metal bench`
#[derive(Debug, Args)]
pub struct Bench {
    /// Name of the task
    pub task: String,
    /// Settings of its world in JSON, as in an experiment file
    #[arg(long, default_value = "{}", value_name = "JSON")]
    pub settings: String,
    #[command(flatten)]
    pub comparing: Comparing,
}

/// `metal tabular`
#[derive(Debug, Args)]
pub struct Tabular {
    /// The table: CSV with a header
    pub file: PathBuf,
    /// Name of the column to be named
    #[arg(long, value_name = "COLUMN")]
    pub target: String,
    /// What columns and groups of columns cost (TOML)
    #[arg(long, value_name = "FILE")]
    pub prices: Option<PathBuf>,
    #[command(flatten)]
    pub comparing: Comparing,
}

/// `metal aliasing`
#[derive(Debug, Args)]
pub struct Aliasing {
    /// Quantisation level of the decision space, q
    #[arg(long)]
    pub q: usize,
    /// Number of physical states that a tiny agent cannot tell apart, k
    #[arg(long)]
    pub k: usize,
    /// Number of motor actions, |A|
    #[arg(long)]
    pub actions: usize,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}
