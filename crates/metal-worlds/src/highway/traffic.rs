//! The red cars: same body and arcs as the learner, at a steady speed of their own, steered by a mind from outside or by a script.

use super::kinematics::{ACTION_SECS, MotorAction, Twist};
use super::pose::Pose;
use super::road::Road;
use std::sync::Arc;

/// Most red cars in the world (Sec. 4.1: "two other cars").
pub const CARS: usize = 2;
/// Speed of a red car, in metres per second, unless it slows down (to half of it): a learner can near it from behind,
/// and can follow it between [`MotorAction::SlowDown`] and [`MotorAction::Medium`].
pub const CRUISE_MPS: f64 = 0.05;
/// Length of what a driver sees: six regions of four colours.
pub const VISION: usize = 24;

/// A mind that drives a red car, greedy and learning nothing (Sec. 4.1: "FOAs that have learned how to drive").
pub trait Driver: Send + Sync {
    /// The motor action (an index below 5 into Eq. (12); the world panics at any other) for what the car's camera
    /// shows: regions in the order MN, LN, RN, MF, LF, RF, for each the fractions of black, white, red and green
    /// pixels in [0, 1].
    fn drive(&self, vision: &[f64; VISION]) -> usize;

    /// Whether what it does depends on what it sees and on nothing else: then it need not be asked twice about the same
    /// sight, and is not.
    fn decides_by_sight(&self) -> bool {
        true
    }
}

/// Who steers the red cars; reading R45.
#[derive(Clone, Default)]
pub enum Steering {
    /// A lane follower with ground truth, until minds are there.
    #[default]
    Scripted,
    /// A trained mind, shared by all cars and all copies of the world.
    Mind(Arc<dyn Driver>),
}

impl std::fmt::Debug for Steering {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Scripted => "Scripted",
            Self::Mind(_) => "Mind",
        })
    }
}

/// The motion of a red car under a motor action: the learner's arcs at the red cars' own steady speed.
#[must_use]
pub fn car_twist(action: MotorAction) -> Twist {
    let speed_mps = if action == MotorAction::SlowDown { 0.5 * CRUISE_MPS } else { CRUISE_MPS };
    let twist = action.twist();
    twist.scaled(speed_mps / twist.speed_mps)
}

/// What the scripted driver does at `me`: it keeps its right lane, slows down behind another red car, and does not
/// care for the learner (Sec. 4.4: the red cars "do not necessarily care about colliding with the learning robot").
#[must_use]
pub fn scripted_action(road: &Road, me: &Pose, others: &[Pose]) -> MotorAction {
    if others.iter().any(|other| me.distance_m(other) < 0.16 && me.bearing_rad(other).abs() < 0.5) {
        return MotorAction::SlowDown;
    }
    let place = road.locate(me.x_m, me.y_m);
    let direction = place.direction(me.heading_rad);
    let wanted = (-8.0 * place.lane_offset_m(direction)).clamp(-0.6, 0.6);
    let bend = direction.sign() * place.curvature * 0.03;
    let turn = wanted - place.heading_error_rad(me.heading_rad, direction) + bend;
    let half_a_turn = 0.5 * car_twist(MotorAction::TurnLeft).turn_radps * ACTION_SECS;
    if turn > half_a_turn {
        MotorAction::TurnLeft
    } else if turn < -half_a_turn {
        MotorAction::TurnRight
    } else {
        MotorAction::Fast
    }
}

#[cfg(test)]
mod tests {
    use super::super::kinematics::advance;
    use super::super::road::Direction;
    use super::super::shape::ShapeRange;
    use super::*;

    #[test]
    fn the_script_keeps_its_lane_on_every_family_of_roads() {
        for (seed, range) in [(1, ShapeRange::TRAINING), (201, ShapeRange::TEST)] {
            let road = Road::new(seed, &range);
            for direction in [Direction::Along, Direction::Against] {
                let mut car = road.pose_at(0.5, -direction.sign() * 0.07, direction);
                let mut run = 0.0;
                for _ in 0..400 {
                    let before = car;
                    car = advance(car, car_twist(scripted_action(&road, &car, &[])), ACTION_SECS);
                    run += before.distance_m(&car);
                    let place = road.locate(car.x_m, car.y_m);
                    assert!(place.lane_offset_m(direction).abs() < 0.03);
                    assert_eq!(place.direction(car.heading_rad), direction);
                }
                assert!(run > 7.0, "it makes way: {run} m");
            }
        }
    }
}
