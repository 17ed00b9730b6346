//! What a user may choose about the highway.

use super::ground::RoadSet;
use super::rgb::RgbConfig;
use super::scenario::Scenario;
use super::senses::Senses;
use super::task::Task;
use serde::{Deserialize, Serialize};

/// How the camera's features come about.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Pixels {
    /// Every pixel's class is looked up directly: the fast path.
    #[default]
    Classes,
    /// A colour picture is made and classified, as on a robot.
    Rgb(RgbConfig),
}

/// Configuration of the highway. The default is the paper's training: its one road, the mix, 50 steps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct HighwayConfig {
    /// Roads to drive on.
    pub roads: RoadSet,
    /// What the episodes are about.
    pub scenario: Scenario,
    /// How the camera's features come about.
    pub pixels: Pixels,
    /// Motor steps of an episode (Table 2: 50).
    pub horizon: usize,
    /// Weights of the motor costs and prices of the looks.
    pub task: Task,
    /// How fast the red cars drive, as a multiple of their speed in `Highway-v0`: 1 unless somebody tries how a mind
    /// takes to other traffic (Sec. 6.2).
    #[serde(skip_serializing_if = "is_usual")]
    pub car_speed: f64,
    /// How the learner's sensors are cut: as in the paper unless somebody wants them cut otherwise.
    #[serde(skip_serializing_if = "Senses::is_usual")]
    pub senses: Senses,
}

/// Files and contracts stay as they were where nobody asked for other traffic.
fn is_usual(car_speed: &f64) -> bool {
    car_speed.total_cmp(&1.0).is_eq()
}

impl Default for HighwayConfig {
    fn default() -> Self {
        Self {
            roads: RoadSet::default(),
            scenario: Scenario::default(),
            pixels: Pixels::default(),
            horizon: 50,
            task: Task::default(),
            car_speed: 1.0,
            senses: Senses::default(),
        }
    }
}

impl HighwayConfig {
    /// The default with these roads and this scenario.
    #[must_use]
    pub fn new(roads: RoadSet, scenario: Scenario) -> Self {
        Self { roads, scenario, ..Self::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::de::value::{Error, MapDeserializer};

    fn read(key: &'static str) -> Result<HighwayConfig, Error> {
        HighwayConfig::deserialize(MapDeserializer::new([(key, 20_usize)].into_iter()))
    }

    #[test]
    fn what_is_left_out_is_the_papers_and_a_misspelt_field_is_refused() {
        assert_eq!(read("horizon").unwrap(), HighwayConfig { horizon: 20, ..HighwayConfig::default() });
        assert!(read("horizont").unwrap_err().to_string().contains("horizon"));
    }
}
