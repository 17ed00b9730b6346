//! The folder of a run: plan, minds, results, records and report, each written whole or not at all.

use crate::mind::{FrozenMind, Mind};
use crate::plan::{self, Plan};
use crate::results::Results;
use crate::trace::EpisodeRecord;
use metal_rl::learner::LearnerError;
use metal_rl::learners::frozen;
use serde::{Deserialize, Serialize};
use std::io::Write;
use std::path::{Path, PathBuf};

/// First bytes of a mind file.
const MAGIC: &[u8; 8] = b"METALMND";

/// What is sealed in a mind file.
const MIND: &str = "mind";

/// Most trainings a run can have: as many as `metal run --seeds` takes.
pub const MOST_SEEDS: usize = 10_000;

/// What went wrong with a run folder: which file, and why.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// The file system said no.
    #[error("{}: {source}", path.display())]
    File {
        /// The file or folder.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The file is there but is not what it should be.
    #[error("{}: {reason}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// A learner cannot be thawed.
    #[error("{}: {source}", path.display())]
    Learner {
        /// The file.
        path: PathBuf,
        /// Why.
        source: LearnerError,
    },
    /// The plan of the run is refused.
    #[error(transparent)]
    Plan(#[from] plan::PlanError),
}

/// What a run was, beside its plan.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunCard {
    /// Version of the program that trained.
    pub version: String,
    /// The one seed of the run.
    pub seed: u64,
    /// Independent trainings.
    pub seeds: usize,
    /// Best constant action on validation roads.
    pub blind: usize,
    /// Whether budgets were cut.
    pub quick: bool,
}

impl RunCard {
    /// Whether the card can belong to `plan`.
    fn check(&self, plan: &Plan) -> Result<(), String> {
        if !(1..=MOST_SEEDS).contains(&self.seeds) {
            return Err(format!("seeds = {}: between 1 and {MOST_SEEDS}", self.seeds));
        }
        let actions = plan.spec.actions.len();
        if self.blind >= actions {
            return Err(format!("blind = {}: {} has {actions} motor actions", self.blind, plan.spec.id));
        }
        Ok(())
    }
}

/// Where the folders of fixed choices of sensors are.
const RIVALS: &str = "fixed";

/// A run folder.
#[derive(Clone, Debug)]
pub struct Store {
    root: PathBuf,
}

impl Store {
    /// Makes the folder, if it is not there.
    ///
    /// # Errors
    /// If it cannot be made.
    pub fn create(root: &Path) -> Result<Self, StoreError> {
        std::fs::create_dir_all(root).map_err(|e| at(root, e))?;
        Ok(Self { root: root.to_path_buf() })
    }

    /// Opens the folder of a finished run.
    ///
    /// # Errors
    /// If it is no run folder.
    pub fn open(root: &Path) -> Result<Self, StoreError> {
        let store = Self { root: root.to_path_buf() };
        let card = store.path("run.json");
        if !card.is_file() {
            let reason = if store.is_unfinished() {
                "the run is not finished: go on with `metal run EXPERIMENT --out FOLDER --resume`"
            } else {
                "not a run folder: `metal reproduce` and `metal run` write one (run.json is missing)"
            };
            return Err(StoreError::Damaged { path: root.to_path_buf(), reason: reason.to_owned() });
        }
        Ok(store)
    }

    /// The folder of a run that was begun and has no end yet, if it is one.
    #[must_use]
    pub fn unfinished(root: &Path) -> Option<Self> {
        let store = Self { root: root.to_path_buf() };
        store.is_unfinished().then_some(store)
    }

    fn is_unfinished(&self) -> bool {
        !self.path("run.json").is_file() && self.path("checkpoint").join(crate::checkpoint::JOB).is_file()
    }

    /// The folder.
    #[must_use]
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// A file in the folder.
    #[must_use]
    pub fn path(&self, name: &str) -> PathBuf {
        self.root.join(name)
    }

    /// Writes `bytes` to `name`: a reader sees the old file or the new one, never half of one.
    ///
    /// # Errors
    /// If the file system refuses.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<(), StoreError> {
        write_whole(&self.path(name), bytes)
    }

    /// Removes `name`, if it is there.
    ///
    /// # Errors
    /// If the file system refuses.
    pub fn remove(&self, name: &str) -> Result<(), StoreError> {
        let path = self.path(name);
        match std::fs::remove_file(&path) {
            Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(at(&path, e)),
            _ => Ok(()),
        }
    }

    /// Writes the plan and the card of a run.
    ///
    /// # Errors
    /// If the file system refuses.
    pub fn write_run(&self, plan: &Plan, card: &RunCard) -> Result<(), StoreError> {
        let damaged = |name: &str, reason: String| StoreError::Damaged { path: self.path(name), reason };
        let text = toml::to_string(&plan.file).map_err(|e| damaged("plan.toml", e.to_string()))?;
        self.write("plan.toml", text.as_bytes())?;
        let card = serde_json::to_string_pretty(card).map_err(|e| damaged("run.json", e.to_string()))?;
        self.write("run.json", card.as_bytes())
    }

    /// Reads the plan and the card of a run.
    ///
    /// # Errors
    /// If a file is missing or damaged.
    pub fn read_run(&self) -> Result<(Plan, RunCard), StoreError> {
        let plan = plan::load(&self.path("plan.toml"), &[])?;
        let path = self.path("run.json");
        let text = std::fs::read_to_string(&path).map_err(|e| at(&path, e))?;
        let card = serde_json::from_str(&text).map_err(|e| e.to_string());
        match card.and_then(|card: RunCard| card.check(&plan).map(|()| card)) {
            Ok(card) => Ok((plan, card)),
            Err(reason) => Err(StoreError::Damaged { path, reason }),
        }
    }

    /// Reads the numbers of a finished run.
    ///
    /// # Errors
    /// If the file is missing or damaged.
    pub fn read_results(&self) -> Result<Results, StoreError> {
        let path = self.path("results.json");
        let text = std::fs::read_to_string(&path).map_err(|e| at(&path, e))?;
        serde_json::from_str(&text).map_err(|e| StoreError::Damaged { path, reason: e.to_string() })
    }

    fn rival_name(number: usize) -> String {
        format!("{RIVALS}/{number}")
    }

    /// Takes the cards off the fixed choices that an earlier run in this folder left behind: they are no runs any more.
    ///
    /// # Errors
    /// If the file system refuses.
    pub fn retire_rivals(&self) -> Result<(), StoreError> {
        self.rivals()?.iter().try_for_each(|rival| rival.remove("run.json"))
    }

    /// The folder inside of a fixed choice of sensors, a run of its own.
    ///
    /// # Errors
    /// If it cannot be made.
    pub fn rival(&self, number: usize) -> Result<Self, StoreError> {
        Self::create(&self.path(&Self::rival_name(number)))
    }

    /// The folders inside of all fixed choices of sensors; none in a run without any, or of an earlier version.
    ///
    /// # Errors
    /// If one of them cannot be opened.
    pub fn rivals(&self) -> Result<Vec<Self>, StoreError> {
        let folders = (0..).map(|number| self.path(&Self::rival_name(number)));
        let finished = folders.take_while(|folder| folder.join("run.json").is_file());
        finished.map(|folder| Self::open(&folder)).collect()
    }

    fn mind_name(seed: usize, phase: &str) -> String {
        format!("minds/seed-{seed}/{phase}.mind")
    }

    /// Writes the minds that `phase` left behind.
    ///
    /// # Errors
    /// If the file system refuses.
    pub fn write_mind(&self, seed: usize, phase: &str, mind: &FrozenMind) -> Result<(), StoreError> {
        let name = Self::mind_name(seed, phase);
        let mut bytes = MAGIC.to_vec();
        bytes.extend(frozen::seal(MIND, mind));
        self.write(&name, &bytes)
    }

    /// Reads the minds that `phase` left behind.
    ///
    /// # Errors
    /// If the file is missing, damaged, or does not fit the plan.
    pub fn read_mind(&self, plan: &Plan, seed: usize, phase: &str) -> Result<Mind, StoreError> {
        let path = self.path(&Self::mind_name(seed, phase));
        let bytes = std::fs::read(&path).map_err(|e| at(&path, e))?;
        let Some(body) = bytes.strip_prefix(MAGIC.as_slice()) else {
            return Err(StoreError::Damaged { path, reason: "not a mind file".into() });
        };
        let thawed = frozen::open::<FrozenMind>(MIND, body).and_then(|frozen| Mind::thaw(plan, &frozen));
        let mind = match thawed {
            Ok(mind) => mind,
            Err(source) => return Err(StoreError::Learner { path, source }),
        };
        let unborn = |name: &&String| plan.is_trained_by(Some(phase), name) && !mind.has_attention(name);
        match plan.file.attention.keys().find(unborn) {
            Some(name) => Err(StoreError::Damaged { path, reason: format!("attention `{name}` is missing") }),
            None => Ok(mind),
        }
    }
}

/// Writes `bytes` to `path`, and its folder if need be: after a crash at any moment, the old file is there or the new one,
/// never half of one.
///
/// # Errors
/// If the file system refuses; no draft is left behind.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder).map_err(|e| at(folder, e))?;
    let mut draft = path.as_os_str().to_owned();
    draft.push(".tmp");
    let draft = PathBuf::from(draft);
    let written = std::fs::File::create(&draft).and_then(|mut file| {
        file.write_all(bytes)?;
        file.sync_all()
    });
    if let Err(e) = written.and_then(|()| std::fs::rename(&draft, path)) {
        // What is left of the draft only takes space; that it cannot be removed is not the news.
        let _ = std::fs::remove_file(&draft);
        return Err(at(path, e));
    }
    sync_folder(folder).map_err(|e| at(folder, e))
}

/// Makes a rename last: the name of a file is kept by its folder.
#[cfg(unix)]
fn sync_folder(folder: &Path) -> std::io::Result<()> {
    std::fs::File::open(folder)?.sync_all()
}

#[cfg(not(unix))]
fn sync_folder(_folder: &Path) -> std::io::Result<()> {
    Ok(())
}

pub(crate) fn at(path: &Path, source: std::io::Error) -> StoreError {
    StoreError::File { path: path.to_path_buf(), source }
}

/// One row of `records.csv`: an evaluation run.
#[derive(Debug, Serialize)]
struct RecordRow<'a> {
    policy: &'a str,
    roads: &'a str,
    scenario: &'a str,
    seed: usize,
    run: usize,
    steps: usize,
    motor: f64,
    perceptual: f64,
    looks: usize,
    accident: bool,
    contact_steps: usize,
    accidents_own_fault: usize,
    accidents_other_fault: usize,
    off_road_share: Option<f64>,
    turn_change_rad_per_step: Option<f64>,
    speed_change_share: Option<f64>,
    lane_offset_m: Option<f64>,
    speed_mps: f64,
}

/// Where a list of runs belongs.
#[derive(Clone, Copy, Debug)]
pub struct RecordKey<'a> {
    /// Policy.
    pub policy: &'a str,
    /// Roads.
    pub roads: &'a str,
    /// Scenario.
    pub scenario: &'a str,
}

/// Per-run records as CSV; costs are sums over a run's motor steps.
///
/// # Errors
/// If a record cannot be written (a bug in the table's shape).
pub fn records_csv<'a>(
    tables: impl Iterator<Item = (RecordKey<'a>, &'a Vec<Vec<EpisodeRecord>>)>,
) -> Result<Vec<u8>, csv::Error> {
    let mut csv = csv::Writer::from_writer(Vec::new());
    for (key, seeds) in tables {
        for (seed, runs) in seeds.iter().enumerate() {
            for (run, r) in runs.iter().enumerate() {
                csv.serialize(row(key, (seed, run), r))?;
            }
        }
    }
    csv.into_inner().map_err(|e| csv::Error::from(std::io::Error::other(e.to_string())))
}

fn row<'a>(key: RecordKey<'a>, (seed, run): (usize, usize), r: &EpisodeRecord) -> RecordRow<'a> {
    RecordRow {
        policy: key.policy,
        roads: key.roads,
        scenario: key.scenario,
        seed,
        run,
        steps: r.steps(),
        motor: r.motor,
        perceptual: r.perceptual,
        looks: r.look_count(),
        accident: r.driving.accident,
        contact_steps: r.driving.contact_steps,
        accidents_own_fault: r.driving.accidents_own_fault,
        accidents_other_fault: r.driving.accidents_other_fault,
        off_road_share: r.driving.off_road_share,
        turn_change_rad_per_step: r.driving.turn_change_rad_per_step,
        speed_change_share: r.driving.speed_change_share,
        lane_offset_m: r.driving.lane_offset_m,
        speed_mps: r.speed_mps,
    }
}
