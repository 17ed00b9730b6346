//! A run folder that is kept as an earlier program wrote it: whatever is frozen in it opens, and comes out of it bit by bit,
//! or the version of the format was raised. Frozen bytes do not describe themselves; without this, a new field would make
//! old minds unreadable and nobody would be told why.
//!
//! `UPDATE_EXPECT=1 cargo test -p metal-lab --test kept_minds` writes the folder anew.
#![allow(clippy::unwrap_used)]

use metal_lab::mind::{FrozenMind, Mind};
use metal_lab::plan::{self, Plan};
use metal_lab::progress::Silent;
use metal_lab::store::{RunCard, Store};
use metal_lab::train::train_phase;
use metal_rl::random::Streams;
use std::collections::BTreeMap;
use std::path::Path;

/// Every kind of learner and of student, as small as they come.
const PLAN: &str = include_str!("golden/kept-run.toml");

fn folder() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/kept-run")
}

fn rosters(plan: &Plan, phase: &str) -> BTreeMap<String, Vec<String>> {
    let named = |name: &String| plan.is_trained_by(Some(phase), name);
    let names = plan.file.attention.keys().filter(|name| named(name));
    names.map(|name| (name.clone(), plan.file.phase[phase].roster.clone())).collect()
}

fn write() {
    let plan = plan::parse(PLAN, &[]).unwrap();
    let store = Store::create(&folder()).unwrap();
    let card = RunCard { version: "0.1.0".into(), seed: 1, seeds: 1, blind: 0, quick: false };
    store.write_run(&plan, &card).unwrap();
    for phase in plan.file.phase.keys() {
        let streams = Streams::new(1);
        let newborn = Mind::newborn(&plan, &streams).unwrap();
        let trained = train_phase(&plan, phase, newborn, &streams, &Silent).unwrap();
        store.write_mind(0, phase, &trained.mind.freeze(&rosters(&plan, phase))).unwrap();
    }
}

/// Every member and every student of the kept phases, frozen again after it was thawed.
fn refrozen() -> Result<Vec<FrozenMind>, String> {
    let store = Store::open(&folder()).map_err(|e| e.to_string())?;
    let (plan, _) = store.read_run().map_err(|e| e.to_string())?;
    let read = |phase: &String| match store.read_mind(&plan, 0, phase) {
        Ok(mind) => Ok(mind.freeze(&rosters(&plan, phase))),
        Err(e) => Err(e.to_string()),
    };
    plan.file.phase.keys().map(read).collect()
}

#[test]
fn minds_that_were_written_before_open_or_the_version_was_raised() {
    if std::env::var_os("UPDATE_EXPECT").is_some() {
        write();
    }
    let advice = "A frozen structure changed. Raise its version in crates/metal-rl/src/learners/frozen.rs (old ones are then \
                  refused by name), and write the folder anew: UPDATE_EXPECT=1 cargo test -p metal-lab --test kept_minds";
    let minds = refrozen().unwrap_or_else(|e| panic!("{e}\n{advice}"));
    let scratch = Store::create(&Path::new(env!("CARGO_TARGET_TMPDIR")).join("kept")).unwrap();
    let plan = plan::parse(PLAN, &[]).unwrap();
    for (phase, mind) in plan.file.phase.keys().zip(&minds) {
        scratch.write_mind(0, phase, mind).unwrap();
        let name = format!("minds/seed-0/{phase}.mind");
        let (kept, again) = (std::fs::read(folder().join(&name)), std::fs::read(scratch.path(&name)));
        assert!(kept.unwrap() == again.unwrap(), "{phase}: other bytes than were kept. {advice}");
    }
}
