//! A run that is killed, again and again, ends as if nothing had happened; what is damaged is done again; what is
//! another run's is refused.
#![allow(clippy::unwrap_used)]

use metal_rl::random::{Rng, Streams};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// The toy with next to no training, but with subsets, so that every kind of work is done.
const TINY: [&str; 4] = [
    "phase.attention.budget.episodes=60",
    "evaluation.runs=12",
    "learner.acl={ mlp = { batches_per_sample = 1.0, capacity = 100 } }",
    "subsets={ learner = \"acl\", like = \"attention\", budget_of = [\"attention\"], screening_share = 0.05, \
     screening_seeds = 1, screening_runs = 3, confirmed = 1 }",
];

/// The toy where attention is learned by counterfactual policy iteration.
const TAUGHT: [&str; 3] = [
    "attention.acl={ counterfactual = { iterations = 8, validation_runs = 20, fit = { batches = 40 } } }",
    "phase.attention.budget.episodes=400",
    "evaluation.runs=12",
];

fn temporary(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&folder);
    folder
}

/// `metal run` of the tiny toy, two trainings of it, saved after every episode.
fn metal(out: &Path, more: &[&str]) -> Command {
    toy(&TINY, out, more)
}

/// `metal run` of the toy with these settings, two trainings of it, saved as often as can be.
fn toy(settings: &[&str], out: &Path, more: &[&str]) -> Command {
    let toy = concat!(env!("CARGO_MANIFEST_DIR"), "/../../experiments/toy.toml");
    let mut command = Command::new(env!("CARGO_BIN_EXE_metal"));
    command.args(["run", toy, "--seeds", "2", "--save-every", "0", "--out"]).arg(out);
    for assignment in settings {
        command.args(["--set", assignment]);
    }
    command.args(more).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

fn run(out: &Path, more: &[&str]) -> Output {
    metal(out, more).output().unwrap()
}

fn complaint(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// Everything that must not depend on how often the run was stopped: file → bytes.
fn remains(out: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    for name in
        ["records.csv", "plan.toml", "run.json", "minds/seed-0/attention.mind", "minds/seed-1/attention.mind"]
    {
        files.insert(name.to_owned(), std::fs::read(out.join(name)).unwrap());
    }
    let mut results: Value =
        serde_json::from_slice(&std::fs::read(out.join("results.json")).unwrap()).unwrap();
    results.as_object_mut().unwrap().remove("cpu_seconds").unwrap();
    files.insert("results.json".to_owned(), results.to_string().into_bytes());
    files
}

/// What an uninterrupted run leaves behind, and how long it takes.
fn uninterrupted() -> &'static (BTreeMap<String, Vec<u8>>, Duration) {
    static WHOLE: OnceLock<(BTreeMap<String, Vec<u8>>, Duration)> = OnceLock::new();
    WHOLE.get_or_init(|| {
        let out = temporary("never-killed");
        let start = Instant::now();
        let output = run(&out, &[]);
        assert!(output.status.success(), "{}", complaint(&output));
        assert!(!out.join("checkpoint").exists(), "a finished run needs no memory");
        (remains(&out), start.elapsed())
    })
}

/// Lets a run live for `life`; whether it was killed.
fn kill_after(mut child: Child, life: Duration) -> bool {
    std::thread::sleep(life);
    let over = child.try_wait().unwrap().is_some();
    // On Unix this is SIGKILL: nobody is asked.
    child.kill().unwrap();
    let output = child.wait_with_output().unwrap();
    assert!(!over || output.status.success(), "{}", complaint(&output));
    !over
}

/// Kills runs with these settings at random moments until so many were killed; `dead` looks at the folder after each. All
/// must end as `whole`, which takes a while.
fn kill_at_random(
    (settings, name): (&[&str], &str),
    least: usize,
    (whole, takes): &(BTreeMap<String, Vec<u8>>, Duration),
    mut dead: impl FnMut(&Path),
) {
    let mut rng: Rng = Streams::new(11).stream("kills");
    let mut kills = 0;
    while kills < least {
        let out = temporary(name);
        loop {
            // Short lives and long ones, so that every part of the work is hit.
            let life = takes.mul_f64(rng.uniform() * 0.4);
            let child = toy(settings, &out, &["--resume"]).spawn().unwrap();
            if !kill_after(child, life) {
                break;
            }
            dead(&out);
            kills += 1;
        }
        assert!(remains(&out) == *whole, "after {kills} kills");
    }
}

#[test]
fn killed_at_any_moment_it_ends_with_the_same_bits() {
    kill_at_random((&TINY, "killed"), 20, uninterrupted(), |_| {});
}

#[test]
fn killed_between_iterations_it_ends_with_the_same_bits() {
    let out = temporary("never-killed-taught");
    let start = Instant::now();
    let output = toy(&TAUGHT, &out, &[]).output().unwrap();
    assert!(output.status.success(), "{}", complaint(&output));
    let (whole, mut underway) = ((remains(&out), start.elapsed()), 0);
    let draft = |piece: &PathBuf| piece.to_str().unwrap().contains("attention_draft");
    kill_at_random((&TAUGHT, "killed-taught"), 6, &whole, |out| {
        underway += usize::from(pieces(out).iter().any(draft));
    });
    assert!(underway > 0, "nobody was killed while it was taught");
}

/// A run that was stopped on its way, with several pieces kept.
fn stopped(name: &str) -> PathBuf {
    stopped_in(temporary(name))
}

fn stopped_in(out: PathBuf) -> PathBuf {
    let mut child = metal(&out, &[]).spawn().unwrap();
    while pieces(&out).len() < 6 {
        std::thread::sleep(Duration::from_millis(2));
        assert!(child.try_wait().unwrap().is_none(), "it ended before it was stopped");
    }
    child.kill().unwrap();
    child.wait().unwrap();
    out
}

fn pieces(out: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(out.join("checkpoint")).into_iter().flatten();
    let mut paths: Vec<PathBuf> = entries.map(|e| e.unwrap().path()).collect();
    paths.retain(|p| p.extension().is_some_and(|e| e == "piece"));
    paths.sort();
    paths
}

#[test]
fn damaged_pieces_are_named_and_done_again() {
    let (whole, _) = uninterrupted();
    let out = stopped("damaged");
    let (pieces, mut spoiled) = (pieces(&out), Vec::new());
    for (i, piece) in pieces.iter().enumerate() {
        let mut bytes = std::fs::read(piece).unwrap();
        let reason = match i % 5 {
            0 => {
                bytes.truncate(bytes.len() / 2);
                "the checksum does not match"
            }
            1 => {
                let middle = bytes.len() / 2;
                bytes[middle] ^= 1;
                "the checksum does not match"
            }
            2 => {
                bytes.clear();
                "not a piece of a checkpoint"
            }
            3 => {
                bytes[8] = 99;
                "format 99, this program reads 2"
            }
            // Whole, but of other work.
            _ => {
                bytes = std::fs::read(&pieces[(i + 1) % pieces.len()]).unwrap();
                "it holds `"
            }
        };
        std::fs::write(piece, &bytes).unwrap();
        spoiled.push((piece.file_name().unwrap().to_str().unwrap().to_owned(), reason));
    }
    let output = run(&out, &["--resume"]);
    let said = complaint(&output);
    assert!(output.status.success(), "{said}");
    for (name, reason) in spoiled.iter().take(4) {
        // A draft of a phase that is finished is not looked at.
        let line = said.lines().find(|line| line.contains(name.as_str()));
        let fine = line.is_some_and(|l| l.contains(reason) && l.contains("done again"));
        assert!(fine, "{name}: {reason}: {said}");
    }
    assert!(remains(&out) == *whole);
}

#[test]
fn a_damaged_job_does_not_let_strangers_in() {
    let (whole, _) = uninterrupted();
    let out = stopped("strange");
    std::fs::write(out.join("checkpoint/job.toml"), "format = ").unwrap();
    let output = run(&out, &["--resume", "--seed", "2"]);
    let said = complaint(&output);
    assert!(
        output.status.success() && said.contains("job.toml") && said.contains("it belongs to another run"),
        "{said}"
    );
    assert!(remains(&out) != *whole, "another seed, other numbers");
}

#[test]
fn another_job_is_refused_by_what_differs() {
    let out = stopped("another");
    let refused = |more: &[&str]| {
        let output = run(&out, more);
        assert_eq!(output.status.code(), Some(1), "{}", complaint(&output));
        complaint(&output)
    };
    assert!(
        refused(&[]).contains("holds an unfinished run; go on with --resume, or start over with --force")
    );
    let seed = refused(&["--resume", "--seed", "7"]);
    assert!(seed.contains("seed was 1 and is 7; start over with --force"), "{seed}");
    let runs = refused(&["--resume", "--set", "evaluation.runs=30"]);
    assert!(runs.contains("evaluation.runs was 12 and is 30"), "{runs}");
    assert!(run(&out, &["--force"]).status.success());
    assert!(refused(&[]).contains("holds a finished run"));
    let finished = std::fs::metadata(out.join("results.json")).unwrap().modified().unwrap();
    let again = run(&out, &["--resume"]);
    assert!(again.status.success() && String::from_utf8(again.stdout).unwrap().contains("acl"));
    let untouched = std::fs::metadata(out.join("results.json")).unwrap().modified().unwrap();
    assert_eq!(finished, untouched, "what is finished is only shown");
    assert!(refused(&["--resume", "--seed", "7"]).contains("seed was 1 and is 7"));
}

#[test]
fn two_at_once_do_not_share_a_folder() {
    let out = temporary("shared");
    let mut first = metal(&out, &[]).spawn().unwrap();
    while pieces(&out).is_empty() {
        std::thread::sleep(Duration::from_millis(2));
    }
    let second = run(&out, &["--resume"]);
    first.kill().unwrap();
    first.wait().unwrap();
    assert_eq!(second.status.code(), Some(1));
    assert!(complaint(&second).contains("another process is at work in this folder"));
}

/// A disk that is full, played by a limit on the size of files: the write fails half-way.
#[cfg(unix)]
#[test]
fn a_full_disk_costs_nothing_that_was_kept() {
    let (whole, _) = uninterrupted();
    let out = temporary("full");
    let command = metal(&out, &[]);
    let words: Vec<String> = std::iter::once(command.get_program())
        .chain(command.get_args())
        .map(|word| format!("'{}'", word.to_str().unwrap().replace('\'', "'\\''")))
        .collect();
    let limited = format!("trap '' XFSZ; ulimit -f 40; exec {}", words.join(" "));
    let output = Command::new("sh").args(["-c", &limited]).output().unwrap();
    let said = complaint(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(
        said.contains("not finished: --resume goes on from") && said.contains("File too large"),
        "{said}"
    );
    let drafts = std::fs::read_dir(out.join("checkpoint")).unwrap();
    assert_eq!(
        drafts.filter(|e| e.as_ref().unwrap().path().extension().is_some_and(|x| x == "tmp")).count(),
        0
    );
    let output = run(&out, &["--resume"]);
    assert!(output.status.success() && remains(&out) == *whole, "{}", complaint(&output));
}

/// Sets the permissions of a folder and of all that is in it, of the folders last.
#[cfg(unix)]
fn permit(folder: &Path, (folders, files): (u32, u32)) {
    use std::os::unix::fs::PermissionsExt;
    let set = |path: &Path, mode| std::fs::set_permissions(path, PermissionsExt::from_mode(mode)).unwrap();
    // Nobody looks into a folder that it may not enter, so that it is opened before its entries are read.
    set(folder, 0o755);
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() { permit(&path, (folders, files)) } else { set(&path, files) }
    }
    set(folder, folders);
}

/// The same command as somebody who is not root, whom no permission binds: its program and its experiment are copied to
/// where everybody may read them.
#[cfg(unix)]
fn unprivileged(command: &Command, place: &Path) -> Command {
    use std::os::unix::{fs::MetadataExt, process::CommandExt};
    let copied = |name: &str, from: &Path| {
        std::fs::copy(from, place.join(name)).unwrap();
        place.join(name)
    };
    let mut other = Command::new(copied("metal", Path::new(command.get_program())));
    for word in command.get_args() {
        let is_experiment = Path::new(word).extension().is_some_and(|e| e == "toml");
        let path = if is_experiment { copied("toy.toml", Path::new(word)) } else { word.into() };
        other.arg(path);
    }
    other.current_dir(place).stdout(Stdio::piped()).stderr(Stdio::piped());
    const NOBODY: u32 = 65534;
    if std::fs::metadata("/proc/self").is_ok_and(|me| me.uid() == 0) {
        other.uid(NOBODY).gid(NOBODY);
    }
    other
}

#[cfg(unix)]
#[test]
fn a_folder_that_may_not_be_written_costs_nothing_that_was_kept() {
    let (whole, _) = uninterrupted();
    let place = std::env::temp_dir().join(format!("metal-read-only-{}", std::process::id()));
    std::fs::create_dir_all(&place).unwrap();
    let out = stopped_in(place.join("out"));
    let kept =
        |out: &Path| -> Vec<Vec<u8>> { pieces(out).iter().map(|p| std::fs::read(p).unwrap()).collect() };
    let before = kept(&out);
    let mut again = unprivileged(&metal(&out, &["--resume"]), &place);
    permit(&out, (0o555, 0o444));
    let output = again.output().unwrap();
    permit(&out, (0o755, 0o644));
    let said = complaint(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("Permission denied") && said.contains(out.to_str().unwrap()), "{said}");
    assert!(kept(&out) == before, "what was kept is as it was");
    let output = run(&out, &["--resume"]);
    assert!(output.status.success() && remains(&out) == *whole, "{}", complaint(&output));
    std::fs::remove_dir_all(&place).unwrap();
}
