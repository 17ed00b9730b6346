//! The report: from results to one self-contained HTML page, paper beside ours.
//!
//! The page needs no script and loads nothing: figures and style are inside. What was not run says "not run". What
//! speaks against attention control is found from the numbers and said at the top.

mod budgets;
mod findings;
pub(crate) mod measure;
mod page;
pub(crate) mod table;
mod tables;

use minijinja::syntax::SyntaxConfig;
use minijinja::value::Serde;
use minijinja::{AutoEscape, Environment, Value};

use crate::results::Results;

/// What the report says beyond the results.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ReportContext {
    /// The command that made the results, as it was typed.
    pub command: String,
    /// When, as text; left out if empty.
    pub generated: String,
    /// Files beside the report: name and relative address.
    pub links: Vec<(String, String)>,
}

/// The page could not be made from its template.
#[derive(Debug, thiserror::Error)]
#[error("the report's template failed: {0:#}")]
pub struct ReportError(#[from] minijinja::Error);

const TEMPLATE: &str = include_str!("report.html.j2");
const PARTS: &str = include_str!("parts.html.j2");
const STYLE: &str = include_str!("style.css");

/// The whole report as one HTML page.
///
/// # Errors
/// If the template cannot be rendered, which would be a fault of this crate.
pub fn render(results: &Results, context: &ReportContext) -> Result<String, ReportError> {
    filled(TEMPLATE, &page::build(results, context))
}

/// A page of the house: `template`, which may use the common parts, filled with `content`.
pub(crate) fn filled(template: &str, content: &impl serde::Serialize) -> Result<String, ReportError> {
    let mut environment = Environment::new();
    environment.set_syntax(SyntaxConfig::builder().trim_blocks(true).lstrip_blocks(true).build()?);
    environment.set_auto_escape_callback(|_| AutoEscape::Html);
    environment.add_template("parts.html", PARTS)?;
    environment.add_template("page.html", template)?;
    Ok(environment.get_template("page.html")?.render(Value::from(Serde(content)))?)
}

/// The style of the report, theme included; the studio uses the same.
#[must_use]
pub fn style() -> String {
    format!("{}{STYLE}", crate::figures::chart::variables(":root"))
}
