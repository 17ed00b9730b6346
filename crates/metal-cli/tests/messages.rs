//! Every message that a body, its link, the doctor or a command on bodies can fail with is explained in
//! `docs/guide/robots.md`: read out of the sources, so that a new one cannot be forgotten.
#![allow(clippy::unwrap_used)]

use std::path::{Path, PathBuf};

/// Where messages begin: behind one of these, the next text in quotes is one.
const MARKERS: [(&str, &str); 13] = [
    ("#[error(", ""),
    ("ProtocolError::Unexpected(", "unexpected: "),
    ("BodyError::Lost(", "the link is lost: "),
    ("BodyError::Unsupported(", ""),
    ("CdrError::Unexpected(", "unexpected: "),
    ("TapeError::Foreign(", "this is no recording of METAL: "),
    ("bail!(", ""),
    ("ensure!(", ""),
    ("context(", ""),
    ("with_context(", ""),
    ("bad(", ""),
    ("doubtful(", ""),
    ("reason: ", ""),
];

fn sources() -> Vec<PathBuf> {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let alone = ["metal-cli/src/robots.rs", "metal-ros/src/main.rs", "metal-rl/src/environment.rs"];
    let mut files: Vec<PathBuf> = alone.iter().map(|file| crates.join(file)).collect();
    let mut folders = vec![crates.join("metal-robots/src"), crates.join("metal-recording/src")];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() { folders.push(path) } else { files.push(path) }
        }
    }
    files.sort();
    files
}

/// All texts in quotes in the parentheses that `code` begins inside of, as they are printed: `…` for what is filled in.
fn texts(code: &str) -> Vec<String> {
    let (mut found, mut depth, mut chars) = (Vec::new(), 1, code.chars().peekable());
    while depth > 0 {
        match chars.next() {
            Some('(') => depth += 1,
            Some(')') => depth -= 1,
            Some('"') => found.push(text(&mut chars)),
            Some(';') | None => return found,
            Some(_) => {}
        }
    }
    found
}

/// The rest of a text in quotes.
fn text(chars: &mut std::iter::Peekable<std::str::Chars<'_>>) -> String {
    let mut said = String::new();
    while let Some(c) = chars.next().filter(|&c| c != '"') {
        match c {
            '\\' => match chars.next().unwrap() {
                '\n' => while chars.next_if(|c| c.is_whitespace()).is_some() {},
                other => said.push(other),
            },
            '{' => {
                said.push('…');
                while chars.next().unwrap() != '}' {}
            }
            other => said.push(other),
        }
    }
    said
}

/// Every message in the sources: where it stands, and how it reads.
fn messages() -> Vec<(String, String)> {
    let mut found = Vec::new();
    for path in sources() {
        let code = std::fs::read_to_string(&path).unwrap();
        let code = code.split("#[cfg(test)]").next().unwrap();
        for (marker, prefix) in MARKERS {
            for (at, _) in code.match_indices(marker) {
                let inside = code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_');
                let line = code[..at].rsplit('\n').next().unwrap().trim_start();
                if inside || line.starts_with("//") || line.starts_with("fn ") {
                    continue;
                }
                let said = texts(&code[at + marker.len()..]);
                // The doctor says first what it looked at, in a word or two.
                let wanted = if marker == "doubtful(" || marker == "bad(" { usize::MAX } else { 1 };
                let said = said.iter().filter(|s| wanted == 1 || s.split(' ').count() > 2).take(wanted);
                // A cause stands behind a context.
                let cause = if marker.ends_with("context(") { ": …" } else { "" };
                found.extend(said.map(|said| (path.display().to_string(), format!("{prefix}{said}{cause}"))));
            }
        }
    }
    found.retain(|(_, said)| said.chars().any(char::is_alphabetic));
    found
}

/// Texts between backticks in the first column of the table of messages.
fn explained() -> Vec<String> {
    let guide = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/guide/robots.md");
    let guide = std::fs::read_to_string(guide).unwrap();
    let section = guide.split("## What messages mean").nth(1).unwrap().split("\n## ").next().unwrap();
    let cells = section.lines().filter_map(|line| line.strip_prefix("| ")?.split(" | ").next());
    let spans =
        cells.flat_map(|cell| cell.split('`').skip(1).step_by(2).map(str::to_owned).collect::<Vec<_>>());
    spans.collect()
}

/// Whether `text` is `pattern`, in which each `…` stands for anything.
fn fits(pattern: &str, text: &str) -> bool {
    let mut rest = text;
    for (i, piece) in pattern.split('…').enumerate() {
        match rest.find(piece) {
            Some(at) if i > 0 || at == 0 => rest = &rest[at + piece.len()..],
            _ => return false,
        }
    }
    pattern.ends_with('…') || rest.is_empty()
}

#[test]
fn every_message_of_the_bodies_is_explained_in_the_guide() {
    let explained = explained();
    assert!(explained.len() > 30, "{explained:?}");
    // Either may be the more general one: the guide shows what `cannot reach …` says most often. The doctor's texts are
    // explained by their tellable part.
    let known = |said: &str| {
        explained.iter().any(|e| {
            e.len() > 3 && (fits(e, said) || fits(said, e) || (e.len() > 9 && said.contains(e.as_str())))
        })
    };
    let messages = messages();
    assert!(messages.len() > 60, "{}", messages.len());
    let missing: Vec<String> = messages
        .iter()
        .filter(|(_, said)| !known(said))
        .map(|(path, said)| format!("{path}: {said}"))
        .collect();
    assert!(missing.is_empty(), "not in docs/guide/robots.md:\n{}", missing.join("\n"));
}
