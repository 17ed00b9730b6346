//! The E-puck's own languages, without any link: bytes in, meaning out, and back.
//!
//! Facts and layouts: the BTcom and advanced-sercom firmwares and the e-puck2's Wi-Fi firmware.

pub mod ascii;
pub mod binary;
pub mod sensors;
pub mod wifi;

pub use sensors::Sensors;

/// Steps of a wheel in one turn.
pub const STEPS_PER_TURN: f64 = 1000.0;
/// Radius of a wheel, in metres.
pub const WHEEL_RADIUS_M: f64 = 0.02;

/// Wheel speed in steps per second, for a speed on the ground in metres per second, kept within ±`most`.
#[must_use]
pub fn steps_per_second(speed_mps: f64, most: i16) -> i16 {
    let turns = speed_mps / (2.0 * std::f64::consts::PI * WHEEL_RADIUS_M);
    (turns * STEPS_PER_TURN).round().clamp(-f64::from(most), f64::from(most)) as i16
}

/// Speed on the ground in metres per second of a wheel that turns `steps` per second.
#[must_use]
pub fn metres_per_second(steps: i16) -> f64 {
    f64::from(steps) / STEPS_PER_TURN * (2.0 * std::f64::consts::PI * WHEEL_RADIUS_M)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thousand_steps_are_one_turn() {
        assert_eq!(steps_per_second(0.1256, 1000), 999);
        assert_eq!(steps_per_second(-0.5, 1000), -1000);
        assert!((metres_per_second(1000) - 0.125_663).abs() < 1e-6);
        assert!((0..=1000).all(|s| steps_per_second(metres_per_second(s), 1000) == s));
    }
}
