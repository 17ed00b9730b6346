//! A training run in a thread of its own: started, held, stopped and watched from the page.
//!
//! Held and stopped is the world, not the mind: a world that stands still makes no step, and one that fails ends the
//! loop with everything learned so far in place. A run that is watched learns the same bits as one that is not.

use crate::frame::{Frame, LaneFrame, Source};
use crate::hub::{Hub, lock};
use crate::learned::{Episode, Learned};
use metal_lab::mind::Mind;
use metal_lab::plan::{Acting, Plan};
use metal_lab::trace::Trace;
use metal_lab::train::{RunError, Watch, classroom, learn_phase};
use metal_lab::watched::Heard;
use metal_rl::environment::{Environment, EnvironmentError, EnvironmentSpec, Outcome};
use metal_rl::member::Member;
use metal_rl::observe::{Observer, Step};
use metal_rl::random::Streams;
use metal_worlds::highway::Highway;
use serde::Serialize;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Duration;

/// How a run stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum State {
    /// It learns.
    Running,
    /// It is held.
    Paused,
    /// Somebody ended it.
    Stopped,
    /// Every phase is learned.
    Finished,
    /// Something went wrong.
    Failed,
}

/// Why a stopped world gives no more steps.
const STOPPED: &str = "stopped from the studio";

/// What page and run share.
pub struct Control {
    state: Mutex<State>,
    changed: Condvar,
    /// Looked at before every step; the lock is taken only if it is set.
    attention_needed: AtomicBool,
    nap_micros: AtomicU64,
}

impl Control {
    fn new() -> Self {
        Self {
            state: Mutex::new(State::Running),
            changed: Condvar::new(),
            attention_needed: AtomicBool::new(false),
            nap_micros: AtomicU64::new(0),
        }
    }

    /// How the run stands.
    pub fn state(&self) -> State {
        *lock(&self.state)
    }

    /// Changes how the run stands; a run that is over stays over.
    pub fn set(&self, wanted: State) {
        let mut state = lock(&self.state);
        if matches!(*state, State::Running | State::Paused) {
            *state = wanted;
        }
        self.attention_needed.store(*state != State::Running, Ordering::Relaxed);
        self.changed.notify_all();
    }

    /// At most so many motor steps a second; 0: as fast as it can.
    pub fn pace(&self, steps_per_sec: f64) {
        let micros = if steps_per_sec > 0.0 { 1e6 / steps_per_sec } else { 0.0 };
        self.nap_micros.store(micros as u64, Ordering::Relaxed);
    }

    /// Lets the run through, holds it, or ends it.
    fn gate(&self, environment: &EnvironmentSpec) -> Result<(), EnvironmentError> {
        let nap = self.nap_micros.load(Ordering::Relaxed);
        if nap > 0 {
            std::thread::sleep(Duration::from_micros(nap));
        }
        if !self.attention_needed.load(Ordering::Relaxed) {
            return Ok(());
        }
        let mut state = lock(&self.state);
        while *state == State::Paused {
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        if *state == State::Running {
            return Ok(());
        }
        Err(EnvironmentError::Motor {
            environment: environment.id.clone(),
            action: "step".to_owned(),
            reason: STOPPED.to_owned(),
        })
    }
}

/// A run that was started.
pub struct Training {
    /// Holds and ends it.
    pub control: Arc<Control>,
    /// What it has learned.
    pub learned: Arc<Learned>,
    thread: Option<std::thread::JoinHandle<()>>,
}

/// What a run is made of.
pub struct Syllabus {
    /// The experiment.
    pub plan: Arc<Plan>,
    /// The one number all randomness comes from; the same as that of the first training of `metal run --seed`.
    pub seed: u64,
    /// Where frames go.
    pub hub: Arc<Hub>,
}

impl Training {
    /// Starts a run.
    ///
    /// # Errors
    /// If the system gives no thread.
    pub fn start(syllabus: Syllabus) -> std::io::Result<Self> {
        let (control, learned) = (Arc::new(Control::new()), Arc::new(Learned::new(shown_first(&syllabus.plan))));
        let (of_thread, book) = (control.clone(), learned.clone());
        let thread = std::thread::Builder::new().name("training".to_owned()).spawn(move || {
            match learn(&syllabus, &of_thread, &book) {
                Ok(()) => of_thread.set(State::Finished),
                Err(_) if of_thread.state() == State::Stopped => {}
                Err(error) => {
                    book.fail(&error.to_string());
                    of_thread.set(State::Failed);
                }
            }
            syllabus.hub.order(crate::hub::Order::Refresh);
        })?;
        Ok(Self { control, learned, thread: Some(thread) })
    }

    /// Whether it still learns or is only held.
    #[must_use]
    pub fn is_alive(&self) -> bool {
        matches!(self.control.state(), State::Running | State::Paused)
    }

    /// Waits for the end of the run.
    pub fn join(&mut self) {
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

impl Drop for Training {
    fn drop(&mut self) {
        self.control.set(State::Stopped);
        self.join();
    }
}

/// Every phase of the plan, one after the other, each from the minds its parent left behind.
fn learn(syllabus: &Syllabus, control: &Arc<Control>, learned: &Learned) -> Result<(), RunError> {
    let plan = &syllabus.plan;
    let streams = Streams::new(syllabus.seed).child("report").nth(0);
    let newborn = Mind::newborn(plan, &streams)?;
    for name in shown_first(plan) {
        let parent = plan.file.phase[&name].after.as_ref();
        let mut mind = parent.and_then(|p| learned.mind(p)).unwrap_or_else(|| newborn.clone());
        learned.begin(&name);
        let tap = Tap::new(syllabus, &name);
        let mut observer = Eye { tap: &tap, learned, trace: Trace::new(&plan.spec) };
        let mut ear = |heard: &Heard<'_>| tap.hear(heard);
        let mut shown = world(plan, &name, (control, &tap))?;
        let watch = Watch { environment: shown.as_mut(), observer: &mut observer, ear: &mut ear };
        learn_phase(plan, &name, &mut mind, &streams, watch)?;
        learned.finish(&name, mind);
        syllabus.hub.order(crate::hub::Order::Refresh);
    }
    Ok(())
}

/// The phases in an order of learning: those that lead to attention control first, the comparisons after them.
fn shown_first(plan: &Plan) -> Vec<String> {
    let phases = &plan.file.phase;
    let attends = plan.order.iter().find(|n| matches!(phases[*n].acting, Acting::Attention(_)));
    let line = std::iter::successors(attends, |n| phases[*n].after.as_ref());
    let mut order: Vec<String> = line.cloned().collect();
    order.reverse();
    order.extend(plan.order.iter().filter(|n| !order.contains(n)).cloned().collect::<Vec<_>>());
    order
}

fn world<'a>(
    plan: &Plan,
    name: &str,
    (control, tap): (&'a Arc<Control>, &'a Tap),
) -> Result<Box<dyn Environment + 'a>, RunError> {
    let recorded = matches!(plan.file.phase[name].acting, Acting::Demonstrations(_));
    let room = match plan.file.environment.as_highway().filter(|_| !recorded) {
        Some((config, steering)) => Room::Road(Box::new(metal_lab::registry::highway(config, steering))),
        None => Room::Recording(classroom(plan, name)?),
    };
    Ok(Box::new(Shown { room, control, tap }))
}

/// Where a phase is learned.
enum Room {
    /// On a road, which can be photographed.
    Road(Box<Highway>),
    /// From a recording, where there are readings but no road.
    Recording(Box<dyn Environment>),
}

/// A world that can be held, and that is photographed before and after a step when a page wants to see it.
struct Shown<'a> {
    room: Room,
    control: &'a Control,
    tap: &'a Tap,
}

impl Shown<'_> {
    fn world(&mut self) -> &mut dyn Environment {
        match &mut self.room {
            Room::Road(world) => world.as_mut(),
            Room::Recording(world) => world.as_mut(),
        }
    }

    fn photograph(&mut self) {
        if let Room::Road(world) = &mut self.room {
            self.tap.see(world);
        }
    }
}

impl Environment for Shown<'_> {
    fn spec(&self) -> &EnvironmentSpec {
        match &self.room {
            Room::Road(world) => world.spec(),
            Room::Recording(world) => world.spec(),
        }
    }

    fn reset(&mut self, seed: u64) -> Result<(), EnvironmentError> {
        self.world().reset(seed)
    }

    fn sense(&mut self, sensor: usize, out: &mut [f64]) -> Result<(), EnvironmentError> {
        self.world().sense(sensor, out)
    }

    fn step(&mut self, action: usize) -> Result<Outcome, EnvironmentError> {
        self.control.gate(self.spec())?;
        if !self.tap.is_open() {
            return self.world().step(action);
        }
        self.photograph();
        let outcome = self.world().step(action);
        self.photograph();
        outcome
    }

    fn measures(&self) -> &[f64] {
        match &self.room {
            Room::Road(world) => world.measures(),
            Room::Recording(world) => world.measures(),
        }
    }

    fn advise(&mut self) -> Option<usize> {
        self.world().advise()
    }
}

/// Collects one frame at a time, and only when a page waits for one.
struct Tap {
    plan: Arc<Plan>,
    hub: Arc<Hub>,
    phase: String,
    open: AtomicBool,
    draft: Mutex<Draft>,
}

#[derive(Default)]
struct Draft {
    lane: LaneFrame,
    seen: bool,
}

impl Tap {
    fn new(syllabus: &Syllabus, phase: &str) -> Self {
        Self {
            plan: syllabus.plan.clone(),
            hub: syllabus.hub.clone(),
            phase: phase.to_owned(),
            open: AtomicBool::new(false),
            draft: Mutex::default(),
        }
    }

    fn is_open(&self) -> bool {
        self.open.load(Ordering::Relaxed)
    }

    fn hear(&self, heard: &Heard<'_>) {
        if self.is_open() {
            lock(&self.draft).lane.overhear(heard);
        }
    }

    /// The first picture is where the decision was made, the second where it has led.
    fn see(&self, world: &mut Highway) {
        let mut draft = lock(&self.draft);
        if draft.seen {
            draft.lane.settle(world);
        } else {
            draft.lane.see(world);
            draft.seen = true;
        }
    }

    /// The step is over: out with the frame, and open for the next if somebody waits by now.
    fn step(&self, step: &Step<'_>) {
        if self.is_open() {
            self.send(step);
        }
        let open = self.hub.shows_training() && self.hub.is_wanted();
        if open {
            *lock(&self.draft) = Draft::default();
        }
        self.open.store(open, Ordering::Relaxed);
    }

    fn send(&self, step: &Step<'_>) {
        let Draft { mut lane, seen } = std::mem::take(&mut *lock(&self.draft));
        if !seen {
            return;
        }
        lane.hear(&self.plan, step.state);
        lane.driver = format!("learning: {}", self.phase.replace('_', " "));
        (lane.action, lane.motor, lane.look_price) = (step.action, step.motor_reward, step.look_price);
        self.hub.publish(Frame {
            n: 0,
            source: Source::Training,
            phase: Some(self.phase.clone()),
            episode: step.episode,
            step: step.index,
            secs: 1.0 / 30.0,
            done: true,
            scene: None,
            lanes: vec![lane],
        });
    }
}

/// Sees everything, writes down what curves need.
struct Eye<'a> {
    tap: &'a Tap,
    learned: &'a Learned,
    trace: Trace,
}

impl Observer for Eye<'_> {
    fn on_step(&mut self, step: &Step<'_>) {
        self.trace.on_step(step);
        self.tap.step(step);
    }

    fn on_episode(&mut self, episode: usize, progress: f64) {
        self.trace.on_episode(episode, progress);
        if let Some(record) = self.trace.episodes.pop() {
            self.learned.add(Episode::of(&record), progress);
        }
    }

    fn on_members(&mut self, members: &[Member]) {
        self.learned.look_at(members);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use metal_lab::plan;
    use std::sync::mpsc::sync_channel;

    fn short_plan() -> Arc<Plan> {
        let mut file = crate::subject::paper().unwrap().file;
        metal_lab::reproduce::quick::cut(&mut file, 3, 40);
        let attends = ["demonstration", "fusion", "attention"];
        file.phase.retain(|name, _| attends.contains(&name.as_str()));
        file.policy.retain(|name, _| name == "acl" || name == "oracle");
        file.subsets = None;
        Arc::new(plan::Plan::check(file).unwrap())
    }

    fn start(hub: &Arc<Hub>) -> Training {
        Training::start(Syllabus { plan: short_plan(), seed: 1, hub: hub.clone() }).unwrap()
    }

    fn hub() -> (Arc<Hub>, std::sync::mpsc::Receiver<crate::hub::Order>) {
        let (orders, stage) = sync_channel(64);
        (Arc::new(Hub::new(orders)), stage)
    }

    #[test]
    fn a_watched_run_learns_the_same_bits_as_the_lab() {
        let (hub, _stage) = hub();
        hub.enter();
        hub.show_training(true);
        let looking = hub.clone();
        let (stop, stopped) = std::sync::mpsc::channel::<()>();
        let pulse = std::thread::spawn(move || {
            while stopped.recv_timeout(Duration::from_millis(1)).is_err() {
                looking.want();
            }
        });
        let mut training = start(&hub);
        training.join();
        assert_eq!(training.control.state(), State::Finished);
        stop.send(()).unwrap();
        pulse.join().unwrap();
        let streams = Streams::new(1).child("report").nth(0);
        let alone =
            metal_lab::train::train_seed(&short_plan(), &streams, &metal_lab::progress::Silent).unwrap();
        for phase in ["demonstration", "fusion", "attention"] {
            let watched = training.learned.mind(phase).unwrap();
            let none = std::collections::BTreeMap::new();
            assert!(watched.freeze(&none) == alone[phase].mind.freeze(&none), "{phase}");
        }
        let frames = hub.lately(1000);
        assert!(frames.iter().any(|f| f.phase.as_deref() == Some("attention")), "{} frames", frames.len());
        let frame = frames.iter().rfind(|f| f.phase.as_deref() == Some("attention")).unwrap();
        assert_eq!(frame.lanes[0].values.len(), frame.lanes[0].asked.len() + 1, "values before each choice");
        assert_ne!(frame.lanes[0].from, frame.lanes[0].to);
    }

    #[test]
    fn a_run_is_held_goes_on_and_is_stopped() {
        let (hub, _stage) = hub();
        let mut training = start(&hub);
        training.control.set(State::Paused);
        std::thread::sleep(Duration::from_millis(50));
        let held = training.learned.episodes();
        std::thread::sleep(Duration::from_millis(50));
        assert_eq!(training.learned.episodes(), held);
        assert!(training.is_alive());
        training.control.set(State::Stopped);
        training.join();
        assert_eq!(training.control.state(), State::Stopped);
        training.control.set(State::Running);
        assert_eq!(training.control.state(), State::Stopped, "what is over stays over");
    }
}
