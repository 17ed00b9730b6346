//! What the learner's sensors are: the paper's six regions and ring, or the raw cells they could have been made of.
//!
//! Sec. 4.2 cuts the picture by hand and names clustering and optimisation as other ways (references \[30\] and \[22\]).
//! Whoever wants to try those needs something finer to cut: a grid of camera cells and each infra-red sensor by itself.

use super::camera::{COLUMNS, LARGEST_PATCH, ROWS, Region, Window};
use super::infrared;
use super::task::Task;
use super::truth::Told;
use metal_rl::set::IndexSet;
use serde::{Deserialize, Serialize};

/// How the learner's sensors are cut.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Senses {
    /// The six regions of Fig. 6c and the ring as one sensor: `Highway-v0`.
    #[default]
    Regions,
    /// Raw cells of the picture, and each infra-red sensor by itself.
    Cells(Grid),
    /// One sensor, `TRUTH`, that hides nothing ([`super::truth`]): no robot's senses, but a yardstick.
    Truth {
        /// Price of a look at it.
        price: f64,
        /// What it tells.
        #[serde(default)]
        tells: Told,
    },
}

impl Senses {
    /// Name and version of the world that is seen like this.
    #[must_use]
    pub fn world(&self) -> &'static str {
        match self {
            Self::Regions => "Highway-v0",
            Self::Cells(_) => "HighwayCells-v0",
            Self::Truth { tells: Told::Everything, .. } => "HighwayTruth-v0",
            Self::Truth { tells: Told::Pose, .. } => "HighwayPose-v0",
            Self::Truth { tells: Told::PoseAndBends, .. } => "HighwayPoseAndBends-v0",
            Self::Truth { tells: Told::PoseAndCars, .. } => "HighwayPoseAndCars-v0",
        }
    }

    /// Whether this is the senses of `Highway-v0`.
    #[must_use]
    pub fn is_usual(&self) -> bool {
        *self == Self::Regions
    }
}

/// A grid over the whole picture, which shows nothing above the horizon.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Grid {
    /// Cells from left to right.
    pub columns: usize,
    /// Cells from the horizon down.
    pub rows: usize,
}

impl Default for Grid {
    fn default() -> Self {
        Self { columns: 6, rows: 4 }
    }
}

/// Camera cells beyond which there would be more sensors than a set of them can hold.
pub const MOST_CELLS: usize = IndexSet::CAPACITY - infrared::SENSORS;

impl Grid {
    /// Whether the picture can be cut like this: every cell has a pixel and is no larger than the camera's largest
    /// region, and all sensors fit into one set.
    #[must_use]
    pub fn is_possible(self) -> bool {
        let (1..=COLUMNS, 1..=ROWS) = (self.columns, self.rows) else { return false };
        let largest = COLUMNS.div_ceil(self.columns) * ROWS.div_ceil(self.rows);
        self.columns * self.rows <= MOST_CELLS && largest <= LARGEST_PATCH
    }

    /// The cells, row by row from the upper left. Pixels that do not share out evenly make some one pixel larger.
    #[must_use]
    pub fn windows(self) -> Vec<Window> {
        let cut = |i: usize, parts: usize, pixels: usize| i * pixels / parts;
        let cell = |i: usize| {
            let (row, column) = (i / self.columns, i % self.columns);
            Window {
                top: cut(row, self.rows, ROWS),
                bottom: cut(row + 1, self.rows, ROWS),
                left: cut(column, self.columns, COLUMNS),
                right: cut(column + 1, self.columns, COLUMNS),
            }
        };
        (0..self.columns * self.rows).map(cell).collect()
    }
}

/// One sensor of the learner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Organ {
    /// A part of the picture.
    Area(Window),
    /// All infra-red sensors.
    Ring,
    /// One infra-red sensor.
    Proximity(usize),
    /// What there is to know.
    Truth(Told),
}

/// A sensor, its name, and what a look at it costs.
#[derive(Clone, Debug, PartialEq)]
pub struct Fitted {
    /// The sensor.
    pub organ: Organ,
    /// Its name: a region's, `IR`, `r1c1` for the first cell of the first row, `ps0` for the first infra-red sensor.
    pub name: String,
    /// Price of one look, in units of reward.
    pub price: f64,
}

/// The learner's sensors, in order.
#[must_use]
pub fn organs(senses: Senses, task: &Task) -> Vec<Fitted> {
    let [.., ring] = task.prices;
    match senses {
        Senses::Truth { price, tells } => {
            vec![Fitted { organ: Organ::Truth(tells), name: "TRUTH".to_owned(), price }]
        }
        Senses::Regions => {
            let named = |(region, price): (&Region, f64)| Fitted {
                organ: Organ::Area(region.window()),
                name: region.name().to_owned(),
                price,
            };
            let mut all: Vec<Fitted> = Region::ALL.iter().zip(task.prices).map(named).collect();
            all.push(Fitted { organ: Organ::Ring, name: "IR".to_owned(), price: ring });
            all
        }
        Senses::Cells(grid) => cells(grid, task),
    }
}

/// Raw cells. The price of vision is shared out by area, that of the ring equally, so that all cells together cost what
/// all regions cost (reading R131).
fn cells(grid: Grid, task: &Task) -> Vec<Fitted> {
    let [vision @ .., ring] = task.prices;
    let vision: f64 = vision.iter().sum();
    let picture = Window::WHOLE.pixels() as f64;
    let cell = |(i, window): (usize, Window)| Fitted {
        organ: Organ::Area(window),
        name: format!("r{}c{}", i / grid.columns + 1, i % grid.columns + 1),
        price: vision * window.pixels() as f64 / picture,
    };
    let one = |i: usize| Fitted {
        organ: Organ::Proximity(i),
        name: format!("ps{i}"),
        price: ring / infrared::SENSORS as f64,
    };
    grid.windows().into_iter().enumerate().map(cell).chain((0..infrared::SENSORS).map(one)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_cover_the_picture_once_and_cost_what_regions_cost() {
        let all = (0..60).flat_map(|columns| (0..45).map(move |rows| Grid { columns, rows }));
        let possible: Vec<Grid> = all.filter(|grid| grid.is_possible()).collect();
        assert!(possible.len() > 100 && possible.contains(&Grid::default()));
        for grid in possible {
            let mut seen = [0; ROWS * COLUMNS];
            for w in grid.windows() {
                assert!((1..=LARGEST_PATCH).contains(&w.pixels()), "{grid:?}");
                (w.top..w.bottom).for_each(|r| (w.left..w.right).for_each(|c| seen[r * COLUMNS + c] += 1));
            }
            assert!(seen.iter().all(|&n| n == 1), "{grid:?}");
            let price = |senses| organs(senses, &Task::default()).iter().map(|o| o.price).sum::<f64>();
            assert!((price(Senses::Cells(grid)) - price(Senses::Regions)).abs() < 1e-9, "{grid:?}");
        }
    }

    #[test]
    fn grids_that_cannot_be_are_refused() {
        for (columns, rows) in [(0, 4), (6, 0), (53, 1), (2, 2), (1, 1), (8, 8), (60, 60)] {
            assert!(!Grid { columns, rows }.is_possible(), "{columns} × {rows}");
        }
        for (columns, rows) in [(6, 4), (3, 2), (8, 7), (52, 1)] {
            assert!(Grid { columns, rows }.is_possible(), "{columns} × {rows}");
        }
    }

    #[test]
    fn names_tell_where_a_cell_is() {
        let names: Vec<String> =
            organs(Senses::Cells(Grid::default()), &Task::default()).into_iter().map(|o| o.name).collect();
        assert_eq!(names.len(), 32);
        assert_eq!([&names[0], &names[5], &names[6], &names[23]], ["r1c1", "r1c6", "r2c1", "r4c6"]);
        assert_eq!([&names[24], &names[31]], ["ps0", "ps7"]);
    }
}
