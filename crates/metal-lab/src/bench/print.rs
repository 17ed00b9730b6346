//! The comparison on a terminal.

use super::{Bench, ROWS, Row};
use metal_rl::measure::statistics::Estimate;
use std::fmt::Write;

/// Table, fronts, looks and warnings as text.
#[must_use]
pub fn text(bench: &Bench) -> String {
    let mut out = String::new();
    let n = bench.options.seeds;
    let _ = writeln!(
        out,
        "{}: per episode, interquartile mean of {n} trainings [95 % bootstrap interval]; {} motor steps each\n",
        bench.task,
        bench.recipe.steps()
    );
    let _ = writeln!(
        out,
        "{:18}  {:>27}  {:>27}  {:>9}  {:>6}  {:>7}",
        "", "reward - cost", "motor reward", "cost", "looks", "CPU s"
    );
    for name in ROWS {
        let _ = writeln!(out, "{}", line(name, &bench.rows[name]));
    }
    front(&mut out, bench);
    histogram(&mut out, bench);
    for warning in &bench.warnings {
        let _ = writeln!(out, "warning: {warning}");
    }
    out
}

fn line(name: &str, row: &Row) -> String {
    let numbers = format!(
        "{name:18}  {:>27}  {:>27}  {:>9.3}  {:>6.2}  {:>7.1}",
        interval(&row.total),
        interval(&row.motor),
        row.cost.mean,
        row.looks.mean,
        row.cpu_secs
    );
    if row.remark.is_empty() { numbers } else { format!("{numbers}  {}", row.remark) }
}

fn interval(e: &Estimate) -> String {
    match e.band() {
        Some((lo, hi)) => format!("{:.3} [{lo:.3}, {hi:.3}]", e.mean),
        None => format!("{:.3}", e.mean),
    }
}

fn front(out: &mut String, bench: &Bench) {
    let front = &bench.front;
    out.push_str("\nfront of motor reward against cost (0: blind, 1: all sensors): ");
    let (metal, fixed) = (front.metal_area, front.fixed_area);
    let _ = if metal.is_nan() {
        writeln!(out, "no area, since all sensors cost nothing or do no better than blind")
    } else {
        writeln!(out, "area {metal:.3}, fixed subsets {fixed:.3}")
    };
    for p in &front.metal {
        let _ = writeln!(out, "  cost {:9.3}  motor reward {:9.3}  {}", p.cost, p.motor, p.name);
    }
}

fn histogram(out: &mut String, bench: &Bench) {
    let scores = &bench.rows[super::rows::METAL].scores;
    let steps: usize = scores.iter().flat_map(|s| &s.steps).sum();
    let share = |count: usize| count as f64 / steps.max(1) as f64;
    let _ = writeln!(out, "\nsensors read by METAL before a move");
    for looks in 0..=bench.sensors.len() {
        let part = share(scores.iter().map(|s| s.looks[looks]).sum());
        if part > 0.0 {
            let bar = "#".repeat((part * 40.0).round() as usize);
            let _ = writeln!(out, "  {looks:2}  {:5.1} %  {bar}", part * 100.0);
        }
    }
    let _ = writeln!(out, "which of them, per move");
    for (s, name) in bench.sensors.iter().enumerate() {
        let part = share(scores.iter().map(|score| score.sensors[s]).sum());
        let _ = writeln!(out, "  {name:16}  {:5.1} %", part * 100.0);
    }
    out.push('\n');
}
