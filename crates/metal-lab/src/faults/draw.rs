//! The report as drawings, in the style of all others.

use super::{Block, Cell, FaultReport, Interruption, Spell};
use crate::figures::chart::{Ink, LineChart, LinePoint, Series};
use crate::figures::policy::{ink, short_label};
use crate::figures::{Figure, policy::sensor_ink};
use metal_rl::measure::statistics::Estimate;

/// Name → drawing as an `.svg` file with its own colours: cost and accidents against the rate, for each fault, and looks
/// through a fault, within an episode and over many.
#[must_use]
pub fn draw(report: &FaultReport) -> Vec<(String, String)> {
    let mut panels = Vec::new();
    for fault in &report.options.faults {
        let name = fault.name();
        panels.push((
            format!("cost-{name}"),
            against_rate(report, name, ("reward − cost per step", |c| &c.total)),
        ));
        let accidents: Number = ("share of episodes with an accident", |c| &c.accidents);
        panels.push((format!("accidents-{name}"), against_rate(report, name, accidents)));
    }
    for i in &report.interruptions {
        panels.push((format!("looks-within-{}-{}", i.policy, i.fault), within(i)));
    }
    for comeback in &report.comebacks {
        panels.push((format!("looks-{}", comeback.fault), through(&comeback.fault, &comeback.blocks)));
    }
    let drawn = panels.into_iter().flat_map(|(name, svg)| {
        let figure = Figure { id: "faults", caption: String::new(), panels: vec![svg] };
        figure.files().into_iter().map(move |file| (name.clone(), file)).collect::<Vec<_>>()
    });
    drawn.collect()
}

/// A number of a cell, and what it is called.
type Number = (&'static str, fn(&Cell) -> &Estimate);

fn point(x: f64, e: &Estimate) -> LinePoint {
    LinePoint { x, y: e.mean, band: e.band() }
}

fn against_rate(report: &FaultReport, fault: &str, (what, number): Number) -> String {
    let line = |policy: &String| {
        let sound = report.cell(policy, None, 0.0).into_iter();
        let broken = report.options.rates.iter().filter_map(|&rate| report.cell(policy, Some(fault), rate));
        Series {
            label: short_label(policy),
            ink: ink(policy),
            width: 2.0,
            dashed: false,
            points: sound.chain(broken).map(|c| point(c.rate, number(c))).collect(),
        }
    };
    LineChart {
        title: format!("Sensors fail in the test: {fault}"),
        x_label: "probability that a sensor fails in an episode".to_owned(),
        y_label: what.to_owned(),
        series: report.options.policies.iter().rev().map(line).collect(),
    }
    .draw()
}

fn within(interruption: &Interruption) -> String {
    let series = |label: &str, dashed: bool, number: fn(&Spell) -> &Estimate| Series {
        label: label.to_owned(),
        ink: ink(&interruption.policy),
        width: 2.0,
        dashed,
        points: interruption
            .spells
            .iter()
            .map(|s| point((s.steps.0 + s.steps.1) as f64 / 2.0, number(s)))
            .collect(),
    };
    let (policy, fault) = (short_label(&interruption.policy), &interruption.fault);
    LineChart {
        title: format!("{policy}: a sensor breaks ({fault}) and is mended within an episode"),
        x_label: "motor steps".to_owned(),
        y_label: "looks per motor step at that sensor".to_owned(),
        series: vec![
            series("it breaks", false, |s| &s.looks_there),
            series("it stays sound", true, |s| &s.looks_there_sound),
        ],
    }
    .draw()
}

fn through(fault: &str, blocks: &[Block]) -> String {
    let series = |label: &str, ink: Ink, number: fn(&Block) -> &Estimate| Series {
        label: label.to_owned(),
        ink,
        width: 2.0,
        dashed: false,
        points: blocks.iter().map(|b| point(b.episodes as f64, number(b))).collect(),
    };
    LineChart {
        title: format!("A sensor breaks ({fault}) and is mended"),
        x_label: "episodes of learning on".to_owned(),
        y_label: "looks per motor step".to_owned(),
        series: vec![
            series("all sensors", sensor_ink(None), |b| &b.looks),
            series("the broken one", ink("acl"), |b| &b.looks_there),
        ],
    }
    .draw()
}
