//! A closed two-lane road: where along it and how far beside its centre line a point lies.
//!
//! Lateral offsets are positive to the left of the centre line's own direction. Traffic keeps right in either
//! direction, so a car that drives along the centre line belongs at −[`LANE_M`]/2 and one against it at +[`LANE_M`]/2.

use super::pose::Pose;
use super::shape::{Curve, ShapeRange};
use metal_rl::num;

/// Width of a lane, from the middle of its one line to the middle of the other, in metres.
pub const LANE_M: f64 = 0.14;
/// Width of a line, in metres.
pub const LINE_M: f64 = 0.014;
/// Distance of the road's border (the outer edge of a side line) from the centre line, in metres.
pub const BORDER_M: f64 = LANE_M + 0.5 * LINE_M;

/// Points of the centre line.
const SAMPLES: usize = 1536;
/// Cell of the look-up grid, in metres.
const CELL_M: f64 = 0.02;
/// Plane kept around the road, in metres; the grid answers beyond it too, from its nearest cell.
const MARGIN_M: f64 = 0.6;

/// Where a point lies relative to a road.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Length along the centre line, in [0, length), in metres.
    pub arc_m: f64,
    /// Distance from the centre line, left positive, in metres.
    pub offset_m: f64,
    /// Direction of the centre line there, in radians.
    pub tangent_rad: f64,
    /// Curvature of the centre line there, left positive, in 1/m.
    pub curvature: f64,
}

/// Which way round the loop a car drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// Along the centre line.
    Along,
    /// Against the centre line.
    Against,
}

impl Direction {
    /// +1 along, −1 against the centre line.
    #[must_use]
    pub fn sign(self) -> f64 {
        match self {
            Self::Along => 1.0,
            Self::Against => -1.0,
        }
    }

    /// The other way round.
    #[must_use]
    pub fn reversed(self) -> Self {
        match self {
            Self::Along => Self::Against,
            Self::Against => Self::Along,
        }
    }
}

impl Place {
    /// The direction a car with this heading drives in; reading R44.
    #[must_use]
    pub fn direction(&self, heading_rad: f64) -> Direction {
        let away = num::wrap_angle(heading_rad - self.tangent_rad).abs();
        if away <= std::f64::consts::FRAC_PI_2 { Direction::Along } else { Direction::Against }
    }

    /// Offset from the middle of the right lane of `direction`, in metres, positive to the driver's left.
    #[must_use]
    pub fn lane_offset_m(&self, direction: Direction) -> f64 {
        direction.sign() * self.offset_m + 0.5 * LANE_M
    }

    /// Heading error against the road in `direction`, in radians, positive if the car points to its left.
    #[must_use]
    pub fn heading_error_rad(&self, heading_rad: f64, direction: Direction) -> f64 {
        let road = match direction {
            Direction::Along => self.tangent_rad,
            Direction::Against => self.tangent_rad + std::f64::consts::PI,
        };
        num::wrap_angle(heading_rad - road)
    }
}

#[derive(Clone, Copy, Debug)]
struct Sample {
    x: f64,
    y: f64,
    cos: f64,
    sin: f64,
    tangent_rad: f64,
    curvature: f64,
}

/// Lines of a road as polylines for a picture from above; each entry is [x, y] in metres.
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    /// The centre line.
    pub centre: Vec<[f64; 2]>,
    /// The border left of the centre line's direction.
    pub left: Vec<[f64; 2]>,
    /// The border right of the centre line's direction.
    pub right: Vec<[f64; 2]>,
}

/// A closed two-lane road.
#[derive(Clone, Debug)]
pub struct Road {
    samples: Vec<Sample>,
    spacing_m: f64,
    low: [f64; 2],
    columns: usize,
    rows: usize,
    nearest: Vec<u16>,
}

impl Road {
    /// The road of `seed` in the family `range`.
    #[must_use]
    pub fn new(seed: u64, range: &ShapeRange) -> Self {
        let samples = even_samples(&Curve::draw(seed, range), range.length_m);
        let bound = |pick: fn(&Sample) -> f64, fold: fn(f64, f64) -> f64| {
            samples.iter().map(pick).fold(pick(&samples[0]), fold)
        };
        let low = [bound(|s| s.x, f64::min) - MARGIN_M, bound(|s| s.y, f64::min) - MARGIN_M];
        let columns = ((bound(|s| s.x, f64::max) + MARGIN_M - low[0]) / CELL_M).ceil() as usize;
        let rows = ((bound(|s| s.y, f64::max) + MARGIN_M - low[1]) / CELL_M).ceil() as usize;
        let spacing_m = range.length_m / SAMPLES as f64;
        let mut road = Self { samples, spacing_m, low, columns, rows, nearest: Vec::new() };
        road.fill_grid();
        road
    }

    /// Length of the centre line, in metres.
    #[must_use]
    pub fn length_m(&self) -> f64 {
        self.spacing_m * SAMPLES as f64
    }

    /// Lower left and upper right corner of the plane around the road, in metres.
    #[must_use]
    pub fn bounds_m(&self) -> [[f64; 2]; 2] {
        let high = [self.columns as f64 * CELL_M + self.low[0], self.rows as f64 * CELL_M + self.low[1]];
        [self.low, high]
    }

    /// The place of the point (`x_m`, `y_m`). Exact near the road; far away (beyond the bends' centres) a nearby one.
    #[must_use]
    pub fn locate(&self, x_m: f64, y_m: f64) -> Place {
        let mut index = usize::from(self.nearest[self.cell(x_m, y_m)]);
        for _ in 0..6 {
            let shift = (self.along(index, x_m, y_m) / self.spacing_m).clamp(-6.0, 6.0).round();
            if shift == 0.0 {
                break;
            }
            index = (index as i64 + shift as i64).rem_euclid(SAMPLES as i64) as usize;
        }
        self.place(index, x_m, y_m)
    }

    /// The pose at `arc_m` along and `offset_m` beside the centre line, heading in `direction`.
    #[must_use]
    pub fn pose_at(&self, arc_m: f64, offset_m: f64, direction: Direction) -> Pose {
        let turns = arc_m / self.length_m();
        let at = (turns - turns.floor()) * SAMPLES as f64;
        let index = (at as usize).min(SAMPLES - 1);
        let s = &self.samples[index];
        let along = (at - index as f64) * self.spacing_m;
        let (x, y) = (s.x + along * s.cos, s.y + along * s.sin);
        let tangent = s.tangent_rad + s.curvature * along;
        let heading = if direction == Direction::Along { tangent } else { tangent + std::f64::consts::PI };
        let (sin, cos) = num::sin_cos(tangent);
        Pose { x_m: x - offset_m * sin, y_m: y + offset_m * cos, heading_rad: num::wrap_angle(heading) }
    }

    /// Length along the centre line where it bends most, in metres.
    #[must_use]
    pub fn sharpest_arc_m(&self) -> f64 {
        let bends: Vec<f64> = self.samples.iter().map(|s| s.curvature.abs()).collect();
        num::argmax(&bends) as f64 * self.spacing_m
    }

    /// Length along the centre line in the middle of its straightest half metre, in metres.
    #[must_use]
    pub fn straightest_arc_m(&self) -> f64 {
        let half = (0.25 / self.spacing_m) as usize;
        let bend = |i: usize| -> f64 {
            (0..2 * half).map(|k| self.samples[(i + k + SAMPLES - half) % SAMPLES].curvature.abs()).sum()
        };
        let straightness: Vec<f64> = (0..SAMPLES).map(|i| -bend(i)).collect();
        num::argmax(&straightness) as f64 * self.spacing_m
    }

    /// Centre line and borders for a picture from above; the polylines are closed.
    #[must_use]
    pub fn outline(&self) -> Outline {
        let line = |offset: f64| {
            let mut points: Vec<[f64; 2]> = self
                .samples
                .iter()
                .step_by(4)
                .map(|s| [s.x - offset * s.sin, s.y + offset * s.cos])
                .collect();
            points.push(points[0]);
            points
        };
        Outline { centre: line(0.0), left: line(BORDER_M), right: line(-BORDER_M) }
    }

    fn cell(&self, x: f64, y: f64) -> usize {
        let column = (((x - self.low[0]) / CELL_M) as usize).min(self.columns - 1);
        let row = (((y - self.low[1]) / CELL_M) as usize).min(self.rows - 1);
        row * self.columns + column
    }

    fn along(&self, index: usize, x: f64, y: f64) -> f64 {
        let s = &self.samples[index];
        (x - s.x) * s.cos + (y - s.y) * s.sin
    }

    fn place(&self, index: usize, x: f64, y: f64) -> Place {
        let s = &self.samples[index];
        let along = self.along(index, x, y);
        let offset_m = (y - s.y) * s.cos - (x - s.x) * s.sin;
        // Seen from beside a bend the same step along the tangent is a longer or shorter step of arc.
        let stretch = (1.0 - s.curvature * offset_m).max(0.2);
        let arc = index as f64 * self.spacing_m + along / stretch;
        let length = self.length_m();
        let arc_m = arc - length * (arc / length).floor();
        Place {
            arc_m: if arc_m < length { arc_m } else { 0.0 },
            offset_m,
            tangent_rad: num::wrap_angle(s.tangent_rad + s.curvature * along / stretch),
            curvature: s.curvature,
        }
    }

    fn fill_grid(&mut self) {
        let mut nearest = Vec::with_capacity(self.rows * self.columns);
        for row in 0..self.rows {
            for column in 0..self.columns {
                let x = self.low[0] + (column as f64 + 0.5) * CELL_M;
                let y = self.low[1] + (row as f64 + 0.5) * CELL_M;
                nearest.push(self.search(x, y) as u16);
            }
        }
        self.nearest = nearest;
    }

    /// Index of the sample nearest to a point: every eighth first, then all around the best.
    fn search(&self, x: f64, y: f64) -> usize {
        let distance2 = |i: usize| {
            let s = &self.samples[i];
            (x - s.x) * (x - s.x) + (y - s.y) * (y - s.y)
        };
        let nearer = |best: (usize, f64), i: usize| {
            let d = distance2(i);
            if d < best.1 { (i, d) } else { best }
        };
        let coarse = (0..SAMPLES).step_by(8).fold((0, f64::INFINITY), nearer).0;
        (0..17).map(|k| (coarse + SAMPLES + k - 8) % SAMPLES).fold((0, f64::INFINITY), nearer).0
    }
}

/// Samples of `curve` at even distances along it.
fn even_samples(curve: &Curve, length_m: f64) -> Vec<Sample> {
    let table = curve.lengths();
    let mut at = 0;
    (0..SAMPLES)
        .map(|i| {
            let run = length_m * i as f64 / SAMPLES as f64;
            while table[at + 1].1 <= run {
                at += 1;
            }
            let ((u0, run0), (u1, run1)) = (table[at], table[at + 1]);
            let point = curve.at(u0 + (u1 - u0) * (run - run0) / (run1 - run0));
            let (sin, cos) = num::sin_cos(point.tangent_rad);
            Sample {
                x: point.x,
                y: point.y,
                cos,
                sin,
                tangent_rad: point.tangent_rad,
                curvature: point.curvature,
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::sync::LazyLock;

    static ROADS: LazyLock<Vec<Road>> =
        LazyLock::new(|| vec![Road::new(1, &ShapeRange::TRAINING), Road::new(2, &ShapeRange::TEST)]);

    proptest! {
        #[test]
        fn a_place_and_its_pose_are_each_others_inverse(which in 0..2_usize, turn in 0.0..1.0, offset in -0.15..0.15) {
            let road = &ROADS[which];
            let arc = turn * road.length_m();
            let pose = road.pose_at(arc, offset, Direction::Along);
            let place = road.locate(pose.x_m, pose.y_m);
            let miss = (place.arc_m - arc).abs();
            prop_assert!(miss.min(road.length_m() - miss) < 2e-3, "arc {} against {}", place.arc_m, arc);
            prop_assert!((place.offset_m - offset).abs() < 1e-4);
            prop_assert!(place.heading_error_rad(pose.heading_rad, Direction::Along).abs() < 1e-2);
            prop_assert_eq!(place.direction(pose.heading_rad), Direction::Along);
        }

        #[test]
        fn no_other_point_of_the_road_is_nearer(which in 0..2_usize, turn in 0.0..1.0, offset in -0.2..0.2) {
            let road = &ROADS[which];
            let pose = road.pose_at(turn * road.length_m(), offset, Direction::Along);
            let best = road.samples.iter()
                .map(|s| num::hypot(s.x - pose.x_m, s.y - pose.y_m))
                .fold(f64::INFINITY, f64::min);
            let found = road.locate(pose.x_m, pose.y_m).offset_m.abs();
            // The point may lie between two samples, half a spacing from either.
            let least = (best * best - 0.3 * road.spacing_m * road.spacing_m).max(0.0).sqrt();
            prop_assert!(found <= best + 1e-4 && found >= least - 1e-4, "{} against {}", found, best);
        }

        #[test]
        fn any_point_of_the_plane_has_a_finite_place(x in -9.0..9.0, y in -9.0..9.0) {
            let place = ROADS[0].locate(x, y);
            prop_assert!(place.offset_m.is_finite() && place.tangent_rad.is_finite());
            prop_assert!((0.0..ROADS[0].length_m()).contains(&place.arc_m));
        }
    }

    #[test]
    fn traffic_keeps_right_in_both_directions() {
        let road = &ROADS[0];
        for direction in [Direction::Along, Direction::Against] {
            let pose = road.pose_at(1.0, -direction.sign() * 0.5 * LANE_M, direction);
            let place = road.locate(pose.x_m, pose.y_m);
            assert_eq!(place.direction(pose.heading_rad), direction);
            assert!(place.lane_offset_m(direction).abs() < 1e-4);
            assert!((place.lane_offset_m(direction.reversed()) - LANE_M).abs() < 1e-4);
        }
    }
}
