//! The report as a page: complete, well-formed, self-contained.

mod common;

use metal_lab::figures::{FIGURES, number};
use metal_lab::report::{ReportContext, render};
use metal_lab::results::Results;

fn context() -> ReportContext {
    ReportContext {
        command: "metal reproduce --seeds 5".to_owned(),
        generated: "1 January 2026".to_owned(),
        links: vec![("results.json".to_owned(), "results.json".to_owned())],
    }
}

fn page(results: &Results) -> String {
    render(results, &context()).expect("the template is sound")
}

/// Opened elements must be closed in order; elements without content must close themselves.
fn assert_tags_balance(html: &str) {
    let mut open: Vec<&str> = Vec::new();
    let mut rest = html;
    while let Some(start) = rest.find('<') {
        let end = start + rest[start..].find('>').expect("a tag that never ends");
        let tag = &rest[start + 1..end];
        rest = &rest[end + 1..];
        let name = tag.trim_start_matches('/').split([' ', '\n']).next().expect("a split has a first part");
        if tag.starts_with('!') || tag.ends_with('/') {
            continue;
        }
        if tag.starts_with('/') {
            assert_eq!(open.pop(), Some(name), "</{name}> closes something else");
        } else {
            open.push(name);
        }
    }
    assert!(open.is_empty(), "never closed: {open:?}");
}

#[test]
fn the_page_is_well_formed_with_and_without_data() {
    for results in [common::results(), Results::default()] {
        assert_tags_balance(&page(&results));
    }
}

#[test]
#[should_panic(expected = "closes something else")]
fn the_checker_sees_a_missing_end() {
    assert_tags_balance("<p><b>x</p>");
}

#[test]
fn nothing_is_loaded_from_outside() {
    let html = page(&common::results());
    for attribute in ["src=", "@import", "url(", "<script", "<link", "<iframe", "<image"] {
        assert!(!html.contains(attribute), "{attribute}");
    }
    for (at, _) in html.match_indices("href=\"") {
        let target = &html[at + 6..at + 20];
        assert!(target.starts_with('#') || target.starts_with("results.json"), "{target}");
    }
}

#[test]
fn every_number_of_the_results_appears() {
    let results = common::results();
    let html = page(&results);
    for policies in [&results.policies].into_iter().chain(results.other_roads.values()) {
        for (measure, estimate) in policies.values().flat_map(|s| s.values()).flatten() {
            let text = match measure.as_str() {
                m if m.ends_with("_rate") || m == "speed_smoothness" => number::percent(estimate.mean),
                "lane_offset" | "path_smoothness" | "speed" => number::fixed(estimate.mean, 3),
                _ => number::fixed(estimate.mean, 2),
            };
            assert!(html.contains(&format!(">{text}<")), "{measure} {text}");
        }
    }
}

#[test]
fn every_figure_is_drawn_and_missing_ones_are_named() {
    let results = common::results();
    for (name, draw) in FIGURES {
        let figure = draw(&results).unwrap_or_else(|| panic!("{name} is not drawn"));
        for file in figure.files() {
            assert_tags_balance(&file);
            assert!(file.contains("<style>") && !file.contains("NaN"), "{name}");
        }
        assert!(draw(&Results::default()).is_none(), "{name} is drawn from nothing");
    }
    assert!(page(&Results::default()).matches("ot run").count() > 15);
}

#[test]
fn a_result_against_attention_control_is_said_at_the_top() {
    let html = page(&common::results());
    let said = html.find("Best fixed (MN+MF) is cheaper than attention control").expect("it is not said");
    assert!(said < html.find("id=\"fig6\"").unwrap());
}

#[test]
fn foreign_text_is_escaped() {
    let html = page(&common::results());
    assert!(html.contains("&lt;own type&gt;") && !html.contains("<own type>"));
}

#[test]
fn a_quick_run_is_labelled() {
    let quick = Results { quick: true, ..common::results() };
    assert!(page(&quick).contains("Quick run."));
    assert!(!page(&common::results()).contains("Quick run."));
}

/// Writes the page and the figures where `METAL_REPORT_DIR` says, to be looked at:
/// `METAL_REPORT_DIR=/tmp/report cargo test -p metal-lab --test markup -- --ignored`.
#[test]
#[ignore = "writes files for the eye"]
fn write_the_page() {
    let directory = std::path::PathBuf::from(std::env::var("METAL_REPORT_DIR").unwrap());
    std::fs::create_dir_all(&directory).unwrap();
    std::fs::write(directory.join("report.html"), page(&common::results())).unwrap();
    std::fs::write(directory.join("empty.html"), page(&Results::default())).unwrap();
    for (name, draw) in FIGURES {
        for (i, file) in draw(&common::results()).unwrap().files().iter().enumerate() {
            std::fs::write(directory.join(format!("{name}-{i}.svg")), file).unwrap();
        }
    }
}
