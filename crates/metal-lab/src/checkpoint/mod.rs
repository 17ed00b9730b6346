//! The memory of a run that is not finished: every finished piece of work in a file of its own under `checkpoint/`, so
//! that a run that was killed goes on and ends with the same bits.
//!
//! A file is whole or not there. It carries the format's version, the job it belongs to (plan, seed, program), the name
//! of its piece of work and a checksum; one that does not fit is reported by name and its work is done again.

mod job;
pub(crate) mod ledger;
mod shelf;
mod unfinished;

pub use job::Job;
pub use ledger::Ledger;
pub use shelf::FORMAT;
pub use unfinished::{Learned, Unfinished};

use crate::store::{Store, StoreError, at, write_whole};
use shelf::Shelf;
use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Name of the file that says what is being done.
pub(crate) const JOB: &str = "job.toml";

/// Why a run cannot begin or go on in a folder.
#[derive(Debug, thiserror::Error)]
pub enum CheckpointError {
    /// The file system said no.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// There is a finished run.
    #[error("{}: holds a finished run; choose another folder, or replace it with --force", .0.display())]
    Finished(PathBuf),
    /// There is a run that was stopped.
    #[error("{}: holds an unfinished run; go on with --resume, or start over with --force", .0.display())]
    Unfinished(PathBuf),
    /// The run in the folder is another one.
    #[error("{}: cannot go on with --resume, because {difference}; start over with --force", folder.display())]
    Changed {
        /// The run folder.
        folder: PathBuf,
        /// What was and what is.
        difference: String,
    },
    /// Somebody else is at work.
    #[error("{}: another process is at work in this folder", .0.display())]
    Busy(PathBuf),
    /// The job cannot be described.
    #[error("{JOB}: {0}")]
    Job(String),
}

/// What to do with what is in the folder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// Nothing may be there.
    Fresh,
    /// Go on with what is there.
    Resume,
    /// Start over, whatever is there.
    Force,
}

/// How a run begins.
pub enum Begun {
    /// There is work to do.
    Work(Checkpoint),
    /// The same run is finished already.
    Finished,
}

/// The folder `checkpoint/` of a run, ours until it is dropped.
pub struct Checkpoint {
    shelf: Shelf,
    every: Duration,
    _lock: File,
}

/// Looks at what is in the folder of `store`, and takes it for `job`. Phases are saved after at most `every` and an
/// episode. `warn` hears of files that are not used.
///
/// # Errors
/// If something is there that `start` does not allow, or the file system refuses.
pub fn begin(
    store: &Store,
    job: &Job,
    (start, every): (Start, Duration),
    warn: &dyn Fn(&str),
) -> Result<Begun, CheckpointError> {
    let (finished, folder) = (store.path("run.json").is_file(), store.path("checkpoint"));
    let stopped = folder.join(JOB).exists();
    if start == Start::Fresh && (finished || stopped) {
        let root = store.root().to_path_buf();
        return Err(if finished {
            CheckpointError::Finished(root)
        } else {
            CheckpointError::Unfinished(root)
        });
    }
    let checkpoint = Checkpoint::take(folder, job, every)?;
    match start {
        Start::Resume if finished && !stopped => {
            agree(store, &Job::of_run(store, job)?, job)?;
            checkpoint.finish()?;
            return Ok(Begun::Finished);
        }
        Start::Resume if stopped => match Job::read(&checkpoint.folder().join(JOB)) {
            Ok(known) => agree(store, &known, job)?,
            Err(e) => warn(&format!("{e}; only pieces of this very job are used")),
        },
        Start::Resume => warn("--resume: nothing was saved yet, starting at the beginning"),
        Start::Fresh | Start::Force => {
            store.remove("run.json")?;
            checkpoint.clear()?;
        }
    }
    write_whole(&checkpoint.folder().join(JOB), job.text()?.as_bytes())?;
    Ok(Begun::Work(checkpoint))
}

fn agree(store: &Store, known: &Job, job: &Job) -> Result<(), CheckpointError> {
    match known.difference(job) {
        Some(difference) => Err(CheckpointError::Changed { folder: store.root().to_path_buf(), difference }),
        None => Ok(()),
    }
}

impl Checkpoint {
    /// Makes the folder and locks it; the lock ends with the process, however it ends.
    fn take(folder: PathBuf, job: &Job, every: Duration) -> Result<Self, CheckpointError> {
        std::fs::create_dir_all(&folder).map_err(|e| at(&folder, e))?;
        let path = folder.join("lock");
        let lock = File::create(&path).map_err(|e| at(&path, e))?;
        match lock.try_lock() {
            Err(TryLockError::WouldBlock) => Err(CheckpointError::Busy(folder)),
            // A file system without locks is no reason not to work on it.
            _ => Ok(Self { shelf: Shelf { key: job.key()?, folder }, every, _lock: lock }),
        }
    }

    /// Forgets everything; the folder stays ours.
    fn clear(&self) -> Result<(), StoreError> {
        // First what the others belong to: a folder without it is no unfinished run.
        let names = std::fs::read_dir(self.folder()).map_err(|e| at(self.folder(), e))?;
        let mut paths: Vec<PathBuf> = names.filter_map(|entry| Some(entry.ok()?.path())).collect();
        paths.sort_by_key(|path| !path.ends_with(JOB));
        for path in paths.iter().filter(|p| p.is_file() && !p.ends_with("lock")) {
            std::fs::remove_file(path).map_err(|e| at(path, e))?;
        }
        Ok(())
    }

    /// Removes the folder: the run is finished and written.
    ///
    /// # Errors
    /// If the file system refuses.
    pub fn finish(self) -> Result<(), StoreError> {
        self.clear()?;
        std::fs::remove_dir_all(self.folder()).map_err(|e| at(self.folder(), e))
    }

    /// The folder.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.shelf.folder
    }
}
