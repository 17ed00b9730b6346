//! Tables as Markdown, for a terminal and for a page.

use super::number;
use crate::results::Estimate;
use std::fmt::Write;

/// One row.
pub fn row(out: &mut String, cells: &[String]) {
    let _ = writeln!(out, "| {} |", cells.join(" | "));
}

/// Names of columns and the line below them, after an empty line.
pub fn header<S: AsRef<str>>(out: &mut String, columns: &[S]) {
    out.push('\n');
    row(out, &columns.iter().map(|name| name.as_ref().to_owned()).collect::<Vec<_>>());
    row(out, &vec!["---".to_owned(); columns.len()]);
}

/// A heading, and a table's head under it.
pub fn table<S: AsRef<str>>(out: &mut String, title: &str, columns: &[S]) {
    let _ = write!(out, "\n### {title}\n");
    header(out, columns);
}

/// `mean [lo, hi]` with two decimals; the mean alone if no interval is known.
#[must_use]
pub fn banded(e: &Estimate) -> String {
    let band = number::interval(e, 2).map(|i| format!(" {i}")).unwrap_or_default();
    format!("{}{band}", number::fixed(e.mean, 2))
}
