//! `metal bench TASK`: what every claim about attention on a task needs, trained with equal budgets over several seeds:
//! blind, a random subset, the best fixed subset, all sensors, fusion, and METAL.

mod check;
mod clock;
mod front;
mod print;
mod problems;
mod rows;
mod search;
mod subset;

pub use check::{Check, CheckOptions, Constant, SensorCheck, check, planned_check_steps};
pub use front::{Front, Point};
pub use print::text;
pub use problems::check_text;
pub use rows::ROWS;
pub use search::Static;

use crate::progress::Progress;
use crate::task::{Recipe, Score, Task};
use crate::train::RunError;
use metal_rl::measure::statistics::{Bootstrap, Estimate, interquartile_mean};
use metal_rl::random::Streams;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// How much is compared.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BenchOptions {
    /// Independent trainings of every row.
    pub seeds: usize,
    /// The one number all randomness comes from.
    pub seed: u64,
    /// Test episodes per training.
    pub episodes: usize,
    /// Share of the budget with which a subset is screened.
    pub screening_share: f64,
    /// Up to this many sensors every subset is screened; beyond, the best subset grows by one sensor at a time.
    pub exhaustive: usize,
    /// Factors on the prices at which METAL is trained once more, for the front of return against cost.
    pub price_factors: Vec<f64>,
}

impl Default for BenchOptions {
    fn default() -> Self {
        Self {
            seeds: 5,
            seed: 1,
            episodes: 100,
            screening_share: 0.1,
            exhaustive: 6,
            price_factors: vec![0.25, 4.0],
        }
    }
}

/// Largest number of sensors whose subsets can all be screened (2^12 of them).
const MOST_EXHAUSTIVE: usize = 12;

impl BenchOptions {
    /// Refuses what cannot be carried out.
    ///
    /// # Errors
    /// The first impossible field, with what is allowed.
    pub fn check(&self) -> Result<(), crate::plan::PlanError> {
        use crate::plan::{PlanError, limits};
        limits::count("seeds", self.seeds, "trainings")?;
        limits::count("episodes", self.episodes, "episodes")?;
        limits::part("screening_share", self.screening_share)?;
        if self.exhaustive > MOST_EXHAUSTIVE {
            let message = format!("{}: at most {MOST_EXHAUSTIVE} sensors", self.exhaustive);
            return Err(PlanError::at("exhaustive", message));
        }
        match self.price_factors.iter().find(|f| !(f.is_finite() && **f >= 0.0)) {
            Some(f) => Err(PlanError::at("price_factors", format!("{f}: finite and at least 0"))),
            None => Ok(()),
        }
    }
}

/// One line of the comparison. Numbers are per episode; intervals are over trainings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Motor reward minus prices: interquartile mean over trainings, 95 % bootstrap interval.
    pub total: Estimate,
    /// Motor reward alone.
    pub motor: Estimate,
    /// Prices paid (≥ 0).
    pub cost: Estimate,
    /// Sensors read per motor step.
    pub looks: Estimate,
    /// Seconds of processor time of one training and its test, searches included, mean over trainings.
    pub cpu_secs: f64,
    /// What was read: the best fixed subset, or how it was drawn.
    pub remark: String,
    /// Every training.
    pub scores: Vec<Score>,
}

impl Row {
    fn new(scores: Vec<Score>, cpu_secs: f64, remark: String) -> Self {
        Self {
            total: estimate(&scores, Score::total),
            motor: estimate(&scores, Score::mean_motor),
            cost: estimate(&scores, Score::mean_price),
            looks: estimate(&scores, Score::looks_per_step),
            cpu_secs,
            remark,
            scores,
        }
    }
}

/// Interquartile mean over trainings; trainings are what is resampled.
fn estimate(scores: &[Score], number: impl Fn(&Score) -> f64) -> Estimate {
    let values: Vec<f64> = scores.iter().map(number).collect();
    let statistic = |v: &[f64]| interquartile_mean(v).unwrap_or(f64::NAN);
    Bootstrap::default().estimate(&[&values], statistic).unwrap_or(Estimate::point(f64::NAN, 0))
}

/// The whole comparison.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bench {
    /// Name of the world.
    pub task: String,
    /// Names of its sensors.
    pub sensors: Vec<String>,
    /// How everybody learned.
    pub recipe: Recipe,
    /// How much was compared.
    pub options: BenchOptions,
    /// The lines, by name ([`ROWS`] says in which order).
    pub rows: BTreeMap<String, Row>,
    /// Fixed subsets that were screened.
    pub statics: Vec<Static>,
    /// Return against cost.
    pub front: Front,
    /// What a reader must know before believing anything.
    pub warnings: Vec<String>,
}

/// Compares everybody on `task`.
///
/// # Errors
/// If recipe, options or task are impossible, the world fails, or the user interrupts.
pub fn bench(
    task: &dyn Task,
    recipe: &Recipe,
    options: &BenchOptions,
    progress: &dyn Progress,
) -> Result<Bench, RunError> {
    recipe.check()?;
    options.check()?;
    let world = task.training()?;
    let (spec, recipe) = (world.spec().clone(), &recipe.clone().for_task(task, world.as_ref()));
    drop(world);
    let streams = Streams::new(options.seed);
    let desk = rows::Desk { task, spec: &spec, recipe, options, streams, progress };
    let (rows, statics) = desk.rows()?;
    let extra = desk.at_other_prices()?;
    let front = front::front(&rows, &statics, &extra);
    let warnings = warnings(&rows);
    Ok(Bench {
        task: spec.id.clone(),
        sensors: spec.sensors.iter().map(|s| s.name.clone()).collect(),
        recipe: recipe.clone(),
        options: options.clone(),
        rows,
        statics,
        front,
        warnings,
    })
}

/// Motor steps of learning that [`bench()`] will make, at least: growing a subset may take more rounds.
#[must_use]
pub fn planned_steps(recipe: &Recipe, options: &BenchOptions, sensors: usize) -> usize {
    let trained = (5 + options.price_factors.len()) * options.seeds * recipe.steps();
    let subsets = if sensors <= options.exhaustive { (1 << sensors) - 1 } else { 2 * sensors };
    trained + (subsets as f64 * recipe.steps() as f64 * options.screening_share) as usize
}

/// A blind driver this close to the full observer says that there is nothing to see.
const NOTHING_TO_SEE: f64 = 0.05;

fn warnings(rows: &BTreeMap<String, Row>) -> Vec<String> {
    let (blind, all) = (rows[rows::BLIND].motor.mean, rows[rows::ALL].motor.mean);
    let scale = blind.abs().max(all.abs());
    let mut warnings = Vec::new();
    if all - blind <= NOTHING_TO_SEE * scale {
        warnings.push(format!(
            "this task does not need attention: without a look {blind:.3}, with all sensors {all:.3}"
        ));
    }
    if rows[rows::METAL].scores.len() < 5 {
        warnings.push("fewer than 5 trainings: intervals mean little".to_owned());
    }
    warnings
}
