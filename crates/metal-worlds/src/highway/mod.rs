//! The miniature two-lane highway of Secs. 4.1-4.4: an E-puck that learns to drive among two red ones.
//!
//! Six camera regions (black, white, red, green fractions) and a ring of infra-red sensors, five motor actions,
//! the hierarchical motor cost of Fig. 7a and the prices of Fig. 7b.

mod blocks;
pub mod camera;
pub mod classify;
mod clearance;
pub mod collision;
pub mod config;
mod decided;
pub mod expert;
pub mod ground;
pub mod infrared;
pub mod kinematics;
pub mod measures;
pub mod pose;
mod raster;
pub mod rgb;
pub mod road;
pub mod scenario;
pub mod senses;
pub mod shape;
mod sight;
pub mod task;
pub mod traffic;
pub mod truth;

pub use config::{HighwayConfig, Pixels};
pub use ground::{Class, Ground, Material, RoadSet};
pub use kinematics::MotorAction;
pub use pose::Pose;
pub use rgb::RgbConfig;
pub use road::{Outline, Road};
pub use scenario::{Scenario, Situation, Start};
pub use senses::{Grid, Senses};
pub use task::Task;
pub use traffic::{Driver, Steering, VISION};

use camera::{COLUMNS, Camera, Obstacle, Patch, ROWS, Region, Scene, Window};
use decided::{Decided, View};
use infrared::Infrared;
use kinematics::{BODY_RADIUS_M, SUBSTEP_SECS, SUBSTEPS, Twist, advance};
use measures::Touch;
use metal_rl::environment::{
    End, Environment, EnvironmentError, EnvironmentSpec, Feature, Outcome, Picture, SensorSpec,
};
use metal_rl::random::Streams;
use senses::{Organ, organs};
use std::sync::Arc;
use task::Facts;
use traffic::CARS;

/// Bodies: the learner first, then the red cars.
const BODIES: usize = 1 + CARS;

/// A sensor of the learner, ready to be read.
#[derive(Clone, Debug)]
enum Sense {
    Area(Box<Patch>),
    Ring,
    Proximity(usize),
    Truth(truth::Told),
}

/// What all copies of a world share.
#[derive(Debug)]
struct Shared {
    spec: EnvironmentSpec,
    config: HighwayConfig,
    grounds: Arc<[Ground]>,
    camera: Camera,
    infrared: Infrared,
    /// The learner's sensors, in the order of the contract.
    senses: Vec<Sense>,
    steering: Steering,
    decided: Decided,
}

/// Where the learner is put when the red cars are to drive as if it was not there: no camera sees so far.
const OUT_OF_SIGHT_M: f64 = 100.0;

/// The highway. A clone is an independent world that shares only what never changes.
#[derive(Clone, Debug)]
pub struct Highway {
    shared: Arc<Shared>,
    episode: Streams,
    road: usize,
    bodies: [Pose; BODIES],
    body_count: usize,
    steps: usize,
    last_turn_radps: f64,
    measures: [f64; measures::NAMES.len()],
}

impl Highway {
    /// The highway of `config`, its red cars driven by `steering`. Building the roads takes some 0.1 s each; to make
    /// many worlds, clone one.
    ///
    /// # Panics
    /// If the list of road seeds is empty, or the picture cannot be cut as configured ([`Grid::is_possible`]).
    #[must_use]
    pub fn new(config: HighwayConfig, steering: Steering) -> Self {
        let grounds = config.roads.build();
        Self::on_roads(config, grounds, steering)
    }

    /// The same on roads that were built before (`config.roads` only says which they are).
    ///
    /// # Panics
    /// If the picture cannot be cut as configured ([`Grid::is_possible`]).
    #[must_use]
    pub fn on_roads(config: HighwayConfig, grounds: Arc<[Ground]>, steering: Steering) -> Self {
        let camera = Camera::new();
        let shared = Shared {
            spec: contract(&config),
            senses: senses(&config, &camera),
            config,
            grounds,
            camera,
            infrared: Infrared::new(),
            steering,
            decided: Decided::default(),
        };
        let mut world = Self {
            shared: Arc::new(shared),
            episode: Streams::new(0),
            road: 0,
            bodies: [Pose::default(); BODIES],
            body_count: 1,
            steps: 0,
            last_turn_radps: 0.0,
            measures: [0.0; measures::NAMES.len()],
        };
        world.begin(0);
        world
    }

    /// The roads, to be shared with [`Self::on_roads`].
    #[must_use]
    pub fn grounds(&self) -> Arc<[Ground]> {
        Arc::clone(&self.shared.grounds)
    }

    /// The road of this episode.
    #[must_use]
    pub fn road(&self) -> &Road {
        self.ground().road()
    }

    /// Where the learner is.
    #[must_use]
    pub fn learner(&self) -> Pose {
        self.bodies[0]
    }

    /// Where the red cars are.
    #[must_use]
    pub fn cars(&self) -> &[Pose] {
        &self.bodies[1..self.body_count]
    }

    /// Begins the episode `seed` on its road in a situation of Table 1 instead of the scenario.
    pub fn reset_to(&mut self, seed: u64, situation: Situation) {
        self.begin(seed);
        self.place(&situation.start(self.road()));
    }

    /// Puts everybody where `start` says; the episode begins anew on the same road.
    pub fn place(&mut self, start: &Start) {
        self.bodies[0] = start.learner;
        self.bodies[1..].copy_from_slice(&start.cars);
        self.body_count = 1 + start.car_count;
        self.steps = 0;
        self.last_turn_radps = 0.0;
        let facts = self.facts(Twist::default(), false);
        self.record(&Touch::default(), &facts, &task::MotorCost::default());
    }

    /// The learner's whole picture in classes, row by row (39 rows of 52).
    #[must_use]
    pub fn class_image(&self) -> Vec<Class> {
        let mut image = vec![Class::Green; ROWS * COLUMNS];
        self.with_learners_scene(|scene| {
            self.see_classes(scene, Window::WHOLE, |index, class| image[index] = class);
        });
        image
    }

    /// The learner's whole picture in colour, row by row; sharp and without noise unless configured otherwise.
    #[must_use]
    pub fn rgb_image(&self) -> Vec<[u8; 3]> {
        let config = match self.shared.config.pixels {
            Pixels::Classes => RgbConfig::default(),
            Pixels::Rgb(config) => config,
        };
        let mut image = vec![[0; 3]; ROWS * COLUMNS];
        self.with_learners_scene(|scene| {
            let noise = self.moment("camera");
            rgb::render(&self.shared.camera, scene, (&config, noise), Window::WHOLE, |i, c| image[i] = c);
        });
        image
    }

    /// Writes which shares of a patch show each class.
    fn look(&self, patch: &Patch, out: &mut [f64]) {
        let mut counts = [0_u32; 4];
        self.with_learners_scene(|scene| {
            if self.shared.config.pixels == Pixels::Classes {
                counts = self.shared.camera.count_patch(scene, patch);
            } else {
                self.see_classes(scene, patch.window(), |_, class| counts[class as usize] += 1);
            }
        });
        fractions(counts, patch.window(), out);
    }

    fn ground(&self) -> &Ground {
        &self.shared.grounds[self.road]
    }

    fn begin(&mut self, seed: u64) {
        self.episode = Streams::new(seed).child("highway");
        self.road = self.episode.stream("road").below(self.shared.grounds.len());
        let start = self.shared.config.scenario.start(self.road(), &self.episode);
        self.place(&start);
    }

    /// The family of a device's noise in this step: a reading depends on the episode, the step and the device only.
    fn moment(&self, device: &str) -> Streams {
        self.episode.child(device).nth(self.steps as u64)
    }

    fn with_learners_scene(&self, look: impl FnOnce(&Scene)) {
        let mut obstacles = [obstacle(&self.bodies[0], Material::RedBody); CARS];
        for (obstacle, car) in obstacles.iter_mut().zip(self.cars()) {
            (obstacle.x_m, obstacle.y_m) = (car.x_m, car.y_m);
        }
        let obstacles = &obstacles[..self.cars().len()];
        look(&Scene { ground: self.ground(), eye: self.bodies[0], obstacles });
    }

    /// Classes of the learner's pixels, by the configured path.
    fn see_classes(&self, scene: &Scene, window: Window, mut see: impl FnMut(usize, Class)) {
        let camera = &self.shared.camera;
        match &self.shared.config.pixels {
            Pixels::Classes => camera.render(scene, window, |i, material| see(i, material.class())),
            Pixels::Rgb(config) => {
                let noise = self.moment("camera");
                rgb::render(camera, scene, (config, noise), window, |i, c| {
                    see(i, config.thresholds.classify(c));
                });
            }
        }
    }

    /// What a red car does among `bodies`: it sees other red cars as red, the learner as black. Its camera is always
    /// the fast path.
    fn cars_choice(&self, car: usize, bodies: &[Pose; BODIES], driver: &dyn Driver) -> MotorAction {
        let mut obstacles = [obstacle(&bodies[0], Material::GreyBody); CARS];
        let mut count = 1;
        for other in (1..self.body_count).filter(|&other| other != car) {
            obstacles[count] = obstacle(&bodies[other], Material::RedBody);
            count += 1;
        }
        let scene = Scene { ground: self.ground(), eye: bodies[car], obstacles: &obstacles[..count] };
        let look_and_think = || MotorAction::ALL[driver.drive(&self.cars_vision(&scene))];
        if !driver.decides_by_sight() {
            return look_and_think();
        }
        let mut seen = [None; CARS];
        for (place, in_sight) in seen.iter_mut().zip(self.shared.camera.bodies_in_sight(&scene)) {
            *place = in_sight.map(|body| [body.x_m, body.y_m]);
        }
        self.shared.decided.or_decide(&View::new(self.road, scene.eye, seen), look_and_think)
    }

    fn cars_vision(&self, scene: &Scene) -> [f64; VISION] {
        let mut vision = [0.0; VISION];
        let counts = self.shared.camera.count_all(scene);
        for ((region, counts), out) in Region::ALL.into_iter().zip(counts).zip(vision.chunks_exact_mut(4)) {
            fractions(counts, region.window(), out);
        }
        vision
    }

    /// What a red car does for the length of a step that begins with everybody at `bodies`.
    fn cars_twist(&self, car: usize, bodies: &[Pose; BODIES]) -> Twist {
        let choice = match &self.shared.steering {
            Steering::Mind(driver) => self.cars_choice(car, bodies, driver.as_ref()),
            Steering::Scripted => {
                let mut others = [bodies[car]; CARS];
                let mut count = 0;
                for other in (1..self.body_count).filter(|&other| other != car) {
                    others[count] = bodies[other];
                    count += 1;
                }
                traffic::scripted_action(self.road(), &bodies[car], &others[..count])
            }
        };
        traffic::car_twist(choice).scaled(self.shared.config.car_speed)
    }

    /// What every body does for the length of this step; all decide on the same state.
    fn twists(&self, action: usize) -> [Twist; BODIES] {
        let mut twists = [MotorAction::ALL[action].twist(); BODIES];
        for (car, twist) in twists.iter_mut().enumerate().take(self.body_count).skip(1) {
            *twist = self.cars_twist(car, &self.bodies);
        }
        twists
    }

    /// Where the red cars will be: they drive as they always do, and do not mind the learner.
    fn foresee(&self) -> expert::Paths {
        expert::Paths::predict(self.cars(), |car, poses| {
            let mut bodies = self.bodies;
            bodies[0].x_m += OUT_OF_SIGHT_M;
            bodies[1..].copy_from_slice(poses);
            self.cars_twist(1 + car, &bodies)
        })
    }

    /// Moves everybody for one substep and notes the learner's contacts.
    fn substep(&mut self, twists: &[Twist; BODIES], touch: &mut Touch) {
        let count = self.body_count;
        let before = self.bodies;
        for (body, twist) in self.bodies.iter_mut().zip(twists).take(count) {
            *body = advance(*body, *twist, SUBSTEP_SECS);
        }
        let mut met = None;
        collision::settle(&before[..count], &mut self.bodies[..count], |contact| {
            if contact.first == 0 {
                met = Some(contact);
            }
        });
        if let Some(contact) = met {
            touch.contact = true;
            touch.fault |= contact.first_share >= 0.5;
            touch.bearing_rad = self.bodies[0].bearing_rad(&self.bodies[contact.second]);
        }
    }

    fn facts(&self, twist: Twist, contact: bool) -> Facts {
        let body = &self.bodies[0];
        let place = self.road().locate(body.x_m, body.y_m);
        let gap = |car: &Pose| car.distance_m(body) - 2.0 * BODY_RADIUS_M;
        Facts {
            contact,
            gap_m: self.cars().iter().map(gap).fold(f64::INFINITY, f64::min),
            offset_m: place.direction(body.heading_rad).sign() * place.offset_m,
            speed_mps: twist.speed_mps,
            turn_radps: twist.turn_radps,
            last_turn_radps: self.last_turn_radps,
        }
    }

    fn record(&mut self, touch: &Touch, facts: &Facts, cost: &task::MotorCost) {
        let body = &self.bodies[0];
        let place = self.road().locate(body.x_m, body.y_m);
        self.measures = measures::collect(body, &place, touch, facts, cost);
    }
}

impl Environment for Highway {
    fn spec(&self) -> &EnvironmentSpec {
        &self.shared.spec
    }

    fn reset(&mut self, seed: u64) -> Result<(), EnvironmentError> {
        self.begin(seed);
        Ok(())
    }

    fn sense(&mut self, sensor: usize, out: &mut [f64]) -> Result<(), EnvironmentError> {
        let moment = || self.moment("infrared");
        match &self.shared.senses[sensor] {
            Sense::Area(patch) => self.look(patch, out),
            Sense::Ring => self.shared.infrared.read(&self.bodies[0], self.cars(), moment(), out),
            Sense::Proximity(i) => {
                out[0] = self.shared.infrared.read_one(*i, &self.bodies[0], self.cars(), moment());
            }
            Sense::Truth(told) => truth::read(*told, (self.road(), &self.bodies[0], self.cars()), out),
        }
        Ok(())
    }

    /// Carries out one motor action.
    ///
    /// # Panics
    /// If `action` is not one of the five of Eq. (12).
    fn step(&mut self, action: usize) -> Result<Outcome, EnvironmentError> {
        let twists = self.twists(action);
        let mut touch = Touch::default();
        for _ in 0..SUBSTEPS {
            self.substep(&twists, &mut touch);
        }
        self.steps += 1;
        let facts = self.facts(twists[0], touch.contact);
        let cost = self.shared.config.task.motor_cost(&facts);
        self.record(&touch, &facts, &cost);
        self.last_turn_radps = twists[0].turn_radps;
        let end = if self.steps >= self.shared.config.horizon { End::TimeLimit } else { End::Running };
        Ok(Outcome { motor_reward: -cost.total(), end })
    }

    fn measures(&self) -> &[f64] {
        &self.measures
    }

    fn picture(&self) -> Option<Picture> {
        Some(Picture { columns: COLUMNS, pixels: self.rgb_image() })
    }

    fn advise(&mut self) -> Option<usize> {
        Some(expert::advise(&expert::Knowledge {
            road: self.road(),
            task: &self.shared.config.task,
            learner: self.bodies[0],
            last_turn_radps: self.last_turn_radps,
            paths: self.foresee(),
        }) as usize)
    }

    fn fork(&self) -> Option<Box<dyn Environment>> {
        Some(Box::new(self.clone()))
    }
}

/// Shares of the classes among the pixels of a window.
fn fractions(counts: [u32; 4], window: Window, out: &mut [f64]) {
    let pixels = window.pixels() as f64;
    out.iter_mut().zip(counts).for_each(|(share, count)| *share = f64::from(count) / pixels);
}

fn obstacle(body: &Pose, material: Material) -> Obstacle {
    Obstacle { x_m: body.x_m, y_m: body.y_m, material }
}

/// The learner's sensors, ready to be read.
fn senses(config: &HighwayConfig, camera: &Camera) -> Vec<Sense> {
    let ready = |organ: Organ| match organ {
        Organ::Area(window) => Sense::Area(Box::new(camera.patch(window))),
        Organ::Ring => Sense::Ring,
        Organ::Proximity(i) => Sense::Proximity(i),
        Organ::Truth(told) => Sense::Truth(told),
    };
    organs(config.senses, &config.task).into_iter().map(|fitted| ready(fitted.organ)).collect()
}

/// The contract of the highway. Sec. 4.2.
///
/// # Panics
/// If the picture cannot be cut as configured ([`Grid::is_possible`]).
#[must_use]
pub fn contract(config: &HighwayConfig) -> EnvironmentSpec {
    if let Senses::Cells(grid) = config.senses {
        assert!(grid.is_possible(), "a grid of {} × {} cells is impossible", grid.columns, grid.rows);
    }
    let sensors = organs(config.senses, &config.task).into_iter().map(|fitted| SensorSpec {
        features: features(fitted.organ),
        name: fitted.name,
        price: fitted.price,
    });
    EnvironmentSpec {
        id: config.senses.world().to_owned(),
        sensors: sensors.collect(),
        actions: MotorAction::ALL.iter().map(|action| action.name().to_owned()).collect(),
        horizon: config.horizon,
        measures: measures::NAMES.iter().map(|&name| name.to_owned()).collect(),
    }
}

/// The numbers a sensor delivers.
fn features(organ: Organ) -> Vec<Feature> {
    let feature = |name: String, low: f64, high: f64| Feature { name, low, high };
    let near = |i: usize| feature(format!("ps{i}"), infrared::LOW, infrared::HIGH);
    match organ {
        Organ::Area(_) => {
            ["black", "white", "red", "green"].map(|colour| feature(colour.to_owned(), 0.0, 1.0)).to_vec()
        }
        Organ::Ring => (0..infrared::SENSORS).map(near).collect(),
        Organ::Proximity(i) => vec![near(i)],
        Organ::Truth(told) => truth::features(told, CARS),
    }
}
