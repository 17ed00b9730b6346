//! Every bad experiment file is refused with a sentence that can be acted on: file, line, field, what was found, what is
//! allowed. And no file, however damaged, makes the program panic.
#![allow(clippy::unwrap_used)]

#[path = "plans/changes.rs"]
mod changes;

use changes::{Change, EVERYBODY, IMPOSSIBLE_NUMBERS, NAMES, PARTS, UNKNOWN_KEYS, WRONG_TYPES};
use metal_lab::experiments;
use metal_lab::plan::{self, Plan, PlanError};
use proptest::prelude::*;
use std::path::{Path, PathBuf};

const PAPER: &str = experiments::PAPER;

/// A file of one test, below the build folder.
fn written(name: &str, text: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, text).unwrap();
    path
}

fn refused(result: Result<Plan, PlanError>) -> String {
    match result {
        Ok(_) => "nothing was refused".to_owned(),
        Err(error) => error.to_string(),
    }
}

/// Applies the changes one by one and collects every message that falls short.
fn check(name: &str, changes: &[Change]) {
    let mut failures = Vec::new();
    for (old, new, mark, wanted) in changes {
        assert!(PAPER.contains(old), "{old:?} is not in paper.toml any more");
        let text = PAPER.replacen(old, new, 1);
        let at = text.find(mark).unwrap_or_else(|| panic!("{mark:?} is not in the changed file"));
        let path = written(name, &text);
        let place = format!("{}:{}: ", path.display(), text[..at].matches('\n').count() + 1);
        let message = refused(plan::load(&path, &[]));
        let missing: Vec<&str> = wanted.iter().copied().filter(|w| !message.contains(w)).collect();
        if !message.starts_with(&place) || !missing.is_empty() {
            failures
                .push(format!("{new:?}\n  place   {place}\n  missing {missing:?}\n  message {message}\n"));
        }
    }
    assert!(failures.is_empty(), "{} of {}:\n{}", failures.len(), changes.len(), failures.join("\n"));
}

#[test]
fn unknown_keys_are_refused_where_they_stand() {
    check("unknown-keys.toml", UNKNOWN_KEYS);
}

#[test]
fn wrong_types_are_refused_where_they_stand() {
    check("wrong-types.toml", WRONG_TYPES);
}

#[test]
fn impossible_numbers_are_refused_with_what_is_allowed() {
    check("impossible-numbers.toml", IMPOSSIBLE_NUMBERS);
}

#[test]
fn names_must_mean_something() {
    check("names.toml", NAMES);
}

#[test]
fn parts_that_nobody_can_play_are_refused() {
    check("parts.toml", PARTS);
}

#[test]
fn a_file_that_is_not_there_is_named() {
    let message = refused(plan::load(Path::new("no/such/plan.toml"), &[]));
    assert!(message.starts_with("no/such/plan.toml: cannot be read: "), "{message}");
}

#[test]
fn the_phase_that_goes_in_circles_is_named_and_not_one_behind_it() {
    let circle = PAPER.replacen(
        "after = \"demonstration\"\nroster = [\"MN\"",
        "after = \"attention\"\nroster = [\"MN\"",
        1,
    );
    let message = refused(plan::parse(&circle, &[]));
    assert!(
        message.contains("phase.attention.after: `fusion` starts, in the end, from `attention`"),
        "{message}"
    );
}

#[test]
fn mistakes_on_the_command_line_are_called_by_their_assignment() {
    let rows: [(&[&str], &[&str]); 9] = [
        (&["phase.fusion.rate"], &["--set phase.fusion.rate: ", "key=value"]),
        (&["title.long=1"], &["--set title.long=1: ", "cannot go into `title`", "string"]),
        (&["evaluation.run=3"], &["--set evaluation.run=3: ", "unknown field `run`", "`runs`"]),
        (&["evaluation.runs=many"], &["--set evaluation.runs=many: ", "string \"many\"", "evaluation.runs"]),
        (&["evaluation.runs=0"], &["--set evaluation.runs=0: evaluation.runs: 0: between 1"]),
        (
            &["evaluation.runs=5", "phase.foa.rate.constant=2", "title=x"],
            &["--set phase.foa.rate.constant=2: ", "(0, 1]"],
        ),
        (&["phase.foa.budget.steps=2"], &["--set phase.foa.budget.steps=2: ", "phase.foa.budget"]),
        (&["=3"], &["--set =3: "]),
        (
            &["phase.foa.roster=[\"MN\""],
            &["--set phase.foa.roster=[\"MN\": ", "phase.foa.roster", "sequence"],
        ),
    ];
    let path = written("assignments.toml", PAPER);
    for (assignments, wanted) in rows {
        let assignments: Vec<String> = assignments.iter().map(|a| (*a).to_owned()).collect();
        let message = refused(plan::load(&path, &assignments));
        assert!(message.starts_with(&format!("{}: ", path.display())), "no line is to blame: {message}");
        assert!(wanted.iter().all(|w| message.contains(w)), "{assignments:?}: {wanted:?} in {message}");
    }
}

#[test]
fn assignments_that_only_fit_together_are_taken_together() {
    let sets = ["policy.two.acting.solo=FOA", "policy.two.after=foa", "policy.two.roster=[\"FOA\"]"]
        .map(String::from);
    let plan = plan::parse(PAPER, &sets).unwrap();
    assert_eq!(plan.file.policy["two"], plan.file.policy["foa"]);
}

#[test]
fn every_experiment_that_ships_is_possible() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../experiments");
    let files: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    // A transfer takes its plan from elsewhere and has a test of its own (transfer.rs).
    let is_plan = |f: &&PathBuf| f.extension().is_some_and(|e| e == "toml") && !f.ends_with("transfer.toml");
    let plans: Vec<&PathBuf> = files.iter().filter(is_plan).collect();
    assert!(plans.len() >= 3);
    for path in plans {
        let plan = plan::load(path, &[]).unwrap_or_else(|e| panic!("{e}"));
        let again = plan::parse(&toml::to_string(&plan.file).unwrap(), &[]).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(
            again.file,
            plan.file,
            "{}: a plan that was written down is the same plan",
            path.display()
        );
    }
}

#[test]
fn weights_of_a_pool_follow_their_members_wherever_these_stand() {
    let pool = |roster: &str, weights: &str| {
        let text = PAPER.replacen(
            &format!("roster = {EVERYBODY}\nacting = {{ fusion = \"log_opinion_pool\" }}"),
            &format!("roster = {roster}\nacting = {{ fusion = {{ weighted_log_opinion_pool = {{ weights = {weights} }} }} }}"),
            1,
        );
        plan::parse(&text, &[]).unwrap().file.policy["fusion_log_pool"].clone()
    };
    assert_eq!(
        pool("[\"FOA\", \"IR\", \"MN\"]", "[8, 7, 1]"),
        pool("[\"MN\", \"IR\", \"FOA\"]", "[1, 7, 8]")
    );
}

/// A few bytes of a text set to others.
fn damaged(text: &str, changes: &[(prop::sample::Index, u8)]) -> String {
    let mut bytes = text.as_bytes().to_vec();
    for (index, byte) in changes {
        let at = index.index(bytes.len());
        bytes[at] = *byte;
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_damage_never_panics(changes in prop::collection::vec((any::<prop::sample::Index>(), 0x20_u8..0x7f), 1..4)) {
        let text = damaged(PAPER, &changes);
        if let Err(error) = plan::parse(&text, &[]) {
            prop_assert!(!error.to_string().is_empty());
        }
    }

    #[test]
    fn random_assignments_never_panic(key in "[a-z_.]{0,12}", value in "[ -~]{0,12}", whole in any::<bool>()) {
        let key = if whole { format!("phase.foa.{key}") } else { key };
        let _ = plan::parse(PAPER, &[format!("{key}={value}")]);
    }

    #[test]
    fn random_numbers_in_place_of_any_number_never_panic(nth in any::<prop::sample::Index>(), value in prop_oneof![
        Just("0".to_owned()), Just("-1".to_owned()), Just("inf".to_owned()), Just("nan".to_owned()),
        Just("9223372036854775807".to_owned()), Just("1e308".to_owned()), Just("5e-324".to_owned()),
    ]) {
        let places: Vec<usize> = PAPER.match_indices(" = ").map(|(i, _)| i + 3)
            .filter(|&i| PAPER.as_bytes()[i].is_ascii_digit()).collect();
        let at = places[nth.index(places.len())];
        let length = PAPER[at..].find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap();
        let text = format!("{}{value}{}", &PAPER[..at], &PAPER[at + length..]);
        let _ = plan::parse(&text, &[]);
    }
}
