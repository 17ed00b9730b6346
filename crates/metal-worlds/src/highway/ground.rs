//! What the plane looks like: a raster of materials, and the roads of an experiment.

use super::clearance::Clearance;
use super::raster::Raster;
use super::road::{BORDER_M, LANE_M, LINE_M, Road};
use super::shape::ShapeRange;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Cell of the raster, in metres.
pub const CELL_M: f64 = 0.002;

/// The four dominant colours of the scene (Sec. 4.2), in the order of a vision sensor's features.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Class {
    /// Road.
    Black,
    /// Middle and side lines.
    White,
    /// Obstacles.
    Red,
    /// Side-road area.
    Green,
}

/// What a ray of light may come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Material {
    /// The road's surface.
    Road,
    /// A painted line.
    Line,
    /// The body of a red car.
    RedBody,
    /// The area beside the road.
    Grass,
    /// The body of the learner, which has no colour: nobody takes it for an obstacle (Sec. 4.1).
    GreyBody,
}

impl Material {
    /// The dominant colour this material is taken for.
    #[must_use]
    pub fn class(self) -> Class {
        match self {
            Self::Road | Self::GreyBody => Class::Black,
            Self::Line => Class::White,
            Self::RedBody => Class::Red,
            Self::Grass => Class::Green,
        }
    }
}

/// A road and its picture from above.
#[derive(Clone, Debug)]
pub struct Ground {
    road: Road,
    raster: Raster,
    clearance: Clearance,
}

impl Ground {
    /// Paints `road`.
    #[must_use]
    pub fn new(road: Road) -> Self {
        let [low, high] = road.bounds_m();
        let columns = ((high[0] - low[0]) / CELL_M).round() as usize;
        let rows = ((high[1] - low[1]) / CELL_M).round() as usize;
        let mut raster = Raster::grass(columns, rows);
        paint(&road, &mut raster);
        let clearance = Clearance::of(&raster);
        Self { road, raster, clearance }
    }

    /// The road.
    #[must_use]
    pub fn road(&self) -> &Road {
        &self.road
    }

    /// Columns and rows of the raster.
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        (self.raster.columns, self.raster.rows)
    }

    /// The material at raster coordinates (cells from the lower left corner); grass everywhere outside.
    #[inline]
    #[must_use]
    pub fn at_cell(&self, column: f64, row: f64) -> Material {
        // Both casts send negative numbers to 0, so the sign is asked first.
        if column < 0.0 || row < 0.0 {
            return Material::Grass;
        }
        let (column, row) = (column as usize, row as usize);
        if column < self.raster.columns && row < self.raster.rows {
            self.raster.at(self.raster.place(column as u32, row as u32))
        } else {
            Material::Grass
        }
    }

    /// The material at the point (`x_m`, `y_m`).
    #[must_use]
    pub fn at(&self, x_m: f64, y_m: f64) -> Material {
        let [column, row] = self.cell_of(x_m, y_m);
        self.at_cell(column, row)
    }

    /// The picture from above.
    pub(super) fn raster(&self) -> &Raster {
        &self.raster
    }

    /// How far around a place it looks the same.
    pub(super) fn clearance(&self) -> &Clearance {
        &self.clearance
    }

    /// Raster coordinates of a point, in cells.
    #[inline]
    pub(super) fn cell_of(&self, x_m: f64, y_m: f64) -> [f64; 2] {
        let low = self.road.bounds_m()[0];
        [(x_m - low[0]) / CELL_M, (y_m - low[1]) / CELL_M]
    }
}

/// Paints block by block; blocks the road cannot reach stay grass, which is most of the plane.
fn paint(road: &Road, raster: &mut Raster) {
    const BLOCK: usize = 16;
    let reach = BORDER_M + BLOCK as f64 * CELL_M;
    let (low, columns, rows) = (road.bounds_m()[0], raster.columns, raster.rows);
    for row in (0..rows).step_by(BLOCK) {
        for column in (0..columns).step_by(BLOCK) {
            let middle = [column + BLOCK / 2, row + BLOCK / 2].map(|k| k as f64 * CELL_M);
            if road.locate(low[0] + middle[0], low[1] + middle[1]).offset_m.abs() > reach {
                continue;
            }
            for r in row..(row + BLOCK).min(rows) {
                for c in column..(column + BLOCK).min(columns) {
                    let point = [c, r].map(|k| (k as f64 + 0.5) * CELL_M);
                    let offset = road.locate(low[0] + point[0], low[1] + point[1]).offset_m;
                    raster.set(c, r, material_at(offset));
                }
            }
        }
    }
}

/// The material at a distance from the centre line.
fn material_at(offset_m: f64) -> Material {
    let beside = offset_m.abs();
    if beside > BORDER_M {
        Material::Grass
    } else if beside < 0.5 * LINE_M || (beside - LANE_M).abs() < 0.5 * LINE_M {
        Material::Line
    } else {
        Material::Road
    }
}

/// Which roads an experiment drives on; an episode draws one of them.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RoadSet {
    /// The one road of learning (Fig. 6b).
    #[default]
    Training,
    /// Four roads of the same family, for choosing settings.
    Validation,
    /// Four longer roads with more and sharper bends, for the final test (Sec. 5: "a road with different shape").
    Test,
    /// The training family's roads of these seeds.
    Seeds(Vec<u64>),
}

impl RoadSet {
    /// Builds the roads with their pictures, to be shared by every copy of a world.
    ///
    /// # Panics
    /// If a list of seeds is empty.
    #[must_use]
    pub fn build(&self) -> Arc<[Ground]> {
        let roads = |seeds: &[u64], range: &ShapeRange| -> Arc<[Ground]> {
            assert!(!seeds.is_empty(), "an experiment needs at least one road seed");
            seeds.iter().map(|&seed| Ground::new(Road::new(seed, range))).collect()
        };
        match self {
            Self::Training => roads(&[1], &ShapeRange::TRAINING),
            Self::Validation => roads(&[101, 102, 103, 104], &ShapeRange::TRAINING),
            Self::Test => roads(&[201, 202, 203, 204], &ShapeRange::TEST),
            Self::Seeds(seeds) => roads(seeds, &ShapeRange::TRAINING),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::road::Direction;
    use super::*;

    #[test]
    fn across_the_road_lie_line_lane_line_lane_line_grass() {
        let ground = Ground::new(Road::new(3, &ShapeRange::TRAINING));
        for arc in [0.1, 1.3, 2.7, 5.9] {
            let at = |offset: f64| {
                let pose = ground.road().pose_at(arc, offset, Direction::Along);
                ground.at(pose.x_m, pose.y_m)
            };
            for side in [-1.0, 1.0] {
                assert_eq!(at(0.0), Material::Line);
                assert_eq!(at(side * 0.07), Material::Road);
                assert_eq!(at(side * 0.012), Material::Road);
                assert_eq!(at(side * 0.128), Material::Road);
                assert_eq!(at(side * 0.14), Material::Line);
                assert_eq!(at(side * 0.152), Material::Grass);
            }
        }
        assert_eq!(ground.at(50.0, 50.0), Material::Grass);
        assert_eq!(ground.at(-50.0, 0.0), Material::Grass);
    }
}
