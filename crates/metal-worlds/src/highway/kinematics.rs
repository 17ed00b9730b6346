//! The E-puck as a differential drive, and the five motor actions of Eq. (12).

use super::pose::Pose;
use metal_rl::num;

/// Radius of the body, in metres (E-puck).
pub const BODY_RADIUS_M: f64 = 0.037;
/// Height of the body's top above the road, in metres (E-puck).
pub const BODY_HEIGHT_M: f64 = 0.0475;
/// Distance between the wheels, in metres (E-puck).
pub const AXLE_M: f64 = 0.052;
/// The fastest a wheel can roll, in metres per second: 6.28 rad/s on a wheel of 20 mm (E-puck).
pub const WHEEL_LIMIT_MPS: f64 = 0.1256;
/// Duration of a motor action, in seconds.
pub const ACTION_SECS: f64 = 0.5;
/// Moves into which a motor action is divided, so that no contact is jumped over.
pub const SUBSTEPS: usize = 4;
/// Duration of one such move, in seconds.
pub const SUBSTEP_SECS: f64 = ACTION_SECS / SUBSTEPS as f64;
/// The fastest a motor action drives, in metres per second.
pub const FAST_MPS: f64 = 0.12;
/// The sharpest a motor action turns, in radians per second.
pub const TURN_RADPS: f64 = 0.45;

/// A motor action. Eq. (12), reading R41.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum MotorAction {
    /// Go fast: straight on at 0.12 m/s.
    Fast,
    /// Go with medium speed: straight on at 0.08 m/s.
    Medium,
    /// Slow down: straight on at 0.03 m/s.
    SlowDown,
    /// Turn right: 0.07 m/s and −0.45 rad/s, an arc of 35 mm through −0.225 rad.
    TurnRight,
    /// Turn left: 0.07 m/s and 0.45 rad/s.
    TurnLeft,
}

impl MotorAction {
    /// All motor actions in the order of Eq. (12).
    pub const ALL: [Self; 5] = [Self::Fast, Self::Medium, Self::SlowDown, Self::TurnRight, Self::TurnLeft];

    /// The action's name in the contract.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Fast => "Fast",
            Self::Medium => "Medium",
            Self::SlowDown => "Slow Down",
            Self::TurnRight => "Turn Right",
            Self::TurnLeft => "Turn Left",
        }
    }

    /// The motion the action commands.
    #[must_use]
    pub fn twist(self) -> Twist {
        let (speed_mps, turn_radps) = match self {
            Self::Fast => (FAST_MPS, 0.0),
            Self::Medium => (0.08, 0.0),
            Self::SlowDown => (0.03, 0.0),
            Self::TurnRight => (0.07, -TURN_RADPS),
            Self::TurnLeft => (0.07, TURN_RADPS),
        };
        Twist { speed_mps, turn_radps }.within_wheel_limits()
    }
}

/// A commanded motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Twist {
    /// Forward speed of the body's centre, in metres per second.
    pub speed_mps: f64,
    /// Turning rate, in radians per second, left positive.
    pub turn_radps: f64,
}

impl Twist {
    /// The same arc driven `factor` times as fast.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        Self { speed_mps: self.speed_mps * factor, turn_radps: self.turn_radps * factor }
    }

    /// Speeds of the left and right wheel, in metres per second.
    #[must_use]
    pub fn wheels_mps(self) -> (f64, f64) {
        let half = 0.5 * AXLE_M * self.turn_radps;
        (self.speed_mps - half, self.speed_mps + half)
    }

    /// The motion an E-puck can follow: each wheel clipped to [`WHEEL_LIMIT_MPS`].
    #[must_use]
    pub fn within_wheel_limits(self) -> Self {
        let (left, right) = self.wheels_mps();
        if left.abs().max(right.abs()) <= WHEEL_LIMIT_MPS {
            return self;
        }
        let left = left.clamp(-WHEEL_LIMIT_MPS, WHEEL_LIMIT_MPS);
        let right = right.clamp(-WHEEL_LIMIT_MPS, WHEEL_LIMIT_MPS);
        Self { speed_mps: 0.5 * (left + right), turn_radps: (right - left) / AXLE_M }
    }
}

/// The pose after driving `twist` for `secs` seconds.
///
/// # Formula
/// The body runs on a circle of radius v/ω. Its chord has the length v·t·sin(φ)/φ with φ = ω·t/2 and the direction
/// heading + φ, which is exact for every arc and has no pole at ω = 0.
#[must_use]
pub fn advance(pose: Pose, twist: Twist, secs: f64) -> Pose {
    let half_turn = 0.5 * twist.turn_radps * secs;
    let (sin, cos) = num::sin_cos(pose.heading_rad + half_turn);
    let chord = twist.speed_mps * secs * sine_ratio(half_turn);
    Pose {
        x_m: pose.x_m + chord * cos,
        y_m: pose.y_m + chord * sin,
        heading_rad: num::wrap_angle(pose.heading_rad + 2.0 * half_turn),
    }
}

/// sin(x)/x, by its series where the quotient loses digits.
fn sine_ratio(x: f64) -> f64 {
    if x.abs() < 1e-4 { 1.0 - x * x / 6.0 } else { num::sin(x) / x }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_full_circle_comes_home() {
        let start = Pose { x_m: 0.3, y_m: -0.2, heading_rad: 1.0 };
        let turn = 2.0 * std::f64::consts::PI;
        let home = advance(start, Twist { speed_mps: 0.07, turn_radps: 0.45 }, turn / 0.45);
        assert!(home.distance_m(&start) < 1e-12 && (home.heading_rad - 1.0).abs() < 1e-12);
    }

    #[test]
    fn every_action_is_within_the_wheels_limits() {
        for action in MotorAction::ALL {
            let (left, right) = action.twist().wheels_mps();
            assert!(left.abs().max(right.abs()) <= WHEEL_LIMIT_MPS, "{}", action.name());
        }
        let (left, right) = Twist { speed_mps: 0.2, turn_radps: 1.0 }.within_wheel_limits().wheels_mps();
        assert!(left <= WHEEL_LIMIT_MPS && right <= WHEEL_LIMIT_MPS + 1e-15);
    }

    proptest! {
        #[test]
        fn the_body_stays_on_the_circle_of_its_arc(heading in -3.0..3.0, v in 0.01..0.12, w in 0.05..1.0, t in 0.0..3.0) {
            let start = Pose { x_m: 0.0, y_m: 0.0, heading_rad: heading };
            let radius: f64 = v / w;
            let (sin, cos) = num::sin_cos(heading);
            let centre = Pose { x_m: -radius * sin, y_m: radius * cos, heading_rad: 0.0 };
            let end = advance(start, Twist { speed_mps: v, turn_radps: w }, t);
            prop_assert!((end.distance_m(&centre) - radius).abs() < 1e-12);
            let middle = advance(start, Twist { speed_mps: v, turn_radps: w }, 0.5 * t);
            let twice = advance(middle, Twist { speed_mps: v, turn_radps: w }, 0.5 * t);
            prop_assert!(twice.distance_m(&end) < 1e-12);
        }
    }
}
