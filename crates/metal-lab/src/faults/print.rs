//! The report as Markdown, for a terminal and for a page.

use super::{Cell, FaultReport};
use crate::figures::markdown::{row, table};
use crate::figures::policy::short_label;
use metal_rl::measure::statistics::Estimate;
use std::fmt::Write;

/// All tables.
#[must_use]
pub fn text(report: &FaultReport) -> String {
    let mut out = String::new();
    let o = &report.options;
    let _ = writeln!(
        out,
        "{}: {} trainings (seed {}), {} test episodes of each in every cell. Mean over trainings [95 % Student \
         interval]; rewards per motor step.",
        report.title, o.seeds, o.seed, o.runs
    );
    tested(&mut out, report);
    trained(&mut out, report);
    interruptions(&mut out, report);
    comebacks(&mut out, report);
    changes(&mut out, report);
    out
}

fn number(e: &Estimate, digits: usize) -> String {
    match e.band() {
        Some((lo, hi)) => format!("{:.digits$} [{lo:.digits$}, {hi:.digits$}]", e.mean),
        None => format!("{:.digits$}", e.mean),
    }
}

fn percent(e: &Estimate) -> String {
    let scaled = |x: f64| 100.0 * x;
    match e.band() {
        Some((lo, hi)) => format!("{:.0} [{:.0}, {:.0}]", scaled(e.mean), scaled(lo), scaled(hi)),
        None => format!("{:.0}", scaled(e.mean)),
    }
}

fn columns(first: &[&str], report: &FaultReport, what: &[&str]) -> Vec<String> {
    let policies = report.options.policies.iter();
    let each = policies.flat_map(|p| what.iter().map(move |w| format!("{} {w}", short_label(p))));
    first.iter().map(|&s| s.to_owned()).chain(each).collect()
}

fn tested(out: &mut String, report: &FaultReport) {
    let names = columns(&["fault", "rate"], report, &["reward − cost", "accidents %"]);
    table(out, "Sensors fail in the test only", &names);
    let mut cases: Vec<(Option<&str>, f64)> = vec![(None, 0.0)];
    for fault in &report.options.faults {
        cases.extend(report.options.rates.iter().map(|&rate| (Some(fault.name()), rate)));
    }
    for (fault, rate) in cases {
        let mut cells = vec![fault.unwrap_or("none").to_owned(), rate.to_string()];
        for policy in &report.options.policies {
            let cell = report.cell(policy, fault, rate);
            cells.push(cell.map_or_else(String::new, |c| number(&c.total, 2)));
            cells.push(cell.map_or_else(String::new, |c| percent(&c.accidents)));
        }
        row(out, &cells);
    }
}

fn trained(out: &mut String, report: &FaultReport) {
    let names = ["trained with", "tested with", "policy", "reward − cost", "accidents %", "looks"];
    table(out, "Sensors fail in training, too", &names.map(str::to_owned));
    let training_rate = report.options.training_rate;
    let line = |cell: &Cell| {
        let fault = cell.fault.clone().unwrap_or_default();
        let rate = if cell.trained_with_it { training_rate } else { 0.0 };
        vec![
            format!("{fault} at {rate}"),
            format!("{fault} at {}", cell.rate),
            short_label(&cell.policy),
            number(&cell.total, 2),
            percent(&cell.accidents),
            number(&cell.looks, 2),
        ]
    };
    for fault in &report.options.trained_with {
        for policy in &report.options.policies {
            if let Some(cell) = report.cell(policy, Some(fault.name()), training_rate) {
                row(out, &line(cell));
            }
        }
        let mine = |c: &&Cell| c.trained_with_it && c.fault.as_deref() == Some(fault.name());
        report.cells.iter().filter(mine).for_each(|cell| row(out, &line(cell)));
    }
}

fn interruptions(out: &mut String, report: &FaultReport) {
    for interruption in &report.interruptions {
        let title = format!(
            "`{}`, within an episode, of the sensor that {} looks at most ({}); nobody learns",
            interruption.fault,
            short_label(&interruption.policy),
            interruption.sensors.join(", ")
        );
        let names = [
            "motor steps",
            "sensor",
            "looks there",
            "with a sound sensor",
            "looks in all",
            "reward − cost",
            "more than with a sound sensor",
        ];
        table(out, &title, &names.map(str::to_owned));
        for spell in &interruption.spells {
            let (from, until) = spell.steps;
            row(
                out,
                &[
                    format!("{from} to {}", until.saturating_sub(1)),
                    spell.sensor.clone(),
                    number(&spell.looks_there, 3),
                    number(&spell.looks_there_sound, 3),
                    number(&spell.looks, 2),
                    number(&spell.total, 2),
                    number(&spell.gain, 2),
                ],
            );
        }
    }
}

fn comebacks(out: &mut String, report: &FaultReport) {
    for comeback in &report.comebacks {
        let title = format!(
            "`{}` of the sensor that {} looks at most ({}), then mended; it learns on",
            comeback.fault,
            short_label(&comeback.policy),
            comeback.sensors.join(", ")
        );
        let names = ["episodes", "sensor", "looks there", "looks in all", "reward − cost"];
        table(out, &title, &names.map(str::to_owned));
        for block in &comeback.blocks {
            let stage = (block.episodes - 1) / report.options.lasting;
            row(
                out,
                &[
                    block.episodes.to_string(),
                    ["sound", "broken", "mended"][stage.min(2)].to_owned(),
                    number(&block.looks_there, 3),
                    number(&block.looks, 2),
                    number(&block.total, 2),
                ],
            );
        }
    }
}

fn changes(out: &mut String, report: &FaultReport) {
    if report.changes.is_empty() {
        return;
    }
    let title = format!("The world changes (Sec. 6.2); it learns on for {} episodes", report.options.lasting);
    let names = ["change", "policy", "before", "at once", "after learning on", "gain by learning", "expert"];
    table(out, &title, &names.map(str::to_owned));
    for c in &report.changes {
        let numbers = [Some(&c.before), Some(&c.at_once), c.adapted.as_ref(), c.gain.as_ref()];
        let mut cells = vec![c.what.clone(), short_label(&c.policy)];
        cells.extend(numbers.map(|e| e.map_or_else(|| "–".to_owned(), |e| number(e, 2))));
        cells.push(format!("{:.2} → {:.2}", c.expert.0.mean, c.expert.1.mean));
        row(out, &cells);
    }
}
