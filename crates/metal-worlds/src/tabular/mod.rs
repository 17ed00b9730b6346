//! Classification with features that cost: an episode is one row of a table, a look buys a group of features, the motor
//! action names the class.

mod classes;
mod cube;
mod data;
mod imagination;
mod mixture;
mod scales;

pub use cube::{CubeConfig, CubeNmConfig, cube, cube_nm};
pub use data::{Column, Data, Group, TableError};
pub use imagination::Imagination;

use metal_rl::belief::Belief;
use metal_rl::environment::{
    End, Environment, EnvironmentError, EnvironmentSpec, Feature, Outcome, SensorSpec,
};
use metal_rl::random::Streams;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// What a named class is worth.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Verdict {
    /// Reward of the right class.
    pub right: f64,
    /// Reward of a wrong one.
    pub wrong: f64,
}

impl Default for Verdict {
    fn default() -> Self {
        Self { right: 0.0, wrong: -1.0 }
    }
}

/// How many rows a model is made of.
const MODELLED_ROWS: std::ops::Range<usize> = 40..4000;
/// How many rows are imagined at a time.
const IMAGINED_ROWS: usize = 20_000;

/// A table as a world of one motor step per episode; some of its rows are drawn, the others kept for tests.
///
/// An absent value is a null, never a number of its own: a column in which anything is absent delivers two numbers,
/// the value (the middle of its range where it is absent) and a bit that says whether it is known.
#[derive(Clone, Debug)]
pub struct Tabular {
    data: Arc<Data>,
    drawn: Arc<[usize]>,
    verdict: Verdict,
    spec: EnvironmentSpec,
    row: usize,
    measures: [f64; 1],
    model: Option<Arc<Imagination>>,
}

impl Tabular {
    /// The world of the rows `drawn` (at least one) of `data`.
    #[must_use]
    pub fn new(data: Arc<Data>, drawn: Arc<[usize]>, verdict: Verdict) -> Self {
        let spec = spec(&data);
        let row = drawn.first().copied().unwrap_or(0);
        let mut world = Self { data, drawn, verdict, spec, row, measures: [0.0], model: None };
        world.begin(0);
        world
    }

    fn begin(&mut self, seed: u64) {
        let place = Streams::new(seed).stream("row").below(self.drawn.len());
        self.row = self.drawn[place];
        self.measures = [0.0];
    }
}

fn spec(data: &Data) -> EnvironmentSpec {
    let sensor = |group: &Group| SensorSpec {
        name: group.name.clone(),
        features: group.columns.iter().flat_map(|&c| features(&data.columns[c])).collect(),
        price: group.price,
    };
    EnvironmentSpec {
        id: data.name.clone(),
        sensors: data.groups.iter().map(sensor).collect(),
        actions: data.classes.clone(),
        horizon: 1,
        measures: vec!["right".to_owned()],
    }
}

fn features(column: &Column) -> Vec<Feature> {
    let mut features = vec![Feature { name: column.name.clone(), low: column.low, high: column.high }];
    if column.nullable {
        features.push(Feature { name: format!("{} known", column.name), low: 0.0, high: 1.0 });
    }
    features
}

impl Environment for Tabular {
    fn spec(&self) -> &EnvironmentSpec {
        &self.spec
    }

    fn reset(&mut self, seed: u64) -> Result<(), EnvironmentError> {
        self.begin(seed);
        Ok(())
    }

    fn sense(&mut self, sensor: usize, out: &mut [f64]) -> Result<(), EnvironmentError> {
        let mut at = 0;
        for &c in &self.data.groups[sensor].columns {
            let column = &self.data.columns[c];
            let value = column.values[self.row];
            out[at] = value.unwrap_or((column.low + column.high) / 2.0).clamp(column.low, column.high);
            at += 1;
            if column.nullable {
                out[at] = f64::from(u8::from(value.is_some()));
                at += 1;
            }
        }
        Ok(())
    }

    fn step(&mut self, action: usize) -> Result<Outcome, EnvironmentError> {
        let right = action == self.data.labels[self.row];
        self.measures = [f64::from(u8::from(right))];
        let motor_reward = if right { self.verdict.right } else { self.verdict.wrong };
        Ok(Outcome { motor_reward, end: End::Terminal })
    }

    fn measures(&self) -> &[f64] {
        &self.measures
    }

    fn advise(&mut self) -> Option<usize> {
        Some(self.data.labels[self.row])
    }

    fn fork(&self) -> Option<Box<dyn Environment>> {
        Some(Box::new(self.clone()))
    }

    /// Rows like those that are drawn; none where there are too few to make a model of, or so many that none is needed.
    fn imagine(&self, streams: &Streams) -> Option<Box<dyn Environment>> {
        if !MODELLED_ROWS.contains(&self.drawn.len()) {
            return None;
        }
        let model = Imagination::of(&self.data, &self.drawn, &streams.child("model"));
        let data = self.data.drawn_from(&model, IMAGINED_ROWS, streams);
        let world = Self::new(Arc::new(data), (0..IMAGINED_ROWS).collect(), self.verdict);
        Some(Box::new(Self { model: Some(Arc::new(model)), ..world }))
    }

    fn belief(&self) -> Option<Belief> {
        self.model.as_ref().map(|model| model.belief(&self.data, self.verdict))
    }
}

#[cfg(test)]
mod tests;
