//! What the studio is opened on: an experiment, or the folder of a run with its trained minds.

use crate::robot::Robot;
use metal_lab::checkpoint::{Learned, Unfinished};
use metal_lab::mind::Mind;
use metal_lab::plan::{self, Acting, Plan, PlanError};
use metal_lab::results::Results;
use metal_lab::store::{Store, StoreError};
use metal_lab::train::RunError;
use metal_recording::{Tape, TapeError};
use metal_rl::random::Streams;
use metal_rl::set::IndexSet;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Somebody who can be put at the wheel.
#[derive(Clone, Debug, PartialEq)]
pub struct Driver {
    /// For people.
    pub label: String,
    /// Who acts.
    pub acting: Acting,
    /// Who may be consulted.
    pub roster: IndexSet,
    /// Where its mind is kept.
    pub home: Home,
}

/// Where a mind comes from.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Home {
    /// Nobody taught it anything.
    Newborn,
    /// A training in the run folder: which one, and after which phase.
    Folder(usize, String),
    /// A phase that was trained in this session.
    Fresh(String),
    /// A checkpoint of a run that is not finished: which training, after or in which phase, and whether it was finished.
    Checkpoint(usize, String, bool),
}

/// The experiment, its folder, and who can drive.
pub struct Subject {
    /// The experiment.
    pub plan: Arc<Plan>,
    /// Where demonstrations and minds are written; nothing else is.
    pub store: Store,
    /// The numbers of the finished run, if the subject is one.
    pub results: Option<Results>,
    /// Who can drive.
    pub drivers: Vec<Driver>,
    /// The body they drive, if it is not the simulated one.
    pub(crate) robot: Option<Robot>,
    recording: Option<PathBuf>,
    unfinished: Option<Unfinished>,
    blind: usize,
    minds: BTreeMap<Home, Arc<Mind>>,
    is_run: bool,
}

/// Why there is nothing to show.
#[derive(Debug, thiserror::Error)]
pub enum SubjectError {
    /// The folder of the run.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The experiment.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// A mind.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The folder belongs to a run that was not made here.
    #[error("{}: holds a finished run; open it with --run, or name another folder with --out", .0.display())]
    Taken(PathBuf),
    /// The world is no road.
    #[error("the studio shows roads, and {0} is none; choose an experiment in the highway")]
    NoRoad(String),
    /// Only the scripted expert would drive.
    #[error(
        "nobody is left to drive a body: the scripted expert knows only the simulated road; open a run with trained minds"
    )]
    Nobody,
    /// A mind that a body has no senses for.
    #[error("the minds of this run have other sensors than a body")]
    OtherSensors,
    /// A body at whose wheel nobody could sit.
    #[error("nobody in this run can drive a body; open a run with trained minds (--run)")]
    NoDriver,
    /// The scripted expert knows the simulated world only.
    #[error("{0}: the scripted expert drives only in simulation; for a body choose a trained mind")]
    NoExpert(String),
    /// A recording that is there already.
    #[error("{}: exists; a training is recorded in a new file: move it away, or name another with --record", .0.display())]
    Recorded(PathBuf),
    /// A recording that cannot be written.
    #[error("{}: {reason}", path.display())]
    Recording {
        /// The recording.
        path: PathBuf,
        /// Why not.
        reason: TapeError,
    },
}

impl Subject {
    /// An experiment whose minds are still to be trained; `out` is where the studio may write.
    ///
    /// # Errors
    /// If its world is not the highway or the folder cannot be made.
    pub fn experiment(plan: Plan, out: &Path) -> Result<Self, SubjectError> {
        if out.join("results.json").exists() {
            return Err(SubjectError::Taken(out.to_path_buf()));
        }
        is_road(&plan)?;
        let mut subject = Self::new(plan, Store::create(out)?, None)?;
        subject.list_kept();
        Ok(subject)
    }

    /// A finished run; or an unfinished one, of which every mind is there that its checkpoint holds. An unfinished run may go
    /// on meanwhile.
    ///
    /// # Errors
    /// If the folder is none of a run.
    pub fn run(folder: &Path) -> Result<Self, SubjectError> {
        if let Some(store) = Store::unfinished(folder) {
            return Self::checkpoint(store);
        }
        let store = Store::open(folder)?;
        let (plan, card) = store.read_run()?;
        let results = std::fs::read_to_string(store.path("results.json")).ok();
        let results = results.and_then(|text| serde_json::from_str(&text).ok());
        let mut subject = Self::new(plan, store, results)?;
        subject.blind = card.blind;
        subject.is_run = true;
        subject.list_folder(card.seeds);
        Ok(subject)
    }

    fn checkpoint(store: Store) -> Result<Self, SubjectError> {
        let gone = || StoreError::Damaged { path: store.path("checkpoint"), reason: "gone".to_owned() };
        let unfinished = Unfinished::open(&store)?.ok_or_else(gone)?;
        let mut subject = Self::new(unfinished.plan.clone(), store, None)?;
        subject.is_run = true;
        let mut found = Vec::new();
        for Learned { seed, phase, whole } in unfinished.learned() {
            let home = |_: &str, after: Option<&str>| {
                (after == Some(&phase)).then(|| Home::Checkpoint(seed, phase.clone(), whole))
            };
            let note = if whole { "checkpoint" } else { "checkpoint, still learning" };
            found.extend(subject.rows(&home, &format!(", training {} ({note})", seed + 1)));
        }
        found.append(&mut subject.drivers);
        subject.drivers = found;
        subject.unfinished = Some(unfinished);
        Ok(subject)
    }

    fn new(plan: Plan, store: Store, results: Option<Results>) -> Result<Self, SubjectError> {
        is_road(&plan)?;
        let newborn = Mind::newborn(&plan, &Streams::new(0)).map_err(RunError::from)?;
        let minds = BTreeMap::from([(Home::Newborn, Arc::new(newborn))]);
        let (drivers, plan) = (Vec::new(), Arc::new(plan));
        let mut subject = Self {
            plan,
            store,
            results,
            drivers,
            robot: None,
            recording: None,
            unfinished: None,
            blind: 0,
            minds,
            is_run: false,
        };
        subject.drivers = subject.rows(&|_, after| after.is_none().then_some(Home::Newborn), "");
        Ok(subject)
    }

    /// Puts `robot` in the place of the simulated car. No scripted expert knows where a body is, so it leaves the list.
    ///
    /// # Errors
    /// If nobody is left to drive.
    pub fn embody(&mut self, robot: Robot) -> Result<(), SubjectError> {
        self.drivers.retain(|driver| !driver.acting.is_watched());
        if self.drivers.is_empty() {
            return Err(SubjectError::NoDriver);
        }
        self.robot = Some(robot);
        Ok(())
    }

    /// Has every training that is started from now on recorded in the file at `path`, which must not be there yet.
    ///
    /// # Errors
    /// If it is there, or its folder is not.
    pub fn record(&mut self, path: &Path) -> Result<(), SubjectError> {
        let path = path.to_path_buf();
        if path.exists() {
            return Err(SubjectError::Recorded(path));
        }
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        if folder.is_some_and(|folder| !folder.is_dir()) {
            let reason = std::io::Error::new(std::io::ErrorKind::NotFound, "its folder is not there").into();
            return Err(SubjectError::Recording { path, reason });
        }
        self.recording = Some(path);
        Ok(())
    }

    /// What a training by `plan` is recorded on, if somebody wishes that.
    pub(crate) fn tape(&self, plan: &Plan) -> Result<Option<Tape>, SubjectError> {
        let Some(path) = self.recording.clone() else { return Ok(None) };
        if path.exists() {
            return Err(SubjectError::Recorded(path));
        }
        let tape = Tape::create(&path, &plan.spec);
        tape.map(Some).map_err(|reason| SubjectError::Recording { path, reason })
    }

    /// Rows of the plan's comparison whose minds are at `home`.
    fn rows(&self, home: &dyn Fn(&str, Option<&str>) -> Option<Home>, note: &str) -> Vec<Driver> {
        let rows = self.plan.file.policy.iter();
        let named = rows.filter_map(|(name, row)| {
            let label = format!("{}{note}", metal_lab::figures::policy::short_label(name));
            let (acting, roster) = (row.acting.clone(), self.plan.roster(&row.roster));
            Some((name, Driver { label, acting, roster, home: home(name, row.after.as_deref())? }))
        });
        let mut named: Vec<(&String, Driver)> = named.collect();
        let place = |name: &str| metal_lab::figures::policy::ORDER.iter().position(|p| *p == name);
        named.sort_by_key(|(name, _)| place(name).unwrap_or(usize::MAX));
        named.into_iter().map(|(_, driver)| driver).collect()
    }

    fn list_folder(&mut self, seeds: usize) {
        let mut found = Vec::new();
        for seed in 0..seeds {
            let home = |_: &str, after: Option<&str>| after.map(|phase| Home::Folder(seed, phase.to_owned()));
            found.extend(self.rows(&home, &format!(", training {}", seed + 1)));
        }
        found.append(&mut self.drivers);
        self.drivers = found;
    }

    /// Minds that an earlier session of the same experiment has left in the folder; others do not fit and are passed over.
    fn list_kept(&mut self) {
        for phase in self.plan.order.clone() {
            let Ok(mind) = self.store.read_mind(&self.plan, 0, &phase) else { continue };
            self.minds.insert(Home::Folder(0, phase.clone()), Arc::new(mind));
            let kept = |_: &str, after: Option<&str>| {
                (after == Some(phase.as_str())).then(|| Home::Folder(0, phase.clone()))
            };
            let rows = self.rows(&kept, ", kept here");
            self.drivers.extend(rows);
        }
    }

    /// Takes in what a phase of this session's training has left behind.
    pub fn add_fresh(&mut self, phase: &str, mind: Mind) {
        self.minds.insert(Home::Fresh(phase.to_owned()), Arc::new(mind));
        let fresh =
            |_: &str, after: Option<&str>| (after == Some(phase)).then(|| Home::Fresh(phase.to_owned()));
        for driver in self.rows(&fresh, ", trained here") {
            if !self.drivers.contains(&driver) {
                self.drivers.push(driver);
            }
        }
    }

    /// The mind of a driver, read from the folder when it is first asked for.
    ///
    /// # Errors
    /// If its file is missing or damaged.
    pub fn mind(&mut self, driver: &Driver) -> Result<Arc<Mind>, SubjectError> {
        if let Some(mind) = self.minds.get(&driver.home) {
            return Ok(mind.clone());
        }
        let mind = match (&driver.home, &self.unfinished) {
            (Home::Folder(seed, phase), _) => self.store.read_mind(&self.plan, *seed, phase)?,
            (Home::Checkpoint(seed, phase, whole), Some(unfinished)) => {
                unfinished.mind(&Learned { seed: *seed, phase: phase.clone(), whole: *whole })?
            }
            _ => return Ok(self.minds[&Home::Newborn].clone()),
        };
        let mind = Arc::new(mind);
        self.minds.insert(driver.home.clone(), mind.clone());
        Ok(mind)
    }

    /// How many roads the simulated world has; a body's own road comes after them.
    #[must_use]
    pub fn road_count(&self) -> usize {
        let highway = self.plan.file.environment.as_highway();
        highway.map_or(0, |(config, steering)| metal_lab::registry::highway(config, steering).grounds().len())
    }

    /// The constant action of the blind driver.
    #[must_use]
    pub fn blind(&self) -> usize {
        self.blind
    }

    /// Whether the folder holds a finished run, which nobody may overwrite.
    #[must_use]
    pub fn is_run(&self) -> bool {
        self.is_run
    }

    /// Who drives first: attention control if somebody trained it, else the expert.
    #[must_use]
    pub fn first_driver(&self) -> usize {
        let attends = |d: &Driver| matches!(d.acting, Acting::Attention(_));
        let expert = |d: &Driver| d.acting == Acting::Advisor;
        let find = |is: &dyn Fn(&Driver) -> bool| self.drivers.iter().position(is);
        find(&attends).or_else(|| find(&expert)).unwrap_or(0)
    }
}

fn is_road(plan: &Plan) -> Result<(), SubjectError> {
    match plan.file.environment.as_highway() {
        Some(_) => Ok(()),
        None => Err(SubjectError::NoRoad(plan.spec.id.clone())),
    }
}

/// The experiment that the studio opens when none is named.
///
/// # Errors
/// Never, as long as the program's own experiment is right.
pub fn paper() -> Result<Plan, PlanError> {
    plan::parse(metal_lab::experiments::PAPER, &[])
}
