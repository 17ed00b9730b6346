//! Experiments as data: what is typed ([`mod@file`]), what it means once checked ([`Plan`]).

mod check;
pub mod error;
pub mod file;
pub mod overrides;

pub use check::{MemberPlan, Plan};
pub use error::PlanError;
pub use file::{Acting, PlanFile};

use std::path::Path;

/// Reads and checks an experiment file, with `--set` assignments on top.
///
/// # Errors
/// Unreadable files, unknown keys, wrong types, impossible values: each with file, line and what is allowed.
pub fn load(path: &Path, assignments: &[String]) -> Result<Plan, PlanError> {
    let text = std::fs::read_to_string(path).map_err(|e| PlanError {
        file: Some(path.to_path_buf()),
        line: None,
        field: String::new(),
        message: format!("cannot be read: {e}"),
    })?;
    parse(&text, assignments).map_err(|e| e.located(path, &text))
}

/// Checks the text of an experiment file, with `--set` assignments on top.
///
/// # Errors
/// As [`load`], without a file name.
pub fn parse(text: &str, assignments: &[String]) -> Result<Plan, PlanError> {
    // First as typed, because only then the parser knows the line of a mistake.
    let mut file: PlanFile = toml::from_str(text).map_err(|e| error::from_toml(&e, text))?;
    if !assignments.is_empty() {
        let mut table: toml::Table = toml::from_str(text).map_err(|e| error::from_toml(&e, text))?;
        overrides::apply(&mut table, assignments)?;
        file = PlanFile::deserialize_table(table)
            .map_err(|e| PlanError::at(format!("--set {}", assignments.join(" --set ")), e.message()))?;
    }
    Plan::check(file)
}

impl PlanFile {
    fn deserialize_table(table: toml::Table) -> Result<Self, toml::de::Error> {
        toml::Value::Table(table).try_into()
    }
}
