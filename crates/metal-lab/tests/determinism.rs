//! The same seed gives the same bits: again, and on any number of threads. Another seed gives others. A bystander
//! changes nobody.
#![allow(clippy::unwrap_used)]

use metal_lab::experiments;
use metal_lab::mind::Mind;
use metal_lab::plan::{self, Plan};
use metal_lab::progress::Silent;
use metal_lab::reproduce::{Options, execute, gather, quick};
use metal_lab::store::{RecordKey, records_csv};
use metal_lab::train::train_phase;
use metal_rl::random::Streams;
use std::collections::BTreeMap;

fn parse(text: &str, assignments: &[&str]) -> Plan {
    let assignments: Vec<String> = assignments.iter().map(|a| (*a).to_owned()).collect();
    plan::parse(text, &assignments).unwrap_or_else(|e| panic!("{e}"))
}

/// Every phase, learner and policy of the paper, a few episodes each.
fn highway() -> Plan {
    let sets = ["evaluation.scenarios=[\"mix\", \"from_behind\"]", "environment.highway.horizon=20"];
    let mut file = parse(experiments::PAPER, &sets).file;
    quick::cut(&mut file, 2, 60);
    file.evaluation.runs = 2;
    file.subsets = None;
    Plan::check(file).unwrap()
}

/// The toy with its fixed subsets, whose screening and confirmation run on all threads, too.
fn toy() -> Plan {
    let subsets = "subsets={ learner = \"acl\", like = \"attention\", budget_of = [\"attention\"], screening_share = 0.5, \
                   screening_seeds = 2, screening_runs = 5, confirmed = 2 }";
    parse(experiments::TOY, &["phase.attention.budget.episodes=8", "evaluation.runs=6", subsets])
}

/// Everything a run leaves behind that must not depend on how it was run.
#[derive(PartialEq)]
struct Remains {
    minds: Vec<BTreeMap<String, Vec<u8>>>,
    records: Vec<u8>,
    results: String,
}

fn remains(plan: &Plan, seed: u64, threads: usize) -> Remains {
    let options = Options { seeds: 2, seed, quick: false, all_subsets: false };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let mut outcome = pool.install(|| execute(plan.clone(), options, &Silent)).unwrap();
    // The time it took is the one thing that may differ.
    outcome.busy.clear();
    let bytes = |mind: &Mind| {
        let frozen = mind.freeze(&BTreeMap::new());
        let attention =
            frozen.attention.into_iter().map(|(name, (_, bytes))| (format!("attention {name}"), bytes));
        frozen
            .members
            .into_iter()
            .chain(attention)
            .flat_map(|(name, bytes)| [name.into_bytes(), bytes].concat())
            .collect()
    };
    let minds = |seed: &BTreeMap<String, metal_lab::train::Trained>| {
        seed.iter().map(|(phase, trained)| (phase.clone(), bytes(&trained.mind))).collect()
    };
    let tables = outcome.tables.iter().flat_map(|(roads, policies)| {
        policies.iter().flat_map(move |(policy, scenarios)| {
            scenarios.iter().map(move |(scenario, runs)| (RecordKey { policy, roads, scenario }, runs))
        })
    });
    Remains {
        records: records_csv(tables).unwrap(),
        minds: outcome.trained.iter().map(minds).collect(),
        results: serde_json::to_string(&gather(&outcome)).unwrap(),
    }
}

fn check(plan: &Plan) {
    let one = remains(plan, 1, 1);
    assert!(one.minds.iter().all(|m| m.values().all(|bytes| !bytes.is_empty())) && one.records.len() > 1000);
    for threads in [1, 2, 8] {
        let again = remains(plan, 1, threads);
        assert!(again.minds == one.minds, "minds on {threads} threads");
        assert!(again.records == one.records, "records on {threads} threads");
        assert!(again.results == one.results, "results on {threads} threads");
    }
    let other = remains(plan, 2, 2);
    for (seed, (a, b)) in one.minds.iter().zip(&other.minds).enumerate() {
        assert!(a.iter().all(|(phase, bytes)| b[phase] != *bytes), "another seed, other minds ({seed})");
    }
    assert!(other.records != one.records, "another seed, other tests");
    assert!(one.minds[0] != one.minds[1], "every training of a run is its own");
}

#[test]
fn the_highway_is_the_same_on_any_number_of_threads() {
    check(&highway());
}

#[test]
fn the_toy_and_its_subsets_are_the_same_on_any_number_of_threads() {
    check(&toy());
}

#[test]
fn a_bystander_changes_nobody() {
    let everybody = "\"MN\", \"LN\", \"RN\", \"MF\", \"LF\", \"RF\", \"IR\", \"FOA\"";
    let steps = "phase.demonstration.budget.steps=120";
    let alone = parse(experiments::PAPER, &[steps]);
    let bystander = [
        steps.to_owned(),
        "member.AB.sensors=[\"LN\", \"IR\"]".to_owned(),
        "member.AB.learner=acl".to_owned(),
        format!("phase.demonstration.roster=[\"AB\", {everybody}]"),
    ];
    let watched = parse(experiments::PAPER, &bystander.each_ref().map(String::as_str));
    let demonstrated = |plan: &Plan| {
        let streams = Streams::new(5);
        let newborn = Mind::newborn(plan, &streams).unwrap();
        let before = newborn.freeze(&BTreeMap::new()).members;
        let after = train_phase(plan, "demonstration", newborn, &streams, &Silent).unwrap().mind;
        (before, after.freeze(&BTreeMap::new()).members)
    };
    let ((_, alone), (newborn, mut watched)) = (demonstrated(&alone), demonstrated(&watched));
    let learned = |name: &String| watched[name] != newborn[name];
    assert!(
        watched.keys().all(|name| learned(name) == (name != "FOA_PAPER")),
        "all who watched learned, AB too"
    );
    assert!(watched.remove("AB").is_some());
    assert!(alone == watched, "and nobody else noticed");
}

/// The plan of the toy with somebody else who learns, draws and is tested beside everybody.
#[test]
fn another_stream_of_random_numbers_moves_no_other() {
    let base = ["phase.attention.budget.episodes=8", "evaluation.runs=6"];
    let everybody = "[\"MN\", \"MF\", \"LN\", \"RN\", \"LF\", \"RF\", \"IR\"]";
    let more = [
        "attention.rival={ learner = \"acl\" }".to_owned(),
        format!(
            "phase.rival={{ roster = {everybody}, acting = {{ attention = \"rival\" }}, teaching = \"nobody\", \
             rate = \"full\", exploration = {{ random = {{ from = 1.0, to = 0.5, until = 1.0 }} }}, \
             budget = {{ episodes = 13 }} }}"
        ),
        format!(
            "policy.aaa_rival={{ after = \"rival\", roster = {everybody}, acting = {{ attention = \"rival\" }} }}"
        ),
        format!("policy.aab_random={{ roster = {everybody}, acting = {{ random_looks = 2.0 }} }}"),
    ];
    let alone = remains(&parse(experiments::TOY, &base), 1, 2);
    let assignments: Vec<&str> = base.into_iter().chain(more.iter().map(String::as_str)).collect();
    let together = remains(&parse(experiments::TOY, &assignments), 1, 2);
    for (a, b) in alone.minds.iter().zip(&together.minds) {
        assert!(a["attention"] == b["attention"] && b.contains_key("rival"), "the same minds");
    }
    let rows = |records: &[u8]| -> Vec<String> {
        let text = String::from_utf8(records.to_vec()).unwrap();
        let known = |line: &&str| !line.starts_with("aaa_rival") && !line.starts_with("aab_random");
        text.lines().filter(known).map(str::to_owned).collect()
    };
    assert_eq!(rows(&alone.records), rows(&together.records), "the same tests of everybody else");
    assert!(together.records.len() > alone.records.len());
}
