//! A table of the user's own as a task: columns, a target, groups with prices.

use super::Task;
use crate::plan::PlanError;
use crate::train::RunError;
use metal_rl::environment::Environment;
use metal_rl::random::Streams;
use metal_worlds::tabular::{Column, Data, Group, TableError, Tabular, Verdict};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;

/// One cell, as typed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Cell {
    /// Nobody knows.
    Absent,
    /// A number.
    Number(f64),
    /// A word: one of a column's categories.
    Word(String),
}

/// A table as typed: columns in their order, and what is to be named.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawTable {
    /// What the table is called.
    pub name: String,
    /// Name and cells of every column but the target.
    pub columns: Vec<(String, Vec<Cell>)>,
    /// The class of every row.
    pub target: Vec<Cell>,
}

/// Prices of a table's columns, and of what is said in the end (`prices.toml`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Prices {
    /// Price of every column that is in no group.
    pub default: f64,
    /// Columns that are bought together.
    pub group: BTreeMap<String, GroupPrice>,
    /// What right and wrong classes earn.
    pub verdict: Verdict,
    /// Share of the rows that nobody learns from.
    pub test_share: f64,
    /// Seed of the split.
    pub split_seed: u64,
}

/// A group of columns and its price.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GroupPrice {
    /// Names of the columns.
    pub columns: Vec<String>,
    /// Price of a look at all of them.
    pub price: f64,
}

impl Default for Prices {
    fn default() -> Self {
        Self {
            default: 0.02,
            group: BTreeMap::new(),
            verdict: Verdict::default(),
            test_share: 0.25,
            split_seed: 1,
        }
    }
}

/// What stands for a value nobody knows.
const ABSENT: [&str; 6] = ["", "na", "nan", "null", "none", "?"];
/// Most different words of a column.
const MOST_WORDS: usize = 16;

/// A table as a task: some rows to learn from, the others to be tested on.
#[derive(Clone, Debug)]
pub struct TableTask {
    data: Arc<Data>,
    training: Arc<[usize]>,
    testing: Arc<[usize]>,
    verdict: Verdict,
}

impl TableTask {
    /// The task of a table at these prices.
    ///
    /// # Errors
    /// Names the column, group or price that is impossible.
    pub fn new(raw: &RawTable, prices: &Prices) -> Result<Self, RunError> {
        crate::plan::limits::part("test_share", prices.test_share)?;
        for (field, value) in
            [("verdict.right", prices.verdict.right), ("verdict.wrong", prices.verdict.wrong)]
        {
            if !value.is_finite() {
                return Err(PlanError::at(field, format!("{value}: finite")).into());
            }
        }
        let (columns, groups) = columns_and_groups(raw, prices)?;
        let data = Data::new(&raw.name, columns, groups, labels(&raw.target)?).map_err(refuse)?;
        let mut rows: Vec<usize> = (0..data.labels.len()).collect();
        Streams::new(prices.split_seed).stream("split").shuffle(&mut rows);
        let tested = (rows.len() as f64 * prices.test_share).round() as usize;
        if tested == 0 || tested >= rows.len() {
            let message = format!("{} of {} rows: some to learn from, some to test", tested, rows.len());
            return Err(PlanError::at("test_share", message).into());
        }
        let (testing, training) = rows.split_at(tested);
        let (testing, training) = (testing.into(), training.into());
        Ok(Self { data: Arc::new(data), training, testing, verdict: prices.verdict })
    }

    /// The task of a CSV file with a header.
    ///
    /// # Errors
    /// If the file cannot be read, or its table is impossible.
    pub fn from_csv(path: &Path, target: &str, prices: &Prices) -> Result<Self, RunError> {
        Self::new(&read_csv(path, target)?, prices)
    }

    /// Rows to learn from, and rows to test on.
    #[must_use]
    pub fn rows(&self) -> (usize, usize) {
        (self.training.len(), self.testing.len())
    }
}

impl Task for TableTask {
    fn training(&self) -> Result<Box<dyn Environment>, RunError> {
        Ok(Box::new(Tabular::new(self.data.clone(), self.training.clone(), self.verdict)))
    }

    fn testing(&self) -> Result<Box<dyn Environment>, RunError> {
        Ok(Box::new(Tabular::new(self.data.clone(), self.testing.clone(), self.verdict)))
    }
}

fn refuse(error: TableError) -> RunError {
    PlanError::at(error.field, error.message).into()
}

fn read_csv(path: &Path, target: &str) -> Result<RawTable, RunError> {
    let place = path.display().to_string();
    let file = std::fs::File::open(path).map_err(|e| PlanError::at(&place, e.to_string()))?;
    let mut table = RawTable::from_csv(&place, file, target)?;
    table.name = path.file_stem().map_or_else(|| "table".to_owned(), |s| s.to_string_lossy().into_owned());
    Ok(table)
}

impl RawTable {
    /// The table of a CSV text with a header, its classes in the column `target`.
    ///
    /// # Errors
    /// If it cannot be read, or has no such column.
    pub fn from_csv(name: &str, text: impl std::io::Read, target: &str) -> Result<Self, RunError> {
        let at = |e: csv::Error| PlanError::at(name, e.to_string());
        let mut reader = csv::Reader::from_reader(text);
        let header: Vec<String> = reader.headers().map_err(at)?.iter().map(str::to_owned).collect();
        let Some(place) = header.iter().position(|h| h == target) else {
            let message = format!("no column `{target}`; known: {}", header.join(", "));
            return Err(PlanError::at("target", message).into());
        };
        let mut columns: Vec<(String, Vec<Cell>)> = header.into_iter().map(|h| (h, Vec::new())).collect();
        for record in reader.records() {
            let record = record.map_err(at)?;
            for (column, text) in columns.iter_mut().zip(record.iter()) {
                column.1.push(cell(text));
            }
        }
        let (_, target) = columns.remove(place);
        Ok(Self { name: name.to_owned(), columns, target })
    }
}

fn cell(text: &str) -> Cell {
    let text = text.trim();
    if ABSENT.contains(&text.to_lowercase().as_str()) {
        return Cell::Absent;
    }
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() => Cell::Number(number),
        _ => Cell::Word(text.to_owned()),
    }
}

/// Classes in order (numbers by size, words by the alphabet), and the class of every row.
fn labels(target: &[Cell]) -> Result<(Vec<String>, Vec<usize>), RunError> {
    let mut names = Vec::new();
    for (row, cell) in target.iter().enumerate() {
        names.push(match cell {
            Cell::Absent => {
                let message = format!("row {}: absent, but every row has a class", row + 1);
                return Err(PlanError::at("target", message).into());
            }
            Cell::Number(x) => x.to_string(),
            Cell::Word(w) => w.clone(),
        });
    }
    let mut classes: Vec<String> = names.iter().cloned().collect::<BTreeSet<_>>().into_iter().collect();
    if classes.iter().all(|c| c.parse::<f64>().is_ok()) {
        classes.sort_by(|a, b| a.parse().unwrap_or(0.0_f64).total_cmp(&b.parse().unwrap_or(0.0)));
    }
    let place = |name: &String| classes.iter().position(|c| c == name).unwrap_or(0);
    let labels = names.iter().map(place).collect();
    Ok((classes, labels))
}

/// Columns as numbers (a column of words becomes one column per word), and what is bought together.
fn columns_and_groups(raw: &RawTable, prices: &Prices) -> Result<(Vec<Column>, Vec<Group>), RunError> {
    let mut columns = Vec::new();
    let mut places: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for (name, cells) in &raw.columns {
        let made = numbers(name, cells)?;
        places.insert(name, (columns.len()..columns.len() + made.len()).collect());
        columns.extend(made);
    }
    let mut groups = Vec::new();
    let mut taken = BTreeSet::new();
    for (name, group) in &prices.group {
        let mut members = Vec::new();
        for column in &group.columns {
            let Some(found) = places.get(column.as_str()).filter(|_| taken.insert(column.clone())) else {
                let message = format!("column `{column}` does not exist, or is in another group");
                return Err(PlanError::at(format!("group.{name}.columns"), message).into());
            };
            members.extend(found);
        }
        groups.push(Group { name: name.clone(), columns: members, price: group.price });
    }
    for (name, _) in raw.columns.iter().filter(|(name, _)| !taken.contains(name)) {
        let columns = places[name.as_str()].clone();
        groups.push(Group { name: name.clone(), columns, price: prices.default });
    }
    Ok((columns, groups))
}

fn numbers(name: &str, cells: &[Cell]) -> Result<Vec<Column>, RunError> {
    let words: BTreeSet<&String> =
        cells.iter().filter_map(|c| if let Cell::Word(w) = c { Some(w) } else { None }).collect();
    let number = |c: &Cell| if let Cell::Number(x) = c { Some(*x) } else { None };
    if words.is_empty() {
        return Ok(vec![Column::new(name, cells.iter().map(number).collect())]);
    }
    if words.len() > MOST_WORDS || cells.iter().any(|c| number(c).is_some()) {
        let message =
            format!("{} different words: at most {MOST_WORDS}, and no numbers among them", words.len());
        return Err(PlanError::at(format!("columns.{name}"), message).into());
    }
    let is = |word: &String| {
        let bit = |c: &Cell| match c {
            Cell::Word(w) => Some(f64::from(u8::from(w == word))),
            _ => None,
        };
        Column::new(&format!("{name}={word}"), cells.iter().map(bit).collect())
    };
    Ok(words.into_iter().map(is).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn raw() -> RawTable {
        let number = |x: f64| Cell::Number(x);
        RawTable {
            name: "small".into(),
            columns: vec![
                ("age".into(), vec![number(1.0), Cell::Absent, number(3.0), number(4.0)]),
                ("colour".into(), ["red", "blue", "red", "red"].map(|w| Cell::Word(w.into())).to_vec()),
                ("blood".into(), vec![number(9.0), number(8.0), number(7.0), number(6.0)]),
            ],
            target: [10.0, 9.0, 10.0, 9.0].map(number).to_vec(),
        }
    }

    #[test]
    fn groups_prices_words_and_nulls_become_sensors() {
        let group = GroupPrice { columns: vec!["blood".into(), "age".into()], price: 0.5 };
        let prices = Prices { group: [("lab".to_owned(), group)].into(), ..Prices::default() };
        let task = TableTask::new(&raw(), &prices).unwrap();
        assert_eq!(task.rows(), (3, 1));
        let world = task.training().unwrap();
        let spec = world.spec();
        assert_eq!(spec.actions, ["9", "10"], "numbers are ordered as numbers");
        let names: Vec<&str> = spec.sensors.iter().map(|s| s.name.as_str()).collect();
        assert_eq!(names, ["lab", "colour"]);
        let features: Vec<&str> = spec.sensors[0].features.iter().map(|f| f.name.as_str()).collect();
        assert_eq!(features, ["blood", "age", "age known"]);
        assert_eq!(spec.sensors[1].features.len(), 2, "one per word");
        assert!((spec.sensors[0].price - 0.5).abs() < 1e-12 && (spec.sensors[1].price - 0.02).abs() < 1e-12);
    }

    #[test]
    fn mistakes_are_named() {
        let refused = |raw: &RawTable, prices: &Prices| TableTask::new(raw, prices).unwrap_err().to_string();
        let stray = GroupPrice { columns: vec!["bone".into()], price: 0.5 };
        let prices = Prices { group: [("lab".to_owned(), stray)].into(), ..Prices::default() };
        assert!(refused(&raw(), &prices).contains("bone"));
        let mut hole = raw();
        hole.target[2] = Cell::Absent;
        assert!(refused(&hole, &Prices::default()).contains("row 3"));
        assert!(refused(&raw(), &Prices { test_share: 0.01, ..Prices::default() }).contains("test_share"));
        assert!(refused(&raw(), &Prices { default: -1.0, ..Prices::default() }).contains("-1"));
    }

    #[test]
    fn cells_are_read_as_people_write_them() {
        assert_eq!(cell(" NA "), Cell::Absent);
        assert_eq!(cell("?"), Cell::Absent);
        assert_eq!(cell("-1.5e3"), Cell::Number(-1500.0));
        assert_eq!(cell("male"), Cell::Word("male".into()));
        assert_eq!(cell("inf"), Cell::Word("inf".into()));
    }
}
