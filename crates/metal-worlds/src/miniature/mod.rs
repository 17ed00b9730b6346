//! The road of the paper's Sec. 5, as far as a computer can stand in for it: a road of another shape with red objects
//! that stand still, seen through another renderer, by a body with other wheels and another infra-red ring.
//!
//! The contract is that of the highway: the same sensors, actions, task and prices, so that a mind that learned there can
//! drive here unchanged. What lies between is what lies between a simulator and a robot: see [`config::Eye`],
//! [`config::Wheels`] and [`config::InfraredLaw`]. The colour classification is the one that the robots share.

mod compression;
pub mod config;
mod infrared;
mod renderer;

pub use config::{Eye, InfraredLaw, MiniatureConfig, Wheels};

use crate::highway::camera::{COLUMNS, Region};
use crate::highway::expert::{Knowledge, Paths, advise};
use crate::highway::infrared::Infrared;
use crate::highway::kinematics::{AXLE_M, BODY_RADIUS_M, SUBSTEP_SECS, SUBSTEPS, Twist, advance};
use crate::highway::measures::{self, Touch};
use crate::highway::road::{Direction, LANE_M, Road};
use crate::highway::shape::ShapeRange;
use crate::highway::task::{Facts, MotorCost, Task};
use crate::highway::{
    Class, Ground, HighwayConfig, MotorAction, Pose, RoadSet, Scenario, collision, contract,
};
use metal_rl::environment::{End, Environment, EnvironmentError, EnvironmentSpec, Outcome, Picture};
use metal_rl::random::Streams;
use renderer::{Renderer, Scene};
use std::sync::Arc;

/// Most red objects on the road.
pub const MOST_OBSTACLES: usize = 12;
/// Index of the infra-red sensor, after the six regions.
const INFRARED: usize = 6;
/// Least distance between the learner's start and an object, in metres.
const START_CLEAR_M: f64 = 0.25;
/// Largest distance of an object from the middle of its lane, in metres.
const BESIDE_M: f64 = 0.02;
/// By what the expert multiplies the weights of the motor costs while it compares plans. A car on the highway drives on;
/// an object that stands must be driven around, which costs more within the expert's eight actions than to creep up to it,
/// and who has crept up cannot turn away any more. With the costs' own weights the expert touched an object in 16 of 100
/// episodes, with these in none (ten settings compared on the same 100 episodes).
const EXPERT_WEIGHTS: [f64; 4] = [2.0, 1.0, 0.15, 1.5];

/// What all copies of a world share.
#[derive(Debug)]
struct Shared {
    spec: EnvironmentSpec,
    config: MiniatureConfig,
    ground: Arc<Ground>,
    renderer: Renderer,
    webots: Infrared,
}

/// The miniature road. A clone is an independent world that shares only what never changes.
#[derive(Clone, Debug)]
pub struct Miniature {
    shared: Arc<Shared>,
    episode: Streams,
    learner: Pose,
    obstacles: Vec<Pose>,
    steps: usize,
    last_turn_radps: f64,
    measures: [f64; measures::NAMES.len()],
    /// Classes of the picture of this motor step, once somebody has looked: a camera delivers whole pictures.
    seen: Option<Vec<Class>>,
}

/// The road of a seed, painted.
#[must_use]
pub fn ground(road_seed: u64) -> Arc<Ground> {
    Arc::new(Ground::new(Road::new(road_seed, &ShapeRange::TEST)))
}

impl Miniature {
    /// The miniature road of `config`.
    #[must_use]
    pub fn new(config: MiniatureConfig) -> Self {
        let ground = ground(config.road_seed);
        Self::on(config, ground)
    }

    /// The same on a road that was painted before.
    #[must_use]
    pub fn on(config: MiniatureConfig, ground: Arc<Ground>) -> Self {
        let highway = HighwayConfig {
            horizon: config.horizon,
            task: config.task,
            ..HighwayConfig::new(RoadSet::Test, Scenario::FreeRoad)
        };
        let spec = EnvironmentSpec { id: "Miniature-v0".to_owned(), ..contract(&highway) };
        let renderer = Renderer::new(&config.eye);
        let shared = Shared { spec, config, ground, renderer, webots: Infrared::new() };
        let mut world = Self {
            shared: Arc::new(shared),
            episode: Streams::new(0),
            learner: Pose::default(),
            obstacles: Vec::new(),
            steps: 0,
            last_turn_radps: 0.0,
            measures: [0.0; measures::NAMES.len()],
            seen: None,
        };
        world.begin(0);
        world
    }

    /// Where the learner is.
    #[must_use]
    pub fn learner(&self) -> Pose {
        self.learner
    }

    /// Where the red objects stand.
    #[must_use]
    pub fn obstacles(&self) -> &[Pose] {
        &self.obstacles
    }

    /// The road.
    #[must_use]
    pub fn road(&self) -> &Road {
        self.shared.ground.road()
    }

    /// The learner's picture in colour, row by row (39 rows of 52).
    #[must_use]
    pub fn rgb_image(&self) -> Vec<[u8; 3]> {
        let scene = Scene { ground: &self.shared.ground, eye: self.learner, obstacles: &self.obstacles };
        self.shared.renderer.picture(&scene, self.moment("camera"))
    }

    fn begin(&mut self, seed: u64) {
        self.episode = Streams::new(seed).child("miniature");
        let obstacles = self.scattered();
        self.obstacles = obstacles;
        // Starts are those of the highway's free road, drawn again while an object stands there.
        let starts = self.episode.child("start");
        let mut attempts = (0..).map(|k| Scenario::FreeRoad.start(self.road(), &starts.nth(k)).learner);
        let clear = |pose: &Pose| self.obstacles.iter().all(|o| o.distance_m(pose) > START_CLEAR_M);
        self.learner = attempts.find(clear).unwrap_or_default();
        (self.steps, self.last_turn_radps, self.seen) = (0, 0.0, None);
        let facts = self.facts(Twist::default(), false);
        self.record(&Touch::default(), &facts, &MotorCost::default());
    }

    /// Objects all along the road, in either lane.
    fn scattered(&self) -> Vec<Pose> {
        let mut rng = self.episode.stream("obstacles");
        let (road, count) = (self.road(), self.shared.config.obstacles);
        let place = |k: usize| {
            let arc = (k as f64 + rng.range(0.2, 0.8)) / count as f64 * road.length_m();
            let side = if rng.chance(0.5) { 1.0 } else { -1.0 };
            let offset = side * 0.5 * LANE_M + rng.range(-BESIDE_M, BESIDE_M);
            road.pose_at(arc, offset, Direction::Along)
        };
        (0..count).map(place).collect()
    }

    /// The family of a device's noise in this step.
    fn moment(&self, device: &str) -> Streams {
        self.episode.child(device).nth(self.steps as u64)
    }

    /// What the wheels make of a command in this step.
    fn slipped(&self, commanded: Twist) -> Twist {
        let wheels = &self.shared.config.wheels;
        let mut rng = self.moment("wheels").stream("slip");
        let (left, right) = commanded.wheels_mps();
        let mut way = |speed: f64, bias: f64| {
            speed * (1.0 - wheels.slip) * (1.0 + bias) * (1.0 + wheels.noise * rng.normal())
        };
        let (left, right) = (way(left, -0.5 * wheels.bias), way(right, 0.5 * wheels.bias));
        Twist { speed_mps: 0.5 * (left + right), turn_radps: (right - left) / AXLE_M }
    }

    /// Moves the learner for one substep and notes its contacts; objects stay where they are.
    fn substep(&mut self, twist: Twist, touch: &mut Touch) {
        let before = self.learner;
        self.learner = advance(before, twist, SUBSTEP_SECS);
        for obstacle in &self.obstacles {
            let mut pair = [self.learner, *obstacle];
            collision::settle(&[before, *obstacle], &mut pair, |_| {
                touch.contact = true;
                touch.fault = true;
                touch.bearing_rad = before.bearing_rad(obstacle);
            });
            self.learner = pair[0];
        }
    }

    fn facts(&self, commanded: Twist, contact: bool) -> Facts {
        let body = &self.learner;
        let place = self.road().locate(body.x_m, body.y_m);
        let gaps = self.obstacles.iter().map(|o| o.distance_m(body) - 2.0 * BODY_RADIUS_M);
        Facts {
            contact,
            gap_m: gaps.fold(f64::INFINITY, f64::min),
            offset_m: place.direction(body.heading_rad).sign() * place.offset_m,
            speed_mps: commanded.speed_mps,
            turn_radps: commanded.turn_radps,
            last_turn_radps: self.last_turn_radps,
        }
    }

    fn record(&mut self, touch: &Touch, facts: &Facts, cost: &MotorCost) {
        let place = self.road().locate(self.learner.x_m, self.learner.y_m);
        self.measures = measures::collect(&self.learner, &place, touch, facts, cost);
    }

    /// Classes of the whole picture of this step.
    fn classes(&self) -> Vec<Class> {
        let thresholds = &self.shared.config.eye.thresholds;
        self.rgb_image().into_iter().map(|rgb| thresholds.classify(rgb)).collect()
    }
}

impl Environment for Miniature {
    fn spec(&self) -> &EnvironmentSpec {
        &self.shared.spec
    }

    fn reset(&mut self, seed: u64) -> Result<(), EnvironmentError> {
        self.begin(seed);
        Ok(())
    }

    fn sense(&mut self, sensor: usize, out: &mut [f64]) -> Result<(), EnvironmentError> {
        if sensor == INFRARED {
            let moment = self.moment("infrared");
            match self.shared.config.infrared {
                InfraredLaw::Enki => infrared::read(&self.learner, &self.obstacles, moment, out),
                InfraredLaw::Webots => self.shared.webots.read(&self.learner, &self.obstacles, moment, out),
            }
            return Ok(());
        }
        if self.seen.is_none() {
            self.seen = Some(self.classes());
        }
        let window = Region::ALL[sensor].window();
        let classes = self.seen.as_deref().unwrap_or_default();
        let mut counts = [0_u32; 4];
        for row in window.top..window.bottom {
            let part = &classes[row * COLUMNS + window.left..row * COLUMNS + window.right];
            part.iter().for_each(|&class| counts[class as usize] += 1);
        }
        let pixels = window.pixels() as f64;
        out.iter_mut().zip(counts).for_each(|(share, count)| *share = f64::from(count) / pixels);
        Ok(())
    }

    /// Carries out one motor action.
    ///
    /// # Panics
    /// If `action` is not one of the five of Eq. (12).
    fn step(&mut self, action: usize) -> Result<Outcome, EnvironmentError> {
        let commanded = MotorAction::ALL[action].twist();
        let real = self.slipped(commanded);
        let mut touch = Touch::default();
        for _ in 0..SUBSTEPS {
            self.substep(real, &mut touch);
        }
        self.steps += 1;
        self.seen = None;
        let facts = self.facts(commanded, touch.contact);
        let cost = self.shared.config.task.motor_cost(&facts);
        self.record(&touch, &facts, &cost);
        self.last_turn_radps = commanded.turn_radps;
        let end = if self.steps >= self.shared.config.horizon { End::TimeLimit } else { End::Running };
        Ok(Outcome { motor_reward: -cost.total(), end })
    }

    fn measures(&self) -> &[f64] {
        &self.measures
    }

    fn picture(&self) -> Option<Picture> {
        Some(Picture { columns: COLUMNS, pixels: self.rgb_image() })
    }

    /// The expert knows the road and the two nearest objects; of slip it knows nothing, as a person would not.
    fn advise(&mut self) -> Option<usize> {
        let mut near = self.obstacles.clone();
        near.sort_by(|a, b| a.distance_m(&self.learner).total_cmp(&b.distance_m(&self.learner)));
        let task = &self.shared.config.task;
        let weights = std::array::from_fn(|k| EXPERT_WEIGHTS[k] * task.weights[k]);
        Some(advise(&Knowledge {
            road: self.road(),
            task: &Task { weights, ..*task },
            learner: self.learner,
            last_turn_radps: self.last_turn_radps,
            paths: Paths::predict(&near, |_, _| Twist::default()),
        }) as usize)
    }

    fn fork(&self) -> Option<Box<dyn Environment>> {
        Some(Box::new(self.clone()))
    }
}

#[cfg(test)]
mod tests;
