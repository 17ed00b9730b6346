//! A table as the template draws it.

use serde::Serialize;

use super::measure;
use crate::results::Estimate;

/// One cell: a main text, a smaller one below it, and a class for the style.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Cell {
    /// What it says.
    pub main: String,
    /// Interval and n.
    pub sub: String,
    /// `paper`, `ours`, `best`, `missing`, `name` or nothing.
    pub class: &'static str,
}

impl Cell {
    /// A plain text.
    #[must_use]
    pub fn text(main: impl Into<String>) -> Self {
        Self { main: main.into(), ..Self::default() }
    }

    /// The name of a row.
    #[must_use]
    pub fn name(main: impl Into<String>) -> Self {
        Self { class: "name", ..Self::text(main) }
    }

    /// A number printed in the paper, with what stands behind it.
    #[must_use]
    pub fn paper(main: impl Into<String>, sub: impl Into<String>) -> Self {
        Self { main: main.into(), sub: sub.into(), class: "paper" }
    }

    /// A number that was not measured.
    #[must_use]
    pub fn missing() -> Self {
        Self { class: "missing", ..Self::text("not run") }
    }

    /// A number that the paper does not print.
    #[must_use]
    pub fn unprinted() -> Self {
        Self::paper("–", "")
    }

    /// A measured number with its interval and n, or "not run".
    #[must_use]
    pub fn measured(measure: &str, estimate: Option<Estimate>) -> Self {
        let Some(estimate) = estimate else { return Self::missing() };
        let interval = measure::interval(measure, &estimate).map(|i| format!("{i} ")).unwrap_or_default();
        Self {
            main: measure::mean(measure, &estimate),
            sub: format!("{interval}n\u{a0}=\u{a0}{}", estimate.n),
            class: "ours",
        }
    }
}

/// A table with a heading row.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Table {
    /// What it shows.
    pub caption: String,
    /// Column headings.
    pub columns: Vec<String>,
    /// Rows of cells.
    pub rows: Vec<Vec<Cell>>,
}
