//! Where a body stands on the plane.

use metal_rl::num;
use serde::{Deserialize, Serialize};

/// A place and a heading on the plane; x and y in metres, heading in radians, counter-clockwise from the x axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// First coordinate of the centre, in metres.
    pub x_m: f64,
    /// Second coordinate of the centre, in metres.
    pub y_m: f64,
    /// Heading in (−π, π], in radians.
    pub heading_rad: f64,
}

impl Pose {
    /// The distance between the centres of two bodies, in metres.
    #[must_use]
    pub fn distance_m(&self, other: &Self) -> f64 {
        let (dx, dy) = (other.x_m - self.x_m, other.y_m - self.y_m);
        (dx * dx + dy * dy).sqrt()
    }

    /// The other body's direction as seen from this one: radians, 0 straight ahead, left positive.
    #[must_use]
    pub fn bearing_rad(&self, other: &Self) -> f64 {
        num::wrap_angle(num::atan2(other.y_m - self.y_m, other.x_m - self.x_m) - self.heading_rad)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn left_is_positive() {
        let eye = Pose { x_m: 1.0, y_m: 1.0, heading_rad: std::f64::consts::FRAC_PI_2 };
        let west = Pose { x_m: 0.0, y_m: 1.0, heading_rad: 0.0 };
        assert!((eye.bearing_rad(&west) - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        assert!((eye.distance_m(&west) - 1.0).abs() < 1e-12);
    }
}
