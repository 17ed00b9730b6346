//! What a run has learned that is not finished, or was killed: to look at, without taking part in it.

use super::ledger::{chapter_of_training, read_finished, read_underway};
use super::shelf::Shelf;
use super::{JOB, Job};
use crate::mind::Mind;
use crate::plan::Plan;
use crate::store::{Store, StoreError};

/// A run with a checkpoint and no end.
#[derive(Debug)]
pub struct Unfinished {
    /// The experiment, as it was begun.
    pub plan: Plan,
    shelf: Shelf,
    seeds: usize,
}

/// A mind in a checkpoint.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Learned {
    /// Which training.
    pub seed: usize,
    /// The phase that it has finished, or is in.
    pub phase: String,
    /// Whether it has finished it.
    pub whole: bool,
}

impl Unfinished {
    /// The unfinished run in the folder of `store`, if there is one.
    ///
    /// # Errors
    /// If its description is damaged or says what cannot be.
    pub fn open(store: &Store) -> Result<Option<Self>, StoreError> {
        let folder = store.path("checkpoint");
        let path = folder.join(JOB);
        if !path.is_file() {
            return Ok(None);
        }
        let job = Job::read(&path)?;
        let damaged = |reason: String| StoreError::Damaged { path: path.clone(), reason };
        let key = job.key().map_err(|e| damaged(e.to_string()))?;
        let seeds = job.seeds();
        let plan = Plan::check(job.into_plan()).map_err(|e| damaged(e.to_string()))?;
        Ok(Some(Self { plan, shelf: Shelf { folder, key }, seeds }))
    }

    /// Minds that are there: training by training, phases in their order.
    #[must_use]
    pub fn learned(&self) -> Vec<Learned> {
        let places = (0..self.seeds).flat_map(|seed| self.plan.order.iter().map(move |phase| (seed, phase)));
        let found = places.filter_map(|(seed, phase)| {
            let (whole, drafts) = chapter_of_training(seed, phase);
            let there = |piece: &String| self.shelf.path(piece).is_file();
            let whole = there(&whole);
            let any = whole || drafts.iter().any(there);
            any.then(|| Learned { seed, phase: phase.clone(), whole })
        });
        found.collect()
    }

    /// The mind that was kept.
    ///
    /// # Errors
    /// If its file is damaged, or gone because the run went on.
    pub fn mind(&self, learned: &Learned) -> Result<Mind, StoreError> {
        let (whole, drafts) = chapter_of_training(learned.seed, &learned.phase);
        let (path, frozen) = if learned.whole {
            (self.shelf.path(&whole), read_finished(&self.shelf, &whole)?)
        } else {
            (self.shelf.path(&drafts[0]), read_underway(&self.shelf, &drafts)?)
        };
        let damaged = |reason: String| StoreError::Damaged { path: path.clone(), reason };
        let frozen =
            frozen.ok_or_else(|| damaged("gone: the run went on, open its folder again".to_owned()))?;
        Mind::thaw(&self.plan, &frozen).map_err(|e| damaged(e.to_string()))
    }
}
