//! The stage: a thread that owns the worlds, listens to the pages, and moves when its clock says so.

use crate::clock::Clock;
use crate::command::Request;
use crate::demonstration::{self, Demonstration, Shown};
use crate::faults::{Fault, Faulty};
use crate::frame::{Frame, LaneFrame, Source};
use crate::hub::{Hub, Order};
use crate::lane::{Lane, world_of};
use crate::situations::{Looked, table1};
use crate::subject::{Subject, SubjectError};
use crate::training::{State, Syllabus, Training};
use metal_lab::plan::{Acting, Plan};
use metal_rl::environment::{End, EnvironmentError};
use metal_rl::num;
use metal_rl::random::Streams;
use metal_worlds::highway::{Ground, Pose, Scenario, Situation, Start};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// How often pages are told how things stand while nothing is asked.
const STATUS_EVERY: Duration = Duration::from_millis(250);

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
    pub(crate) clock: Clock,
    pub(crate) scenario: Scenario,
    pub(crate) scene: Option<usize>,
    pub(crate) demonstration: Option<Demonstration>,
    pub(crate) held: Option<usize>,
    pub(crate) cruise: usize,
    pub(crate) saved: Option<String>,
    pub(crate) training: Option<Training>,
    pub(crate) shared: SharedTraining,
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
            clock: Clock::new(true),
            scenario,
            scene: None,
            demonstration: None,
            held: None,
            cruise: 1,
            saved,
            training: None,
            shared: SharedTraining::default(),
            situations: Vec::new(),
            notice: None,
            streams: Streams::new(seed).child("studio"),
            seed,
            told: Instant::now(),
        };
        stage.begin_episode()?;
        stage.look_at_situations()?;
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

    /// The roads of its world.
    #[must_use]
    pub fn grounds(&self) -> Arc<[Ground]> {
        self.lanes[0].world.world.grounds()
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
        let step = if self.hub.shows_training() { None } else { self.clock.wait() };
        step.unwrap_or(STATUS_EVERY)
    }

    fn refresh(&mut self) -> Result<(), StageError> {
        self.take_in_what_was_learned();
        self.tell();
        Ok(())
    }

    /// The clock struck.
    fn tick(&mut self) -> Result<(), StageError> {
        if !self.hub.shows_training() && self.clock.is_running() {
            self.advance()?;
            self.clock.stepped();
        }
        let now = Instant::now();
        if now.duration_since(self.told) >= STATUS_EVERY && self.hub.pages() > 0 {
            self.tell();
        }
        Ok(())
    }

    /// One motor step of whoever is at the wheel.
    fn advance(&mut self) -> Result<(), StageError> {
        self.scene = None;
        match self.demonstration {
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
        let (secs, scene) = (self.clock.step_secs(), self.scene);
        let phase = None;
        self.hub.publish(Frame { n: 0, source, phase, episode, step, secs, done: true, scene, lanes });
    }

    /// Shows what would be done where everybody stands.
    fn preview(&mut self) -> Result<(), StageError> {
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
        for lane in &mut self.lanes {
            lane.reset(self.seed)?;
            lane.episode += 1;
        }
        Ok(())
    }

    /// One step of a person, written down.
    fn demonstrate(&mut self, action: usize) -> Result<(), StageError> {
        let Some(demonstration) = &mut self.demonstration else { return Ok(()) };
        let lane = &mut self.lanes[0];
        let readings = demonstration.before(lane)?;
        let mut frame = lane.watch(action)?;
        let (step, episode) = (lane.step, lane.episode);
        let outcome = lane.act(&mut frame)?;
        let (advice, accident) = (frame.advice, frame.accident);
        demonstration.record(readings, &Shown { step, action, advice, accident, outcome });
        let complete = demonstration.quality().steps == demonstration::WANTED;
        if outcome.end != End::Running {
            demonstration.close_episode(lane)?;
        }
        self.publish(vec![frame], (episode, step), Source::Demonstration);
        if outcome.end != End::Running {
            self.begin_episode()?;
        }
        if complete {
            self.clock.run(false);
            self.save()?;
        }
        Ok(())
    }

    fn save(&mut self) -> Result<(), StageError> {
        if let Some(demonstration) = self.demonstration.as_mut().filter(|d| d.is_unsaved()) {
            self.saved = Some(demonstration.save(&self.subject.store)?);
        }
        Ok(())
    }

    /// Does what a page asks for.
    fn obey(&mut self, request: Request) -> Result<(), StageError> {
        match request {
            Request::Pause => self.clock.run(false),
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
            Request::TakeWheel | Request::ReleaseWheel | Request::Recall { .. } => {}
        }
        self.tell();
        Ok(())
    }

    fn single_step(&mut self) -> Result<(), StageError> {
        self.clock.run(false);
        self.advance()
    }

    /// A person takes the wheel: the clock stands until they move.
    fn take_over(&mut self) -> Result<(), StageError> {
        self.hub.show_training(false);
        self.lanes.truncate(1);
        self.clock.run(false);
        self.clock.set_times(1.0);
        (self.held, self.cruise, self.scene) = (None, 1, None);
        if self.demonstration.is_none() {
            self.demonstration = Some(Demonstration::new(&self.subject.plan.spec));
            self.begin_episode()?;
        }
        self.preview()
    }

    /// The person leaves the wheel; nothing they showed is lost.
    fn end_demonstration(&mut self) -> Result<(), StageError> {
        if let Some(demonstration) = &mut self.demonstration {
            demonstration.close_episode(&mut self.lanes[0])?;
        }
        self.save()?;
        self.demonstration = None;
        Ok(())
    }

    fn press(&mut self, action: usize) -> Result<(), StageError> {
        if action >= self.subject.plan.spec.actions.len() || self.demonstration.is_none() {
            return Err(StageError::Request("press needs a person at the wheel and one of the actions"));
        }
        if !self.clock.is_running() {
            return self.demonstrate(action);
        }
        // A turn lasts as long as its key is held; a speed stays.
        self.held = Some(action);
        if action < 3 {
            self.cruise = action;
        }
        Ok(())
    }

    fn undo(&mut self) -> Result<(), StageError> {
        let lane = &mut self.lanes[0];
        let undone = self.demonstration.as_mut().is_some_and(|d| d.undo(lane));
        if !undone {
            return Err(StageError::Request("there is no step to take back"));
        }
        self.clock.run(false);
        self.hub.forget_last();
        self.preview()
    }

    fn reset(&mut self) -> Result<(), StageError> {
        if let Some(demonstration) = &mut self.demonstration {
            demonstration.close_episode(&mut self.lanes[0])?;
        }
        self.scene = None;
        self.begin_episode()?;
        self.preview()
    }

    fn watch(&mut self, driver: usize) -> Result<(), StageError> {
        if driver >= self.subject.drivers.len() {
            return Err(StageError::Request("there is no such driver"));
        }
        self.end_demonstration()?;
        let (world, step) = (self.lanes[0].world.clone(), self.lanes[0].step);
        let mut lane = Lane::new(&mut self.subject, driver, world)?;
        (lane.step, lane.episode) = (step, self.lanes[0].episode);
        self.lanes[0] = lane;
        self.hub.show_training(false);
        self.look_at_situations()?;
        self.preview()
    }

    /// A second mind, from the same start in the same traffic.
    fn compare(&mut self, driver: Option<usize>) -> Result<(), StageError> {
        self.end_demonstration()?;
        self.lanes.truncate(1);
        if let Some(driver) = driver {
            if driver >= self.subject.drivers.len() {
                return Err(StageError::Request("there is no such driver"));
            }
            let world = self.lanes[0].world.clone();
            self.lanes.push(Lane::new(&mut self.subject, driver, world)?);
            self.begin_episode()?;
        }
        self.hub.show_training(false);
        self.preview()
    }

    fn choose_scenario(&mut self, name: &str) -> Result<(), StageError> {
        let Some(&scenario) = Scenario::ALL.iter().find(|s| s.name() == name) else {
            return Err(StageError::Request("there is no such scenario"));
        };
        self.scenario = scenario;
        let world = world_of(&self.subject.plan, |config| config.scenario = scenario)?;
        for lane in &mut self.lanes {
            lane.world.world = world.clone();
        }
        self.reset()
    }

    fn choose_scene(&mut self, index: usize) -> Result<(), StageError> {
        let Some(&situation) = Situation::ALL.get(index) else {
            return Err(StageError::Request("Table 1 has six situations"));
        };
        let start = situation.start(self.lanes[0].world.world.road());
        self.arrange(&start)?;
        self.clock.run(false);
        self.scene = Some(index);
        self.hub.show_training(false);
        self.preview()
    }

    /// Everybody to where `start` says: a demonstration that goes on begins a new episode there.
    fn arrange(&mut self, start: &Start) -> Result<(), StageError> {
        if let Some(demonstration) = &mut self.demonstration {
            demonstration.close_episode(&mut self.lanes[0])?;
        }
        for lane in &mut self.lanes {
            lane.world.world.place(start);
            lane.step = 0;
        }
        Ok(())
    }

    fn place(&mut self, body: usize, (x, y): (f64, f64), heading: Option<f64>) -> Result<(), StageError> {
        let world = &self.lanes[0].world.world;
        let mut cars = [Pose::default(); 2];
        let car_count = world.cars().len();
        cars[..car_count].copy_from_slice(world.cars());
        let mut start = Start { learner: world.learner(), cars, car_count };
        let [low, high] = world.road().bounds_m();
        let inside = (low[0]..=high[0]).contains(&x) && (low[1]..=high[1]).contains(&y);
        let moved = match body {
            0 => &mut start.learner,
            n if n <= car_count => &mut start.cars[n - 1],
            _ => return Err(StageError::Request("there is no such car")),
        };
        let heading_rad = heading.map_or(moved.heading_rad, num::wrap_angle);
        if !inside || !heading_rad.is_finite() {
            return Err(StageError::Request("that place is outside the world"));
        }
        *moved = Pose { x_m: x, y_m: y, heading_rad };
        self.clock.run(false);
        self.scene = None;
        self.arrange(&start)?;
        self.preview()
    }

    fn set_fault(&mut self, sensor: usize, fault: Fault) -> Result<(), StageError> {
        if sensor >= self.subject.plan.spec.sensors.len() {
            return Err(StageError::Request("there is no such sensor"));
        }
        for lane in &mut self.lanes {
            lane.world.faults[sensor] = fault;
        }
        self.look_at_situations()?;
        self.preview()
    }

    fn train(&mut self, from_person: bool) -> Result<(), StageError> {
        if self.training.as_ref().is_some_and(Training::is_alive) {
            return Err(StageError::Request("a run is training already"));
        }
        self.end_demonstration()?;
        let mut file = self.subject.plan.file.clone();
        if from_person {
            let Some(name) = &self.saved else {
                return Err(StageError::Request("no demonstration was saved yet"));
            };
            file.watch_demonstrations(&self.subject.store.path(name));
        }
        let plan = Arc::new(Plan::check(file)?);
        let training = Training::start(Syllabus { plan, seed: 1, hub: self.hub.clone() })?;
        *crate::hub::lock(&self.shared) = Some(training.learned.clone());
        self.training = Some(training);
        self.hub.show_training(true);
        Ok(())
    }

    fn control_training(&mut self, state: State) -> Result<(), StageError> {
        let Some(training) = &mut self.training else {
            return Err(StageError::Request("no run is training"));
        };
        training.control.set(state);
        if state == State::Stopped {
            training.join();
            self.take_in_what_was_learned();
        }
        Ok(())
    }

    fn pace(&mut self, steps_per_sec: f64) -> Result<(), StageError> {
        let Some(training) = &self.training else {
            return Err(StageError::Request("no run is training"));
        };
        training.control.pace(if steps_per_sec.is_finite() { steps_per_sec.clamp(0.0, 1000.0) } else { 0.0 });
        Ok(())
    }

    /// Minds of phases that were finished meanwhile become drivers, and are kept in the folder unless it holds a run.
    fn take_in_what_was_learned(&mut self) {
        let Some(training) = &self.training else { return };
        let rosters = |plan: &Plan| {
            let rows = plan.file.phase.values();
            rows.filter_map(|row| match &row.acting {
                Acting::Attention(name) => Some((name.clone(), row.roster.clone())),
                _ => None,
            })
            .collect()
        };
        for phase in training.learned.finished() {
            if self.subject.knows_fresh(&phase) {
                continue;
            }
            let Some(mind) = training.learned.mind(&phase) else { continue };
            if !self.subject.is_run() {
                let frozen = mind.freeze(&rosters(&self.subject.plan));
                let written = self.subject.store.write_mind(0, &phase, &frozen);
                self.notice = written.err().map(|e| e.to_string());
            }
            self.subject.add_fresh(&phase, mind);
        }
        if !training.is_alive() {
            self.hub.show_training(false);
        }
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
