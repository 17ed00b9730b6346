//! A sensor that hides nothing: where the learner is on the road, how the road goes on, where the cars are.
//!
//! No robot has it. It is a yardstick: what driving costs if a look at the price of a camera region tells everything there
//! is to know, so that what is lost beyond that is lost by what the real sensors do not show. Reading R136.

use super::kinematics::BODY_RADIUS_M;
use super::pose::Pose;
use super::road::{Direction, Road};
use metal_rl::environment::Feature;
use metal_rl::num;
use serde::{Deserialize, Serialize};

/// How far ahead the road's bend is told, in metres.
pub const AHEAD_M: [f64; 5] = [0.0, 0.08, 0.16, 0.24, 0.36];
/// Numbers about each car.
const PER_CAR: usize = 5;
/// Gap at which a car is half as close as can be, in metres.
const HALF_CLOSE_M: f64 = 0.08;
/// Beyond these limits nothing is told apart: offset in metres, bend in 1/m.
const OFFSET_M: f64 = 0.25;
const BEND: f64 = 4.0;

/// How much of it is told: to find out what a robot lacks that sees less.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Told {
    /// Pose, bends and cars.
    #[default]
    Everything,
    /// Where the learner is in its lane, and which way it looks.
    Pose,
    /// That, and how the road goes on.
    PoseAndBends,
    /// Pose and cars.
    PoseAndCars,
}

impl Told {
    fn bends(self) -> bool {
        matches!(self, Self::Everything | Self::PoseAndBends)
    }

    fn cars(self) -> bool {
        matches!(self, Self::Everything | Self::PoseAndCars)
    }
}

/// The numbers of a reading with so many cars.
#[must_use]
pub fn features(told: Told, cars: usize) -> Vec<Feature> {
    let feature = |name: String, limit: f64| Feature { name, low: -limit, high: limit };
    let mut all = vec![feature("offset_m".into(), OFFSET_M)];
    all.extend(["heading_sin", "heading_cos"].map(|name| feature(name.into(), 1.0)));
    if told.bends() {
        all.extend(AHEAD_M.iter().map(|ahead| feature(format!("bend_{:.0}cm", 100.0 * ahead), BEND)));
    }
    for car in 0..if told.cars() { cars } else { 0 } {
        let names = ["close", "ahead", "left", "heading_sin", "heading_cos"];
        all.extend(names.map(|name| feature(format!("car{car}_{name}"), 1.0)));
    }
    all
}

/// Tells so much about `learner` among `cars`, the nearest first; what would be told of further cars stays 0.
///
/// # Panics
/// If `out` is shorter than [`features`] says.
pub fn read(told: Told, (road, learner, cars): (&Road, &Pose, &[Pose]), out: &mut [f64]) {
    let place = road.locate(learner.x_m, learner.y_m);
    let direction = place.direction(learner.heading_rad);
    let (sin, cos) = num::sin_cos(place.heading_error_rad(learner.heading_rad, direction));
    out.fill(0.0);
    out[0] = place.lane_offset_m(direction).clamp(-OFFSET_M, OFFSET_M);
    (out[1], out[2]) = (sin, cos);
    let (bends, others) = out[3..].split_at_mut(if told.bends() { AHEAD_M.len() } else { 0 });
    for (out, ahead) in bends.iter_mut().zip(AHEAD_M) {
        *out = bend(road, place.arc_m + direction.sign() * ahead, direction).clamp(-BEND, BEND);
    }
    if !told.cars() {
        return;
    }
    let mut near: Vec<&Pose> = cars.iter().collect();
    near.sort_by(|a, b| a.distance_m(learner).total_cmp(&b.distance_m(learner)));
    for (car, out) in near.iter().zip(others.chunks_exact_mut(PER_CAR)) {
        out.copy_from_slice(&about(learner, car));
    }
}

/// How the road bends at `arc_m`, positive to the driver's left.
fn bend(road: &Road, arc_m: f64, direction: Direction) -> f64 {
    let middle = road.pose_at(arc_m, 0.0, Direction::Along);
    direction.sign() * road.locate(middle.x_m, middle.y_m).curvature
}

fn about(learner: &Pose, car: &Pose) -> [f64; PER_CAR] {
    let gap = (car.distance_m(learner) - 2.0 * BODY_RADIUS_M).max(0.0);
    let (left, ahead) = num::sin_cos(learner.bearing_rad(car));
    let (sin, cos) = num::sin_cos(car.heading_rad - learner.heading_rad);
    [HALF_CLOSE_M / (HALF_CLOSE_M + gap), ahead, left, sin, cos]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::highway::road::LANE_M;
    use crate::highway::shape::ShapeRange;

    #[test]
    fn everything_is_told_from_the_drivers_side() {
        let road = Road::new(3, &ShapeRange::TRAINING);
        let at = road.sharpest_arc_m();
        for direction in [Direction::Along, Direction::Against] {
            let lane = -direction.sign() * 0.5 * LANE_M;
            let learner = road.pose_at(at, lane, direction);
            let car = Pose {
                x_m: learner.x_m + 0.154 * num::sin_cos(learner.heading_rad).1,
                y_m: learner.y_m + 0.154 * num::sin_cos(learner.heading_rad).0,
                heading_rad: learner.heading_rad + std::f64::consts::PI,
            };
            let tell = |told| {
                let mut out = vec![f64::NAN; features(told, 2).len()];
                read(told, (&road, &learner, &[car]), &mut out);
                out
            };
            let out = tell(Told::Everything);
            assert!(out[0].abs() < 1e-3, "in the middle of its lane: {}", out[0]);
            assert!(out[1].abs() < 0.02 && out[2] > 0.99, "along the road: {} {}", out[1], out[2]);
            let bend = direction.sign() * road.locate(learner.x_m, learner.y_m).curvature;
            assert!((out[3] - bend.clamp(-BEND, BEND)).abs() < 1e-6, "{} {bend}", out[3]);
            let first = &out[3 + AHEAD_M.len()..];
            assert!((first[0] - 0.5).abs() < 1e-6, "8 cm away: {}", first[0]);
            assert!(first[1] > 0.999 && first[2].abs() < 1e-6, "straight ahead");
            assert!(first[4] < -0.999, "coming");
            assert!(first[PER_CAR..].iter().all(|&x| x == 0.0), "there is no other car");
            assert_eq!(tell(Told::Pose), out[..3]);
            assert_eq!(tell(Told::PoseAndBends), out[..3 + AHEAD_M.len()]);
            assert_eq!(tell(Told::PoseAndCars), [&out[..3], first].concat());
        }
    }
}
