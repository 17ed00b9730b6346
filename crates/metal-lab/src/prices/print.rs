//! The report as Markdown, for a terminal and for a page.

use super::{PricesReport, Row};
use crate::figures::markdown::{banded, header, row};
use crate::figures::{number, policy};
use std::fmt::Write;

/// All tables.
#[must_use]
pub fn text(report: &PricesReport) -> String {
    let mut out = format!(
        "{}: attention and fixed choices in {} at other prices of looking. {} trainings each (seed {}), {} episodes on \
         validation roads. Rewards per motor step, 95 % Student intervals over trainings. The best fixed choice is that of \
         the same trainings, which flatters it.\n",
        report.title, report.world, report.options.seeds, report.options.seed, report.options.runs
    );
    prices(&mut out, report);
    fixed(&mut out, &report.fixed);
    if let Some(saved) = &report.saved {
        let _ = writeln!(
            out,
            "\nSaved of what the best fixed choice costs, over all prices from {} to {} (area between by area below): {}.",
            report.options.factors[0],
            report.options.factors[report.options.factors.len() - 1],
            banded(saved)
        );
    }
    out
}

fn prices(out: &mut String, report: &PricesReport) {
    let columns =
        ["prices ×", "looks", "motor", "total", "best fixed choice", "motor", "total", "ratio of totals"];
    header(out, &columns);
    for at in &report.prices {
        let cells = [
            at.factor.to_string(),
            banded(&at.attention.looks),
            banded(&at.attention.motor),
            banded(&at.total),
            policy::short_label(&at.best),
            banded(&at.best_motor),
            banded(&at.best_total),
            at.ratio.as_ref().map_or("–".to_owned(), banded),
        ];
        row(out, &cells);
    }
}

fn fixed(out: &mut String, rows: &[Row]) {
    header(out, &["fixed choice", "looks", "their price", "motor", "motor by training"]);
    for r in rows {
        let trainings: Vec<String> = r.trainings.iter().map(|&m| number::fixed(m, 2)).collect();
        let cells = [
            policy::short_label(&r.name),
            number::fixed(r.looks.mean, 2),
            number::fixed(r.price.mean, 2),
            banded(&r.motor),
            trainings.join(", "),
        ];
        row(out, &cells);
    }
}
