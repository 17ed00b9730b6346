//! Run folders that were damaged, cut, mixed up or made by somebody else: errors that name the file, and never a panic.
#![allow(clippy::unwrap_used)]

use metal_lab::mind::{FROZEN_VERSION, FrozenMind, Mind};
use metal_lab::plan::{self, Plan};
use metal_lab::progress::Silent;
use metal_lab::registry::Roads;
use metal_lab::store::{RunCard, Store};
use metal_lab::train::train_phase;
use metal_lab::{experiments, reevaluate};
use metal_rl::random::Streams;
use proptest::prelude::*;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

fn plan() -> Plan {
    plan::parse(experiments::TOY, &["phase.attention.budget.episodes=20".into()]).unwrap()
}

fn card() -> RunCard {
    RunCard { version: "0.1.0".into(), seed: 1, seeds: 1, blind: 0, quick: false }
}

/// A trained and frozen mind of the toy.
fn frozen() -> &'static FrozenMind {
    static FROZEN: OnceLock<FrozenMind> = OnceLock::new();
    FROZEN.get_or_init(|| {
        let (plan, streams) = (plan(), Streams::new(1));
        let newborn = Mind::newborn(&plan, &streams).unwrap();
        let mind = train_phase(&plan, "attention", newborn, &streams, &Silent).unwrap().mind;
        let roster = plan.file.phase["attention"].roster.clone();
        mind.freeze(&BTreeMap::from([("acl".to_owned(), roster)]))
    })
}

const MIND: &str = "minds/seed-0/attention.mind";

/// A whole run folder of its own for one test.
fn folder(name: &str) -> Store {
    let root = Path::new(env!("CARGO_TARGET_TMPDIR")).join("stored").join(name);
    let _ = std::fs::remove_dir_all(&root);
    let store = Store::create(&root).unwrap();
    store.write_run(&plan(), &card()).unwrap();
    store.write_mind(0, "attention", frozen()).unwrap();
    store
}

/// The folder tested again as `metal eval` does.
fn evaluate(root: &Path) -> Result<(), String> {
    let store = Store::open(root).map_err(|e| e.to_string())?;
    reevaluate::on(&store, None, 3).map(drop).map_err(|e| e.to_string())
}

/// What is said when `name` of a folder is spoiled; it must begin with the path of what is wrong.
fn complaint(store: &Store, name: &str) -> String {
    let message = evaluate(store.root()).expect_err("this folder is spoiled");
    let path: PathBuf = if name.is_empty() { store.root().to_path_buf() } else { store.path(name) };
    assert!(message.starts_with(&path.display().to_string()), "{message} does not name {}", path.display());
    message
}

#[test]
fn a_whole_folder_is_read_back_bit_for_bit() {
    let store = folder("whole");
    evaluate(store.root()).unwrap();
    let (plan, card) = Store::open(store.root()).unwrap().read_run().unwrap();
    assert_eq!((plan.file.clone(), card), (self::plan().file, self::card()));
    let mind = store.read_mind(&plan, 0, "attention").unwrap();
    let roster = plan.file.phase["attention"].roster.clone();
    assert_eq!(mind.freeze(&BTreeMap::from([("acl".to_owned(), roster)])), *frozen());
}

#[test]
fn a_folder_without_its_files_is_no_run() {
    for (name, wanted) in
        [("run.json", "run.json is missing"), ("plan.toml", "cannot be read"), (MIND, "No such file")]
    {
        let store = folder("missing");
        std::fs::remove_file(store.path(name)).unwrap();
        let place = if name == "run.json" { "" } else { name };
        let message = complaint(&store, place);
        assert!(message.contains(wanted), "{message}");
    }
}

#[test]
fn foreign_and_damaged_files_are_called_by_name() {
    let rows: [(&str, &[u8], &str); 9] = [
        ("run.json", b"", "EOF"),
        ("run.json", b"{}", "missing field"),
        ("run.json", b"\xff\xfe", "UTF-8"),
        (
            "run.json",
            br#"{"version": "0.1.0", "seed": 1, "seeds": 0, "blind": 0, "quick": false}"#,
            "seeds = 0",
        ),
        (
            "run.json",
            br#"{"version": "0.1.0", "seed": 1, "seeds": 1, "blind": 9, "quick": false}"#,
            "blind = 9",
        ),
        ("plan.toml", b"title = 1", "title"),
        (MIND, b"", "not a mind file"),
        (MIND, b"PK\x03\x04 a zip file", "not a mind file"),
        (MIND, b"METALMND", "too few"),
    ];
    for (name, bytes, wanted) in rows {
        let store = folder("foreign");
        std::fs::write(store.path(name), bytes).unwrap();
        let message = complaint(&store, name);
        assert!(message.contains(wanted), "{message} does not say {wanted}");
    }
}

#[test]
fn minds_of_another_version_or_plan_are_refused() {
    let changed = |change: &dyn Fn(&mut FrozenMind)| {
        let store = folder("changed");
        let mut mind = frozen().clone();
        change(&mut mind);
        store.write_mind(0, "attention", &mind).unwrap();
        complaint(&store, MIND)
    };
    let version = changed(&|m| m.version += 1);
    assert!(
        version.contains(&format!("version {}, this program reads {FROZEN_VERSION}", FROZEN_VERSION + 1)),
        "{version}"
    );
    assert!(changed(&|m| drop(m.members.remove("IR"))).contains("member `IR` is missing"));
    // An expert over nine actions is a sound learner, but not of this world.
    let shape = changed(&|m| drop(m.members.insert("IR".into(), 9_u64.to_le_bytes().to_vec())));
    assert!(shape.contains("member `IR` has another shape"), "{shape}");
    assert!(changed(&|m| m.attention.get_mut("acl").unwrap().0.truncate(3)).contains("another shape"));
    let stranger = changed(&|m| {
        let acl = m.attention["acl"].clone();
        m.attention.insert("other".into(), acl);
    });
    assert!(stranger.contains("attention `other` is not in the plan"), "{stranger}");
    assert!(changed(&|m| m.attention.get_mut("acl").unwrap().1[40] ^= 1).contains("checksum"));
    let born = changed(&|m| m.attention.clear());
    assert!(born.contains("attention `acl` is missing"), "{born}");
}

#[test]
fn roads_are_refused_where_there_are_none() {
    let store = folder("roads");
    let error = reevaluate::on(&store, Some(&Roads::Test), 3).unwrap_err();
    assert_eq!(error.to_string(), "Toy-v0 has no roads to choose");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_changed_or_cut_mind_is_always_noticed(
        at in any::<prop::sample::Index>(), flip in 1_u8..=255, cut in any::<bool>(),
    ) {
        static STORE: OnceLock<(Store, Plan, Vec<u8>)> = OnceLock::new();
        let (store, plan, whole) = STORE.get_or_init(|| {
            let store = folder("random");
            let bytes = std::fs::read(store.path(MIND)).unwrap();
            (store, plan(), bytes)
        });
        let mut bytes = whole.clone();
        let at = at.index(bytes.len());
        if cut { bytes.truncate(at) } else { bytes[at] ^= flip }
        std::fs::write(store.path(MIND), bytes).unwrap();
        let error = store.read_mind(plan, 0, "attention").err().map(|e| e.to_string());
        prop_assert!(error.is_some_and(|e| e.contains("attention.mind: ")), "byte {at}");
    }

    #[test]
    fn a_mind_with_random_insides_never_panics(insides in prop::collection::vec(any::<u8>(), 0..200)) {
        let mut mind = frozen().clone();
        mind.members.insert("MN".into(), insides.clone());
        prop_assert!(Mind::thaw(&plan(), &mind).is_err() || insides == frozen().members["MN"]);
        let mut mind = frozen().clone();
        mind.attention.get_mut("acl").unwrap().1 = insides;
        prop_assert!(Mind::thaw(&plan(), &mind).is_err());
    }
}
