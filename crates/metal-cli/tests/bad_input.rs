//! What every bad input is told, to the letter, and with which exit code. No panic, no backtrace, no results.
#![allow(clippy::unwrap_used)]

#[path = "bad_input/cases.rs"]
mod cases;
#[path = "bad_input/files.rs"]
mod files;

use cases::CASES;
use expect_test::expect_file;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A folder with nothing in it but what `files` puts there; messages name paths relative to it.
fn folder() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("bad-input");
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    files::write(&folder);
    folder
}

/// `metal` in `folder`: exit code and everything it says on standard error.
fn metal(folder: &Path, words: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_metal"));
    command.env_remove("COLUMNS").env_remove("LINES").env("RUST_BACKTRACE", "1").current_dir(folder);
    let output = command.args(words).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.stdout.is_empty(), "metal {words:?}: a mistake prints no results");
    assert!(!said.contains("panicked") && !said.contains("stack backtrace"), "metal {words:?}: {said}");
    (output.status.code(), said)
}

// Some messages quote the operating system, which has its own words everywhere.
#[cfg(target_os = "linux")]
#[test]
fn every_mistake_gets_its_message() {
    let folder = folder();
    let (mut book, mut clumsy) = (String::new(), Vec::new());
    for words in CASES {
        let (code, said) = metal(&folder, words);
        assert!(matches!(code, Some(1 | 2)), "metal {words:?}: {code:?} {said}");
        // What the parser of flags says has its own shape; what we say is one line.
        if code == Some(1) && !(said.starts_with("metal: ") && said.trim_end().lines().count() == 1) {
            clumsy.push(format!("metal {words:?}: {said}"));
        }
        let lines: Vec<&str> = said.lines().filter(|l| !l.is_empty()).collect();
        book += &format!("$ metal {}\n[{}] {}\n\n", words.join(" "), code.unwrap(), lines.join("\n    "));
    }
    assert!(CASES.len() >= 60, "{} cases", CASES.len());
    assert!(clumsy.is_empty(), "{}", clumsy.join("\n"));
    expect_file!["golden/bad-input.txt"].assert_eq(&book);
    assert!(!folder.join("never").exists(), "what is refused leaves nothing behind");
}

#[test]
fn files_in_the_way_are_left_alone() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("left-alone");
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(folder.join("webots/worlds")).unwrap();
    std::fs::write(folder.join("mine.mind"), "mine").unwrap();
    let (code, said) = metal(&folder, &["train-traffic", "--out", "mine.mind"]);
    assert_eq!((code, said.as_str()), (Some(1), "metal: mine.mind: exists; replace it with --force\n"));
    assert_eq!(std::fs::read_to_string(folder.join("mine.mind")).unwrap(), "mine");
}
