//! Where everybody starts: the test scenarios of Table 2, their mix for training, and the situations of Table 1.
//! Readings R50 and R51.

use super::kinematics::BODY_RADIUS_M;
use super::pose::Pose;
use super::road::{BORDER_M, Direction, LANE_M, Road};
use super::traffic::CARS;
use metal_rl::num;
use metal_rl::random::{Rng, Streams};
use serde::{Deserialize, Serialize};

/// Half the lane: distance of a lane's middle from the centre line.
const MIDDLE_M: f64 = 0.5 * LANE_M;
/// Largest start offset from the middle of a lane: its centre stays on the road, its edge at most
/// 20 mm beyond the border.
const SPREAD_M: f64 = BORDER_M - MIDDLE_M - BODY_RADIUS_M + 0.02;
/// Largest start angle against the driving direction, in radians.
const ASKEW_RAD: f64 = 0.4;
/// Share of starts in the wrong lane.
const WRONG_LANE: f64 = 0.35;
/// Share of approaching cars that come in the learner's own lane, as if overtaking.
const OVERTAKING: f64 = 0.5;
/// How far ahead an approaching car starts, in metres.
const APPROACHING_M: (f64, f64) = (0.55, 1.05);
/// How far ahead a car starts that the learner nears from behind, in metres.
const FROM_BEHIND_M: (f64, f64) = (0.25, 0.6);

/// What an episode is about.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Scenario {
    /// Each episode draws one of the other three; a second red car drives somewhere else. The training distribution.
    #[default]
    Mix,
    /// Free road: no other car. Table 2, row 1.
    FreeRoad,
    /// A moving car is approaching: 0.55 to 1.05 m ahead, in its own lane or in the learner's. Table 2, row 2.
    Approaching,
    /// The robot is nearing a moving car from behind: 0.25 to 0.6 m ahead in the same lane. Table 2, row 3.
    FromBehind,
}

impl Scenario {
    /// Name in experiment files and results.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Mix => "mix",
            Self::FreeRoad => "free_road",
            Self::Approaching => "approaching",
            Self::FromBehind => "from_behind",
        }
    }

    /// All scenarios.
    pub const ALL: [Self; 4] = [Self::Mix, Self::FreeRoad, Self::Approaching, Self::FromBehind];
    /// The test scenarios of Table 2.
    pub const TABLE_2: [Self; 3] = [Self::FreeRoad, Self::Approaching, Self::FromBehind];
}

/// Where everybody stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// The learner.
    pub learner: Pose,
    /// The red cars, of which the first [`Self::car_count`] are there.
    pub cars: [Pose; CARS],
    /// Number of red cars.
    pub car_count: usize,
}

impl Start {
    fn alone(learner: Pose) -> Self {
        Self { learner, cars: [Pose::default(); CARS], car_count: 0 }
    }

    fn with(mut self, car: Pose) -> Self {
        self.cars[self.car_count] = car;
        self.car_count += 1;
        self
    }

    fn keeps_apart(&self) -> bool {
        let cars = &self.cars[..self.car_count];
        cars.iter().all(|car| car.distance_m(&self.learner) > 0.2)
            && (cars.len() < 2 || cars[0].distance_m(&cars[1]) > 0.2)
    }
}

impl Scenario {
    /// Draws the start of the episode `streams`: everything random about it comes from there.
    #[must_use]
    pub fn start(self, road: &Road, streams: &Streams) -> Start {
        let mut rng = streams.stream("start");
        let kind = if self == Self::Mix { Self::TABLE_2[rng.below(3)] } else { self };
        loop {
            let mut start = kind.draw(road, &mut rng);
            if self == Self::Mix && kind != Self::FreeRoad {
                start = start.with(elsewhere(road, &mut rng));
            }
            if start.keeps_apart() {
                return start;
            }
        }
    }

    fn draw(self, road: &Road, rng: &mut Rng) -> Start {
        let direction = if rng.chance(0.5) { Direction::Along } else { Direction::Against };
        let arc = rng.range(0.0, road.length_m());
        let side = if self != Self::FromBehind && rng.chance(WRONG_LANE) { 1.0 } else { -1.0 };
        let from_middle = rng.range(-SPREAD_M, SPREAD_M);
        let offset = direction.sign() * (side * MIDDLE_M + from_middle);
        let mut learner = road.pose_at(arc, offset, direction);
        learner.heading_rad = num::wrap_angle(learner.heading_rad + rng.range(-ASKEW_RAD, ASKEW_RAD));
        let start = Start::alone(learner);
        match self {
            Self::Mix | Self::FreeRoad => start,
            Self::Approaching => {
                let at = arc + direction.sign() * rng.range(APPROACHING_M.0, APPROACHING_M.1);
                let side = if rng.chance(OVERTAKING) { -1.0 } else { 1.0 };
                start.with(road.pose_at(at, side * direction.sign() * MIDDLE_M, direction.reversed()))
            }
            Self::FromBehind => {
                let at = arc + direction.sign() * rng.range(FROM_BEHIND_M.0, FROM_BEHIND_M.1);
                start.with(in_lane(road, at, direction))
            }
        }
    }
}

/// The middle of the right lane.
fn in_lane(road: &Road, arc_m: f64, direction: Direction) -> Pose {
    road.pose_at(arc_m, -direction.sign() * MIDDLE_M, direction)
}

/// A red car anywhere in its lane.
fn elsewhere(road: &Road, rng: &mut Rng) -> Pose {
    let direction = if rng.chance(0.5) { Direction::Along } else { Direction::Against };
    in_lane(road, rng.range(0.0, road.length_m()), direction)
}

/// A situation of Table 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Situation {
    /// Perpendicular view to free road.
    Perpendicular,
    /// Looking at a free curve from the roadside.
    CurveFromRoadside,
    /// An obstacle at the left.
    ObstacleLeft,
    /// The road is blocked with an obstacle.
    Blocked,
    /// Free road (middle).
    FreeMiddle,
    /// Free road (left).
    FreeLeft,
}

impl Situation {
    /// All situations in the order of Table 1.
    pub const ALL: [Self; 6] = [
        Self::Perpendicular,
        Self::CurveFromRoadside,
        Self::ObstacleLeft,
        Self::Blocked,
        Self::FreeMiddle,
        Self::FreeLeft,
    ];

    /// The name in Table 1.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Perpendicular => "Perpendicular view to free road",
            Self::CurveFromRoadside => "Looking at a free curve from the roadside",
            Self::ObstacleLeft => "An obstacle at the left",
            Self::Blocked => "The road is blocked with an obstacle",
            Self::FreeMiddle => "Free road (middle)",
            Self::FreeLeft => "Free road (left)",
        }
    }

    /// The poses of the situation on `road`, always the same.
    #[must_use]
    pub fn start(self, road: &Road) -> Start {
        let straight = road.straightest_arc_m();
        let along = |arc: f64, offset: f64| road.pose_at(arc, offset, Direction::Along);
        match self {
            Self::Perpendicular => {
                let mut learner = along(straight, -MIDDLE_M);
                learner.heading_rad = num::wrap_angle(learner.heading_rad + std::f64::consts::FRAC_PI_2);
                Start::alone(learner)
            }
            Self::CurveFromRoadside => Start::alone(along(road.sharpest_arc_m() - 0.15, -BORDER_M)),
            Self::ObstacleLeft => {
                Start::alone(along(straight, -MIDDLE_M)).with(along(straight + 0.12, -0.035))
            }
            Self::Blocked => Start::alone(along(straight, -MIDDLE_M))
                .with(along(straight + 0.15, -MIDDLE_M))
                .with(along(straight + 0.15, MIDDLE_M)),
            Self::FreeMiddle => Start::alone(along(straight, 0.0)),
            Self::FreeLeft => Start::alone(along(straight, MIDDLE_M)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::shape::ShapeRange;
    use super::*;

    #[test]
    fn starts_are_on_the_road_and_as_described() {
        let road = Road::new(1, &ShapeRange::TRAINING);
        let (mut wrong_lane, mut overtaking) = (0, 0);
        for seed in 0..2000 {
            let start = Scenario::Approaching.start(&road, &Streams::new(seed));
            let place = road.locate(start.learner.x_m, start.learner.y_m);
            let direction = place.direction(start.learner.heading_rad);
            assert!(place.offset_m.abs() < BORDER_M);
            assert!(place.heading_error_rad(start.learner.heading_rad, direction).abs() <= ASKEW_RAD + 0.01);
            wrong_lane += usize::from(place.lane_offset_m(direction) > MIDDLE_M);
            let car = road.locate(start.cars[0].x_m, start.cars[0].y_m);
            assert_ne!(car.direction(start.cars[0].heading_rad), direction);
            let from_its_lane = car.lane_offset_m(direction.reversed());
            assert!(from_its_lane.abs() < 1e-3 || (from_its_lane - 2.0 * MIDDLE_M).abs() < 1e-3);
            overtaking += usize::from(from_its_lane > MIDDLE_M);
        }
        assert!((920..1080).contains(&overtaking), "{overtaking}");
        assert!((600..800).contains(&wrong_lane), "{wrong_lane}");
    }

    #[test]
    fn the_mix_draws_each_kind_alike() {
        let road = Road::new(1, &ShapeRange::TRAINING);
        let free =
            (0..3000).filter(|&seed| Scenario::Mix.start(&road, &Streams::new(seed)).car_count == 0).count();
        assert!((900..1100).contains(&free), "{free}");
    }
}
