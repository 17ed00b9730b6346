//! The only place where names become worlds.

use crate::traffic;
use metal_rl::environment::Environment;
use metal_worlds::highway::{Ground, Highway, HighwayConfig, RoadSet, Scenario, Steering};
use metal_worlds::maze::{Maze, MazeConfig};
use metal_worlds::puddle::{Puddle, PuddleConfig};
use metal_worlds::toy::Toy;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

pub use metal_worlds::highway::RoadSet as Roads;

/// A world and its settings, as written in an experiment file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EnvironmentConfig {
    /// The miniature two-lane highway of the paper (`Highway-v0`).
    Highway(HighwayConfig),
    /// The same among scripted cars, where the traffic of `Highway-v0` learned to drive.
    HighwayScripted(HighwayConfig),
    /// The maze of Eq. (14) with its two tiny agents, X and Y.
    Maze(MazeConfig),
    /// Puddle world: the usual proving ground of continuous reinforcement learning.
    Puddle(PuddleConfig),
    /// Seven experts and one move: attention control with a known optimum.
    Toy(NoSettings),
}

/// A world without settings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NoSettings {}

/// Why a world could not be built.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct WorldError(pub String);

/// The scenario of worlds that have only one.
const ONLY: &str = "mix";

impl EnvironmentConfig {
    /// The world itself.
    ///
    /// # Errors
    /// If its settings are impossible.
    pub fn build(&self) -> Result<Box<dyn Environment>, WorldError> {
        let refuse = |e: &dyn std::fmt::Display| WorldError(e.to_string());
        Ok(match self {
            Self::Highway(config) => Box::new(highway(config, traffic::steering())),
            Self::HighwayScripted(config) => Box::new(highway(config, Steering::Scripted)),
            Self::Maze(config) => Box::new(Maze::new(config.clone()).map_err(|e| refuse(&e))?),
            Self::Puddle(config) => Box::new(Puddle::new(config)),
            Self::Toy(_) => Box::new(Toy::new()),
        })
    }

    /// Names of its scenarios, the one of learning first.
    #[must_use]
    pub fn scenarios(&self) -> Vec<String> {
        match self {
            Self::Highway(_) | Self::HighwayScripted(_) => {
                Scenario::ALL.iter().map(|s| s.name().to_owned()).collect()
            }
            _ => vec![ONLY.to_owned()],
        }
    }

    /// The scenario that is learned in.
    #[must_use]
    pub fn training_scenario(&self) -> String {
        match self {
            Self::Highway(config) | Self::HighwayScripted(config) => config.scenario.name().to_owned(),
            _ => ONLY.to_owned(),
        }
    }

    /// Switches the scenario, where there are several and `name` is one of them.
    pub fn set_scenario(&mut self, name: &str) {
        if let Self::Highway(config) | Self::HighwayScripted(config) = self {
            if let Some(scenario) = Scenario::ALL.iter().find(|s| s.name() == name) {
                config.scenario = *scenario;
            }
        }
    }

    /// Moves to other roads, where there are roads.
    pub fn set_roads(&mut self, roads: &RoadSet) {
        if let Self::Highway(config) | Self::HighwayScripted(config) = self {
            config.roads = roads.clone();
        }
    }

    /// The settings of the highway and who drives its red cars, if this world is a highway.
    #[must_use]
    pub fn as_highway(&self) -> Option<(&HighwayConfig, Steering)> {
        match self {
            Self::Highway(config) => Some((config, traffic::steering())),
            Self::HighwayScripted(config) => Some((config, Steering::Scripted)),
            _ => None,
        }
    }

    /// The kinds of roads a full test drives on.
    #[must_use]
    pub fn road_sets(&self) -> Vec<RoadSet> {
        match self {
            Self::Highway(_) | Self::HighwayScripted(_) => {
                vec![RoadSet::Training, RoadSet::Validation, RoadSet::Test]
            }
            _ => vec![RoadSet::Training],
        }
    }
}

/// The highway as its own type: figures draw it. Roads are built once in the life of the program.
#[must_use]
pub fn highway(config: &HighwayConfig, steering: Steering) -> Highway {
    static ROADS: Mutex<BTreeMap<String, Arc<[Ground]>>> = Mutex::new(BTreeMap::new());
    let mut built = ROADS.lock().unwrap_or_else(PoisonError::into_inner);
    let grounds = built.entry(roads_name(&config.roads)).or_insert_with(|| config.roads.build()).clone();
    drop(built);
    Highway::on_roads(config.clone(), grounds, steering)
}

/// Name of a set of roads in results and on the command line.
#[must_use]
pub fn roads_name(roads: &RoadSet) -> String {
    match roads {
        RoadSet::Training => "training".to_owned(),
        RoadSet::Validation => "validation".to_owned(),
        RoadSet::Test => "test".to_owned(),
        RoadSet::Seeds(seeds) => {
            let seeds: Vec<String> = seeds.iter().map(u64::to_string).collect();
            format!("seeds:{}", seeds.join(","))
        }
    }
}
