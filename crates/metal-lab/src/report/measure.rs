//! How each measure is named and written.

use crate::figures::number;
use crate::reproduce::table::is_share;
use crate::results::Estimate;

/// Measures with a name of their own, in the order of tables; any others follow under their key.
pub const ORDER: [&str; 12] = [
    "total",
    "motor",
    "perceptual",
    "looks",
    "accident_rate",
    "fault_rate",
    "contact_steps",
    "off_road_rate",
    "lane_offset",
    "path_smoothness",
    "speed_smoothness",
    "speed",
];

/// The measures of Sec. 3.3 that describe behaviour rather than cost.
pub const BEHAVIOUR: [&str; 8] = [
    "accident_rate",
    "fault_rate",
    "contact_steps",
    "off_road_rate",
    "lane_offset",
    "path_smoothness",
    "speed_smoothness",
    "speed",
];

/// The measure's name for people.
#[must_use]
pub fn label(measure: &str) -> &str {
    match measure {
        "total" => "Total cost",
        "motor" => "Motor cost",
        "perceptual" => "Perceptual cost",
        "looks" => "Looks per step, of 7",
        "accident_rate" => "Runs with accident",
        "fault_rate" => "Runs with accident at own fault",
        "off_road_rate" => "Steps off the road",
        "contact_steps" => "Contact steps per run",
        "lane_offset" => "From the lane’s middle, m",
        "path_smoothness" => "Change of turn, rad/step",
        "speed_smoothness" => "Steps that change speed",
        "speed" => "Speed, m/s",
        other => other,
    }
}

/// The mean as text.
#[must_use]
pub fn mean(measure: &str, estimate: &Estimate) -> String {
    if is_share(measure) {
        number::percent(estimate.mean)
    } else {
        number::fixed(estimate.mean, digits(measure))
    }
}

/// The interval as text, if it is known.
#[must_use]
pub fn interval(measure: &str, estimate: &Estimate) -> Option<String> {
    if is_share(measure) {
        let (lo, hi) = estimate.band()?;
        return Some(format!("[{}, {}]", number::percent(lo), number::percent(hi)));
    }
    number::interval(estimate, digits(measure))
}

fn digits(measure: &str) -> usize {
    match measure {
        "lane_offset" | "path_smoothness" | "speed" => 3,
        _ => 2,
    }
}
