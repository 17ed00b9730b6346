//! The report of a transfer: one self-contained page in the style of the house.

use super::{Arm, Curve, TransferResults, verdict};
use crate::figures::chart::{Ink, LineChart, LinePoint, Series};
use crate::figures::policy;
use crate::report::table::{Cell, Table};
use crate::report::{ReportError, filled, measure, style};
use crate::results::{Estimate, Measures};
use serde::Serialize;

const TEMPLATE: &str = include_str!("transfer.html.j2");

/// Measures of the tables.
const MEASURES: [&str; 7] =
    ["total", "motor", "perceptual", "looks", "accident_rate", "off_road_rate", "speed"];
/// Colours of the arms: from no demonstration to many, then from scratch.
const INKS: [&str; 5] = ["acl-paper", "fusion-pool", "acl", "foa", "foa-paper"];

#[derive(Serialize)]
struct Page {
    style: String,
    title: String,
    quick: bool,
    seeds: usize,
    runs: usize,
    command: String,
    verdict: Vec<String>,
    drives: Drawing,
    learning: Drawing,
    tests: Table,
    learned: Table,
    worlds: Table,
    config: String,
}

#[derive(Serialize)]
struct Drawing {
    caption: String,
    panels: Vec<String>,
}

/// The page; `command` is what was typed.
///
/// # Errors
/// If the template cannot be rendered, which would be a fault of this crate.
pub fn render(results: &TransferResults, command: &str) -> Result<String, ReportError> {
    let experiment = &results.experiment;
    let lead = policy::short_label(&experiment.policies[0]);
    let page = Page {
        style: style(),
        title: experiment.title.clone(),
        quick: results.options.quick,
        seeds: results.options.seeds,
        runs: experiment.runs,
        command: command.to_owned(),
        verdict: verdict::sentences(results),
        drives: Drawing {
            caption: format!(
                "{lead} tested after its demonstrations, nobody learns; mean of all test drives and trainings, looks \
                 included, with the 95 % interval over trainings (paper: Fig. 11, one drive of the robot). From scratch \
                 there is no attention yet to be tested."
            ),
            panels: panels(results, |r, arm| r.drives.get(&arm.name()), "motor steps"),
        },
        learning: Drawing {
            caption: format!(
                "{lead} learns on in the other world. From scratch: newborn minds after as many demonstrations, \
                 exploring as on the training road."
            ),
            panels: panels(results, |r, arm| r.learning.get(&arm.name()), "episodes"),
        },
        tests: tests(results),
        learned: learned(results),
        worlds: worlds(results),
        config: serde_json::to_string_pretty(experiment).unwrap_or_default(),
    };
    filled(TEMPLATE, &page)
}

/// Title of a panel, and the line it draws of a curve.
type Panel = (&'static str, fn(&Curve) -> &[Estimate]);

/// The three panels of Fig. 11.
fn panels(
    results: &TransferResults,
    curve: fn(&TransferResults, Arm) -> Option<&Curve>,
    x_label: &str,
) -> Vec<String> {
    let pick: [Panel; 3] = [
        ("Received reward", |c| &c.reward),
        ("Average over a moving window (5)", |c| &c.moving_average),
        ("Accumulated reward", |c| &c.accumulated),
    ];
    pick.map(|(title, values)| {
        let arms = results.experiment.arms().into_iter().zip(INKS.into_iter().cycle());
        let series = arms.filter_map(|(arm, ink)| Some(series(arm, ink, values(curve(results, arm)?))));
        let y_label = if title.starts_with("Acc") { "sum of reward" } else { "reward per motor step" };
        LineChart {
            title: title.to_owned(),
            x_label: x_label.to_owned(),
            y_label: y_label.to_owned(),
            series: series.collect(),
        }
        .draw()
    })
    .to_vec()
}

fn series(arm: Arm, ink: &'static str, values: &[Estimate]) -> Series {
    let point = |(i, e): (usize, &Estimate)| LinePoint { x: (i + 1) as f64, y: e.mean, band: e.band() };
    Series {
        label: arm.label(),
        ink: Ink(ink),
        width: 1.6,
        dashed: arm.newborn,
        points: values.iter().enumerate().map(point).collect(),
    }
}

fn columns(first: &str) -> Vec<String> {
    std::iter::once(first).chain(MEASURES.iter().map(|m| measure::label(m))).map(str::to_owned).collect()
}

fn row(name: String, measures: Option<&Measures>) -> Vec<Cell> {
    let cell = |m: &&str| Cell::measured(m, measures.and_then(|all| all.get(*m)).copied());
    std::iter::once(Cell::name(name)).chain(MEASURES.iter().map(cell)).collect()
}

fn tests(results: &TransferResults) -> Table {
    let arms = results.experiment.arms();
    let of = |name: &String| {
        let label = policy::short_label(name);
        let rows = arms.iter().filter_map(|arm| {
            let measures = results.tests.get(&arm.name())?.get(name)?;
            Some(row(format!("{label}, {}", arm.label()), Some(measures)))
        });
        rows.collect::<Vec<_>>()
    };
    let mut rows: Vec<Vec<Cell>> = results.experiment.policies.iter().flat_map(of).collect();
    rows.push(row("expert with ground truth".to_owned(), Some(&results.expert)));
    Table { caption: String::new(), columns: columns("Tested, nobody learns"), rows }
}

fn learned(results: &TransferResults) -> Table {
    let arms = results.experiment.arms().into_iter();
    let rows = arms.map(|arm| row(arm.label(), results.learned.get(&arm.name()))).collect();
    Table { caption: String::new(), columns: columns("Tested after learning on"), rows }
}

fn worlds(results: &TransferResults) -> Table {
    let names = results.experiment.world.iter().map(|w| w.name.as_str());
    let mut rows = Vec::new();
    for name in &results.experiment.policies {
        for world in std::iter::once("source").chain(names.clone()) {
            let label = if world == "source" { "where it learned" } else { world };
            let measures = results.worlds.get(world).and_then(|policies| policies.get(name));
            rows.push(row(format!("{}: {label}", policy::short_label(name)), measures));
        }
    }
    Table { caption: String::new(), columns: columns("As they come"), rows }
}
