//! The best fixed subset of sensors, screened with a share of the budget.

use super::rows::{Desk, names};
use super::subset::train_subset;
use crate::task::Score;
use crate::train::RunError;
use metal_rl::set::IndexSet;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// A screened subset.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Static {
    /// Its sensors.
    pub sensors: IndexSet,
    /// Their names.
    pub name: String,
    /// How it did in the world of learning.
    pub score: Score,
}

/// Screens subsets with a share of the budget: all of them where there are few sensors; otherwise all single ones,
/// then from the best on one more sensor at a time for as long as that pays.
pub(super) fn search(desk: &Desk<'_>) -> Result<Vec<Static>, RunError> {
    let n = desk.spec.sensors.len();
    if n <= desk.options.exhaustive {
        return screen(desk, &(1..1_u64 << n).map(IndexSet::from_bits).collect::<Vec<_>>());
    }
    let mut screened: Vec<Static> = Vec::new();
    let mut best = IndexSet::EMPTY;
    while best.len() < n {
        let larger: Vec<IndexSet> = IndexSet::first(n).minus(best).iter().map(|s| best.with(s)).collect();
        let found = screen(desk, &larger)?;
        let top = found.iter().max_by(|a, b| a.score.total().total_cmp(&b.score.total()));
        let top = top.map(|s| (s.sensors, s.score.total()));
        let before = screened.iter().map(|s| s.score.total()).fold(f64::NEG_INFINITY, f64::max);
        screened.extend(found);
        match top {
            Some((sensors, total)) if total > before => best = sensors,
            _ => break,
        }
    }
    Ok(screened)
}

/// Learns each of `subsets` with the screening share of the budget, and tries it in the world of learning.
pub(super) fn screen(desk: &Desk<'_>, subsets: &[IndexSet]) -> Result<Vec<Static>, RunError> {
    let one = |&sensors: &IndexSet| {
        let streams = desk.streams.child("screening");
        let mut student = train_subset(desk, sensors, desk.options.screening_share, &streams)?;
        let mut world = desk.task.training()?;
        let score = student.drive(world.as_mut(), (desk.options.episodes, &streams.child("validation")))?;
        Ok(Static { sensors, name: names(desk.spec, sensors), score })
    };
    if desk.progress.interrupted() {
        return Err(RunError::Interrupted);
    }
    if desk.task.is_parallel() {
        return subsets.par_iter().map(one).collect();
    }
    subsets.iter().map(one).collect()
}
