//! Where pieces of work are kept and looked up, chapter by chapter; or nowhere, for those who need no memory.

use super::Checkpoint;
use super::shelf::Shelf;
use crate::mind::{FrozenMind, Mind};
use crate::plan::Plan;
use crate::progress::Progress;
use crate::store::StoreError;
use crate::trace::{EpisodeRecord, Trace};
use crate::train::{RunError, Trained};
use metal_rl::counterfactual::Iterate;
use metal_rl::run::Position;
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use std::time::{Duration, Instant};

/// A chapter of a checkpoint, and who is told how far the work is.
#[derive(Clone)]
pub struct Ledger<'a> {
    checkpoint: Option<&'a Checkpoint>,
    progress: &'a dyn Progress,
    chapter: String,
}

/// A finished phase.
#[derive(Serialize, Deserialize)]
struct Finished {
    mind: FrozenMind,
    episodes: Vec<EpisodeRecord>,
    diary: Vec<Iterate>,
}

/// A phase on its way.
#[derive(Serialize, Deserialize)]
struct Underway {
    mind: FrozenMind,
    episodes: Vec<EpisodeRecord>,
    at: Position,
    course: Option<Vec<u8>>,
    /// How often the phase was saved before.
    nth: usize,
}

/// A phase as it goes on: newborn, or from where it was saved.
pub(crate) struct Draft {
    /// The minds.
    pub mind: Mind,
    /// What happened so far.
    pub trace: Trace,
    /// How many episodes it is on its way.
    pub at: Position,
    /// How many iterations it is on its way, with all that they left behind; only in counterfactual policy iteration.
    pub course: Option<Vec<u8>>,
    /// How often it was saved.
    pub saved: usize,
}

impl Draft {
    /// A phase at its beginning.
    pub fn newborn(mind: Mind, trace: Trace) -> Self {
        Self { mind, trace, at: Position::default(), course: None, saved: 0 }
    }
}

impl<'a> Ledger<'a> {
    /// Nothing is kept.
    #[must_use]
    pub fn none(progress: &'a dyn Progress) -> Self {
        Self { checkpoint: None, progress, chapter: String::new() }
    }

    /// Everything is kept.
    #[must_use]
    pub fn new(checkpoint: &'a Checkpoint, progress: &'a dyn Progress) -> Self {
        Self { checkpoint: Some(checkpoint), progress, chapter: String::new() }
    }

    /// The chapter `name` of this one.
    #[must_use]
    pub fn chapter(&self, name: &str) -> Self {
        Self { chapter: self.name(name), ..self.clone() }
    }

    /// Who is told how far the work is.
    #[must_use]
    pub fn progress(&self) -> &'a dyn Progress {
        self.progress
    }

    fn name(&self, piece: &str) -> String {
        if self.chapter.is_empty() { piece.to_owned() } else { format!("{}/{piece}", self.chapter) }
    }

    /// What was kept; a file that cannot be used is as good as none, but is not passed over in silence.
    fn recall<T: DeserializeOwned>(&self, piece: &str) -> Option<T> {
        match self.checkpoint?.shelf.recall(&self.name(piece)) {
            Ok(found) => found,
            Err(e) => {
                self.progress.warn(&format!("{e}; its work is done again"));
                None
            }
        }
    }

    fn keep<T: Serialize>(&self, piece: &str, what: &T) -> Result<(), RunError> {
        let Some(checkpoint) = self.checkpoint else { return Ok(()) };
        checkpoint.shelf.keep(&self.name(piece), what).map_err(RunError::Checkpoint)
    }

    /// The result of `work`, which is done only if it was not kept.
    ///
    /// # Errors
    /// If the work fails or its result cannot be kept.
    pub fn once<T: Serialize + DeserializeOwned>(
        &self,
        piece: &str,
        work: impl FnOnce() -> Result<T, RunError>,
    ) -> Result<T, RunError> {
        if let Some(done) = self.recall(piece) {
            return Ok(done);
        }
        let done = work()?;
        self.keep(piece, &done)?;
        Ok(done)
    }

    fn thaw(&self, plan: &Plan, piece: &str, frozen: &FrozenMind) -> Option<Mind> {
        let refused = |e| self.progress.warn(&format!("{}: {e}; its work is done again", self.name(piece)));
        Mind::thaw(plan, frozen).map_err(refused).ok()
    }

    /// What the finished phase `name` left behind, if it was kept.
    pub(crate) fn finished(&self, plan: &Plan, name: &str) -> Option<Trained> {
        let Finished { mind, episodes, diary } = self.recall(name)?;
        let mind = self.thaw(plan, name, &mind)?;
        let trace = Trace::of(&plan.spec, episodes);
        self.progress.steps(trace.steps());
        Some(Trained { mind, trace, diary })
    }

    /// Keeps what the phase `name` left behind.
    pub(crate) fn finish(&self, plan: &Plan, name: &str, trained: &Trained) -> Result<(), RunError> {
        let Some(checkpoint) = self.checkpoint else { return Ok(()) };
        let (mind, episodes) = (trained.mind.freeze_for(plan), trained.trace.episodes.clone());
        self.keep(name, &Finished { mind, episodes, diary: trained.diary.clone() })?;
        for draft in drafts(name) {
            checkpoint.shelf.forget(&self.name(&draft)).map_err(RunError::Checkpoint)?;
        }
        Ok(())
    }

    /// The phase `name` as it was last saved; the one saved before, if that cannot be used.
    pub(crate) fn draft(&self, plan: &Plan, name: &str) -> Option<Draft> {
        let read = |draft: &String| Some((draft.clone(), self.recall::<Underway>(draft)?));
        let mut found: Vec<(String, Underway)> = drafts(name).iter().filter_map(read).collect();
        found.sort_by_key(|(_, draft)| std::cmp::Reverse(draft.nth));
        let (mind, draft) = found
            .into_iter()
            .find_map(|(piece, draft)| Some((self.thaw(plan, &piece, &draft.mind)?, draft)))?;
        let trace = Trace::of(&plan.spec, draft.episodes);
        self.progress.steps(trace.steps());
        Some(Draft { mind, trace, at: draft.at, course: draft.course, saved: draft.nth + 1 })
    }

    /// Saves the phase `name` between two episodes or iterations, beside the time before.
    pub(crate) fn save(&self, plan: &Plan, name: &str, draft: &Draft) -> Result<(), RunError> {
        let (mind, episodes) = (draft.mind.freeze_for(plan), draft.trace.episodes.clone());
        let course = draft.course.clone();
        let underway = Underway { mind, episodes, at: draft.at, course, nth: draft.saved };
        self.keep(&drafts(name)[draft.saved % 2], &underway)
    }

    /// Says when the next save is due, from now on; never, if nothing is kept.
    pub(crate) fn alarm(&self) -> impl Fn() -> bool + use<> {
        let every = self.checkpoint.map_or(Duration::MAX, |checkpoint| checkpoint.every);
        let start = Instant::now();
        move || start.elapsed() >= every
    }
}

/// Two places for a phase on its way: the last one is good until the next one is whole.
fn drafts(phase: &str) -> [String; 2] {
    [0, 1].map(|place| format!("{phase}/draft-{place}"))
}

/// Name of the chapter in which training number `seed` is kept.
pub(crate) fn chapter_of_seed(seed: usize) -> String {
    format!("train/seed-{seed}")
}

/// Names of the pieces of a phase of a training: finished, and on its way.
pub(super) fn chapter_of_training(seed: usize, phase: &str) -> (String, [String; 2]) {
    let chapter = chapter_of_seed(seed);
    (format!("{chapter}/{phase}"), drafts(phase).map(|draft| format!("{chapter}/{draft}")))
}

/// The mind of a finished phase.
pub(super) fn read_finished(shelf: &Shelf, piece: &str) -> Result<Option<FrozenMind>, StoreError> {
    Ok(shelf.recall::<Finished>(piece)?.map(|phase| phase.mind))
}

/// The mind of a phase on its way, as it was last saved; the one before, if that cannot be read.
pub(super) fn read_underway(shelf: &Shelf, drafts: &[String]) -> Result<Option<FrozenMind>, StoreError> {
    let read = drafts.iter().map(|draft| shelf.recall::<Underway>(draft));
    let (good, bad): (Vec<_>, Vec<_>) = read.partition(Result::is_ok);
    let last = good.into_iter().flatten().flatten().max_by_key(|draft| draft.nth);
    match (last, bad.into_iter().next()) {
        (Some(draft), _) => Ok(Some(draft.mind)),
        (None, Some(Err(e))) => Err(e),
        (None, _) => Ok(None),
    }
}
