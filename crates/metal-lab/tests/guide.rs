//! The guide says what the code does: its programs are the examples, and no field of an experiment is left out.

use metal_lab::plan::{PlanFile, parse};
use metal_rl::learners::{BayesMixConfig, GivenConfig, IgmnConfig, LearnerConfig, MlpConfig, TileConfig};
use std::collections::BTreeSet;
use std::path::Path;

fn read(path: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path);
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

#[test]
fn the_programs_of_the_guide_are_the_examples() {
    for (page, example) in [("own-environment", "own_environment"), ("own-learner", "own_learner")] {
        let (text, program) = (
            read(&format!("docs/guide/{page}.md")),
            read(&format!("crates/metal-lab/examples/{example}.rs")),
        );
        let blocks: Vec<&str> =
            text.split("```rust\n").skip(1).map(|b| b.split("```").next().unwrap_or_default()).collect();
        assert!(!blocks.is_empty(), "{page} shows no program");
        for block in blocks {
            assert!(program.contains(block.trim_end()), "{page}.md differs from examples/{example}.rs");
        }
    }
}

/// All keys of a table, at any depth; the names that users give (one level below `named`) are no keys.
fn keys(value: &toml::Value, named: bool, found: &mut BTreeSet<String>) {
    const NAMED: [&str; 5] = ["learner", "member", "attention", "phase", "policy"];
    match value {
        toml::Value::Table(table) => {
            for (key, inner) in table {
                if !named {
                    found.insert(key.clone());
                }
                keys(inner, !named && NAMED.contains(&key.as_str()) && inner.is_table(), found);
            }
        }
        toml::Value::Array(items) => items.iter().for_each(|item| keys(item, false, found)),
        _ => {}
    }
}

/// The paper's experiment with one learner of every kind.
fn everything() -> PlanFile {
    let mut file = parse(metal_lab::experiments::PAPER, &[]).expect("the paper's plan is sound").file;
    for learner in [
        LearnerConfig::BayesMix(BayesMixConfig::default()),
        LearnerConfig::Igmn(IgmnConfig::default()),
        LearnerConfig::Tile(TileConfig::default()),
        LearnerConfig::Mlp(MlpConfig::default()),
        LearnerConfig::Given(GivenConfig::default()),
    ] {
        file.learner.insert(learner.name().to_owned(), learner);
    }
    file
}

#[test]
fn every_field_of_an_experiment_is_in_the_guide() {
    let text = read("docs/guide/experiments.md");
    let words: BTreeSet<&str> = text.split(|c: char| !c.is_alphanumeric() && c != '_').collect();
    let mut found = BTreeSet::new();
    keys(&toml::Value::try_from(everything()).unwrap(), false, &mut found);
    assert!(found.len() > 60, "only {} fields were found", found.len());
    let missing: Vec<_> = found.iter().filter(|key| !words.contains(key.as_str())).collect();
    assert!(missing.is_empty(), "docs/guide/experiments.md does not name {missing:?}");
}
