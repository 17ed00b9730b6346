//! Facts about the last step for records and figures.

use super::pose::Pose;
use super::road::{BORDER_M, Place};
use super::task::{Facts, MotorCost};

/// Names of the measures, in order.
pub const NAMES: [&str; 18] = [
    "x_m",
    "y_m",
    "heading_rad",
    "arc_m",
    "offset_m",
    "lane_offset_m",
    "heading_error_rad",
    "off_road",
    "gap_m",
    "accident",
    "fault",
    "contact_bearing_rad",
    "speed_mps",
    "turn_radps",
    "cost_accident",
    "cost_road",
    "cost_lane",
    "cost_smooth",
];

/// Longest gap reported, in metres: without cars the gap is infinite, which no table likes.
pub const FAR_GAP_M: f64 = 10.0;

/// Contacts of the learner in one step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Touch {
    /// Whether it touched a car.
    pub contact: bool,
    /// Whether it was the one who drove into the car (at least half of the approach was its own).
    pub fault: bool,
    /// Direction of the touched car, radians, 0 ahead, left positive.
    pub bearing_rad: f64,
}

/// The measures in the order of [`NAMES`].
#[must_use]
pub fn collect(body: &Pose, place: &Place, touch: &Touch, facts: &Facts, cost: &MotorCost) -> [f64; 18] {
    let direction = place.direction(body.heading_rad);
    [
        body.x_m,
        body.y_m,
        body.heading_rad,
        place.arc_m,
        place.offset_m,
        place.lane_offset_m(direction),
        place.heading_error_rad(body.heading_rad, direction),
        f64::from(u8::from(place.offset_m.abs() > BORDER_M)),
        facts.gap_m.min(FAR_GAP_M),
        f64::from(u8::from(touch.contact)),
        f64::from(u8::from(touch.fault)),
        touch.bearing_rad,
        facts.speed_mps,
        facts.turn_radps,
        cost.accident,
        cost.road,
        cost.lane,
        cost.smooth,
    ]
}
