//! What is done with foreign bytes: each function may refuse them, and must not panic, hang or ask for memory without
//! end. An ordinary test feeds the kept corpus to the same functions.

#[path = "course.rs"]
pub mod course;

use metal_lab::demonstrations::{Demonstrations, Recording};
use metal_lab::mind::{FrozenMind, Mind};
use metal_lab::plan::{self, Plan};
use metal_lab::task::{Prices, RawTable, TableTask, Task};
use metal_lab::trace::{EpisodeRecord, Trace};
use metal_recording::Replay;
use metal_rl::environment::Environment;
use metal_rl::environment::EnvironmentSpec;
use metal_studio::command::Request;
use metal_studio::hub::{Hub, Order};
use metal_studio::stage::Stage;
use metal_studio::subject::{self, Subject};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Most motor steps that a foreign world is asked for.
const STEPS: usize = 50;

/// An experiment file: read and checked.
pub fn experiment(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let _ = plan::parse(text, &[]);
}

/// The plan whose minds are fuzzed.
fn every_family() -> &'static Plan {
    static PLAN: OnceLock<Plan> = OnceLock::new();
    PLAN.get_or_init(|| plan::parse(include_str!("../mind.toml"), &[]).expect("a good plan"))
}

/// FNV-1a, as at the end of everything frozen.
fn checksum(bytes: &[u8]) -> [u8; 8] {
    let step = |h: u64, &b: &u8| (h ^ u64::from(b)).wrapping_mul(0x0000_0100_0000_01b3);
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, step).to_le_bytes()
}

/// Puts the right checksum behind the bytes of a learner: accidents end there, forgery does not.
fn forge(bytes: &mut [u8]) {
    if let Some((body, sum)) = bytes.split_last_chunk_mut::<8>() {
        *sum = checksum(body);
    }
}

/// What a checkpoint and a run folder keep, with every checksum made right: a mind, and what happened to it.
pub fn checkpoint(bytes: &[u8]) {
    let kept = postcard::from_bytes::<(FrozenMind, Vec<EpisodeRecord>)>(bytes);
    let Ok((mut frozen, episodes)) = kept else { return };
    let _ = Trace::of(&every_family().spec, episodes).last_episode_steps();
    frozen.members.values_mut().for_each(|learner| forge(learner));
    frozen.attention.values_mut().for_each(|(_, learner)| forge(learner));
    let Ok(mind) = Mind::thaw(every_family(), &frozen) else { return };
    for member in &mind.members {
        let dims = member.learner.dims();
        let (mut values, mut support) = (vec![0.0; dims.choices], vec![0.0; dims.choices]);
        member.learner.values_and_support(&vec![0.5; dims.inputs], &mut values, &mut support);
    }
}

/// A table as CSV, its target in the column `class`.
pub fn csv(bytes: &[u8]) {
    let Ok(table) = RawTable::from_csv("fuzz", bytes, "class") else { return };
    let Ok(task) = TableTask::new(&table, &Prices::default()) else { return };
    if let Ok(mut world) = task.training() {
        wander(world.as_mut());
    }
}

fn maze() -> EnvironmentSpec {
    every_family().spec.clone()
}

/// Demonstrations for a maze.
pub fn demonstration(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let Ok(set) = Demonstrations::parse(text, "fuzz".as_ref(), &maze()) else { return };
    let _ = set.quality();
    wander(&mut Recording::new(set, &maze()));
}

/// A recording (MCAP), replayed.
pub fn recording(bytes: &[u8]) {
    if let Ok(mut replay) = Replay::of(bytes) {
        wander(&mut replay);
    }
}

/// Looks at everything and does what is advised, for a while.
fn wander(world: &mut dyn Environment) {
    let _ = world.reset(1);
    for _ in 0..STEPS {
        for sensor in 0..world.spec().sensors.len() {
            let mut out = vec![0.0; world.spec().sensors[sensor].features.len()];
            let _ = world.sense(sensor, &mut out);
        }
        let _ = world.measures();
        let action = world.advise().unwrap_or(0);
        if world.step(action).is_err() {
            let _ = world.reset(2);
        }
    }
}

/// What a page asks of the studio, a request a line. Whatever can be read is done, but for what starts a training or
/// writes a file.
pub fn request(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let studio = studio().lock().unwrap_or_else(PoisonError::into_inner);
    for line in text.lines().take(20) {
        let Ok(request) = serde_json::from_str::<Request>(line) else { continue };
        if !matches!(request, Request::Train { .. } | Request::Save) {
            studio.send(Order::Ask(request)).expect("the stage lives");
        }
    }
    // Nobody takes an order before the one in front of it is carried out.
    studio.send(Order::Ask(Request::Pause)).expect("the stage lives");
    studio.send(Order::Ask(Request::Pause)).expect("the stage lives");
}

/// A stage of its own, for as long as the program lives.
fn studio() -> &'static Mutex<SyncSender<Order>> {
    static STUDIO: OnceLock<Mutex<SyncSender<Order>>> = OnceLock::new();
    STUDIO.get_or_init(|| {
        let (orders, taken) = sync_channel(0);
        std::thread::spawn(move || play(&taken));
        Mutex::new(orders)
    })
}

fn play(orders: &Receiver<Order>) {
    let folder = std::env::temp_dir().join(format!("metal-fuzz-{}", std::process::id()));
    let plan = subject::paper().expect("the paper's plan");
    let subject = Subject::experiment(plan, &folder).expect("a folder to write in");
    let hub = Arc::new(Hub::new(sync_channel(1).0));
    hub.enter();
    Stage::new(hub, subject, 1).expect("a stage").run(orders);
}
