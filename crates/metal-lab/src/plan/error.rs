//! What is wrong with an experiment file, said so that it can be mended: file, line, field, what was found, what is allowed.

use std::fmt;
use std::path::{Path, PathBuf};

/// A refused experiment file.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanError {
    /// The file, if the plan came from one.
    pub file: Option<PathBuf>,
    /// Line, from 1, where it is known.
    pub line: Option<usize>,
    /// The `--set` assignment that is to blame, if one is.
    pub assignment: Option<String>,
    /// Dotted path of the field, e.g. `phase.fusion.rate`.
    pub field: String,
    /// What was found and what is allowed.
    pub message: String,
}

impl PlanError {
    /// An error at a field.
    #[must_use]
    pub fn at(field: impl Into<String>, message: impl Into<String>) -> Self {
        Self { file: None, line: None, assignment: None, field: field.into(), message: message.into() }
    }

    /// The same error, with the assignment that is to blame.
    #[must_use]
    pub fn caused_by(mut self, assignment: &str) -> Self {
        self.assignment = Some(assignment.to_owned());
        self
    }

    /// The same error, with the file it came from and the line where the field stands in `text`.
    #[must_use]
    pub fn located(mut self, file: &Path, text: &str) -> Self {
        // What was assigned stands on no line.
        if self.assignment.is_none() {
            self.line = self.line.or_else(|| line_of(text, &self.field));
        }
        self.file = Some(file.to_path_buf());
        self
    }
}

impl fmt::Display for PlanError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (&self.file, self.line) {
            (Some(file), Some(line)) => write!(f, "{}:{line}: ", file.display())?,
            (Some(file), None) => write!(f, "{}: ", file.display())?,
            _ => {}
        }
        if let Some(assignment) = &self.assignment {
            write!(f, "--set {assignment}: ")?;
        }
        if self.field.is_empty() {
            f.write_str(&self.message)
        } else {
            write!(f, "{}: {}", self.field, self.message)
        }
    }
}

impl std::error::Error for PlanError {}

/// Line (from 1) of the dotted `field` in the TOML `text`; of its nearest parent if the field itself is not written.
fn line_of(text: &str, field: &str) -> Option<usize> {
    let root = toml::de::DeTable::parse(text).ok()?;
    let mut table = root.get_ref();
    let mut found = None;
    for key in field.split('.') {
        let Some((name, value)) = table.iter().find(|(k, _)| k.get_ref() == key) else { break };
        found = Some(name.span().start);
        match value.get_ref() {
            toml::de::DeValue::Table(inner) => table = inner,
            _ => break,
        }
    }
    found.map(|at| text[..at].matches('\n').count() + 1)
}

/// Dotted path of the innermost field of the TOML `text` whose key or value holds the byte `at`.
fn field_at(text: &str, at: usize) -> String {
    let mut path = Vec::new();
    if let Ok(root) = toml::de::DeTable::parse(text) {
        descend(root.get_ref(), at, &mut path);
    }
    path.join(".")
}

/// Puts the keys that lead to the byte `at` on the path, and says whether there are any.
fn descend(table: &toml::de::DeTable<'_>, at: usize, path: &mut Vec<String>) -> bool {
    for (key, value) in table {
        path.push(key.get_ref().to_string());
        // A table of its own may be spread over the file, so that its span says nothing about its fields.
        let inside = matches!(value.get_ref(), toml::de::DeValue::Table(inner) if descend(inner, at, path));
        if inside || key.span().contains(&at) || value.span().contains(&at) {
            return true;
        }
        path.pop();
    }
    false
}

/// The error of the TOML parser (which knows where) as a [`PlanError`].
#[must_use]
pub fn from_toml(error: &toml::de::Error, text: &str) -> PlanError {
    let start = error.span().map(|span| span.start.min(text.len()));
    let field = start.map_or_else(String::new, |at| field_at(text, at));
    let line = start.map(|at| text[..at].matches('\n').count() + 1);
    PlanError { line, ..PlanError::at(field, error.message()) }
}

/// The error of a table that was never text, on one line, with the keys it knows.
#[must_use]
pub fn with_keys(error: &toml::de::Error) -> String {
    let text = error.to_string();
    text.lines().filter(|l| !l.is_empty()).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_of_a_field_is_found_through_tables() {
        let text = "a = 1\n[phase.x]\nrate = 'full'\n\n[phase.y]\ncredit = { gamma = 2.0 }\n";
        assert_eq!(line_of(text, "phase.y.credit.gamma"), Some(6));
        assert_eq!(line_of(text, "phase.x.rate"), Some(3));
        assert_eq!(line_of(text, "phase.x.missing"), Some(2));
        assert_eq!(line_of(text, "nothing"), None);
    }
}
