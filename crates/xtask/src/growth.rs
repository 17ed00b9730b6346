//! How time grows with an amount: the exponent of each group, fitted to all of its rows, and a picture of them.

use crate::{Row, duration};
use std::io::{Error, Write};
use std::path::Path;
use std::process::{Command, Stdio};

/// A group of measurements over a growing amount: (amount, seconds).
type Curve<'a> = (&'a str, Vec<(f64, f64)>);

/// The groups in which something grows.
fn curves(rows: &[Row]) -> Vec<Curve<'_>> {
    let mut curves: Vec<Curve<'_>> = Vec::new();
    for row in rows {
        let Some(amount) = row.amount else { continue };
        match curves.iter_mut().find(|(group, _)| *group == row.group) {
            Some((_, points)) => points.push((amount, row.secs)),
            None => curves.push((&row.group, vec![(amount, row.secs)])),
        }
    }
    curves.retain(|(_, points)| points.len() > 1);
    curves
}

/// The exponent p of the law "time ~ amountᵖ": the slope of the line of least squares through the logarithms.
#[expect(clippy::disallowed_methods, reason = "it is only shown")]
fn exponent(points: &[(f64, f64)]) -> f64 {
    let logs: Vec<(f64, f64)> = points.iter().map(|(n, t)| (n.ln(), t.ln())).collect();
    let mean = |of: fn(&(f64, f64)) -> f64| logs.iter().map(of).sum::<f64>() / logs.len() as f64;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let covariance: f64 = logs.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    let variance: f64 = logs.iter().map(|p| (p.0 - x) * (p.0 - x)).sum();
    covariance / variance
}

/// Prints the exponents, if anything grows.
pub(crate) fn print(rows: &[Row]) -> Result<(), Error> {
    let (curves, mut out) = (curves(rows), std::io::stdout().lock());
    if curves.is_empty() {
        return Ok(());
    }
    writeln!(out, "\n| what grows | from → to | time | exponent |\n|---|---|---|---:|")?;
    for (group, points) in &curves {
        let ((from, first), (to, last)) = (points[0], points[points.len() - 1]);
        let (first, last, exponent) = (duration(first), duration(last), exponent(points));
        writeln!(out, "| {group} | {from} → {to} | {first} → {last} | {exponent:.2} |")?;
    }
    Ok(())
}

/// Has the growth drawn into `file` by the lab, which has the charts.
pub(crate) fn draw(rows: &[Row], file: &Path) -> Result<(), Error> {
    let mut lab = Command::new(env!("CARGO"))
        .args(["bench", "--quiet", "--package", "metal-lab", "--bench", "growth_chart"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()?;
    if let Some(mut input) = lab.stdin.take() {
        for (group, points) in curves(rows) {
            points.iter().try_for_each(|(n, t)| writeln!(input, "{group}\t{n}\t{t:e}"))?;
        }
    }
    let output = lab.wait_with_output()?;
    if !output.status.success() {
        return Err(Error::other("the chart could not be drawn"));
    }
    std::fs::write(file, output.stdout)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exponent_is_that_of_the_law() {
        let row = |group: &str, amount: Option<f64>, secs: f64| Row {
            group: group.into(),
            name: String::new(),
            secs,
            what: String::new(),
            amount,
        };
        let square = |n: f64| row("square", Some(n), 3.0 * n * n);
        let rows =
            [square(1.0), row("none", None, 1.0), square(2.0), row("one", Some(1.0), 1.0), square(8.0)];
        let found = curves(&rows);
        assert_eq!(found.len(), 1);
        assert!((exponent(&found[0].1) - 2.0).abs() < 1e-12);
    }
}
