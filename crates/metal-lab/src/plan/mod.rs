//! Experiments as data: what is typed ([`mod@file`]), what it means once checked ([`Plan`]).

mod check;
pub mod error;
pub mod file;
pub(crate) mod limits;
pub mod overrides;
pub mod rival;
mod roles;

pub use check::{MemberPlan, Plan};
pub use error::PlanError;
pub use file::{Acting, PlanFile};

use std::path::Path;

/// Reads and checks an experiment file, with `--set` assignments on top.
///
/// # Errors
/// Unreadable files, unknown keys, wrong types, impossible values: each with file, line and what is allowed.
pub fn load(path: &Path, assignments: &[String]) -> Result<Plan, PlanError> {
    let unreadable = |e: std::io::Error| PlanError::at("", format!("cannot be read: {e}")).located(path, "");
    let text = std::fs::read_to_string(path).map_err(unreadable)?;
    parse(&text, assignments).map_err(|e| e.located(path, &text))
}

/// Checks the text of an experiment file, with `--set` assignments on top.
///
/// # Errors
/// As [`load`], without a file name.
pub fn parse(text: &str, assignments: &[String]) -> Result<Plan, PlanError> {
    // First as typed, because only then the parser knows the line of a mistake.
    let file: PlanFile = toml::from_str(text).map_err(|e| error::from_toml(&e, text))?;
    if assignments.is_empty() {
        return Plan::check(file);
    }
    assigned(text, assignments).map_err(|e| blame(e, text, assignments))
}

fn assigned(text: &str, assignments: &[String]) -> Result<Plan, PlanError> {
    let mut table: toml::Table = toml::from_str(text).map_err(|e| error::from_toml(&e, text))?;
    overrides::apply(&mut table, assignments)?;
    let file = PlanFile::deserialize_table(table).map_err(|e| PlanError::at("", error::with_keys(&e)))?;
    Plan::check(file)
}

/// The assignment after which the plan was never right again is the one to mend.
fn blame(error: PlanError, text: &str, assignments: &[String]) -> PlanError {
    let right = (0..assignments.len()).rev().find(|&n| assigned(text, &assignments[..n]).is_ok());
    right.map_or(error.clone(), |n| error.caused_by(&assignments[n]))
}

impl PlanFile {
    fn deserialize_table(table: toml::Table) -> Result<Self, toml::de::Error> {
        toml::Value::Table(table).try_into()
    }
}
