//! The report as Markdown, for a terminal and for a page.

use super::{CeilingReport, Line};
use crate::figures::markdown::{banded, row, table};
use crate::figures::number;
use std::fmt::Write;

/// All tables.
#[must_use]
pub fn text(report: &CeilingReport) -> String {
    let mut out = String::new();
    head(&mut out, report);
    for (title, remembers) in [("Without memory", false), ("With memory of the last looks", true)] {
        ceilings(&mut out, title, report.lines.iter().filter(|l| l.remembers == remembers));
    }
    ratios(&mut out, report);
    places(&mut out, report);
    causes(&mut out, report);
    learned(&mut out, report);
    out
}

fn plain(value: f64) -> String {
    number::fixed(value, 2)
}

fn head(out: &mut String, report: &CeilingReport) {
    let moments: usize = report.logs.iter().map(|l| l.moments).sum();
    let motors: Vec<String> = report.logs.iter().map(|l| plain(l.motor)).collect();
    let _ = writeln!(
        out,
        "{}: what the sensors of {} allow. {moments} moments of {} drivers that see everything (motor reward {}). \
         Rewards per motor step, 95 % intervals: bootstrap over the episodes that judge for ceilings, Student's over \
         trainings at the wheel. A ceiling judges one move at a time on the driver's own moments. At the wheel, fixed \
         choices are driven by a universal student that was taught where they lead to, looks by need by the student of \
         the ceiling.",
        report.title,
        report.world,
        report.logs.len(),
        motors.join(", "),
    );
}

fn ceilings<'a>(out: &mut String, title: &str, lines: impl Iterator<Item = &'a Line>) {
    let columns = [
        "looks are",
        "ceiling of",
        "looks",
        "motor",
        "total",
        "at the wheel",
        "looks",
        "motor",
        "total",
        "accidents",
    ];
    table(out, title, &columns);
    for line in lines {
        let choice = line.choice.as_ref().map_or("–".to_owned(), |(name, share)| {
            if *share < 1.0 { format!("{name} ({})", number::percent(*share)) } else { name.clone() }
        });
        let mut cells = vec![
            line.name.clone(),
            choice,
            plain(line.looks.mean),
            plain(line.motor.mean),
            banded(&line.total),
        ];
        if let Some(d) = &line.driven {
            let choices = if d.choices.is_empty() { "–".to_owned() } else { d.choices.join(", ") };
            let numbers = [
                plain(d.looks.mean),
                plain(d.motor.mean),
                banded(&d.total),
                number::percent(d.accidents.mean),
            ];
            cells.push(choices);
            cells.extend(numbers);
        }
        row(out, &cells);
    }
}

fn ratios(out: &mut String, report: &CeilingReport) {
    table(out, "Total cost of one against the other (ceilings, paired)", &["", "against", "memory", "ratio"]);
    for r in &report.ratios {
        let memory = if r.remembers { "yes" } else { "no" };
        row(out, &[r.of.clone(), r.to.clone(), memory.to_owned(), banded(&r.ratio)]);
    }
}

/// Lines that say where it is lost: few, so that they can be read.
fn telling(line: &&Line) -> bool {
    let names = ["nobody", "best single", "best of 2", "best fixed choice of all", "adaptive looks"];
    names.contains(&line.name.as_str()) || line.choice.as_ref().is_some_and(|(name, _)| name == "everybody")
}

fn label(line: &Line) -> String {
    format!("{}, {}", line.name, if line.remembers { "memory" } else { "no memory" })
}

fn places(out: &mut String, report: &CeilingReport) {
    let Some(first) = report.lines.first().filter(|l| l.places.len() > 1) else { return };
    let shares = first.places.iter().map(|p| format!("{} ({})", p.situation, number::percent(p.moments)));
    let names: Vec<String> = std::iter::once("looks are".to_owned()).chain(shares).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    table(out, "Where it is lost: per motor step there, and share of all that is lost", &names);
    for line in report.lines.iter().filter(telling) {
        let cells = line.places.iter().map(|p| format!("{} ({})", plain(p.lost), number::percent(p.share)));
        row(out, &std::iter::once(label(line)).chain(cells).collect::<Vec<_>>());
    }
}

fn causes(out: &mut String, report: &CeilingReport) {
    let known = report.lines.iter().find_map(|l| l.driven.as_ref().filter(|d| !d.causes.is_empty()));
    let Some(known) = known else { return };
    let names: Vec<&str> =
        std::iter::once("looks are").chain(known.causes.keys().map(String::as_str)).collect();
    table(out, "What is paid for at the wheel", &names);
    for (line, driven) in report.lines.iter().filter(telling).filter_map(|l| Some((l, l.driven.as_ref()?))) {
        let cells = driven.causes.values().map(|&cost| plain(cost));
        row(out, &std::iter::once(label(line)).chain(cells).collect::<Vec<_>>());
    }
}

fn learned(out: &mut String, report: &CeilingReport) {
    if report.learned.is_empty() {
        return;
    }
    table(out, "Learned", &["policy", "looks", "motor", "total"]);
    for l in &report.learned {
        row(out, &[l.name.clone(), plain(l.looks), banded(&l.motor), banded(&l.total)]);
    }
}
