//! CUBE and CUBE-NM, generated from their published descriptions (Shim et al. 2018; AFABench 2025).

use super::{Column, Data, Group};
use metal_rl::random::{Rng, Streams};
use serde::{Deserialize, Serialize};

/// Classes: the corners of a cube.
const CLASSES: usize = 8;
/// Columns of a block: the corner of class k stands at places k, k + 1, k + 2.
const BLOCK: usize = 10;
/// What a feature delivers; beyond, it is clipped.
const RANGE: (f64, f64) = (-1.0, 2.0);
/// Mean of what tells nothing.
const NOISE_MEAN: f64 = 0.5;

/// CUBE: 20 features, 8 classes, three of the features tell the class, and which three depends on it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CubeConfig {
    /// Rows of the table.
    pub rows: usize,
    /// Seed of the table.
    pub seed: u64,
    /// Price of one feature.
    pub look_price: f64,
    /// Spread of what tells the class.
    pub informative_sd: f64,
    /// Spread of everything else.
    pub noise_sd: f64,
}

impl Default for CubeConfig {
    fn default() -> Self {
        Self { rows: 600, seed: 1, look_price: 0.02, informative_sd: 0.1, noise_sd: 0.3 }
    }
}

/// CUBE-NM: five contexts, each with a block of ten features of which three tell the class; which block, only the
/// context says, and the context itself says nothing about the class.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CubeNmConfig {
    /// Rows of the table.
    pub rows: usize,
    /// Seed of the table.
    pub seed: u64,
    /// Price of the context as a whole, and of every other feature.
    pub look_price: f64,
    /// Number of contexts, 2 to 5.
    pub contexts: usize,
    /// Spread of what tells the class.
    pub informative_sd: f64,
    /// Spread of the context.
    pub context_sd: f64,
    /// Spread of everything else.
    pub noise_sd: f64,
}

impl Default for CubeNmConfig {
    fn default() -> Self {
        Self {
            rows: 600,
            seed: 1,
            look_price: 0.02,
            contexts: 5,
            informative_sd: 0.3,
            context_sd: 0.1,
            noise_sd: 0.3,
        }
    }
}

/// The table of CUBE.
#[must_use]
pub fn cube(config: &CubeConfig) -> Data {
    let mut rng = Streams::new(config.seed).stream("cube");
    let mut columns = vec![Vec::new(); 2 * BLOCK];
    let mut labels = Vec::with_capacity(config.rows);
    for _ in 0..config.rows {
        let label = rng.below(CLASSES);
        noise(&mut columns, config.noise_sd, &mut rng);
        corner(&mut columns, label, config.informative_sd, &mut rng);
        labels.push(label);
    }
    let columns: Vec<Column> =
        columns.into_iter().enumerate().map(|(i, v)| ranged(&format!("x{i}"), v)).collect();
    let groups = (0..2 * BLOCK).map(|c| single(&columns, c, config.look_price)).collect();
    whole("Cube-v0", columns, groups, labels)
}

/// The table of CUBE-NM.
#[must_use]
pub fn cube_nm(config: &CubeNmConfig) -> Data {
    let mut rng = Streams::new(config.seed).stream("cube_nm");
    let n = config.contexts;
    let mut columns = vec![Vec::new(); n + n * BLOCK];
    let mut labels = Vec::with_capacity(config.rows);
    for _ in 0..config.rows {
        let (label, context) = (rng.below(CLASSES), rng.below(n));
        for (i, column) in columns[..n].iter_mut().enumerate() {
            let mean = f64::from(u8::from(i == context));
            column.push(Some(mean + config.context_sd * rng.normal()));
        }
        noise(&mut columns[n..], config.noise_sd, &mut rng);
        corner(&mut columns[n + context * BLOCK..], label, config.informative_sd, &mut rng);
        labels.push(label);
    }
    let name = |i: usize| {
        if i < n { format!("context{i}") } else { format!("b{}x{}", (i - n) / BLOCK, (i - n) % BLOCK) }
    };
    let columns: Vec<Column> = columns.into_iter().enumerate().map(|(i, v)| ranged(&name(i), v)).collect();
    let mut groups =
        vec![Group { name: "context".to_owned(), columns: (0..n).collect(), price: config.look_price }];
    groups.extend((n..columns.len()).map(|c| single(&columns, c, config.look_price)));
    whole("CubeNM-v0", columns, groups, labels)
}

/// All tables of a kind have the same ranges, or a test table would be read in other units than the one learned from.
fn ranged(name: &str, values: Vec<Option<f64>>) -> Column {
    Column::new(name, values).within(RANGE.0, RANGE.1)
}

fn noise(columns: &mut [Vec<Option<f64>>], sd: f64, rng: &mut Rng) {
    for column in columns {
        column.push(Some(NOISE_MEAN + sd * rng.normal()));
    }
}

/// Writes the corner of class `label` over the noise of the last row: bit j of the label at place label + j.
fn corner(columns: &mut [Vec<Option<f64>>], label: usize, sd: f64, rng: &mut Rng) {
    for bit in 0..3 {
        let value = f64::from(u8::from(label >> bit & 1 == 1)) + sd * rng.normal();
        if let Some(last) = columns[label + bit].last_mut() {
            *last = Some(value);
        }
    }
}

fn single(columns: &[Column], column: usize, price: f64) -> Group {
    Group { name: columns[column].name.clone(), columns: vec![column], price }
}

fn whole(name: &str, columns: Vec<Column>, groups: Vec<Group>, labels: Vec<usize>) -> Data {
    let classes = (0..CLASSES).map(|k| k.to_string()).collect();
    Data { name: name.to_owned(), columns, groups, classes, labels }
}
