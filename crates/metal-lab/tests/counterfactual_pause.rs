//! Counterfactual policy iteration that is stopped after every iteration ends as if nobody had stopped it: judged by
//! roll-outs, by roll-outs where every step is dear, and by a critic.
#![allow(clippy::unwrap_used)]

#[path = "common/maze.rs"]
mod common;

use metal_lab::checkpoint::{Begun, Checkpoint, Job, Ledger, begin};
use metal_lab::plan::{self, Plan};
use metal_lab::progress::{Progress, Silent};
use metal_lab::reproduce::Options;
use metal_lab::store::Store;
use metal_lab::train::{RunError, Trained, train_seed, train_seed_kept};
use metal_rl::random::Streams;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

const RECIPE: &str = "iterations = 5
wide_eyed = 1
price_ramp = 2
horizon = 6
window = 2
validation_runs = 5
memory = { looks = 1, steps = 3, actions = 1 }
fit = { batches = 20, averaged = 0.3, inputs = \"standardized\" }
network = { ensemble = 2, hidden = [16] }";

/// The maze with one more line of settings.
fn maze(setting: &str) -> Plan {
    plan::parse(&common::maze(&format!("{RECIPE}\n{setting}"), 1000), &[]).unwrap()
}

/// Somebody who wants to stop whenever something was saved, and never before.
#[derive(Default)]
struct Impatient {
    asked: AtomicUsize,
}

impl Progress for Impatient {
    fn steps(&self, _steps: usize) {}
    fn warn(&self, what: &str) {
        panic!("{what}");
    }
    fn interrupted(&self) -> bool {
        // Asked before an iteration and after it was saved.
        self.asked.fetch_add(1, Ordering::Relaxed) > 0
    }
}

/// The run in `folder`, saved after every iteration.
fn checkpoint(folder: &Path, plan: &Plan) -> Checkpoint {
    let job = Job::new(plan, &Options { seeds: 1, seed: 3, quick: false, all_subsets: false }).unwrap();
    let start = (metal_lab::checkpoint::Start::Resume, Duration::ZERO);
    match begin(&Store::create(folder).unwrap(), &job, start, &|_| {}).unwrap() {
        Begun::Work(checkpoint) => checkpoint,
        Begun::Finished => panic!("it is not finished"),
    }
}

/// Trains with a stop after every iteration; also how often it was stopped.
fn stopped_often(name: &str, plan: &Plan) -> (Trained, usize) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&folder);
    let mut stops = 0;
    loop {
        let (checkpoint, person) = (checkpoint(&folder, plan), Impatient::default());
        match train_seed_kept(plan, &Streams::new(3), &Ledger::new(&checkpoint, &person)) {
            Err(RunError::Interrupted) => stops += 1,
            Err(e) => panic!("{e}"),
            Ok(mut trained) => return (trained.remove("attention").unwrap(), stops),
        }
    }
}

fn ends_the_same(name: &str, plan: &Plan) {
    let whole = train_seed(plan, &Streams::new(3), &Silent).unwrap().remove("attention").unwrap();
    let (pieced, stops) = stopped_often(name, plan);
    assert!(stops >= plan.counterfactual("attention").unwrap().1.iterations, "{name}: {stops} stops");
    assert!(pieced.mind.freeze_for(plan) == whole.mind.freeze_for(plan), "{name}: another student");
    assert_eq!(pieced.diary, whole.diary, "{name}");
    assert_eq!(pieced.trace.episodes, whole.trace.episodes, "{name}");
}

#[test]
fn with_roll_outs() {
    ends_the_same("pause-roll-outs", &maze(""));
}

#[test]
fn with_roll_outs_where_every_step_is_dear() {
    ends_the_same("pause-thrifty", &maze("thrifty = true"));
}

#[test]
fn with_a_critic() {
    let critic = "judge = { critic = { batches = 20, capacity = 500, labels = 300, hidden = [16] } }";
    ends_the_same("pause-critic", &maze(critic));
}

#[test]
fn with_what_is_recollected_and_appointed() {
    let text = common::maze(RECIPE, 1000)
        .replace("actions = 1 }", "actions = 1, recurrent = 16 }\nrecollection = { batches = 5, batch = 4 }")
        .replace("{ adaptive = { max_looks = 2 } }", "{ appointed = { max_looks = 2, ahead = 3 } }");
    ends_the_same("pause-appointed", &plan::parse(&text, &[]).unwrap());
}
