//! A table that can be bought by the group.

use metal_rl::set::IndexSet;

/// A column of numbers, some of which may be absent.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Name.
    pub name: String,
    /// Smallest value.
    pub low: f64,
    /// Largest value.
    pub high: f64,
    /// Whether any value is absent.
    pub nullable: bool,
    /// One entry per row.
    pub values: Vec<Option<f64>>,
}

impl Column {
    /// A column with the range of its values; one that never changes gets a range around its value.
    #[must_use]
    pub fn new(name: &str, values: Vec<Option<f64>>) -> Self {
        let known = || values.iter().flatten().copied();
        let (low, high) = (known().fold(f64::INFINITY, f64::min), known().fold(f64::NEG_INFINITY, f64::max));
        let nullable = values.iter().any(Option::is_none);
        let (low, high) = if low < high { (low, high) } else { (low - 0.5, low + 0.5) };
        Self { name: name.to_owned(), low, high, nullable, values }
    }

    /// The same column with a range of its own, which does not depend on the rows that were drawn.
    #[must_use]
    pub fn within(self, low: f64, high: f64) -> Self {
        Self { low, high, ..self }
    }
}

/// Columns that are bought together.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// Name.
    pub name: String,
    /// Columns, as indices.
    pub columns: Vec<usize>,
    /// Price of a look.
    pub price: f64,
}

/// A table with classes and prices.
#[derive(Clone, Debug, PartialEq)]
pub struct Data {
    /// Name, with a version where it is a benchmark.
    pub name: String,
    /// Columns of equal length.
    pub columns: Vec<Column>,
    /// What can be bought.
    pub groups: Vec<Group>,
    /// Names of the classes.
    pub classes: Vec<String>,
    /// Class of every row.
    pub labels: Vec<usize>,
}

/// Why a table is no task.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{field}: {message}")]
pub struct TableError {
    /// Where.
    pub field: String,
    /// What was found and what is allowed.
    pub message: String,
}

fn refuse(field: impl Into<String>, message: impl Into<String>) -> TableError {
    TableError { field: field.into(), message: message.into() }
}

impl Data {
    /// A table in which everything fits together.
    ///
    /// # Errors
    /// Names the first column, group or label that does not.
    pub fn new(
        name: &str,
        columns: Vec<Column>,
        groups: Vec<Group>,
        (classes, labels): (Vec<String>, Vec<usize>),
    ) -> Result<Self, TableError> {
        let data = Self { name: name.to_owned(), columns, groups, classes, labels };
        data.check()?;
        Ok(data)
    }

    fn check(&self) -> Result<(), TableError> {
        if self.labels.is_empty() || self.classes.len() < 2 {
            let message =
                format!("{} rows, {} classes: at least 1 and 2", self.labels.len(), self.classes.len());
            return Err(refuse("target", message));
        }
        if let Some(label) = self.labels.iter().find(|l| **l >= self.classes.len()) {
            return Err(refuse("target", format!("label {label} of {} classes", self.classes.len())));
        }
        if self.groups.is_empty() || self.groups.len() + self.classes.len() > IndexSet::CAPACITY {
            let most = IndexSet::CAPACITY - self.classes.len().min(IndexSet::CAPACITY);
            let message = format!("{}: 1 to {most} groups beside these classes", self.groups.len());
            return Err(refuse("groups", message));
        }
        self.columns.iter().try_for_each(|c| self.check_column(c))?;
        self.groups.iter().try_for_each(|g| self.check_group(g))
    }

    fn check_column(&self, column: &Column) -> Result<(), TableError> {
        let rows = self.labels.len();
        if column.values.len() != rows {
            let message = format!("{} values, but {rows} labels", column.values.len());
            return Err(refuse(format!("columns.{}", column.name), message));
        }
        if column.low.is_finite() && column.high.is_finite() {
            return Ok(());
        }
        Err(refuse(format!("columns.{}", column.name), "no value in it, or one that is not finite"))
    }

    fn check_group(&self, group: &Group) -> Result<(), TableError> {
        let field = format!("groups.{}", group.name);
        if !(group.price.is_finite() && group.price >= 0.0) {
            return Err(refuse(field, format!("price {}: finite and at least 0", group.price)));
        }
        if self.groups.iter().filter(|g| g.name == group.name).count() > 1 {
            return Err(refuse(field, "twice"));
        }
        if group.columns.is_empty() || group.columns.iter().any(|c| *c >= self.columns.len()) {
            return Err(refuse(field, "no column, or one that does not exist"));
        }
        Ok(())
    }
}
