//! The command `metal` as a user meets it: help, examples, results on disk, and mistakes answered in plain words.
#![allow(clippy::unwrap_used)]

use expect_test::expect_file;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::OnceLock;

fn metal(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_metal"));
    // Help is wrapped to the terminal's width, and a test has none.
    command.env_remove("COLUMNS").env_remove("LINES").current_dir(env!("CARGO_TARGET_TMPDIR"));
    command.args(arguments).output().unwrap()
}

/// Standard output of a command that must succeed.
fn output(arguments: &[&str]) -> String {
    let output = metal(arguments);
    let complaint = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "metal {arguments:?}: {complaint}");
    String::from_utf8(output.stdout).unwrap()
}

/// What a command that must fail with `code` says on standard error.
fn complaint(code: i32, arguments: &[&str]) -> String {
    let output = metal(arguments);
    let complaint = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(code), "metal {arguments:?}: {complaint}");
    assert!(!complaint.contains("panicked"), "{complaint}");
    assert_eq!(output.stdout, b"", "mistakes print no results");
    complaint
}

fn temporary(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}

fn toy() -> String {
    concat!(env!("CARGO_MANIFEST_DIR"), "/../../experiments/toy.toml").to_owned()
}

/// The toy with next to no training, two trainings of it.
fn tiny<'a>(toy: &'a str, out: &'a str) -> Vec<&'a str> {
    let budgets = ["--set", "phase.attention.budget.episodes=40", "--set", "evaluation.runs=60"];
    [vec!["run", toy, "--out", out, "--seeds", "2", "--threads", "1", "--force"], budgets.to_vec()].concat()
}

/// The folder of one tiny run of the toy, made once for all tests.
fn run_folder() -> &'static str {
    static FOLDER: OnceLock<String> = OnceLock::new();
    FOLDER.get_or_init(|| {
        let folder = temporary("toy-run");
        let _ = std::fs::remove_dir_all(&folder);
        let folder = folder.to_str().unwrap().to_owned();
        let printed = output(&tiny(&toy(), &folder));
        for wanted in ["mix: mean per motor step", "policy", "acl", "oracle", "report.html", "results.json"] {
            assert!(printed.contains(wanted), "{wanted} is missing in\n{printed}");
        }
        folder
    })
}

#[test]
fn help_texts_teach() {
    let commands = [
        "reproduce",
        "run",
        "eval",
        "studio",
        "aliasing",
        "list",
        "completions",
        "train-traffic",
        "serve",
        "doctor",
        "calibrate",
        "drive",
        "world",
        "replay",
        "check",
        "bench",
        "tabular",
        "transfer",
        "faults",
        "ceiling",
        "prices",
        "partition",
    ];
    expect_file!["golden/help.txt"].assert_eq(&output(&["--help"]));
    for command in commands {
        expect_file![format!("golden/help-{command}.txt")].assert_eq(&output(&[command, "--help"]));
        assert!(output(&["--help"]).contains(command));
    }
    assert!(output(&["--version"]).starts_with("metal "));
}

#[test]
fn the_studio_shows_roads_and_leaves_finished_runs_alone() {
    let missing = complaint(1, &["studio", "--run", "/nowhere/at-all"]);
    assert!(missing.contains("/nowhere/at-all") && missing.contains("not a run folder"), "{missing}");
    let toy = concat!(env!("CARGO_MANIFEST_DIR"), "/../../experiments/toy.toml");
    assert!(complaint(1, &["studio", "--experiment", toy]).contains("shows roads, and Toy-v0 is none"));
    let folder = std::env::temp_dir().join(format!("metal-studio-taken-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("results.json"), "{}").unwrap();
    let taken = complaint(1, &["studio", "--out", folder.to_str().unwrap()]);
    std::fs::remove_file(folder.join("results.json")).unwrap();
    assert!(taken.contains("holds a finished run") && taken.contains("--run"), "{taken}");
    let there = complaint(1, &["studio", "--out", folder.to_str().unwrap(), "--record", toy]);
    assert!(there.contains("toy.toml: exists") && there.contains("--record"), "{there}");
    let nowhere =
        complaint(1, &["studio", "--out", folder.to_str().unwrap(), "--record", "/nowhere/at-all.mcap"]);
    assert!(nowhere.contains("/nowhere/at-all.mcap: its folder is not there"), "{nowhere}");
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn the_second_row_of_table_3_comes_out() {
    let row = ["aliasing", "--q", "4", "--k", "4", "--actions", "4"];
    let numbers: Value = serde_json::from_str(&output(&[&row[..], &["--json"]].concat())).unwrap();
    // As printed in the paper (its last digit cut off, not rounded): p0 = 0.1234, p = 2.32e-4.
    let (p0, p) = (numbers["collision"].as_f64().unwrap(), numbers["all_actions"].as_f64().unwrap());
    assert!((0.1234..0.1235).contains(&p0), "{p0}");
    assert!((2.32e-4..2.33e-4).contains(&p), "{p}");
    expect_file!["golden/aliasing.txt"].assert_eq(&output(&row));
}

#[test]
fn impossible_numbers_are_refused() {
    for (q, k, actions) in [("1", "4", "4"), ("4", "0", "4"), ("4", "4", "0"), ("99999999999", "4", "4")] {
        let message = complaint(1, &["aliasing", "--q", q, "--k", k, "--actions", actions]);
        assert!(message.starts_with("metal: ") && message.len() > 20, "{message}");
    }
    assert!(complaint(2, &["aliasing", "--q", "-4", "--k", "4", "--actions", "4"]).contains("--q"));
    assert!(complaint(2, &["reproduce", "--seeds", "0"]).contains("0 is not in 1..=10000"));
    assert!(complaint(2, &["eval", "--run", "x", "--runs", "0"]).contains("0 is not in 1..="));
    assert!(complaint(2, &["reproduce", "--threads", "5000"]).contains("--threads"));
}

#[test]
fn everything_there_is_is_listed() {
    let list = output(&["list"]);
    for name in [
        "environments",
        "highway",
        "learners",
        "absp",
        "mlp",
        "fusers",
        "max_confidence",
        "experiments/paper.toml",
    ] {
        assert!(list.contains(name), "{name} is missing in\n{list}");
    }
}

#[test]
fn completions_know_the_commands() {
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = output(&["completions", shell]);
        assert!(script.contains("reproduce") && script.contains("road-seed"), "{shell}");
    }
    assert!(complaint(2, &["completions", "tcsh"]).contains("bash"));
}

#[test]
fn a_reader_who_has_heard_enough_is_no_error() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_metal"))
        .args(["completions", "bash"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert!(
        output.status.success() && output.stderr.is_empty(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
}

#[test]
fn a_run_leaves_everything_behind() {
    let folder = Path::new(run_folder());
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
    let results: Value = serde_json::from_str(&read("results.json")).unwrap();
    assert_eq!(results["seeds"], 2);
    assert_eq!(results["config"]["evaluation"]["runs"], 60, "what was set is what was run");
    assert!(read("plan.toml").contains("episodes = 40"));
    assert!(read("report.html").contains("<svg"));
    let card: Value = serde_json::from_str(&read("run.json")).unwrap();
    assert_eq!((&card["seeds"], &card["seed"], &card["quick"]), (&2.into(), &1.into(), &false.into()));
    // 5 policies, 2 seeds, 30 runs each, and a header.
    assert_eq!(read("records.csv").lines().count(), 1 + 5 * 2 * 30);
    assert!(folder.join("minds/seed-1/attention.mind").is_file());
    let strays = std::fs::read_dir(folder)
        .unwrap()
        .filter(|e| e.as_ref().unwrap().path().extension().is_some_and(|x| x == "tmp"));
    assert_eq!(strays.count(), 0, "no drafts are left behind");
}

#[test]
fn results_as_json_are_the_results() {
    let folder = temporary("toy-json");
    let toy = toy();
    let arguments = [tiny(&toy, folder.to_str().unwrap()), vec!["--json"]].concat();
    let printed: Value = serde_json::from_str(&output(&arguments)).unwrap();
    let written: Value =
        serde_json::from_str(&std::fs::read_to_string(folder.join("results.json")).unwrap()).unwrap();
    assert_eq!(printed, written);
    // The same plan and seed as in the other folder, in another process.
    let other = std::fs::read_to_string(Path::new(run_folder()).join("records.csv")).unwrap();
    assert_eq!(std::fs::read_to_string(folder.join("records.csv")).unwrap(), other);
}

#[test]
fn trained_minds_are_tested_again() {
    let folder = run_folder();
    let eval = ["eval", "--run", folder, "--runs", "50"];
    let results: Value = serde_json::from_str(&output(&[&eval[..], &["--json"]].concat())).unwrap();
    let measures = &results["policies"]["acl"]["mix"];
    let (total, looks) =
        (measures["total"]["mean"].as_f64().unwrap(), measures["looks"]["mean"].as_f64().unwrap());
    assert!(total < 0.0 && (0.0..=7.0).contains(&looks), "{total} {looks}");
    let table = output(&eval);
    assert!(table.contains("oracle") && table.contains("looks"), "{table}");
    assert_eq!(table, output(&eval), "the same minds, the same test, the same numbers");
}

#[test]
fn roads_are_chosen_one_way_and_only_where_there_are_roads() {
    let eval = ["eval", "--run", run_folder()];
    let with = |more: &[&str]| -> Vec<String> { eval.iter().chain(more).map(|a| (*a).to_owned()).collect() };
    let refused = |code, more: &[&str]| {
        let arguments = with(more);
        complaint(code, &arguments.iter().map(String::as_str).collect::<Vec<_>>())
    };
    let both = refused(2, &["--roads", "test", "--road-seed", "7"]);
    assert!(
        both.contains("--roads") && both.contains("--road-seed") && both.contains("cannot be used with"),
        "{both}"
    );
    assert!(refused(2, &["--roads", "moon"]).contains("training, validation, test"));
    assert!(refused(2, &["--road-seed", "x"]).contains("--road-seed"));
    assert!(refused(1, &["--roads", "test"]).contains("Toy-v0 has no roads"));
    assert!(refused(1, &["--road-seed", "7"]).contains("Toy-v0 has no roads"));
}

#[test]
fn a_folder_that_is_no_run_is_called_by_name() {
    let folder = temporary("no-run");
    std::fs::create_dir_all(&folder).unwrap();
    let message = complaint(1, &["eval", "--run", folder.to_str().unwrap()]);
    assert!(message.contains("no-run") && message.contains("run.json is missing"), "{message}");
    assert!(complaint(1, &["eval", "--run", "nowhere/at/all"]).contains("nowhere/at/all"));
    assert!(complaint(2, &["eval"]).contains("--run"));
}

#[test]
fn experiment_files_are_called_by_name() {
    let message = complaint(1, &["run", "missing.toml"]);
    assert!(message.starts_with("metal: missing.toml: cannot be read"), "{message}");
    let toy = toy();
    let message = complaint(1, &["run", &toy, "--set", "evaluation.runs=0"]);
    assert!(
        message.contains("toy.toml: --set evaluation.runs=0: evaluation.runs: 0: between 1"),
        "{message}"
    );
    let bad = temporary("bad.toml");
    let text = std::fs::read_to_string(&toy).unwrap();
    std::fs::write(&bad, text.replace("runs = 20000", "runs = 0")).unwrap();
    let line = text.lines().position(|l| l == "runs = 20000").unwrap() + 1;
    let message = complaint(1, &["run", bad.to_str().unwrap(), "--out", "never"]);
    assert!(message.contains(&format!("bad.toml:{line}: evaluation.runs: 0")), "{message}");
    assert!(!temporary("never").exists(), "a refused experiment leaves nothing behind");
    let message = complaint(1, &["reproduce", "--set", "phase.foa.rate.constant=7", "--out", "never"]);
    assert!(
        message.starts_with("metal: --set phase.foa.rate.constant=7: phase.foa.rate.constant: 7"),
        "{message}"
    );
}

#[test]
fn a_folder_that_cannot_be_made_is_called_by_name() {
    let file = temporary("in-the-way");
    std::fs::write(&file, "a file").unwrap();
    let toy = toy();
    let message = complaint(1, &tiny(&toy, file.to_str().unwrap()));
    assert!(message.contains("in-the-way"), "{message}");
}

/// Budgets that only show that everything works.
const BRIEFLY: [&str; 6] = ["--steps", "120", "--seeds", "2", "--episodes", "5"];

#[test]
fn a_task_is_compared() {
    let text = output(&[&["bench", "toy", "--exhaustive", "0"][..], &BRIEFLY].concat());
    let rows = ["blind", "random subset", "best static subset", "all sensors", "fusion", "METAL"];
    for wanted in
        rows.iter().chain(&["front of motor reward", "sensors read by METAL", "fewer than 5 trainings"])
    {
        assert!(text.contains(wanted), "{wanted} is missing in\n{text}");
    }
    let free = ["bench", "maze", "--settings", "{\"look_price\": 0.0}"];
    let text = output(&[&free[..], &BRIEFLY].concat());
    assert!(text.contains("no area, since all sensors cost nothing"), "{text}");
    let settings = ["bench", "maze", "--json", "--settings", "{\"look_price\": 0.5}"];
    let json = output(&[&settings[..], &BRIEFLY].concat());
    let bench: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(bench["task"], "Maze-v0");
    assert_eq!(bench["rows"]["all sensors"]["looks"]["mean"], 2.0);
    assert_eq!(bench["statics"].as_array().unwrap().len(), 3, "every subset of X and Y");
    assert!(complaint(1, &["bench", "moon"]).contains("moon"));
    assert!(complaint(1, &["bench", "maze", "--settings", "{\"sides\": 1}"]).contains("sides"));
}

#[test]
fn a_task_is_checked() {
    let brief = ["--steps", "300", "--episodes", "20"];
    let text = output(&[&["check", "maze"][..], &brief].concat());
    for wanted in ["Maze-v0", "blind", "at random", "all sensors", "\nX ", "\nY "] {
        assert!(text.contains(wanted), "{wanted} is missing in\n{text}");
    }
    let dear = ["check", "maze", "--json", "--settings", "{\"look_price\": 5000.0}"];
    let found: Value = serde_json::from_str(&output(&[&dear[..], &brief].concat())).unwrap();
    let problems = found["problems"].as_array().unwrap();
    assert!(problems.iter().any(|p| p.as_str().unwrap().contains("sensor X costs 5000")), "{problems:?}");
    let file = temporary("checked.csv");
    let rows: String = (0..40).map(|i| format!("{},7,{}\n", i % 2, i % 2)).collect();
    std::fs::write(&file, format!("a,b,ill\n{rows}")).unwrap();
    let file = file.to_str().unwrap();
    let table = output(&[&["check", file, "--target", "ill"][..], &brief].concat());
    assert!(table.contains("problem: sensor b never changes"), "{table}");
    assert!(complaint(1, &["check", "moon"]).contains("moon"));
    assert!(complaint(2, &["check", "maze", "--prices", "p.toml"]).contains("--target"));
}

#[test]
fn members_are_proposed_and_can_be_run() {
    let cells = concat!(env!("CARGO_MANIFEST_DIR"), "/../../experiments/partition.toml");
    let (file, picture) = (temporary("proposed.toml"), temporary("proposed.svg"));
    [&file, &picture].into_iter().for_each(|path| drop(std::fs::remove_file(path)));
    let out = file.to_str().unwrap();
    let arguments = ["partition", cells, "--by", "alike", "--groups", "5", "--steps", "300", "--out", out];
    let table = output(&arguments);
    for wanted in ["HighwayCells-v0: 5 groups", "\nG5 ", "ps7", "\nall    12.00"] {
        assert!(table.contains(wanted), "{wanted} is missing in\n{table}");
    }
    assert!(std::fs::read_to_string(&picture).unwrap().starts_with("<svg"));
    let again = complaint(1, &arguments);
    assert!(again.contains("proposed.toml: exists; replace it with --force"), "{again}");
    let json = output(&[&arguments[..], &["--force", "--json"]].concat());
    let proposal: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(proposal["groups"].as_array().unwrap().len(), 5);
    let folder = temporary("proposed-run");
    let folder = folder.to_str().unwrap();
    let quick = ["run", out, "--quick", "--seeds", "1", "--threads", "1", "--force", "--out", folder];
    let briefly = ["--set", "evaluation.runs=4", "--set", "attention.acl.counterfactual.iterations=1"];
    assert!(output(&[&quick[..], &briefly].concat()).contains("acl"));
}

#[test]
fn what_cannot_be_proposed_is_said() {
    let cells = concat!(env!("CARGO_MANIFEST_DIR"), "/../../experiments/partition.toml");
    assert!(complaint(1, &["partition", "missing.toml"]).contains("missing.toml: cannot be read"));
    assert!(complaint(1, &["partition", cells, "--out", "groups.txt"]).contains("ends in .toml"));
    assert!(complaint(2, &["partition", cells, "--by", "colour"]).contains("alike, worth, random"));
    assert!(
        complaint(1, &["partition", cells, "--groups", "33", "--steps", "50", "--by", "alike"])
            .contains("groups: 33: at most 32")
    );
    let coarse = "environment.highway.senses={ cells = { columns = 2, rows = 2 } }";
    let refused = complaint(1, &["partition", cells, "--set", coarse]);
    assert!(refused.contains("senses.cells") && refused.contains("2 columns of 2"), "{refused}");
}

#[test]
fn a_table_is_compared() {
    let (file, prices) = (temporary("rows.csv"), temporary("prices.toml"));
    let row = |i: usize| format!("{},{},{}\n", i % 2, if i.is_multiple_of(5) { "NA" } else { "7" }, i % 2);
    let rows: String = (0..40).map(row).collect();
    std::fs::write(&file, format!("a,b,ill\n{rows}")).unwrap();
    let groups = "default = 0.1\n[group.both]\ncolumns = [\"a\", \"b\"]\nprice = 0.5\n";
    std::fs::write(&prices, groups).unwrap();
    let (file, prices) = (file.to_str().unwrap(), prices.to_str().unwrap());
    let json = output(&[&["tabular", file, "--target", "ill", "--json"][..], &BRIEFLY].concat());
    let bench: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(bench["sensors"], serde_json::json!(["a", "b"]));
    let priced = ["tabular", file, "--target", "ill", "--prices", prices];
    let text = output(&[&priced[..], &BRIEFLY].concat());
    assert!(text.contains("both") && text.contains("always `"), "{text}");
    assert!(complaint(1, &["tabular", file, "--target", "sick"]).contains("known: a, b, ill"));
}

/// Who of two coordinates to ask in a small maze, by counterfactual policy iteration.
const MAZE: &str = r#"
title = "Looks in a maze"
scaling = "linear"

[environment.maze]

[learner.table.tile]

[member.X]
sensors = ["X"]
learner = "table"

[member.Y]
sensors = ["Y"]
learner = "table"

[attention.acl.counterfactual]
looks = { adaptive = { min_looks = 0, max_looks = 2 } }
memory = { looks = 1, steps = 4, actions = 1 }

[phase.attention]
roster = ["X", "Y"]
acting = { attention = "acl" }
teaching = "nobody"
rate = "full"
exploration = { random = { from = 0.5, to = 0.1, until = 0.6 } }
budget = { steps = 4000 }

[policy.acl]
after = "attention"
roster = ["X", "Y"]
acting = { attention = "acl" }

[subsets]
like = "attention"
budget_of = ["attention"]
among = ["X", "Y/2"]
screening_share = 0.5
screening_seeds = 1
screening_runs = 2
confirmed = 1
"#;

#[test]
fn attention_is_priced_against_fixed_choices() {
    let folder = temporary("prices");
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    let (file, out) = (folder.join("maze.toml"), folder.join("out"));
    std::fs::write(&file, MAZE).unwrap();
    let (file, out) = (file.to_str().unwrap(), out.to_str().unwrap());
    let quick = ["prices", file, "--quick", "--factors", "0,1,50", "--threads", "1"];
    let text = output(&[&quick[..], &["--out", out]].concat());
    for wanted in
        ["| prices × |", "| 50 |", "| Y/2 |", "| X+Y |", "Saved of what the best fixed choice costs"]
    {
        assert!(text.contains(wanted), "{wanted} is missing in\n{text}");
    }
    let read = |name: &str| std::fs::read_to_string(folder.join("out").join(name)).unwrap();
    assert_eq!(read("prices.md"), text);
    let report: Value = serde_json::from_str(&read("prices.json")).unwrap();
    let free = &report["prices"][0];
    assert_eq!((&free["factor"], &free["attention"]["price"]["mean"]), (&0.0.into(), &0.0.into()));
    assert_eq!(report["fixed"].as_array().unwrap().len(), 3);
    assert!(
        ["motor", "total", "looks"]
            .iter()
            .all(|name| read(&format!("prices-{name}.svg")).starts_with("<svg"))
    );
    assert_eq!(output(&[&quick[..5], &["--threads", "2"]].concat()), text);
    let again = complaint(1, &[&quick[..], &["--out", out]].concat());
    assert!(again.contains("prices.json: exists; replace it with --force"), "{again}");
    let said = |more: &[&str]| complaint(1, &[&quick[..5], more].concat());
    assert!(
        complaint(1, &["prices", file, "--factors", "2,1"]).contains("factors: [2.0, 1.0]: at least one")
    );
    assert!(said(&["--rivals", "z"]).contains("rivals: unknown sensor `z`; known: X, Y"));
    assert!(complaint(1, &["prices", &toy()]).contains("subsets"));
}

#[test]
fn a_ceiling_is_measured_beside_what_was_learned() {
    let (toy, folder) = (toy(), temporary("ceiling"));
    let _ = std::fs::remove_dir_all(&folder);
    let out = folder.to_str().unwrap();
    let quick = ["ceiling", &toy, "--quick", "--set", "phase.attention.roster=[\"MN\", \"IR\"]"];
    let quick = [&quick[..], &["--set", "policy.acl.roster=[\"MN\", \"IR\"]", "--threads", "1"]].concat();
    let text = output(&[&quick[..], &["--learned", run_folder(), "--out", out]].concat());
    for wanted in ["what the sensors of Toy-v0 allow", "best of 2", "adaptive looks", "Learned", "| acl |"] {
        assert!(text.contains(wanted), "{wanted} is missing in\n{text}");
    }
    assert_eq!(std::fs::read_to_string(folder.join("ceiling.md")).unwrap(), text);
    let json = std::fs::read_to_string(folder.join("ceiling.json")).unwrap();
    let report: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(report["members"], serde_json::json!(["MN", "IR"]));
    assert_eq!(report["points"].as_array().unwrap().len(), 4 + 1 + 3 * 4);
    assert!(std::fs::read_to_string(folder.join("ceiling-all.svg")).unwrap().starts_with("<svg"));
    let again = complaint(1, &[&quick[..], &["--out", out]].concat());
    assert!(again.contains("ceiling.json: exists; replace it with --force"), "{again}");
    let said = complaint(1, &[&quick[..], &["--phase", "nowhere"]].concat());
    assert!(said.contains("phase: unknown phase `nowhere`; known: attention"), "{said}");
    assert!(complaint(1, &[&quick[..], &["--chance", "2"]].concat()).contains("chance: 2: in (0, 1]"));
    assert!(complaint(1, &[&quick[..], &["--learned", "/nowhere"]].concat()).contains("not a run folder"));
}

/// The paper's experiment, too short to learn anything: every part of `metal faults` happens on it within seconds.
const SHORT: [&str; 16] = [
    "--set",
    "phase.demonstration.budget.steps=60",
    "--set",
    "phase.fusion.budget.episodes=3",
    "--set",
    "phase.attention.budget.steps=200",
    "--set",
    "attention.acl.counterfactual.iterations=2",
    "--set",
    "attention.acl.counterfactual.validation_runs=1",
    "--set",
    "attention.acl.counterfactual.fit.batches=30",
    "--set",
    "phase.attention_phase3.budget.episodes=3",
    "--set",
    "attention.acl_phase3.settings.min_looks=1",
];

#[test]
fn sensors_break_and_are_mended() {
    let folder = temporary("faults");
    let _ = std::fs::remove_dir_all(&folder);
    let out = folder.to_str().unwrap();
    let sizes = ["--seeds", "2", "--runs", "1", "--lasting", "6", "--fault", "nan", "dead", "--rate", "0.5"];
    let what = ["--train-with", "nan", "--follow", "nan", "noisy", "--policy", "acl", "acl_phase3"];
    let quick = [&["faults"][..], &SHORT, &sizes, &what].concat();
    let text = output(&[&quick[..], &["--threads", "1", "--out", out]].concat());
    for wanted in [
        "### Sensors fail in the test only",
        "### Sensors fail in training, too",
        "within an episode, of the sensor that ACL, Phase III looks at most",
        "| 50 to 59 | broken |",
        "then mended; it learns on",
        "### The world changes (Sec. 6.2); it learns on for 6 episodes",
    ] {
        assert!(text.contains(wanted), "{wanted} is missing in\n{text}");
    }
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
    assert_eq!(read("faults.md"), text);
    let report: Value = serde_json::from_str(&read("faults.json")).unwrap();
    let list = |name: &str| report[name].as_array().unwrap().clone();
    assert_eq!(list("cells").len(), 2 * (1 + 2 + 2));
    assert_eq!((list("comebacks").len(), list("changes").len()), (2, 4 * 2));
    let interruptions = list("interruptions");
    let who: Vec<String> = interruptions.iter().map(|i| format!("{} {}", i["policy"], i["fault"])).collect();
    let wanted = ["acl", "acl_phase3"].map(|p| ["nan", "noisy"].map(|f| format!("{p:?} {f:?}")));
    assert_eq!(who, wanted.concat());
    for interruption in &interruptions {
        let spells = interruption["spells"].as_array().unwrap();
        assert_eq!(spells.len(), 15);
        let before = spells.iter().filter(|s| s["sensor"] == "sound");
        assert!(before.clone().all(|s| s["gain"]["mean"] == 0.0), "the same episodes until it breaks");
        assert_eq!(before.count(), 5);
        let there = |at: usize| spells[at]["looks_there"]["mean"].as_f64().unwrap();
        if interruption["policy"] == "acl_phase3" && interruption["fault"] == "nan" {
            assert!(there(5) < there(4), "silent members are left alone: {} {}", there(4), there(5));
        }
    }
    for drawing in ["cost-nan", "accidents-dead", "looks-within-acl-nan", "looks-noisy"] {
        assert!(read(&format!("faults-{drawing}.svg")).starts_with("<svg"), "{drawing}");
    }
    assert_eq!(output(&[&quick[..], &["--threads", "2"]].concat()), text);
    let again = complaint(1, &[&quick[..], &["--out", out]].concat());
    assert!(again.contains("faults.json: exists; replace it with --force"), "{again}");
    let said = complaint(1, &["faults", "--policy", "oracle"]);
    assert!(said.contains("policies: `oracle`: policies of the experiment that were trained"), "{said}");
    assert!(complaint(1, &["faults", "--rate", "1.5"]).contains("rates: 1.5: in [0, 1]"));
}
