//! `metal ceiling`: what the sensors of a task allow, for every fixed choice of looks and for looks by need.
//!
//! Two answers from two sides, for every subset of members at every rhythm:
//!
//! **The ceiling.** A driver that sees everything, taught by the plan's own recipe, drives and keeps a log: at every motor
//! step the readings of all members, and what *every* motor action would have been worth, judged by roll-outs in copies
//! of the world. On that log one network without memory and one with memory learn what to do for any set of readings; then
//! any way of looking can be replayed, because looks move nothing. Its motor cost = what the driver's own moves cost +
//! what is lost per step by the moves that can be told from these looks. By the performance-difference lemma (Kakade and
//! Langford 2002) this is the true cost per step *if* the moments are those that this way of looking leads to. They are
//! not: they are the driver's own, with some moves left to chance. So it is a **one-step ceiling**,
//!
//! * *optimistic about drift*: one move is judged, then somebody drives on who sees everything. Whoever sees less gets more
//!   often to where it is dangerous, and is not helped there. Where drift is what looks prevent, this can be most of the
//!   cost, and the ceiling of looking at nobody is then close to that of everybody;
//! * *pessimistic about adaptation*: whoever knows how little it sees may keep away from where more must be seen; the
//!   driver, who sees everything, does not;
//! * *only as good as its network*: another reader of the same readings may read more out of them.
//!
//! Three shares of the log keep it honest: one is learned from, one chooses among subsets, rhythms and students, one
//! judges; they take turns.
//!
//! **The floor.** Universal students, one without memory and one with, learn all fixed choices of looks at once, each where
//! it leads to and under its own continuation (`own`), and are put at the wheel. What they cost the sensors surely allow.
//!
//! In the order of the data: `subject` → `driver` → `log` → `lesson` → `replay` → `rows`, and `own` → `wheel`. Not in the
//! paper: it asks what its introduction leaves open, whether attention *can* beat "a fixed subset".

mod draw;
mod driver;
mod lesson;
mod log;
mod options;
mod own;
mod print;
mod replay;
mod report;
mod rows;
mod situation;
mod subject;
#[cfg(test)]
mod tests;
mod trial;
mod wheel;

pub use draw::draw;
pub use options::CeilingOptions;
pub use print::text;
pub use report::{CeilingReport, Driven, Learned, Line, Log, Place, Point, Ratio, learned};

use crate::plan::Plan;
use crate::progress::Progress;
use crate::train::RunError;
use metal_rl::random::Streams;
use subject::Subject;

/// Measures everything. The same plan and options give the same report, whatever the number of threads.
///
/// # Errors
/// If options do not fit the plan, its world cannot be copied or fails, or the user interrupts.
pub fn run(
    plan: &Plan,
    options: &CeilingOptions,
    progress: &dyn Progress,
) -> Result<CeilingReport, RunError> {
    options.check()?;
    let subject = Subject::new(plan, options)?;
    let streams = Streams::new(options.seed).child("ceiling");
    let trials: Vec<trial::Trial> = (0..options.seeds)
        .map(|seed| trial::run(&subject, options, &streams.nth(seed as u64), progress))
        .collect::<Result<_, RunError>>()?;
    Ok(report::write(&subject, options, &trials))
}

/// About how many motor steps [`run`] will simulate, for a progress bar.
///
/// # Errors
/// If options do not fit the plan.
pub fn planned_steps(plan: &Plan, options: &CeilingOptions) -> Result<usize, RunError> {
    options.check()?;
    Ok(Subject::new(plan, options)?.planned_steps(options))
}
