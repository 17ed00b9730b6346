//! How each measure is named and written.

use crate::figures::number;
use crate::results::Estimate;

/// Measures with a name of their own, in the order of tables; any others follow under their key.
pub const ORDER: [&str; 12] = [
    "total",
    "motor",
    "perceptual",
    "looks",
    "accident_rate",
    "accident_at_fault_rate",
    "accident_hit_rate",
    "off_road_rate",
    "contact_steps",
    "path_smoothness",
    "speed_smoothness",
    "speed",
];

/// The measures of Sec. 3.3 that describe behaviour rather than cost.
pub const BEHAVIOUR: [&str; 8] = [
    "accident_rate",
    "accident_at_fault_rate",
    "accident_hit_rate",
    "off_road_rate",
    "contact_steps",
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
        "looks" => "Looks of 7",
        "accident_rate" => "Runs with accident",
        "accident_at_fault_rate" => "… at own fault",
        "accident_hit_rate" => "… hit by another",
        "off_road_rate" => "Steps off the road",
        "contact_steps" => "Contact steps per run",
        "path_smoothness" => "Turning, rad/step",
        "speed_smoothness" => "Speed change, m/s",
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

fn is_share(measure: &str) -> bool {
    measure.ends_with("_rate")
}

fn digits(measure: &str) -> usize {
    match measure {
        "path_smoothness" | "speed_smoothness" | "speed" => 3,
        _ => 2,
    }
}
