//! What the real robots of both generations share: their time is ours, their wheels count steps, their infra-red readings
//! are calibrated on board, and their link may break and come back.

use super::may_come_back;
use crate::body::{InfraredScale, Wheels};
use crate::epuck::{metres_per_second, steps_per_second};
use crate::error::BodyError;
use crate::link::Line;
use std::time::Duration;

/// Time between two commands while the wheels turn, in seconds.
pub const TICK_SECS: f64 = 0.05;
/// A calibrated robot reads 0 when nothing is near.
pub const INFRARED_SCALE: InfraredScale = InfraredScale { idle: 0.0, factor: 1.0 };
/// Standard gravity, in metres per second squared.
const GRAVITY_MPS2: f64 = 9.806_65;

/// Speeds of the wheels in steps per second, at most `most`.
pub fn steps(wheels: Wheels, most: i16) -> [i16; 2] {
    [wheels.left_mps, wheels.right_mps].map(|speed| steps_per_second(speed, most))
}

/// Metres that step counters stand for.
pub fn rolled_m(counters: [i16; 2]) -> [f64; 2] {
    counters.map(metres_per_second)
}

/// Raw acceleration in metres per second squared: `zero` at none, `per_g` more at one g.
pub fn acceleration_mps2(raw: [i16; 3], zero: f64, per_g: f64) -> [f64; 3] {
    raw.map(|r| (f64::from(r) - zero) / per_g * GRAVITY_MPS2)
}

/// Raw turning rates in radians per second; the full range is 250 degrees per second.
pub fn turn_radps(raw: [i16; 3]) -> [f64; 3] {
    raw.map(|r| (f64::from(r) * 250.0 / 32_768.0).to_radians())
}

/// Waits: a robot's time passes by itself.
pub fn pass(secs: f64) {
    std::thread::sleep(Duration::from_secs_f64(secs));
}

/// A robot on a line that may be opened again.
pub trait OnLine {
    /// The line.
    fn line(&mut self) -> &mut Line;

    /// What has to be said on a line that was just opened; the wheels stand then.
    fn enter(&mut self) -> Result<(), BodyError>;

    /// Asks; opens the line again if it is lost, and asks once more.
    fn persist<T>(&mut self, mut ask: impl FnMut(&mut Self) -> Result<T, BodyError>) -> Result<T, BodyError> {
        if !self.line().is_open() {
            self.come_back()?;
        }
        match ask(self) {
            Err(error) if may_come_back(&error) => {
                self.come_back()?;
                ask(self)
            }
            outcome => outcome,
        }
    }

    /// Opens the line again after a loss.
    fn come_back(&mut self) -> Result<(), BodyError> {
        self.line().reopen()?;
        self.enter()
    }
}
