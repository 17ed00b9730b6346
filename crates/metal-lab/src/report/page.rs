//! What the template is given.

use serde::Serialize;

use super::budgets;
use super::findings::{self, Goal};
use super::table::Table;
use super::{ReportContext, style, tables};
use crate::figures::{FIGURES, number, policy};
use crate::paper;
use crate::results::{Policies, Results};

/// Everything that the template shows.
#[derive(Debug, Serialize)]
pub struct Page {
    style: String,
    quick: bool,
    seeds: u32,
    roads: String,
    command: String,
    generated: String,
    links: Vec<(String, String)>,
    headline: String,
    caveat: Option<String>,
    goals: Vec<Goal>,
    is_acl_run: bool,
    against: Vec<String>,
    budgets: Vec<budgets::Row>,
    figures: std::collections::BTreeMap<&'static str, FigureView>,
    scenes: Vec<Scene>,
    tables: Tables,
    everything: Vec<Everything>,
    versions: Vec<(String, String)>,
    cpu: Vec<(String, String)>,
    config: String,
}

/// A figure as the template places it.
#[derive(Debug, Serialize)]
struct FigureView {
    caption: String,
    panels: Vec<String>,
}

#[derive(Debug, Serialize)]
struct Tables {
    headline: Table,
    table2: Vec<Table>,
    table3: Table,
    aliasing: Table,
    behaviour: Table,
    baselines: Table,
    subsets: Table,
    roads: Option<Table>,
}

/// One row of Table 1.
#[derive(Debug, Serialize)]
struct Scene {
    situation: String,
    picture: Option<String>,
    learned: Option<String>,
    agreement: String,
    action: Option<String>,
    paper: String,
    reason: String,
}

/// All numbers of one scenario on one set of roads.
#[derive(Debug, Serialize)]
struct Everything {
    title: String,
    table: Table,
}

/// Gathers everything that the template shows.
#[must_use]
pub fn build(results: &Results, context: &ReportContext) -> Page {
    Page {
        style: style(),
        quick: results.quick,
        seeds: results.seeds,
        roads: results.roads.clone(),
        command: context.command.clone(),
        generated: context.generated.clone(),
        links: context.links.clone(),
        headline: findings::headline(results),
        caveat: findings::caveat(results),
        goals: findings::goals(results),
        is_acl_run: results.estimate("acl", "mix", "total").is_some(),
        against: findings::against(results),
        budgets: budgets::rows(results),
        figures: figures(results),
        scenes: scenes(results),
        tables: all_tables(results),
        everything: everything(results),
        versions: results.versions.iter().map(|(k, v)| (k.clone(), v.clone())).collect(),
        cpu: cpu(results),
        config: config(results),
    }
}

fn figures(results: &Results) -> std::collections::BTreeMap<&'static str, FigureView> {
    let view = |(id, draw): (&'static str, crate::figures::Draw)| {
        let figure = draw(results)?;
        Some((id, FigureView { caption: figure.caption, panels: figure.panels }))
    };
    FIGURES.into_iter().filter_map(view).collect()
}

fn all_tables(results: &Results) -> Tables {
    let style_caption = |style: &str| match style {
        "ten_runs" => "As in the paper: ten runs of 50 steps per cell.".to_owned(),
        "full" => "The same with many more runs.".to_owned(),
        other => other.to_owned(),
    };
    // Ten runs, as in the paper, come first.
    let mut table2: Vec<_> = results.table2.iter().collect();
    table2.sort_by_key(|(style, _)| style.as_str() != "ten_runs");
    let table2 = table2.into_iter().map(|(style, table)| tables::table2(table, &style_caption(style)));
    Tables {
        headline: tables::headline(results),
        table2: table2.collect(),
        table3: tables::table3(results),
        aliasing: tables::aliasing(results),
        behaviour: tables::behaviour(results),
        baselines: tables::baselines(results),
        subsets: tables::subsets(results),
        roads: (!results.other_roads.is_empty()).then(|| tables::roads(results)),
    }
}

/// The paper's six rows, with ours where they were run.
fn scenes(results: &Results) -> Vec<Scene> {
    let measured = &results.figures.table1;
    let pictures = crate::figures::draw("table1", results).map(|f| f.panels).unwrap_or_default();
    let row = |&(situation, looks, reason): &(&str, &[&str], &str)| {
        let index = measured.iter().position(|m| m.situation == situation);
        let ours = index.map(|i| &measured[i]);
        Scene {
            situation: situation.to_owned(),
            picture: index.and_then(|i| pictures.get(i).cloned()),
            learned: ours.map(|m| sequence(&m.learned)),
            agreement: ours.map(|m| number::percent(m.agreement)).unwrap_or_default(),
            action: ours.and_then(|m| m.action.clone()),
            paper: looks.join(" → "),
            reason: reason.to_owned(),
        }
    };
    paper::TABLE1.iter().map(row).collect()
}

fn sequence(looks: &[String]) -> String {
    if looks.is_empty() { "no look".to_owned() } else { looks.join(" → ") }
}

fn everything(results: &Results) -> Vec<Everything> {
    let mut sets: Vec<(&str, &Policies)> = vec![(results.roads.as_str(), &results.policies)];
    sets.extend(results.other_roads.iter().map(|(name, policies)| (name.as_str(), policies)));
    let mut found = Vec::new();
    for (roads, policies) in sets {
        let scenarios: std::collections::BTreeSet<&String> =
            policies.values().flat_map(|s| s.keys()).collect();
        for scenario in scenarios {
            let title = format!("{}, {roads} roads", policy::scenario_label(scenario));
            found.push(Everything { title, table: tables::everything(results, (policies, scenario)) });
        }
    }
    found
}

fn cpu(results: &Results) -> Vec<(String, String)> {
    let total: f64 = results.cpu_seconds.values().sum();
    let mut parts: Vec<_> =
        results.cpu_seconds.iter().map(|(part, &s)| (part.replace('_', " "), seconds(s))).collect();
    if parts.len() > 1 {
        parts.push(("all".to_owned(), seconds(total)));
    }
    parts
}

fn seconds(seconds: f64) -> String {
    format!("{}\u{a0}s", number::fixed(seconds, number::digits_for(seconds).min(1)))
}

fn config(results: &Results) -> String {
    if results.config.is_null() {
        return String::new();
    }
    // A JSON value can always be written.
    serde_json::to_string_pretty(&results.config).unwrap_or_default()
}
