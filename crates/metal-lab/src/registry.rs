//! The only place where names become worlds.

use crate::traffic;
use metal_recording::Replay;
use metal_rl::environment::Environment;
use metal_worlds::faulty::{Faults, Faulty};
use metal_worlds::highway::camera::{COLUMNS, LARGEST_PATCH, ROWS};
use metal_worlds::highway::classify::ColourThresholds;
use metal_worlds::highway::senses::MOST_CELLS;
use metal_worlds::highway::{
    Grid, Ground, Highway, HighwayConfig, Pixels, RgbConfig, RoadSet, Scenario, Senses, Steering, Task,
};
use metal_worlds::maze::{Maze, MazeConfig};
use metal_worlds::miniature::{self, Eye, MOST_OBSTACLES, Miniature, MiniatureConfig, Wheels};
use metal_worlds::priced::Priced;
use metal_worlds::puddle::{Puddle, PuddleConfig};
use metal_worlds::tabular::{CubeConfig, CubeNmConfig, Data, Tabular, Verdict, cube, cube_nm};
use metal_worlds::toy::Toy;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::PathBuf;
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
    /// The road of Sec. 5: another shape, red objects that stand, another renderer and another body (`Miniature-v0`).
    Miniature(MiniatureConfig),
    /// The maze of Eq. (14) with its two tiny agents, X and Y.
    Maze(MazeConfig),
    /// Puddle world: the usual proving ground of continuous reinforcement learning.
    Puddle(PuddleConfig),
    /// Seven experts and one move: attention control with a known optimum.
    Toy(NoSettings),
    /// CUBE: classification with 20 features that cost (`Cube-v0`).
    Cube(CubeConfig),
    /// CUBE-NM: the same in five contexts, which must be bought, too (`CubeNM-v0`).
    CubeNm(CubeNmConfig),
    /// Any of these behind sensors that fail.
    Faulty(FaultyConfig),
    /// Any of these at other prices of looking.
    Priced(PricedConfig),
    /// A recording (MCAP), of a simulation or of a robot.
    Replay(ReplayConfig),
}

/// A recording as a world: it shows what was seen and goes on with what was done then, whatever a mind does now.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReplayConfig {
    /// The recording, from the folder in which `metal` is started.
    pub file: PathBuf,
}

/// A world and what is wrong with its sensors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FaultyConfig {
    /// The world behind the sensors.
    pub world: Box<EnvironmentConfig>,
    /// What is wrong.
    pub faults: Faults,
}

/// A world whose looks cost more, or less.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PricedConfig {
    /// The world itself.
    pub world: Box<EnvironmentConfig>,
    /// What every price is multiplied by, finite, ≥ 0.
    pub factor: f64,
}

/// A world without settings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NoSettings {}

/// Why a world could not be built.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{field}: {message}")]
pub struct WorldError {
    /// Dotted path of the field below `environment`, e.g. `highway.horizon`.
    pub field: String,
    /// What was found and what is allowed.
    pub message: String,
}

/// Longest episode, in motor steps.
const LONGEST: usize = 100_000;

/// The scenario of worlds that have only one.
const ONLY: &str = "mix";

impl EnvironmentConfig {
    /// The world itself.
    ///
    /// # Errors
    /// If its settings are impossible.
    pub fn build(&self) -> Result<Box<dyn Environment>, WorldError> {
        self.check()?;
        Ok(match self {
            Self::Highway(config) => Box::new(highway(config, traffic::steering())),
            Self::HighwayScripted(config) => Box::new(highway(config, Steering::Scripted)),
            Self::Miniature(config) => Box::new(miniature(config)),
            Self::Maze(config) => Box::new(Maze::new(config.clone()).map_err(|e| refuse("maze", e))?),
            Self::Puddle(config) => Box::new(Puddle::new(config)),
            Self::Toy(_) => Box::new(Toy::new()),
            Self::Cube(config) => Box::new(table(cube(config))),
            Self::CubeNm(config) => Box::new(table(cube_nm(config))),
            Self::Replay(config) => {
                let found = Replay::open(&config.file);
                let named = |e| refuse("replay.file", format!("{}: {e}", config.file.display()));
                Box::new(found.map_err(named)?.stubborn())
            }
            Self::Faulty(config) => {
                let broken = Faulty::new(config.world.build()?, config.faults.clone());
                Box::new(broken.map_err(|e| refuse(format!("faulty.faults.{}", e.field), e.message))?)
            }
            Self::Priced(config) => Box::new(Priced::new(config.world.build()?, config.factor)),
        })
    }

    /// Refuses settings that no world can be built from.
    fn check(&self) -> Result<(), WorldError> {
        match self {
            Self::Highway(config) => check_highway("highway", config),
            Self::HighwayScripted(config) => check_highway("highway_scripted", config),
            Self::Miniature(config) => check_miniature("miniature", config),
            Self::Maze(config) if config.side > 1000 => {
                Err(refuse("maze.side", format!("{}: at most 1000", config.side)))
            }
            Self::Puddle(config) => {
                check_horizon("puddle", config.horizon)?;
                check_prices("puddle.position_price", &[config.position_price])?;
                check_prices("puddle.coordinate_price", &[config.coordinate_price])
            }
            Self::Cube(c) => check_cube("cube", c.rows, &[c.look_price, c.informative_sd, c.noise_sd]),
            Self::CubeNm(c) => {
                let numbers = [c.look_price, c.informative_sd, c.noise_sd, c.context_sd];
                check_cube("cube_nm", c.rows, &numbers)?;
                if (2..=5).contains(&c.contexts) {
                    return Ok(());
                }
                Err(refuse("cube_nm.contexts", format!("{}: 2 to 5", c.contexts)))
            }
            // Their worlds are checked when they are built. Files nest as deep as somebody types, worlds do not.
            Self::Faulty(config) if matches!(*config.world, Self::Faulty(_)) => {
                Err(refuse("faulty.world", "faulty: faults of faults are not to be had"))
            }
            Self::Priced(config) if config.world.behind().is_some() => {
                Err(refuse("priced.world", "a world itself, not one behind faults or other prices"))
            }
            Self::Priced(config) => check_prices("priced.factor", &[config.factor]),
            Self::Maze(_) | Self::Toy(_) | Self::Faulty(_) | Self::Replay(_) => Ok(()),
        }
    }

    /// The world behind faults or other prices.
    fn behind(&self) -> Option<&Self> {
        match self {
            Self::Faulty(config) => Some(&config.world),
            Self::Priced(config) => Some(&config.world),
            _ => None,
        }
    }

    /// The same, to be changed: itself if nothing is in front of it.
    fn innermost_mut(&mut self) -> &mut Self {
        match self {
            Self::Faulty(FaultyConfig { world, .. }) | Self::Priced(PricedConfig { world, .. }) => {
                world.innermost_mut()
            }
            itself => itself,
        }
    }

    /// Names of its scenarios, the one of learning first.
    #[must_use]
    pub fn scenarios(&self) -> Vec<String> {
        match (self, self.behind()) {
            (_, Some(world)) => world.scenarios(),
            (Self::Highway(_) | Self::HighwayScripted(_), _) => {
                Scenario::ALL.iter().map(|s| s.name().to_owned()).collect()
            }
            _ => vec![ONLY.to_owned()],
        }
    }

    /// The scenario that is learned in.
    #[must_use]
    pub fn training_scenario(&self) -> String {
        match (self, self.behind()) {
            (_, Some(world)) => world.training_scenario(),
            (Self::Highway(config) | Self::HighwayScripted(config), _) => config.scenario.name().to_owned(),
            _ => ONLY.to_owned(),
        }
    }

    /// Switches the scenario, where there are several and `name` is one of them.
    pub fn set_scenario(&mut self, name: &str) {
        let known = Scenario::ALL.iter().find(|s| s.name() == name);
        let world = self.innermost_mut();
        if let (Self::Highway(config) | Self::HighwayScripted(config), Some(scenario)) = (world, known) {
            config.scenario = *scenario;
        }
    }

    /// The same world with `faults` in front of its sensors instead of those it had.
    #[must_use]
    pub fn with_faults(self, faults: Faults) -> Self {
        let world = match self {
            Self::Faulty(config) => config.world,
            world => Box::new(world),
        };
        Self::Faulty(FaultyConfig { world, faults })
    }

    /// The same world with looks at `factor` times their price.
    #[must_use]
    pub fn at_prices(self, factor: f64) -> Self {
        match self {
            Self::Priced(config) => Self::Priced(PricedConfig { factor: config.factor * factor, ..config }),
            Self::Faulty(config) => {
                let world = Box::new(config.world.at_prices(factor));
                Self::Faulty(FaultyConfig { world, ..config })
            }
            world => Self::Priced(PricedConfig { world: Box::new(world), factor }),
        }
    }

    /// Lets episodes last so many times as long, where their length is a setting.
    #[must_use]
    pub fn for_longer(mut self, times: usize) -> Self {
        match self.innermost_mut() {
            Self::Highway(HighwayConfig { horizon, .. })
            | Self::HighwayScripted(HighwayConfig { horizon, .. })
            | Self::Miniature(MiniatureConfig { horizon, .. })
            | Self::Puddle(PuddleConfig { horizon, .. }) => {
                *horizon = horizon.saturating_mul(times).min(LONGEST)
            }
            _ => {}
        }
        self
    }

    /// Moves to other roads, where there are roads.
    pub fn set_roads(&mut self, roads: &RoadSet) {
        if let Self::Highway(config) | Self::HighwayScripted(config) = self.innermost_mut() {
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
        match (self, self.behind()) {
            (_, Some(world)) => world.road_sets(),
            (Self::Highway(_) | Self::HighwayScripted(_), _) => {
                vec![RoadSet::Training, RoadSet::Validation, RoadSet::Test]
            }
            _ => vec![RoadSet::Training],
        }
    }
}

fn refuse(field: impl Into<String>, message: impl ToString) -> WorldError {
    WorldError { field: field.into(), message: message.to_string() }
}

fn check_horizon(world: &str, horizon: usize) -> Result<(), WorldError> {
    if (1..=LONGEST).contains(&horizon) {
        return Ok(());
    }
    Err(refuse(format!("{world}.horizon"), format!("{horizon}: between 1 and {LONGEST} motor steps")))
}

fn check_prices(field: &str, prices: &[f64]) -> Result<(), WorldError> {
    match prices.iter().find(|p| !(p.is_finite() && **p >= 0.0)) {
        Some(price) => Err(refuse(field, format!("{price}: finite and at least 0"))),
        None => Ok(()),
    }
}

/// Most rows of a generated table.
const MOST_ROWS: usize = 1_000_000;

fn check_cube(world: &str, rows: usize, numbers: &[f64]) -> Result<(), WorldError> {
    if !(2..=MOST_ROWS).contains(&rows) {
        return Err(refuse(format!("{world}.rows"), format!("{rows}: 2 to {MOST_ROWS}")));
    }
    check_prices(world, numbers)
}

/// A generated table, all of it.
fn table(data: Data) -> Tabular {
    let rows = (0..data.labels.len()).collect();
    Tabular::new(Arc::new(data), rows, Verdict::default())
}

/// Red cars drive at most this many times as fast as they learned to.
const FASTEST_CARS: f64 = 4.0;

fn check_highway(world: &str, config: &HighwayConfig) -> Result<(), WorldError> {
    check_horizon(world, config.horizon)?;
    check_task(world, &config.task)?;
    if config.roads == RoadSet::Seeds(Vec::new()) {
        return Err(refuse(format!("{world}.roads.seeds"), "empty: at least one road"));
    }
    if !(0.0..=FASTEST_CARS).contains(&config.car_speed) {
        let message = format!("{}: in [0, {FASTEST_CARS}] times the usual", config.car_speed);
        return Err(refuse(format!("{world}.car_speed"), message));
    }
    check_senses(world, config.senses)?;
    match &config.pixels {
        Pixels::Classes => Ok(()),
        Pixels::Rgb(rgb) => check_rgb(&format!("{world}.pixels.rgb"), rgb),
    }
}

fn check_senses(world: &str, senses: Senses) -> Result<(), WorldError> {
    let grid = match senses {
        Senses::Regions => return Ok(()),
        Senses::Truth { price, .. } => return check_prices(&format!("{world}.senses.truth.price"), &[price]),
        Senses::Cells(grid) => grid,
    };
    if grid.is_possible() {
        return Ok(());
    }
    let Grid { columns, rows } = grid;
    let message = format!(
        "{columns} columns of {rows}: at most {MOST_CELLS} cells, each with a pixel and at most {LARGEST_PATCH} of \
         {COLUMNS} × {ROWS}, e.g. 6 columns of 4"
    );
    Err(refuse(format!("{world}.senses.cells"), message))
}

fn check_task(world: &str, task: &Task) -> Result<(), WorldError> {
    let [.., smooth] = task.weights;
    let heavier = |w: &[f64]| w[0] >= w[1] && w[1] > 0.0 && w[0].is_finite();
    if !(task.weights[..3].windows(2).all(heavier) && smooth >= 0.0 && smooth.is_finite()) {
        let message =
            format!("{:?}: finite, above 0, and the graver the larger (smoothness may be 0)", task.weights);
        return Err(refuse(format!("{world}.task.weights"), message));
    }
    check_prices(&format!("{world}.task.prices"), &task.prices)
}

fn check_miniature(world: &str, config: &MiniatureConfig) -> Result<(), WorldError> {
    check_horizon(world, config.horizon)?;
    check_task(world, &config.task)?;
    if config.obstacles > MOST_OBSTACLES {
        let message = format!("{}: at most {MOST_OBSTACLES}", config.obstacles);
        return Err(refuse(format!("{world}.obstacles"), message));
    }
    let (Eye { light_gradient, vignetting, noise, compression, pitch_error_rad, thresholds }, wheels) =
        (config.eye, config.wheels);
    check_thresholds(&format!("{world}.eye.thresholds"), &thresholds)?;
    let Wheels { slip, bias, noise: wheel_noise } = wheels;
    let rows = [
        ("eye.light_gradient", light_gradient, 0.0, 0.9),
        ("eye.vignetting", vignetting, 0.0, 1.0),
        ("eye.noise", noise, 0.0, 1.0),
        ("eye.compression", compression, 0.0, 64.0),
        ("eye.pitch_error_rad", pitch_error_rad, -0.3, 0.3),
        ("wheels.slip", slip, 0.0, 0.9),
        ("wheels.bias", bias, -0.5, 0.5),
        ("wheels.noise", wheel_noise, 0.0, 0.5),
    ];
    match rows.iter().find(|(_, value, least, most)| !(least..=most).contains(&value)) {
        Some((name, value, least, most)) => {
            Err(refuse(format!("{world}.{name}"), format!("{value}: in [{least}, {most}]")))
        }
        None => Ok(()),
    }
}

fn check_rgb(field: &str, rgb: &RgbConfig) -> Result<(), WorldError> {
    check_thresholds(&format!("{field}.thresholds"), &rgb.thresholds)?;
    check_shares(field, &[("light", rgb.light, 100.0), ("noise", rgb.noise, 1.0), ("blur", rgb.blur, 0.75)])
}

fn check_thresholds(field: &str, t: &ColourThresholds) -> Result<(), WorldError> {
    let rows = [
        ("dark_below", t.dark_below, 1.0),
        ("grey_below", t.grey_below, 1.0),
        ("white_from", t.white_from, 1.0),
        ("red_within_deg", t.red_within_deg, 180.0),
    ];
    check_shares(field, &rows)
}

/// Each number at least 0 and at most what stands beside it.
fn check_shares(field: &str, rows: &[(&str, f64, f64)]) -> Result<(), WorldError> {
    match rows.iter().find(|(_, value, most)| !(0.0..=*most).contains(value)) {
        Some((name, value, most)) => {
            Err(refuse(format!("{field}.{name}"), format!("{value}: in [0, {most}]")))
        }
        None => Ok(()),
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

/// The miniature road; each road is built once in the life of the program.
fn miniature(config: &MiniatureConfig) -> Miniature {
    static ROADS: Mutex<BTreeMap<u64, Arc<Ground>>> = Mutex::new(BTreeMap::new());
    let mut built = ROADS.lock().unwrap_or_else(PoisonError::into_inner);
    let ground = built.entry(config.road_seed).or_insert_with(|| miniature::ground(config.road_seed)).clone();
    drop(built);
    Miniature::on(config.clone(), ground)
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
