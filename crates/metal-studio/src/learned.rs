//! What a training run has learned so far: episodes in numbers, sizes of the members' models, minds of finished phases.

use crate::hub::lock;
use metal_lab::mind::Mind;
use metal_lab::trace::EpisodeRecord;
use metal_rl::member::Member;
use serde::Serialize;
use std::collections::BTreeMap;
use std::sync::Mutex;

/// Most different numbers of looks that are told apart.
pub const MOST_LOOKS: usize = 8;
/// Episodes between two measurements of the models' sizes.
const SIZES_EVERY: usize = 10;

/// One episode in numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Episode {
    /// Motor steps.
    pub steps: u32,
    /// Sum of motor rewards.
    pub motor: f64,
    /// Minus the prices of all looks.
    pub perceptual: f64,
    /// Motor steps after 0, 1, 2, … looks.
    pub looks: [u32; MOST_LOOKS],
    /// Whether something was hit.
    pub accident: bool,
}

impl Episode {
    /// The numbers of a record.
    #[must_use]
    pub fn of(record: &EpisodeRecord) -> Self {
        let mut looks = [0; MOST_LOOKS];
        for &n in &record.looks {
            looks[usize::from(n).min(MOST_LOOKS - 1)] += 1;
        }
        Self {
            steps: u32::try_from(record.steps()).unwrap_or(u32::MAX),
            motor: record.motor,
            perceptual: record.perceptual,
            looks,
            accident: record.driving.accident,
        }
    }
}

/// What is known of one phase.
#[derive(Clone, Debug, Default)]
pub struct PhaseLog {
    /// Its episodes.
    pub episodes: Vec<Episode>,
    /// Episode, then the size of every member's model.
    pub sizes: Vec<(usize, Vec<usize>)>,
    /// Unit of these sizes, per member.
    pub units: Vec<&'static str>,
    /// Share of the phase that is over.
    pub progress: f64,
}

/// How far a run is, for the page.
#[derive(Clone, Debug, Serialize)]
pub struct Progress {
    /// The phase that is learned now.
    pub phase: String,
    /// Every phase and the share of it that is over.
    pub phases: Vec<(String, f64)>,
    /// Episodes of the phase.
    pub episode: usize,
    /// What went wrong.
    pub error: Option<String>,
}

#[derive(Default)]
struct Book {
    order: Vec<String>,
    phase: String,
    logs: BTreeMap<String, PhaseLog>,
    minds: BTreeMap<String, Mind>,
    error: Option<String>,
    portrait: Option<Vec<Member>>,
    portrait_wanted: bool,
    blind: Option<usize>,
}

/// Everything learned so far; the training thread writes, pages read.
pub struct Learned {
    book: Mutex<Book>,
}

impl Learned {
    /// Nothing yet of the phases in `order`.
    #[must_use]
    pub fn new(order: Vec<String>) -> Self {
        Self { book: Mutex::new(Book { order, portrait_wanted: true, ..Book::default() }) }
    }

    /// A phase begins.
    pub fn begin(&self, phase: &str) {
        let mut book = lock(&self.book);
        phase.clone_into(&mut book.phase);
        book.logs.insert(phase.to_owned(), PhaseLog::default());
    }

    /// An episode of the phase is over.
    pub fn add(&self, episode: Episode, progress: f64) {
        let mut book = lock(&self.book);
        let phase = book.phase.clone();
        if let Some(log) = book.logs.get_mut(&phase) {
            log.episodes.push(episode);
            log.progress = progress;
        }
    }

    /// Measures the members now and then, and keeps a copy of them if somebody asked for one.
    pub fn look_at(&self, members: &[Member]) {
        let mut book = lock(&self.book);
        if book.portrait_wanted {
            book.portrait = Some(members.to_vec());
            book.portrait_wanted = false;
        }
        let phase = book.phase.clone();
        let Some(log) = book.logs.get_mut(&phase) else { return };
        let episode = log.episodes.len();
        if episode % SIZES_EVERY == 1 || log.sizes.is_empty() {
            let sizes = members.iter().map(|m| m.learner.size());
            log.units = sizes.clone().map(|(_, unit)| unit).collect();
            log.sizes.push((episode, sizes.map(|(n, _)| n).collect()));
        }
    }

    /// A phase has left this mind behind.
    pub fn finish(&self, phase: &str, mind: Mind) {
        let mut book = lock(&self.book);
        if let Some(log) = book.logs.get_mut(phase) {
            log.progress = 1.0;
        }
        book.portrait = Some(mind.members.clone());
        book.minds.insert(phase.to_owned(), mind);
    }

    /// The best constant action is known: the run is complete.
    pub fn set_blind(&self, action: usize) {
        lock(&self.book).blind = Some(action);
    }

    /// The best constant action, once the run is complete.
    #[must_use]
    pub fn blind(&self) -> Option<usize> {
        lock(&self.book).blind
    }

    /// Something went wrong.
    pub fn fail(&self, error: &str) {
        lock(&self.book).error = Some(error.to_owned());
    }

    /// The mind that a finished phase left behind.
    #[must_use]
    pub fn mind(&self, phase: &str) -> Option<Mind> {
        lock(&self.book).minds.get(phase).cloned()
    }

    /// The phases that are finished.
    #[must_use]
    pub fn finished(&self) -> Vec<String> {
        lock(&self.book).minds.keys().cloned().collect()
    }

    /// Episodes of all phases.
    #[must_use]
    pub fn episodes(&self) -> usize {
        lock(&self.book).logs.values().map(|log| log.episodes.len()).sum()
    }

    /// What is known of a phase.
    #[must_use]
    pub fn log(&self, phase: &str) -> Option<PhaseLog> {
        lock(&self.book).logs.get(phase).cloned()
    }

    /// The members as `phase` left them behind; of no phase, or of one that still learns, as they lately were (asking
    /// makes the next episode bring a newer copy).
    #[must_use]
    pub fn members(&self, phase: Option<&str>) -> Option<Vec<Member>> {
        let mut book = lock(&self.book);
        if let Some(mind) = phase.and_then(|p| book.minds.get(p)) {
            return Some(mind.members.clone());
        }
        book.portrait_wanted = true;
        book.portrait.clone()
    }

    /// How far the run is.
    #[must_use]
    pub fn progress(&self) -> Progress {
        let book = lock(&self.book);
        let share = |name: &String| book.logs.get(name).map_or(0.0, |log| log.progress);
        Progress {
            phase: book.phase.clone(),
            phases: book.order.iter().map(|name| (name.clone(), share(name))).collect(),
            episode: book.logs.get(&book.phase).map_or(0, |log| log.episodes.len()),
            error: book.error.clone(),
        }
    }
}
