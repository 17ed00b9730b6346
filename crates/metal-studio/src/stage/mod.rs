//! The stage: a thread that owns the worlds, listens to the pages, and moves when its clock says so.

mod body;
mod explore;
mod learning;
mod person;

use crate::clock::Clock;
use crate::command::Request;
use crate::demonstration::{self, Demonstration};
use crate::faults::Faulty;
use crate::frame::{Frame, LaneFrame, Source};
use crate::hub::{Hub, Order};
use crate::lane::{Lane, world_of};
use crate::robot::BodyLane;
use crate::situations::{Looked, table1};
use crate::subject::{Subject, SubjectError};
use crate::training::{State, Training};
use metal_lab::plan::Plan;
use metal_lab::results::RoadOutline;
use metal_rl::environment::EnvironmentError;
use metal_rl::random::Streams;
use metal_worlds::highway::Scenario;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// How often pages are told how things stand while nothing is asked.
const STATUS_EVERY: Duration = Duration::from_millis(250);

/// How long a single step takes on the screen while the clock stands, in seconds.
const SINGLE_STEP_SECS: f64 = 0.3;

/// What could not be done, for a person.
#[derive(Debug, thiserror::Error)]
pub enum StageError {
    /// A world failed.
    #[error(transparent)]
    Environment(#[from] EnvironmentError),
    /// A mind or a folder.
    #[error(transparent)]
    Subject(#[from] SubjectError),
    /// A file.
    #[error(transparent)]
    Store(#[from] metal_lab::store::StoreError),
    /// A plan.
    #[error(transparent)]
    Plan(#[from] metal_lab::plan::PlanError),
    /// A thread.
    #[error("cannot start a thread: {0}")]
    Thread(#[from] std::io::Error),
    /// The request makes no sense now.
    #[error("{0}")]
    Request(&'static str),
}

/// The run that the page sees, shared with whoever draws curves.
pub type SharedTraining = Arc<Mutex<Option<Arc<crate::learned::Learned>>>>;

/// Everything the stage's thread owns.
pub struct Stage {
    pub(crate) hub: Arc<Hub>,
    pub(crate) subject: Subject,
    pub(crate) lanes: Vec<Lane>,
    pub(crate) body: Option<BodyLane>,
    pub(crate) clock: Clock,
    pub(crate) scenario: Scenario,
    pub(crate) scene: Option<usize>,
    pub(crate) demonstration: Option<Demonstration>,
    pub(crate) held: Option<usize>,
    pub(crate) cruise: usize,
    pub(crate) saved: Option<String>,
    pub(crate) training: Option<Training>,
    pub(crate) shared: SharedTraining,
    taken_in: Vec<String>,
    run_kept: bool,
    pub(crate) situations: Vec<Looked>,
    pub(crate) notice: Option<String>,
    streams: Streams,
    seed: u64,
    told: Instant,
}

impl Stage {
    /// The stage of `subject`, its first driver at the wheel.
    ///
    /// # Errors
    /// If the driver's mind cannot be read.
    pub fn new(hub: Arc<Hub>, mut subject: Subject, seed: u64) -> Result<Self, StageError> {
        let driver = subject.first_driver();
        let world = Faulty::new(world_of(&subject.plan, |_| {})?);
        let lane = Lane::new(&mut subject, driver, world)?;
        let scenario = subject.plan.file.environment.as_highway().map_or(Scenario::Mix, |(c, _)| c.scenario);
        let saved = demonstration::last_saved(&subject.store);
        let mut stage = Self {
            hub,
            subject,
            lanes: vec![lane],
            body: None,
            clock: Clock::new(true),
            scenario,
            scene: None,
            demonstration: None,
            held: None,
            cruise: 1,
            saved,
            training: None,
            shared: SharedTraining::default(),
            taken_in: Vec::new(),
            run_kept: false,
            situations: Vec::new(),
            notice: None,
            streams: Streams::new(seed).child("studio"),
            seed,
            told: Instant::now(),
        };
        stage.begin_episode()?;
        stage.look_at_situations()?;
        stage.take_in_body(driver)?;
        Ok(stage)
    }

    /// What pages draw curves from.
    #[must_use]
    pub fn shared(&self) -> SharedTraining {
        self.shared.clone()
    }

    /// The experiment.
    #[must_use]
    pub fn plan(&self) -> Arc<Plan> {
        self.subject.plan.clone()
    }

    /// The roads of its world, and after them the one that a body is on, where that is known.
    #[must_use]
    pub fn roads(&self) -> Vec<RoadOutline> {
        let simulated = self.lanes[0].world.world.grounds();
        let real = self.body.as_ref().and_then(BodyLane::ground);
        simulated.iter().chain(real).map(crate::drawings::outline).collect()
    }

    /// Listens and moves until somebody says quit.
    pub fn run(mut self, orders: &Receiver<Order>) {
        self.tell();
        loop {
            let patience = self.wait();
            let done = match orders.recv_timeout(patience) {
                Ok(Order::Quit) | Err(RecvTimeoutError::Disconnected) => break,
                Ok(Order::Refresh) => self.refresh(),
                Ok(Order::Ask(request)) => self.obey(request),
                Err(RecvTimeoutError::Timeout) => self.tick(),
            };
            self.notice = done.err().map(|error| error.to_string());
            if self.notice.is_some() {
                self.clock.run(false);
                self.tell();
            }
        }
        // Nobody is left to be told if this fails.
        let _ = self.end_demonstration();
    }

    /// Until the next motor step, or the next report while a run trains.
    fn wait(&self) -> Duration {
        if self.is_idle() { STATUS_EVERY } else { self.clock.wait().unwrap_or(STATUS_EVERY) }
    }

    /// Whether nobody would see a step: there is no page, or the stage shows the training run.
    fn is_idle(&self) -> bool {
        self.hub.shows_training() || self.hub.pages() == 0
    }

    fn refresh(&mut self) -> Result<(), StageError> {
        let taken = self.take_in_what_was_learned();
        self.tell();
        taken
    }

    /// The clock struck.
    fn tick(&mut self) -> Result<(), StageError> {
        if !self.is_idle() && self.clock.is_running() {
            self.advance()?;
            self.clock.stepped();
        }
        let now = Instant::now();
        if now.duration_since(self.told) < STATUS_EVERY {
            return Ok(());
        }
        self.told = now;
        if self.hub.pages() > 0 {
            self.tell();
        }
        self.take_in_what_was_learned()
    }

    /// One motor step of whoever is at the wheel.
    fn advance(&mut self) -> Result<(), StageError> {
        self.scene = None;
        match self.demonstration {
            _ if self.body.is_some() => self.drive_body(),
            Some(_) => self.demonstrate(self.held.unwrap_or(self.cruise)),
            None => self.drive(),
        }
    }

    /// Every lane decides and moves.
    fn drive(&mut self) -> Result<(), StageError> {
        let mut frames = Vec::new();
        let mut over = false;
        for lane in &mut self.lanes {
            let mut frame = lane.think()?;
            let outcome = lane.act(&mut frame)?;
            over |= Lane::is_over(&outcome);
            frames.push(frame);
        }
        let (step, episode) = (self.lanes[0].step - 1, self.lanes[0].episode);
        self.publish(frames, (episode, step), Source::Drive);
        if over { self.begin_episode() } else { Ok(()) }
    }

    fn publish(&self, lanes: Vec<LaneFrame>, (episode, step): (usize, usize), source: Source) {
        let (scene, phase) = (self.scene, None);
        let secs = if self.clock.is_running() { self.clock.step_secs() } else { SINGLE_STEP_SECS };
        self.hub.publish(Frame { n: 0, source, phase, episode, step, secs, done: true, scene, lanes });
    }

    /// Shows what would be done where everybody stands.
    fn preview(&mut self) -> Result<(), StageError> {
        if self.body.is_some() {
            return self.preview_body();
        }
        let mut lanes = Vec::new();
        for lane in &mut self.lanes {
            lanes.push(lane.think()?);
        }
        let source = if self.demonstration.is_some() { Source::Demonstration } else { Source::Drive };
        let (step, episode) = (self.lanes[0].step, self.lanes[0].episode);
        let (secs, scene) = (self.clock.step_secs(), self.scene);
        let frame = Frame { n: 0, source, phase: None, episode, step, secs, done: false, scene, lanes };
        self.hub.publish(frame);
        Ok(())
    }

    /// All lanes to the same start, in the same traffic.
    fn begin_episode(&mut self) -> Result<(), StageError> {
        self.seed = self.streams.seed();
        self.streams = self.streams.nth(1);
        if let Some(body) = &mut self.body {
            body.episode += 1;
            return Ok(body.reset(self.seed)?);
        }
        for lane in &mut self.lanes {
            lane.reset(self.seed)?;
            lane.episode += 1;
        }
        Ok(())
    }

    /// Does what a page asks for.
    fn obey(&mut self, request: Request) -> Result<(), StageError> {
        if self.body.is_some() && !request.suits_a_body() {
            return Err(StageError::Request("a body is only watched here, and held, and stopped"));
        }
        match request {
            Request::Pause => {
                self.clock.run(false);
                self.hub.show_last();
            }
            Request::Resume => self.clock.run(true),
            Request::Step => self.single_step()?,
            Request::Speed { times } => self.clock.set_times(times),
            Request::Demonstrate => self.take_over()?,
            Request::Press { action } => self.press(action)?,
            Request::Lift => self.held = None,
            Request::Undo => self.undo()?,
            Request::Save => self.save()?,
            Request::Reset => self.reset()?,
            Request::Watch { driver } => self.watch(driver)?,
            Request::Compare { driver } => self.compare(driver)?,
            Request::Scenario { name } => self.choose_scenario(&name)?,
            Request::Scene { index } => self.choose_scene(index)?,
            Request::Place { body, x, y, heading } => self.place(body, (x, y), heading)?,
            Request::Fault { sensor, fault } => self.set_fault(sensor, fault)?,
            Request::Train { demonstrations } => self.train(demonstrations)?,
            Request::PauseTraining => self.control_training(State::Paused)?,
            Request::ResumeTraining => self.control_training(State::Running)?,
            Request::StopTraining => self.control_training(State::Stopped)?,
            Request::ViewTraining { on } => self.hub.show_training(on && self.training.is_some()),
            Request::Pace { steps_per_sec } => self.pace(steps_per_sec)?,
            Request::TakeWheel | Request::ReleaseWheel | Request::Recall { .. } | Request::Brake => {}
        }
        self.tell();
        Ok(())
    }

    fn single_step(&mut self) -> Result<(), StageError> {
        self.clock.run(false);
        self.advance()
    }

    fn reset(&mut self) -> Result<(), StageError> {
        if let Some(demonstration) = &mut self.demonstration {
            demonstration.close_episode(&mut self.lanes[0])?;
        }
        self.scene = None;
        self.begin_episode()?;
        self.preview()
    }

    fn look_at_situations(&mut self) -> Result<(), StageError> {
        self.situations = table1(&mut self.lanes[0])?;
        Ok(())
    }

    pub(crate) fn tell(&mut self) {
        self.told = Instant::now();
        if let Ok(text) = serde_json::to_string(&crate::status::Status::of(self)) {
            self.hub.tell(&text);
        }
    }
}
