//! Tile coding: several coarse grids, each displaced a little, whose cells share a value (Albus 1975; Sutton 1996).
//! The plain baseline. Grids that do not fit into memory are hashed, so that any dimension works.

use super::frozen;
use super::settings::{POSITIVE, Settings};
use crate::learner::{Dims, Learner, LearnerError, Rate, Sample};
use crate::num;
use serde::{Deserialize, Serialize};

/// Name in configurations and frozen bytes.
pub(super) const NAME: &str = "tile";

/// Largest number of tilings (a query keeps one cell per tiling on the stack).
const MAX_TILINGS: usize = 64;

/// Settings of [`Tile`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TileConfig {
    /// Number of grids, 1 to 64.
    pub tilings: usize,
    /// Cells per dimension of one grid.
    pub cells: usize,
    /// Cells stored per action; more than fit are hashed onto them.
    pub memory: usize,
    /// Value of a state nobody has seen.
    pub first_value: f64,
    /// Temperature of the degrees of support, in units of value: softmax(Q/temperature).
    pub temperature: f64,
}

impl Default for TileConfig {
    fn default() -> Self {
        Self { tilings: 8, cells: 8, memory: 16384, first_value: 0.0, temperature: 1.0 }
    }
}

impl TileConfig {
    /// Refuses settings outside their range.
    ///
    /// # Errors
    /// Names the first field that is out of range.
    pub fn validate(&self) -> Result<(), LearnerError> {
        let s = Settings(NAME);
        s.within("tilings", self.tilings as f64, 1.0..=MAX_TILINGS as f64, "must be 1 to 64")?;
        s.within("cells", self.cells as f64, 1.0..=1e6, "must be 1 to a million")?;
        s.within("memory", self.memory as f64, 1.0..=1e9, "must be 1 to a billion")?;
        s.within("first_value", self.first_value, -1e12..=1e12, "must be finite")?;
        s.check("temperature", self.temperature, POSITIVE)
    }

    /// Whether every cell of every grid has its own place.
    fn is_dense(&self, inputs: usize) -> bool {
        let one = (0..inputs).try_fold(1_usize, |n, _| n.checked_mul(self.cells + 1));
        one.and_then(|n| n.checked_mul(self.tilings)).is_some_and(|n| n <= self.memory)
    }
}

/// Tile coding; see the [module](self).
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Tile {
    config: TileConfig,
    dims: Dims,
    dense: bool,
    /// Actions × memory: a tiling's share of the value.
    values: Vec<f64>,
    /// Actions × memory: samples learned, saturating.
    counts: Vec<u32>,
    used: usize,
}

impl Tile {
    /// A learner that knows nothing.
    ///
    /// # Errors
    /// If a setting is outside its range.
    pub fn new(config: &TileConfig, dims: Dims) -> Result<Self, LearnerError> {
        config.validate()?;
        let cells = dims.choices * config.memory;
        Ok(Self {
            config: config.clone(),
            dims,
            dense: config.is_dense(dims.inputs),
            values: vec![config.first_value / config.tilings as f64; cells],
            counts: vec![0; cells],
            used: 0,
        })
    }

    /// The learner frozen in `bytes`.
    ///
    /// # Errors
    /// If the bytes are damaged or were frozen under other settings.
    pub fn thaw(config: &TileConfig, bytes: &[u8]) -> Result<Self, LearnerError> {
        let tile: Self = frozen::open(NAME, bytes)?;
        let cells = tile.dims.choices.checked_mul(config.memory);
        let sound = tile.dense == config.is_dense(tile.dims.inputs)
            && cells == Some(tile.values.len())
            && cells == Some(tile.counts.len());
        if sound && tile.config == *config { Ok(tile) } else { Err(frozen::foreign(NAME)) }
    }

    /// The cell of each tiling that a state falls into.
    fn cells(&self, state: &[f64]) -> [usize; MAX_TILINGS] {
        assert_eq!(state.len(), self.dims.inputs, "length of the state");
        let mut cells = [0; MAX_TILINGS];
        for (tiling, cell) in cells[..self.config.tilings].iter_mut().enumerate() {
            *cell = self.cell(tiling, state);
        }
        cells
    }

    /// The cell of one tiling. Displacements are 1, 3, 5 … units per dimension, which spreads them evenly.
    fn cell(&self, tiling: usize, state: &[f64]) -> usize {
        let (n, side) = (self.config.tilings, self.config.cells as f64);
        let mut code = tiling as u64;
        for (i, x) in state.iter().enumerate() {
            let shift = (tiling * (2 * i + 1) % n) as f64 / n as f64;
            let coordinate = (x.clamp(0.0, 1.0) * side + shift).floor().min(side) as u64;
            code = if self.dense {
                code * (self.config.cells as u64 + 1) + coordinate
            } else {
                scramble(code ^ coordinate.wrapping_mul(0x9e37_79b9_7f4a_7c15)).wrapping_add(i as u64)
            };
        }
        if self.dense { code as usize } else { (scramble(code) % self.config.memory as u64) as usize }
    }

    /// Q(s, a) from the cells of s.
    fn value(&self, cells: &[usize; MAX_TILINGS], choice: usize) -> f64 {
        let table = &self.values[choice * self.config.memory..];
        cells[..self.config.tilings].iter().map(|&c| table[c]).sum()
    }
}

/// The finalizer of SplitMix64: every input bit reaches every output bit.
fn scramble(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

impl Learner for Tile {
    fn dims(&self) -> Dims {
        self.dims
    }

    fn values(&self, state: &[f64], out: &mut [f64]) {
        let cells = self.cells(state);
        for (a, out) in out.iter_mut().enumerate() {
            *out = self.value(&cells, a);
        }
    }

    fn support(&self, state: &[f64], out: &mut [f64]) {
        self.values(state, out);
        num::soft_max(out, self.config.temperature);
    }

    fn values_and_support(&self, state: &[f64], values: &mut [f64], support: &mut [f64]) {
        self.values(state, values);
        support.copy_from_slice(values);
        num::soft_max(support, self.config.temperature);
    }

    fn learn(&mut self, sample: Sample<'_>, rate: Rate) -> f64 {
        let cells = self.cells(sample.state);
        let error = sample.target - self.value(&cells, sample.choice);
        let tilings = self.config.tilings;
        let first = sample.choice * self.config.memory;
        for &cell in &cells[..tilings] {
            let count = &mut self.counts[first + cell];
            self.used += usize::from(*count == 0);
            *count = count.saturating_add(1);
            let alpha = match rate {
                Rate::Full => 1.0,
                Rate::Constant(alpha) => alpha,
                Rate::Average(floor) => (1.0 / f64::from(*count)).max(floor),
            };
            self.values[first + cell] += alpha * error / tilings as f64;
        }
        error
    }

    fn size(&self) -> (usize, &'static str) {
        (self.used, "cells")
    }

    fn freeze(&self) -> Vec<u8> {
        frozen::seal(NAME, self)
    }

    fn boxed_clone(&self) -> Box<dyn Learner> {
        Box::new(self.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dense_cells_are_distinct_and_neighbours_share_some() {
        let tile = Tile::new(&TileConfig::default(), Dims { inputs: 2, choices: 1 }).unwrap();
        assert!(tile.dense);
        let shared = |s: [f64; 2], t: [f64; 2]| {
            let (a, b) = (tile.cells(&s), tile.cells(&t));
            (0..8).filter(|&i| a[i] == b[i]).count()
        };
        assert_eq!(shared([0.5, 0.5], [0.5, 0.5]), 8);
        assert!((1..8).contains(&shared([0.5, 0.5], [0.55, 0.52])));
        assert_eq!(shared([0.1, 0.1], [0.9, 0.9]), 0);
    }

    #[test]
    fn many_dimensions_are_hashed() {
        let mut tile = Tile::new(&TileConfig::default(), Dims { inputs: 24, choices: 2 }).unwrap();
        assert!(!tile.dense);
        let state = [0.3; 24];
        tile.learn(Sample { state: &state, choice: 1, target: -7.0, demonstrated: false }, Rate::Full);
        let mut values = [0.0; 2];
        tile.values(&state, &mut values);
        assert!(values[0].abs() < 1e-12 && (values[1] + 7.0).abs() < 1e-9, "{values:?}");
    }
}
