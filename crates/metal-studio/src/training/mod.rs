//! A training run in a thread of its own: started, held, stopped and watched from the page.
//!
//! Held and stopped is the world, not the mind: a world that stands still makes no step, and one that fails ends the
//! loop with everything learned so far in place. A run that is watched learns the same bits as one that is not.

mod control;
mod tap;

pub use control::{Control, State};

use crate::hub::Hub;
use crate::learned::Learned;
use metal_lab::evaluate::{Course, best_blind_action};
use metal_lab::mind::Mind;
use metal_lab::plan::{Acting, Plan};
use metal_lab::recorded::recorder;
use metal_lab::registry::Roads;
use metal_lab::trace::Trace;
use metal_lab::train::{RunError, Watch, learn_phase};
use metal_recording::{Beliefs, Tape};
use metal_rl::policy::Heard;
use metal_rl::random::Streams;
use std::sync::Arc;
use tap::{Eye, Tap, world};

/// The one number all randomness of a run comes from: that of `metal run` when nobody names another.
pub const SEED: u64 = 1;
/// Test runs per constant action.
const BLIND_RUNS: usize = 40;

/// A run that was started.
pub struct Training {
    /// Holds and ends it.
    pub control: Arc<Control>,
    /// What it has learned.
    pub learned: Arc<Learned>,
    /// The experiment as it is learned.
    pub plan: Arc<Plan>,
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
    /// Where every step of learning is recorded, if anywhere.
    pub tape: Option<Tape>,
}

impl Training {
    /// Starts a run.
    ///
    /// # Errors
    /// If the system gives no thread.
    pub fn start(syllabus: Syllabus) -> std::io::Result<Self> {
        let (control, learned) =
            (Arc::new(Control::new()), Arc::new(Learned::new(shown_first(&syllabus.plan))));
        let (of_thread, book) = (control.clone(), learned.clone());
        let plan = syllabus.plan.clone();
        let thread = std::thread::Builder::new().name("training".to_owned()).spawn(move || {
            let learned = learn(&syllabus, &of_thread, &book);
            // What was recorded until something failed is worth keeping.
            let recorded = syllabus.tape.as_ref().map_or(Ok(()), Tape::finish);
            let failure = match (learned, recorded) {
                (Err(error), _) if of_thread.state() != State::Stopped => Some(error.to_string()),
                (_, Err(error)) => {
                    Some(format!("what is learned is kept, but the recording is not whole: {error}"))
                }
                _ => None,
            };
            match failure {
                Some(failure) => {
                    book.fail(&failure);
                    of_thread.set(State::Failed);
                }
                None => of_thread.set(State::Finished),
            }
            syllabus.hub.order(crate::hub::Order::Refresh);
        })?;
        Ok(Self { control, learned, plan, thread: Some(thread) })
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
        let (trace, beliefs) = (Trace::new(&plan.spec), syllabus.tape.clone().map(Beliefs));
        let mut observer = Eye { tap: &tap, learned, trace, beliefs };
        let mut ear = |heard: &Heard<'_>| tap.hear(heard);
        let mut shown = world(plan, &name, (control, &tap))?;
        if let Some(tape) = &syllabus.tape {
            tape.text("/phase", &name);
            shown = Box::new(recorder((plan, &name), shown, tape));
        }
        let progress = &Patience { control };
        let watch = Watch { environment: shown.as_mut(), observer: &mut observer, ear: &mut ear, progress };
        learn_phase(plan, &name, &mut mind, &streams, watch)?;
        learned.finish(&name, mind);
        syllabus.hub.order(crate::hub::Order::Refresh);
    }
    learned.set_blind(best_blind(plan, &newborn, control)?);
    Ok(())
}

/// The best constant action, as every run folder names it.
fn best_blind(plan: &Plan, mind: &Mind, control: &Control) -> Result<usize, RunError> {
    let scenario = plan.file.environment.training_scenario();
    let course = Course { scenario, roads: Roads::Validation, runs: BLIND_RUNS };
    best_blind_action(plan, mind, &course, &Streams::new(SEED).child("blind"), &Patience { control })
}

/// Lets a test be stopped.
struct Patience<'a> {
    control: &'a Control,
}

impl metal_lab::progress::Progress for Patience<'_> {
    fn steps(&self, _steps: usize) {}

    fn interrupted(&self) -> bool {
        self.control.state() == State::Stopped
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use metal_lab::plan;
    use std::sync::mpsc::sync_channel;
    use std::time::Duration;

    fn short_plan() -> Arc<Plan> {
        let mut file = crate::subject::paper().unwrap().file;
        metal_lab::reproduce::quick::cut(&mut file, 3, 40);
        let attends = ["demonstration", "fusion", "attention"];
        file.phase.retain(|name, _| attends.contains(&name.as_str()));
        file.policy.retain(|name, _| name == "acl" || name == "oracle");
        file.subsets = None;
        Arc::new(plan::Plan::check(file).unwrap())
    }

    fn start(hub: &Arc<Hub>, tape: Option<Tape>) -> Training {
        Training::start(Syllabus { plan: short_plan(), seed: 1, hub: hub.clone(), tape }).unwrap()
    }

    fn hub() -> (Arc<Hub>, std::sync::mpsc::Receiver<crate::hub::Order>) {
        let (orders, stage) = sync_channel(64);
        (Arc::new(Hub::new(orders)), stage)
    }

    #[test]
    fn a_watched_and_recorded_run_learns_the_same_bits_as_the_lab() {
        let file = std::env::temp_dir().join(format!("metal-studio-tape-{}.mcap", std::process::id()));
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
        let mut training = start(&hub, Some(Tape::create(&file, &short_plan().spec).unwrap()));
        training.join();
        assert_eq!(training.control.state(), State::Finished);
        stop.send(()).unwrap();
        pulse.join().unwrap();
        let streams = Streams::new(1).child("report").nth(0);
        let alone =
            metal_lab::train::train_seed(&short_plan(), &streams, &metal_lab::progress::Silent).unwrap();
        let order = ["demonstration", "fusion", "attention"];
        for phase in order {
            let watched = training.learned.mind(phase).unwrap();
            let none = std::collections::BTreeMap::new();
            assert!(watched.freeze(&none) == alone[phase].mind.freeze(&none), "{phase}");
        }
        let happened = order.iter().flat_map(|&phase| &alone[phase].trace.episodes);
        let happened: Vec<(usize, f64)> = happened.map(|e| (e.looks.len(), e.motor)).collect();
        assert_eq!(recorded(&file).len(), happened.len());
        for (recorded, happened) in recorded(&file).into_iter().zip(happened) {
            assert_eq!(recorded, happened, "steps and motor reward of an episode");
        }
        let on_tape = metal_recording::tape::index(&std::fs::read(&file).unwrap()).unwrap();
        assert!(["/image_raw", "/supports/0"].iter().all(|topic| on_tape.iter().any(|(t, _)| t == topic)));
        std::fs::remove_file(&file).unwrap();
        let frames = hub.lately(1000);
        assert!(frames.iter().any(|f| f.phase.as_deref() == Some("attention")), "{} frames", frames.len());
        let frame = frames.iter().rfind(|f| f.phase.as_deref() == Some("attention")).unwrap();
        assert_eq!(frame.lanes[0].values.len(), frame.lanes[0].asked.len() + 1, "values before each choice");
        assert_ne!(frame.lanes[0].from, frame.lanes[0].to);
    }

    /// Motor steps and the sum of their rewards, by episode.
    fn recorded(file: &std::path::Path) -> Vec<(usize, f64)> {
        let replay = metal_recording::Replay::open(file).unwrap();
        let rewards = |steps: &Vec<metal_recording::replay::Recorded>| {
            let rewards = steps.iter().filter_map(|s| s.moved).map(|(_, outcome)| outcome.motor_reward);
            (rewards.clone().count(), rewards.sum())
        };
        replay.episodes().iter().map(rewards).collect()
    }

    #[test]
    fn a_run_is_held_goes_on_and_is_stopped() {
        let (hub, _stage) = hub();
        let mut training = start(&hub, None);
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
