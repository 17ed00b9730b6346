//! The house rules as tests: layers, purity, equations, readings, paths named in documents.

#[path = "house/citations.rs"]
mod citations;
#[path = "house/tree.rs"]
mod tree;

use citations::{equations, numbered};
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use tree::{Source, read, root, sources};

/// One line of `docs/paper/equations.toml`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    what: String,
    #[serde(default)]
    items: Vec<String>,
    absent: Option<String>,
    #[serde(default)]
    planned: bool,
}

/// `docs/paper/equations.toml`: number → entry.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Register {
    equation: BTreeMap<String, Entry>,
    figure: BTreeMap<String, Entry>,
    table: BTreeMap<String, Entry>,
}

fn register() -> Register {
    let text = read("docs/paper/equations.toml").expect("the register of equations exists");
    toml::from_str(&text).expect("the register of equations is well formed")
}

/// Whether every segment of a Rust path is an identifier in the code of its crate.
fn exists(path: &str, sources: &[Source]) -> bool {
    let mut segments = path.split("::");
    let home = format!("crates/{}/src/", segments.next().unwrap_or_default().replace('_', "-"));
    let files: Vec<&Source> = sources.iter().filter(|s| s.path.starts_with(&home)).collect();
    segments.all(|segment| files.iter().any(|f| f.identifiers.contains(segment)))
}

#[test]
fn the_register_is_complete() {
    let register = register();
    for (part, count) in [(&register.equation, 26), (&register.figure, 12), (&register.table, 3)] {
        let expected: BTreeSet<String> = (1..=count).map(|n: u32| n.to_string()).collect();
        assert_eq!(part.keys().cloned().collect::<BTreeSet<_>>(), expected);
        for (number, entry) in part {
            assert!(!entry.what.is_empty(), "{number} has no description");
            let excused = entry.absent.as_ref().is_some_and(|why| !why.is_empty());
            assert!(entry.items.is_empty() == excused, "{number}: either items or absent = \"why\"");
        }
    }
}

#[test]
fn registered_items_exist() {
    let (register, sources) = (register(), sources());
    let parts = [("equation", &register.equation), ("figure", &register.figure), ("table", &register.table)];
    for (part, entries) in parts {
        for (number, entry) in entries {
            let missing: Vec<_> = entry.items.iter().filter(|item| !exists(item, &sources)).collect();
            assert!(entry.planned || missing.is_empty(), "{part} {number}: {missing:?} is not in the code");
            let done = entry.planned && missing.is_empty();
            assert!(
                !done,
                "{part} {number} exists now: remove `planned = true` from docs/paper/equations.toml"
            );
        }
    }
}

#[test]
fn what_is_cited_is_registered() {
    let register = register();
    for source in sources() {
        let parts = [
            ("Eq.", equations(&source.comments), &register.equation),
            ("Fig.", numbered(&source.comments, &["Fig. ", "Figs. "]), &register.figure),
            ("Table", numbered(&source.comments, &["Table "]), &register.table),
        ];
        for (name, cited, known) in parts {
            for n in cited {
                let known = known.contains_key(&n.to_string());
                assert!(
                    known,
                    "{} cites {name} {n}, which docs/paper/equations.toml does not know",
                    source.path
                );
            }
        }
    }
}

#[test]
fn an_implemented_equation_is_cited_in_its_crate() {
    let sources = sources();
    for (number, entry) in register().equation {
        for item in entry.items.iter().filter(|_| !entry.planned) {
            let home = format!("crates/{}/", item.split("::").next().unwrap_or_default().replace('_', "-"));
            let cited = sources
                .iter()
                .filter(|s| s.path.starts_with(&home))
                .any(|s| equations(&s.comments).contains(&number.parse().expect("numbers are numbers")));
            assert!(cited, "no doc comment in {home} cites Eq. ({number}), which {item} implements");
        }
    }
}

#[test]
fn readings_are_unique_and_cited_readings_exist() {
    let text = read("docs/paper/fidelity.md").expect("docs/paper/fidelity.md exists");
    let mut known = BTreeSet::new();
    for row in text.lines().filter_map(|l| l.strip_prefix("| R")) {
        let id: u32 =
            row.split_whitespace().next().and_then(|n| n.parse().ok()).expect("a reading has a number");
        assert!(known.insert(id), "R{id} stands twice in docs/paper/fidelity.md");
        assert_eq!(row.replace("\\|", "").matches('|').count(), 5, "R{id} has not five columns");
    }
    for source in sources() {
        for id in citations::readings(&source.comments) {
            assert!(known.contains(&id), "{} cites R{id}, unknown to docs/paper/fidelity.md", source.path);
        }
    }
}

/// The crates of this workspace that `manifest` depends on, for building or for tests.
fn house_dependencies(manifest: &str) -> BTreeSet<String> {
    let text = read(manifest).expect("a crate has a manifest");
    let table: toml::Table = toml::from_str(&text).expect("manifests are TOML");
    ["dependencies", "dev-dependencies", "build-dependencies"]
        .iter()
        .filter_map(|section| table.get(*section)?.as_table())
        .flat_map(|section| section.keys().cloned())
        .filter(|name| name.starts_with("metal-"))
        .collect()
}

#[test]
fn layers_only_look_down() {
    for (name, allowed) in [
        ("metal-rl", &[][..]),
        ("metal-worlds", &["metal-rl"][..]),
        ("metal-lab", &["metal-recording", "metal-rl", "metal-worlds"][..]),
    ] {
        let found = house_dependencies(&format!("crates/{name}/Cargo.toml"));
        let allowed = allowed.iter().map(|a| (*a).to_owned()).collect();
        assert!(found.is_subset(&allowed), "{name} may depend on {allowed:?}, but depends on {found:?}");
    }
}

#[test]
fn the_mind_and_the_worlds_are_pure() {
    let impure = ["std::fs", "std::time", "std::thread", "std::net", "std::env", "std::process"];
    for source in sources() {
        let mind = source.path.starts_with("crates/metal-rl/src/");
        let world = source.path.starts_with("crates/metal-worlds/src/");
        for name in impure.iter().filter(|_| mind || world) {
            assert!(
                !source.code.contains(name),
                "{} uses {name}: files, clocks and threads live in the lab",
                source.path
            );
        }
        let learns = source.code.contains("metal_rl::learner") || source.code.contains("metal_rl::policies");
        assert!(!(world && learns), "{}: a world knows no learner and no policy", source.path);
    }
}

/// Words in single backticks outside fenced blocks that look like paths of this repository.
fn repository_paths(text: &str) -> Vec<String> {
    let folders = ["crates/", "docs/", "experiments/", "examples/", "xtask/", "python/", ".github/"];
    let prose = text.split("```").step_by(2);
    let words = prose.flat_map(|part| part.split('`').skip(1).step_by(2));
    words
        .filter(|w| folders.iter().any(|f| w.starts_with(f)) || (w.ends_with(".md") && !w.contains('/')))
        .filter(|w| !w.contains(|c: char| c.is_whitespace() || "*<>{}$…".contains(c)))
        .map(str::to_owned)
        .collect()
}

#[test]
fn paths_named_in_documents_exist() {
    for document in ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md"] {
        let Some(text) = read(document) else { continue };
        for path in repository_paths(&text) {
            assert!(root().join(&path).exists(), "{document} names `{path}`, which does not exist");
        }
    }
}

#[test]
fn paths_are_recognised_in_prose_only() {
    let text = "See `crates/a/src/lib.rs` and `docs/x.md`, `R60`, `metal run`, `crates/*/src`.\n```\n`docs/no`\n```\n`A.md`";
    assert_eq!(repository_paths(text), ["crates/a/src/lib.rs", "docs/x.md", "A.md"]);
}
