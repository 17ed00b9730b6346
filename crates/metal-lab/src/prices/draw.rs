//! The report as drawings: motor cost and total cost against the price of looking.

use super::{At, PricesReport, Row};
use crate::figures::chart::{Ink, LineChart, LinePoint, Series};
use crate::figures::{Figure, policy};
use crate::results::Estimate;

const ATTENTION: Ink = Ink("acl");
const FIXED: Ink = Ink("fixed");
const OTHERS: Ink = Ink("blind");

/// Name → drawing as an `.svg` file with its own colours: motor cost, total cost, looks.
#[must_use]
pub fn draw(report: &PricesReport) -> Vec<(String, String)> {
    let panels = [("motor", motor(report)), ("total", total(report)), ("looks", looks(report))];
    let drawn = panels.into_iter().flat_map(|(name, chart)| {
        let figure = Figure { id: "prices", caption: String::new(), panels: vec![chart.draw()] };
        figure.files().into_iter().map(move |file| (name.to_owned(), file)).collect::<Vec<_>>()
    });
    drawn.collect()
}

fn chart(title: &str, y_label: &str, series: Vec<Series>) -> LineChart {
    LineChart {
        title: title.to_owned(),
        x_label: "prices of looks, in multiples of the task's".to_owned(),
        y_label: y_label.to_owned(),
        series,
    }
}

fn line(label: &str, ink: Ink, (width, dashed): (f64, bool), points: Vec<LinePoint>) -> Series {
    Series { label: label.to_owned(), ink, width, dashed, points }
}

fn over_prices(report: &PricesReport, value: impl Fn(&At) -> &Estimate) -> Vec<LinePoint> {
    let point = |at: &At| LinePoint { x: at.factor, y: value(at).mean, band: value(at).band() };
    report.prices.iter().map(point).collect()
}

/// A fixed choice as a straight line over all prices.
fn straight(report: &PricesReport, height: impl Fn(f64) -> f64) -> Vec<LinePoint> {
    report.prices.iter().map(|at| LinePoint { x: at.factor, y: height(at.factor), band: None }).collect()
}

/// Those that are the best somewhere, and all sensors: the others would hide them.
fn worth_drawing(report: &PricesReport) -> impl Iterator<Item = &Row> {
    let last = report.fixed.len().saturating_sub(1);
    let best = |row: &Row| report.prices.iter().any(|at| at.best == row.name);
    report.fixed.iter().enumerate().filter(move |(i, row)| *i == last || best(row)).map(|(_, row)| row)
}

fn motor(report: &PricesReport) -> LineChart {
    let others = worth_drawing(report).map(|row| {
        let points = straight(report, |_| row.motor.mean);
        line(&policy::short_label(&row.name), OTHERS, (1.2, true), points)
    });
    let best = line("best fixed choice", FIXED, (1.8, false), over_prices(report, |at| &at.best_motor));
    let own = line("attention", ATTENTION, (2.8, false), over_prices(report, |at| &at.attention.motor));
    chart("Motor part alone", "motor cost per motor step", others.chain([best, own]).collect())
}

fn total(report: &PricesReport) -> LineChart {
    let best = line("best fixed choice", FIXED, (1.8, false), over_prices(report, |at| &at.best_total));
    let own = line("attention", ATTENTION, (2.8, false), over_prices(report, |at| &at.total));
    chart("Total", "total cost per motor step", vec![best, own])
}

fn looks(report: &PricesReport) -> LineChart {
    let of_best =
        |at: &At| report.fixed.iter().find(|row| row.name == at.best).map_or(0.0, |row| row.looks.mean);
    let points =
        report.prices.iter().map(|at| LinePoint { x: at.factor, y: of_best(at), band: None }).collect();
    let best = line("best fixed choice", FIXED, (1.8, false), points);
    let own = line("attention", ATTENTION, (2.8, false), over_prices(report, |at| &at.attention.looks));
    chart("Looks", "looks per motor step", vec![best, own])
}
