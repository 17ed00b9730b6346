//! What a user may choose about the miniature road: where it runs, what stands on it, and how far eye and body are from
//! those of the highway. Every deviation can be switched off, so that each can be tested alone.

use crate::highway::classify::ColourThresholds;
use crate::highway::task::Task;
use serde::{Deserialize, Serialize};

/// How the camera differs from the one that was learned with.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Eye {
    /// Brightness changes by this share from the middle of the plane to its edge, along a diagonal.
    pub light_gradient: f64,
    /// Share of the light that is missing in the corners of the picture.
    pub vignetting: f64,
    /// Standard deviation of each channel's noise, as a share of its range.
    pub noise: f64,
    /// Step in which the lowest frequency of an 8×8 cosine block is coarsened (JPEG at quality 50: 16); it grows with
    /// frequency. 0: none.
    pub compression: f64,
    /// How much farther down than it should the camera looks, in radians; below 0, it looks beyond the plane.
    pub pitch_error_rad: f64,
    /// Thresholds between the colours: the code is that of the robots.
    pub thresholds: ColourThresholds,
}

impl Default for Eye {
    fn default() -> Self {
        Self {
            light_gradient: 0.35,
            vignetting: 0.25,
            noise: 0.03,
            compression: 12.0,
            pitch_error_rad: -0.04,
            thresholds: ColourThresholds::default(),
        }
    }
}

impl Eye {
    /// No deviation but that of the renderer.
    #[must_use]
    pub fn exact() -> Self {
        Self {
            light_gradient: 0.0,
            vignetting: 0.0,
            noise: 0.0,
            compression: 0.0,
            pitch_error_rad: 0.0,
            thresholds: ColourThresholds::default(),
        }
    }
}

/// How the wheels differ from the ideal ones.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Wheels {
    /// Share of a wheel's way that is lost, always.
    pub slip: f64,
    /// How much farther than the left wheel the right one gets, as a share: the body does not run straight.
    pub bias: f64,
    /// Standard deviation of each wheel's way in one motor action, as a share of it.
    pub noise: f64,
}

impl Default for Wheels {
    fn default() -> Self {
        Self { slip: 0.06, bias: 0.015, noise: 0.05 }
    }
}

impl Wheels {
    /// No deviation.
    #[must_use]
    pub fn exact() -> Self {
        Self { slip: 0.0, bias: 0.0, noise: 0.0 }
    }
}

/// By which law the infra-red ring answers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum InfraredLaw {
    /// Enki's: another ring, an inverse-square law that reaches 12 cm, additive noise, 0 where nothing is near.
    #[default]
    Enki,
    /// The one that was learned with.
    Webots,
}

/// Configuration of the miniature road.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MiniatureConfig {
    /// The road is grown from this seed, in the family of the test roads: longer than the training road, with more and
    /// sharper bends.
    pub road_seed: u64,
    /// Red objects that stand on the road, at most [`super::MOST_OBSTACLES`].
    pub obstacles: usize,
    /// The camera.
    pub eye: Eye,
    /// The wheels.
    pub wheels: Wheels,
    /// The infra-red ring.
    pub infrared: InfraredLaw,
    /// Motor steps of an episode.
    pub horizon: usize,
    /// Weights of the motor costs and prices of the looks: those of the highway.
    pub task: Task,
}

impl Default for MiniatureConfig {
    fn default() -> Self {
        Self {
            road_seed: 301,
            obstacles: 6,
            eye: Eye::default(),
            wheels: Wheels::default(),
            infrared: InfraredLaw::default(),
            horizon: 50,
            task: Task::default(),
        }
    }
}

impl MiniatureConfig {
    /// The same road and obstacles with the body that was learned with; only the renderer is another.
    #[must_use]
    pub fn exact() -> Self {
        Self { eye: Eye::exact(), wheels: Wheels::exact(), infrared: InfraredLaw::Webots, ..Self::default() }
    }
}
