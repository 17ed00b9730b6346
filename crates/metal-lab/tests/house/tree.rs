//! The repository as text.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// One Rust file of the workspace.
pub struct Source {
    /// Path from the root of the repository, with `/`.
    pub path: String,
    /// Text of all comments, joined, so that a citation may run over a line end.
    pub comments: String,
    /// Everything else.
    pub code: String,
    /// The words of the code.
    pub identifiers: BTreeSet<String>,
}

/// Root of the repository.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// A file of the repository, if it exists.
pub fn read(path: &str) -> Option<String> {
    std::fs::read_to_string(root().join(path)).ok()
}

/// All Rust files below `crates`, except these house rules, which cite made-up numbers.
pub fn sources() -> Vec<Source> {
    let mut files = Vec::new();
    collect(&root().join("crates"), "crates", &mut files);
    files.retain(|f| !f.starts_with("crates/metal-lab/tests/house"));
    assert!(files.len() > 10, "the sources were not found");
    files.into_iter().map(source).collect()
}

fn collect(folder: &Path, name: &str, files: &mut Vec<String>) {
    let entries = std::fs::read_dir(folder).expect("folders can be read");
    let mut entries: Vec<_> = entries.map(|e| e.expect("folders can be read")).collect();
    entries.sort_by_key(std::fs::DirEntry::file_name);
    for entry in entries {
        let name = format!("{name}/{}", entry.file_name().to_string_lossy());
        if entry.path().is_dir() {
            collect(&entry.path(), &name, files);
        } else if name.ends_with(".rs") {
            files.push(name);
        }
    }
}

fn source(path: String) -> Source {
    let text = read(&path).expect("sources are UTF-8");
    let (mut comments, mut code) = (String::new(), String::new());
    for line in text.lines() {
        match line.trim_start().strip_prefix("//") {
            Some(comment) => {
                comments.push_str(&format!("{} ", comment.trim_start_matches(['/', '!']).trim()))
            }
            None => code.push_str(&format!("{line}\n")),
        }
    }
    let words = code.split(|c: char| !c.is_alphanumeric() && c != '_');
    let identifiers = words.filter(|w| !w.is_empty()).map(str::to_owned).collect();
    Source { path, comments, code, identifiers }
}
