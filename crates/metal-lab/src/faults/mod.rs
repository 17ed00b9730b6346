//! `metal faults`: what broken sensors and changed worlds cost, for every policy of an experiment that is asked about.
//!
//! Five questions. Trained with sound sensors, tested with broken ones: cost and accidents against the rate of faults.
//! Trained and tested with broken ones. A sensor that breaks and is mended within an episode, nobody learning: does the
//! policy stop looking there, and does it come back? The same over hundreds of episodes while the mind learns on. A world
//! that changes while the mind learns on (the claims of Sec. 6.2): other roads, other positions and speeds of the cars,
//! exchanged expertise of two tiny agents.

mod change;
mod comeback;
mod desk;
mod draw;
mod favourite;
mod interruption;
mod print;

pub use change::Change;
pub use comeback::{Block, Comeback};
pub use draw::draw;
pub use interruption::{Interruption, Spell};
pub use print::text;

use crate::plan::{Plan, PlanError, limits};
use crate::progress::Progress;
use crate::train::RunError;
use desk::Desk;
use metal_rl::measure::statistics::Estimate;
use metal_worlds::faulty::Fault;
use serde::{Deserialize, Serialize};

/// How much is tried.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FaultOptions {
    /// Independent trainings.
    pub seeds: usize,
    /// The one number all randomness comes from.
    pub seed: u64,
    /// Policies of the experiment that are tried; the looks of those that choose them are followed through faults.
    pub policies: Vec<String>,
    /// Faults of the tests.
    pub faults: Vec<Fault>,
    /// Probabilities that a sensor fails in an episode.
    pub rates: Vec<f64>,
    /// Test episodes of each training and cell.
    pub runs: usize,
    /// Faults that trainings of their own begin and end with, at [`Self::training_rate`].
    pub trained_with: Vec<Fault>,
    /// Rate of faults in those trainings.
    pub training_rate: f64,
    /// Faults through which looks are followed: within an episode, and, of the first policy that can learn on, over many.
    pub followed: Vec<Fault>,
    /// Episodes of learning before, during and after such a fault, and after a change of the world.
    pub lasting: usize,
}

impl Default for FaultOptions {
    fn default() -> Self {
        Self {
            seeds: 5,
            seed: 1,
            policies: ["acl", "acl_phase3", "foa", "fusion"].map(str::to_owned).to_vec(),
            faults: Fault::ALL.to_vec(),
            rates: vec![0.1, 0.25, 0.5, 1.0],
            runs: 20,
            trained_with: vec![Fault::Nan, Fault::Noisy(0.15)],
            training_rate: 0.25,
            followed: vec![Fault::Nan, Fault::Dead],
            lasting: 300,
        }
    }
}

impl FaultOptions {
    /// Refuses what cannot be tried on `plan`.
    ///
    /// # Errors
    /// The first impossible field, with what is allowed.
    pub fn check(&self, plan: &Plan) -> Result<(), PlanError> {
        limits::count("seeds", self.seeds, "trainings")?;
        limits::count("runs", self.runs, "episodes")?;
        limits::count("lasting", self.lasting, "episodes")?;
        if self.policies.is_empty() {
            return Err(PlanError::at("policies", "none: at least one policy of the experiment"));
        }
        for name in &self.policies {
            let row = plan.file.policy.get(name);
            if row.is_none_or(|row| row.after.is_none()) {
                let message = format!("`{name}`: policies of the experiment that were trained in a phase");
                return Err(PlanError::at("policies", message));
            }
        }
        match self.rates.iter().chain([&self.training_rate]).find(|r| !(0.0..=1.0).contains(*r)) {
            Some(rate) => Err(PlanError::at("rates", format!("{rate}: in [0, 1]"))),
            None => Ok(()),
        }
    }
}

/// What one policy cost under one fault at one rate, per motor step; intervals are over trainings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cell {
    /// Name of the policy.
    pub policy: String,
    /// Name of the fault; none: sound sensors.
    pub fault: Option<String>,
    /// Probability that a sensor fails in an episode.
    pub rate: f64,
    /// Whether the training had the same fault at its own rate.
    pub trained_with_it: bool,
    /// Motor reward minus prices.
    pub total: Estimate,
    /// Motor reward alone.
    pub motor: Estimate,
    /// Sensors read per motor step.
    pub looks: Estimate,
    /// Share of episodes with an accident.
    pub accidents: Estimate,
}

/// Everything that was found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FaultReport {
    /// Title of the experiment.
    pub title: String,
    /// How much was tried.
    pub options: FaultOptions,
    /// Tests.
    pub cells: Vec<Cell>,
    /// A sensor breaks and is mended within an episode.
    pub interruptions: Vec<Interruption>,
    /// A sensor breaks and is mended while a mind learns on.
    pub comebacks: Vec<Comeback>,
    /// The world changes.
    pub changes: Vec<Change>,
}

impl FaultReport {
    /// The cell of `policy` trained with sound sensors, under `fault` at `rate`.
    #[must_use]
    pub fn cell(&self, policy: &str, fault: Option<&str>, rate: f64) -> Option<&Cell> {
        let same = |c: &&Cell| {
            c.policy == policy
                && c.fault.as_deref() == fault
                && c.rate.total_cmp(&rate).is_eq()
                && !c.trained_with_it
        };
        self.cells.iter().find(same)
    }
}

/// Tries everything. The same plan and options give the same report, whatever the number of threads.
///
/// # Errors
/// If options do not fit the plan, a world fails, or the user interrupts.
pub fn run(plan: &Plan, options: &FaultOptions, progress: &dyn Progress) -> Result<FaultReport, RunError> {
    options.check(plan)?;
    let desk = Desk::new(plan, options, progress)?;
    progress.stage("training with sound sensors");
    let minds = desk.train(None)?;
    progress.stage("testing with broken sensors");
    let mut cells = desk.test_all(&minds)?;
    progress.stage("training with broken sensors");
    for &fault in &options.trained_with {
        cells.extend(desk.trained_with(fault)?);
    }
    progress.stage("a sensor breaks and is mended");
    let interruptions = interruption::all(&desk, &minds)?;
    let mut comebacks = Vec::new();
    for &fault in &options.followed {
        comebacks.extend(comeback::follow(&desk, &minds, fault)?);
    }
    progress.stage("the world changes");
    let changes = change::all(&desk, &minds)?;
    let (title, options) = (plan.file.title.clone(), options.clone());
    Ok(FaultReport { title, options, cells, interruptions, comebacks, changes })
}

/// About how many motor steps [`run`] will simulate, for a progress bar.
///
/// # Errors
/// If options do not fit the plan.
pub fn planned_steps(plan: &Plan, options: &FaultOptions) -> Result<usize, RunError> {
    options.check(plan)?;
    let pupils = desk::pupils(plan, &options.policies)?;
    let training: usize = pupils.order.iter().map(|name| pupils.budget_steps(name)).sum();
    let trainings = training * (1 + options.trained_with.len());
    let tests = options.policies.len()
        * (1 + options.faults.len() * options.rates.len() + 2 * options.trained_with.len() + 8)
        * options.runs;
    // Everybody who may choose looks drives three episodes' length twice, and once to show its favourite.
    let interrupted = 7 * options.followed.len() * options.policies.len() * options.runs;
    let lasting = options.lasting * (3 * options.followed.len() + 4 * options.policies.len());
    Ok(options.seeds * (trainings + pupils.spec.horizon * (tests + interrupted + lasting)))
}
