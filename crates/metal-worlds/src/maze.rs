//! The n × n maze of Eq. (14) and Fig. 12: two sensors, X and Y, each of which tells one coordinate.
//!
//! Half the truth merges all cells of a column or a row, so aliasing can be checked by hand. Episodes end at the goal
//! (reading R68).

use metal_rl::environment::{
    End, Environment, EnvironmentError, EnvironmentSpec, Feature, Outcome, SensorSpec,
};
use metal_rl::random::Streams;
use serde::{Deserialize, Serialize};

mod optimum;
pub use optimum::optimal_values;
use optimum::{best_action, reaches_goal};

/// Motor actions: north is towards larger y, east towards larger x.
const ACTIONS: [&str; 4] = ["north", "east", "south", "west"];

/// A cell of the maze.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cell {
    /// Column, 0 … side − 1.
    pub x: usize,
    /// Row, 0 … side − 1.
    pub y: usize,
}

/// A maze.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MazeConfig {
    /// Cells per side, n of Eq. (14), at least 2.
    pub side: usize,
    /// Cells nobody can enter.
    pub walls: Vec<Cell>,
    /// Where the episode ends.
    pub goal: Cell,
    /// Reward of every motor step, < 0.
    pub step_reward: f64,
    /// Added to it when the step runs into a wall or the border (and leads nowhere), ≤ 0.
    pub bump_reward: f64,
    /// Price of reading X or Y.
    pub look_price: f64,
}

impl Default for MazeConfig {
    /// The 4 × 4 maze of Fig. 12, without walls, with the goal in the north-east corner.
    fn default() -> Self {
        Self {
            side: 4,
            walls: Vec::new(),
            goal: Cell { x: 3, y: 3 },
            step_reward: -1.0,
            bump_reward: -1.0,
            look_price: 0.1,
        }
    }
}

/// Why a maze is impossible.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MazeError {
    /// Fewer than two cells per side.
    #[error("a maze of side {0}: at least 2 are needed")]
    TooSmall(usize),
    /// A wall or the goal is outside.
    #[error("cell ({}, {}) is outside the maze of side {side}", .cell.x, .cell.y)]
    Outside {
        /// The cell.
        cell: Cell,
        /// Cells per side.
        side: usize,
    },
    /// The goal is a wall, or every other cell is.
    #[error("the goal is a wall, or nothing but the goal is free")]
    NoWay,
    /// A free cell is cut off.
    #[error("from cell ({}, {}) there is no way to the goal", .0.x, .0.y)]
    CutOff(Cell),
    /// A reward or price has the wrong sign or is not a number.
    #[error("maze.{field} = {value}: {allowed}")]
    Number {
        /// Field.
        field: &'static str,
        /// Value found.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
}

impl MazeConfig {
    /// Checks that the maze can be solved from everywhere.
    ///
    /// # Errors
    /// If a cell is outside, the goal cannot be reached from a free cell, or a number has the wrong sign.
    pub fn check(&self) -> Result<(), MazeError> {
        self.check_numbers()?;
        if self.side < 2 {
            return Err(MazeError::TooSmall(self.side));
        }
        for &cell in self.walls.iter().chain([&self.goal]) {
            if cell.x >= self.side || cell.y >= self.side {
                return Err(MazeError::Outside { cell, side: self.side });
            }
        }
        if self.walls.contains(&self.goal) || self.starts().is_empty() {
            return Err(MazeError::NoWay);
        }
        let reached = reaches_goal(self);
        match self.starts().into_iter().find(|&c| !reached[self.index(c)]) {
            Some(cell) => Err(MazeError::CutOff(cell)),
            None => Ok(()),
        }
    }

    fn check_numbers(&self) -> Result<(), MazeError> {
        let number = |ok: bool, field, value, allowed| {
            if ok { Ok(()) } else { Err(MazeError::Number { field, value, allowed }) }
        };
        let negative = |v: f64| v.is_finite() && v < 0.0;
        let (step, bump, price) = (self.step_reward, self.bump_reward, self.look_price);
        number(negative(step), "step_reward", step, "finite and below 0")?;
        number(bump.is_finite() && bump <= 0.0, "bump_reward", bump, "finite and at most 0")?;
        number(price.is_finite() && price >= 0.0, "look_price", price, "finite and at least 0")
    }

    /// Number of `cell` in [`optimal_values`]: row by row.
    #[must_use]
    pub fn index(&self, cell: Cell) -> usize {
        cell.y * self.side + cell.x
    }

    /// Cells where an episode may begin: all but walls and goal.
    fn starts(&self) -> Vec<Cell> {
        let cells = (0..self.side * self.side).map(|i| Cell { x: i % self.side, y: i / self.side });
        cells.filter(|c| *c != self.goal && !self.walls.contains(c)).collect()
    }

    /// Where `action` leads from `cell`, or nowhere if something is in the way.
    fn next(&self, cell: Cell, action: usize) -> Option<Cell> {
        let Cell { x, y } = cell;
        let (x, y) = match action {
            0 => (Some(x), y.checked_add(1)),
            1 => (x.checked_add(1), Some(y)),
            2 => (Some(x), y.checked_sub(1)),
            _ => (x.checked_sub(1), Some(y)),
        };
        let next = Cell { x: x?, y: y? };
        (next.x < self.side && next.y < self.side && !self.walls.contains(&next)).then_some(next)
    }

    /// Reward of one motor step that bumps or not.
    fn reward(&self, bumps: bool) -> f64 {
        self.step_reward + if bumps { self.bump_reward } else { 0.0 }
    }
}

/// A maze as an environment. Everything but the start is certain.
#[derive(Clone, Debug)]
pub struct Maze {
    spec: EnvironmentSpec,
    config: MazeConfig,
    values: Vec<f64>,
    at: Cell,
    steps: usize,
    measures: [f64; 3],
}

impl Maze {
    /// The maze, standing at the beginning of the episode of seed 0.
    ///
    /// # Errors
    /// If the maze is impossible (see [`MazeConfig::check`]).
    pub fn new(config: MazeConfig) -> Result<Self, MazeError> {
        config.check()?;
        let (spec, values) = (spec(&config), optimal_values(&config, 1.0));
        let mut maze = Self { spec, at: config.goal, config, values, steps: 0, measures: [0.0; 3] };
        maze.begin(0);
        Ok(maze)
    }

    fn begin(&mut self, seed: u64) {
        let starts = self.config.starts();
        self.at = starts[Streams::new(seed).stream("maze").below(starts.len())];
        self.steps = 0;
        self.note(false);
    }

    fn note(&mut self, bumped: bool) {
        self.measures = [self.at.x as f64, self.at.y as f64, f64::from(u8::from(bumped))];
    }

    fn end(&self) -> End {
        if self.at == self.config.goal {
            End::Terminal
        } else if self.steps >= self.spec.horizon {
            End::TimeLimit
        } else {
            End::Running
        }
    }
}

fn spec(config: &MazeConfig) -> EnvironmentSpec {
    let last = (config.side - 1) as f64;
    let sensor = |name: &str| SensorSpec {
        name: name.to_owned(),
        features: vec![Feature { name: "coordinate".to_owned(), low: 0.0, high: last }],
        price: config.look_price,
    };
    EnvironmentSpec {
        id: "Maze-v0".to_owned(),
        sensors: vec![sensor("X"), sensor("Y")],
        actions: ACTIONS.map(str::to_owned).to_vec(),
        horizon: 4 * config.side * config.side,
        measures: ["x", "y", "bump"].map(str::to_owned).to_vec(),
    }
}

impl Environment for Maze {
    fn spec(&self) -> &EnvironmentSpec {
        &self.spec
    }

    fn reset(&mut self, seed: u64) -> Result<(), EnvironmentError> {
        self.begin(seed);
        Ok(())
    }

    fn sense(&mut self, sensor: usize, out: &mut [f64]) -> Result<(), EnvironmentError> {
        out[0] = [self.at.x, self.at.y][sensor] as f64;
        Ok(())
    }

    fn step(&mut self, action: usize) -> Result<Outcome, EnvironmentError> {
        let next = self.config.next(self.at, action);
        self.at = next.unwrap_or(self.at);
        self.steps += 1;
        self.note(next.is_none());
        Ok(Outcome { motor_reward: self.config.reward(next.is_none()), end: self.end() })
    }

    fn measures(&self) -> &[f64] {
        &self.measures
    }

    fn advise(&mut self) -> Option<usize> {
        Some(best_action(&self.config, &self.values, self.at))
    }

    fn fork(&self) -> Option<Box<dyn Environment>> {
        Some(Box::new(self.clone()))
    }
}

#[cfg(test)]
mod tests;
