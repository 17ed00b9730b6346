//! `results.json`: round trip, and the layout as a golden text.

mod common;

use expect_test::expect_file;
use metal_lab::results::{Estimate, Results};
use serde_json::Value;

#[test]
fn results_survive_the_way_through_json() {
    for results in [common::results(), Results::default()] {
        let text = serde_json::to_string(&results).unwrap();
        let back: Results = serde_json::from_str(&text).unwrap();
        // Compared without printing: the files are long.
        assert!(
            back == results && serde_json::to_string(&back).unwrap() == text,
            "a number changed on the way"
        );
    }
}

#[test]
fn an_unknown_interval_is_null() {
    let text = serde_json::to_string(&Estimate::point(-1.5, 1)).unwrap();
    assert_eq!(text, r#"{"mean":-1.5,"lo":null,"hi":null,"n":1}"#);
}

#[test]
fn the_least_file_of_schema_1_is_read() {
    let text = r#"{"schema":1,"quick":true,"seeds":2,"roads":"test",
        "policies":{"acl":{"mix":{"total":{"mean":-12.0,"lo":-13.0,"hi":-11.0,"n":2}}}},"table3":[],"figures":{}}"#;
    let results: Results = serde_json::from_str(text).unwrap();
    assert_eq!(results.estimate("acl", "mix", "total"), Some(Estimate::interval(-12.0, -13.0, -11.0, 2)));
}

/// Maps whose keys are names rather than fields: one entry stands for all.
const NAMED: [&str; 9] = [
    "policies",
    "other_roads",
    "table2",
    "learning_curves",
    "sensitivity",
    "ratios",
    "cpu_seconds",
    "versions",
    "config",
];

/// Every path of the layout with its type; the first entry stands for a list.
fn outline(path: &str, value: &Value, lines: &mut Vec<String>) {
    match value {
        Value::Object(fields) if path == ".config" => {
            lines.push(format!("{path}: any ({} here)", fields.len()))
        }
        Value::Object(fields) if fields.contains_key("mean") => lines.push(format!("{path}: estimate")),
        Value::Object(fields) => {
            let is_named = is_named(path, fields);
            for (name, inner) in fields.iter().take(if is_named { 1 } else { usize::MAX }) {
                let name = if is_named { "*" } else { name };
                outline(&format!("{path}.{name}"), inner, lines);
            }
        }
        Value::Array(items) => match items.first() {
            Some(first) => outline(&format!("{path}[]"), first, lines),
            None => lines.push(format!("{path}: empty list")),
        },
        Value::Number(_) => lines.push(format!("{path}: number")),
        Value::String(_) => lines.push(format!("{path}: text")),
        Value::Bool(_) => lines.push(format!("{path}: bool")),
        Value::Null => lines.push(format!("{path}: null")),
    }
}

fn is_named(path: &str, fields: &serde_json::Map<String, Value>) -> bool {
    let last = path.rsplit('.').next().expect("a split has a first part");
    let is_map_of_maps = last == "*" && fields.values().all(Value::is_object) && !fields.contains_key("all");
    NAMED.contains(&last) || is_map_of_maps
}

#[test]
fn the_layout_is_stable() {
    let value = serde_json::to_value(common::results()).unwrap();
    let mut lines = Vec::new();
    outline("", &value, &mut lines);
    expect_file!["golden/results-layout.txt"].assert_eq(&(lines.join("\n") + "\n"));
}

#[test]
fn every_field_of_the_layout_is_documented() {
    let document = std::fs::read_to_string("../../docs/results-json.md").unwrap();
    let layout = include_str!("golden/results-layout.txt");
    for line in layout.lines() {
        let path = line.split(':').next().unwrap();
        for field in path.split(['.', '[', ']']).filter(|f| !f.is_empty() && *f != "*") {
            assert!(document.contains(&format!("`{field}`")), "docs/results-json.md does not name `{field}`");
        }
    }
}
