//! What every body can do, whatever it is made of and however it is reached.

use crate::error::BodyError;
use crate::link::Meter;
use crate::picture::Picture;
use metal_worlds::highway::Pose;
use metal_worlds::highway::camera::Window;
use metal_worlds::highway::kinematics::Twist;
use serde::{Deserialize, Serialize};

/// Number of infra-red sensors, ps0 … ps7.
pub const INFRARED: usize = 8;

/// Speeds of the two wheels on the ground.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wheels {
    /// Left, in metres per second.
    pub left_mps: f64,
    /// Right, in metres per second.
    pub right_mps: f64,
}

impl Wheels {
    /// Standing still.
    pub const STILL: Self = Self { left_mps: 0.0, right_mps: 0.0 };

    /// The wheels of a motion.
    #[must_use]
    pub fn of(twist: Twist) -> Self {
        let (left_mps, right_mps) = twist.wheels_mps();
        Self { left_mps, right_mps }
    }

    /// The same arc, `factor` times as fast.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        Self { left_mps: self.left_mps * factor, right_mps: self.right_mps * factor }
    }

    /// Speed of the faster wheel, in metres per second.
    #[must_use]
    pub fn fastest_mps(self) -> f64 {
        self.left_mps.abs().max(self.right_mps.abs())
    }
}

/// How a body's infra-red readings become those the mind has learned with: 67 if nothing is near, as in Webots.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InfraredScale {
    /// Reading when nothing is near: 67 in Webots, 0 on a calibrated robot.
    pub idle: f64,
    /// Factor on what exceeds it.
    pub factor: f64,
}

/// What a body feels beside its ring; `None` where it has no such sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Feelings {
    /// How far the left and the right wheel have rolled, in metres. Counters of steps run over.
    pub rolled_m: Option<[f64; 2]>,
    /// Ambient light at ps0 … ps7, in the body's own unit: dark is high.
    pub ambient: Option<[f64; INFRARED]>,
    /// Acceleration along x (forward), y (left) and z (up), in metres per second squared; lying still, z is +9.81.
    pub acceleration_mps2: Option<[f64; 3]>,
    /// Turning rates about the same axes, in radians per second.
    pub turn_radps: Option<[f64; 3]>,
    /// Reflection of the three ground sensors, in the body's own unit.
    pub ground: Option<[f64; 3]>,
    /// Distance of the time-of-flight sensor, in metres.
    pub ahead_m: Option<f64>,
}

/// What a fact about a body is called, and what it is.
pub type About = Vec<(String, String)>;

/// A body: wheels, a camera and a ring of infra-red sensors.
///
/// Nothing is requested from a device before it is asked for. Every method returns within a bounded time.
pub trait Body: Send {
    /// Short name, e.g. `epuck2`.
    fn name(&self) -> &str;

    /// The fastest a wheel can roll, in metres per second.
    fn fastest_mps(&self) -> f64;

    /// How its infra-red readings are to be understood before anybody calibrated them.
    fn infrared_scale(&self) -> InfraredScale;

    /// Whether a part of the picture is cheaper than the whole.
    fn crops(&self) -> bool {
        false
    }

    /// Lets the wheels turn at these speeds from now on. Standing still is carried out at once.
    ///
    /// # Errors
    /// If the link fails.
    fn drive(&mut self, wheels: Wheels) -> Result<(), BodyError>;

    /// Lets time pass: on a robot the real one, in a simulator the simulated one. A body may round it.
    ///
    /// # Errors
    /// If the link fails.
    fn pass(&mut self, secs: f64) -> Result<(), BodyError>;

    /// Time between two commands while the wheels turn, in seconds.
    fn tick_secs(&self) -> f64;

    /// Takes a picture: `window` of the 52×39 pixels, nothing else.
    ///
    /// # Errors
    /// If the camera does not answer.
    fn picture(&mut self, window: Window) -> Result<Picture, BodyError>;

    /// Reads the ring of infra-red sensors, in the body's own unit.
    ///
    /// # Errors
    /// If it does not answer.
    fn proximity(&mut self) -> Result<[f64; INFRARED], BodyError>;

    /// Reads everything else there is.
    ///
    /// # Errors
    /// If the link fails.
    fn feel(&mut self) -> Result<Feelings, BodyError> {
        Ok(Feelings::default())
    }

    /// Lets light `which` of the ring (0 to 7) shine in red, green and blue, 0 to 255; black is off. A light of one colour
    /// is on or off, and a body without lights does nothing.
    ///
    /// # Errors
    /// If the link fails.
    fn light(&mut self, _which: usize, _rgb: [u8; 3]) -> Result<(), BodyError> {
        Ok(())
    }

    /// Where the learner and the cars are, the learner first, where somebody knows.
    ///
    /// # Errors
    /// If the link fails.
    fn poses(&mut self) -> Result<Option<Vec<Pose>>, BodyError> {
        Ok(None)
    }

    /// Puts the learner and the cars somewhere else, standing, where that is possible; says whether it was.
    ///
    /// # Errors
    /// If the link fails.
    fn place(&mut self, _poses: &[Pose]) -> Result<bool, BodyError> {
        Ok(false)
    }

    /// What the link has cost so far.
    fn meter(&self) -> Meter;

    /// Facts for whoever checks the body: firmware, voltage, names of devices.
    ///
    /// # Errors
    /// If the link fails.
    fn about(&mut self) -> Result<About, BodyError>;
}
