//! Looking at a run without touching it: its world is photographed, its policy overheard, its episodes written down.

use super::Syllabus;
use super::control::Control;
use crate::frame::{Frame, LaneFrame, Source};
use crate::hub::{Hub, lock};
use crate::learned::{Episode, Learned};
use metal_lab::plan::{Acting, Plan};
use metal_lab::trace::Trace;
use metal_lab::train::{RunError, classroom};
use metal_recording::Beliefs;
use metal_rl::environment::{Environment, EnvironmentError, EnvironmentSpec, Outcome, Picture};
use metal_rl::member::Member;
use metal_rl::observe::{Observer, Step};
use metal_rl::policy::Heard;
use metal_worlds::highway::Highway;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

/// The world of phase `name`, to be held by `control` and seen through `tap`.
pub(super) fn world<'a>(
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

    fn picture(&self) -> Option<Picture> {
        match &self.room {
            Room::Road(world) => world.picture(),
            Room::Recording(world) => world.picture(),
        }
    }

    fn advise(&mut self) -> Option<usize> {
        self.world().advise()
    }

    /// Copies are where moves are tried out: nobody watches them, and a pause waits for the next step of the world itself.
    fn fork(&self) -> Option<Box<dyn Environment>> {
        match &self.room {
            Room::Road(world) => world.fork(),
            Room::Recording(world) => world.fork(),
        }
    }
}

/// Collects one frame at a time, and only when a page waits for one.
pub(super) struct Tap {
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
    pub(super) fn new(syllabus: &Syllabus, phase: &str) -> Self {
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

    pub(super) fn hear(&self, heard: &Heard<'_>) {
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
pub(super) struct Eye<'a> {
    pub tap: &'a Tap,
    pub learned: &'a Learned,
    pub trace: Trace,
    /// Somebody writes down what is believed, too.
    pub beliefs: Option<Beliefs>,
}

impl Observer for Eye<'_> {
    fn on_step(&mut self, step: &Step<'_>) {
        self.trace.on_step(step);
        if let Some(beliefs) = &mut self.beliefs {
            beliefs.on_step(step);
        }
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
