//! The highway in continuous time, with a body whose wheels anybody may turn: what the servers show to the world.
//!
//! Road, camera, infra-red ring, kinematics and contacts are those of the simulated highway; only the motor actions are
//! replaced by wheel speeds, and the half seconds by milliseconds.

use crate::body::{INFRARED, Wheels};
use crate::picture::Picture;
use metal_rl::random::Streams;
use metal_worlds::highway::camera::{COLUMNS, Camera, Obstacle, ROWS, Scene, Window};
use metal_worlds::highway::infrared::Infrared;
use metal_worlds::highway::kinematics::{ACTION_SECS, AXLE_M, Twist, advance};
use metal_worlds::highway::scenario::Start;
use metal_worlds::highway::traffic::{car_twist, scripted_action};
use metal_worlds::highway::{Ground, Material, Pose, RgbConfig, Scenario, collision, rgb};
use std::sync::Arc;

/// Longest move, in milliseconds, so that no contact is jumped over.
const SLICE_MS: u64 = 16;

/// What the cars do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Traffic {
    /// They stand, as the red objects of the paper's real road do (Sec. 5).
    #[default]
    Standing,
    /// They keep to their lanes by a script.
    Scripted,
}

/// What an arena is made of.
#[derive(Clone, Debug)]
pub struct ArenaConfig {
    /// Roads; the first is driven on.
    pub grounds: Arc<[Ground]>,
    /// Where everybody begins.
    pub scenario: Scenario,
    /// What the cars do.
    pub traffic: Traffic,
    /// How the colour picture comes about.
    pub rgb: RgbConfig,
    /// Where all randomness comes from.
    pub seed: u64,
}

/// A road, a body, cars and a clock.
#[derive(Clone, Debug)]
pub struct Arena {
    config: ArenaConfig,
    streams: Streams,
    camera: Camera,
    infrared: Infrared,
    bodies: Vec<Pose>,
    car_twists: Vec<Twist>,
    wheels: Wheels,
    rolled_m: [f64; 2],
    time_ms: u64,
    contacts: u64,
}

impl Arena {
    /// Everybody at the beginning of the scenario, standing.
    ///
    /// # Panics
    /// If there is no ground.
    #[must_use]
    pub fn new(config: ArenaConfig) -> Self {
        assert!(!config.grounds.is_empty(), "an arena needs a road");
        let streams = Streams::new(config.seed).child("arena");
        let mut arena = Self {
            config,
            streams,
            camera: Camera::new(),
            infrared: Infrared::new(),
            bodies: Vec::new(),
            car_twists: Vec::new(),
            wheels: Wheels::STILL,
            rolled_m: [0.0; 2],
            time_ms: 0,
            contacts: 0,
        };
        arena.restart();
        arena
    }

    /// Puts everybody where the scenario begins. The clock goes on.
    pub fn restart(&mut self) {
        let start = self.start();
        self.bodies = vec![start.learner];
        self.bodies.extend_from_slice(&start.cars[..start.car_count]);
        self.car_twists = vec![Twist::default(); start.car_count];
        self.wheels = Wheels::STILL;
    }

    /// Where the scenario begins.
    #[must_use]
    pub fn start(&self) -> Start {
        self.config.scenario.start(self.ground().road(), &self.streams)
    }

    /// The ground.
    #[must_use]
    pub fn ground(&self) -> &Ground {
        &self.config.grounds[0]
    }

    /// The learner, then the cars.
    #[must_use]
    pub fn bodies(&self) -> &[Pose] {
        &self.bodies
    }

    /// Puts one of [`Self::bodies`] elsewhere; an index that nobody has is ignored.
    pub fn place(&mut self, index: usize, pose: Pose) {
        if let Some(body) = self.bodies.get_mut(index) {
            *body = pose;
        }
    }

    /// Time since the beginning, in milliseconds.
    #[must_use]
    pub fn time_ms(&self) -> u64 {
        self.time_ms
    }

    /// The learner's wheels.
    #[must_use]
    pub fn wheels(&self) -> Wheels {
        self.wheels
    }

    /// Lets the learner's wheels turn from now on, as fast as an E-puck's can.
    pub fn drive(&mut self, wheels: Wheels) {
        let within = twist(wheels).within_wheel_limits();
        self.wheels = if within == twist(wheels) { wheels } else { Wheels::of(within) };
    }

    /// How far the left and the right wheel have rolled, in metres.
    #[must_use]
    pub fn rolled_m(&self) -> [f64; 2] {
        self.rolled_m
    }

    /// Sets what [`Self::rolled_m`] counts from.
    pub fn set_rolled_m(&mut self, rolled_m: [f64; 2]) {
        self.rolled_m = rolled_m;
    }

    /// Moves in which the learner touched a car, so far.
    #[must_use]
    pub fn contacts(&self) -> u64 {
        self.contacts
    }

    /// Lets time pass.
    pub fn pass(&mut self, ms: u64) {
        let end = self.time_ms + ms;
        while self.time_ms < end {
            let slice = SLICE_MS.min(end - self.time_ms);
            self.steer_cars(slice);
            self.glide(slice as f64 / 1000.0);
            self.time_ms += slice;
        }
    }

    /// Cars decide as often as motor actions last.
    fn steer_cars(&mut self, slice_ms: u64) {
        let action_ms = (1000.0 * ACTION_SECS) as u64;
        let due = self.time_ms / action_ms != (self.time_ms + slice_ms) / action_ms || self.time_ms == 0;
        if self.config.traffic == Traffic::Standing || !due {
            return;
        }
        let road = self.config.grounds[0].road();
        for car in 1..self.bodies.len() {
            let others: Vec<Pose> =
                (1..self.bodies.len()).filter(|&o| o != car).map(|o| self.bodies[o]).collect();
            self.car_twists[car - 1] = car_twist(scripted_action(road, &self.bodies[car], &others));
        }
    }

    fn glide(&mut self, secs: f64) {
        let before = self.bodies.clone();
        self.bodies[0] = advance(self.bodies[0], twist(self.wheels), secs);
        for (car, twist) in self.bodies[1..].iter_mut().zip(&self.car_twists) {
            *car = advance(*car, *twist, secs);
        }
        let mut touched = false;
        collision::settle(&before, &mut self.bodies, |contact| touched |= contact.first == 0);
        self.contacts += u64::from(touched);
        self.rolled_m[0] += self.wheels.left_mps * secs;
        self.rolled_m[1] += self.wheels.right_mps * secs;
    }

    /// What the learner's camera sees.
    #[must_use]
    pub fn picture(&self) -> Picture {
        let red = |car: &Pose| Obstacle { x_m: car.x_m, y_m: car.y_m, material: Material::RedBody };
        let obstacles: Vec<Obstacle> = self.bodies[1..].iter().map(red).collect();
        let scene = Scene { ground: self.ground(), eye: self.bodies[0], obstacles: &obstacles };
        let mut pixels = vec![[0; 3]; ROWS * COLUMNS];
        let noise = self.moment("camera");
        rgb::render(&self.camera, &scene, (&self.config.rgb, noise), Window::WHOLE, |i, c| pixels[i] = c);
        Picture { columns: COLUMNS, pixels }
    }

    /// What the learner's infra-red sensors read, in Webots' units: 67 if nothing is near.
    #[must_use]
    pub fn proximity(&self) -> [f64; INFRARED] {
        let mut out = [0.0; INFRARED];
        self.infrared.read(&self.bodies[0], &self.bodies[1..], self.moment("infrared"), &mut out);
        out
    }

    fn moment(&self, device: &str) -> Streams {
        self.streams.child(device).nth(self.time_ms)
    }
}

/// The motion of a pair of wheels.
fn twist(wheels: Wheels) -> Twist {
    Twist {
        speed_mps: 0.5 * (wheels.left_mps + wheels.right_mps),
        turn_radps: (wheels.right_mps - wheels.left_mps) / AXLE_M,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use metal_worlds::highway::{MotorAction, RoadSet};

    fn arena(scenario: Scenario) -> Arena {
        let grounds = RoadSet::Seeds(vec![1]).build();
        let (traffic, rgb) = (Traffic::Standing, RgbConfig::default());
        Arena::new(ArenaConfig { grounds, scenario, traffic, rgb, seed: 1 })
    }

    #[test]
    fn an_action_in_slices_leads_where_the_highway_goes() {
        for action in MotorAction::ALL {
            let mut arena = arena(Scenario::FreeRoad);
            let start = arena.bodies()[0];
            arena.drive(Wheels::of(action.twist()));
            arena.pass(500);
            let end = advance(start, action.twist(), ACTION_SECS);
            assert!(arena.bodies()[0].distance_m(&end) < 1e-9, "{action:?}");
            assert_eq!(arena.time_ms(), 500);
        }
    }

    #[test]
    fn a_car_in_the_way_blocks_is_seen_and_reflects() {
        let mut arena = arena(Scenario::Mix);
        let start = arena.bodies()[0];
        let ahead = advance(start, Twist { speed_mps: 0.1, turn_radps: 0.0 }, 1.0);
        arena.place(1, ahead);
        arena.drive(Wheels { left_mps: 0.1, right_mps: 0.1 });
        arena.pass(1000);
        assert!(arena.contacts() > 0);
        assert!(arena.bodies()[0].distance_m(&ahead) >= 2.0 * 0.037 - 1e-9);
        let ring = arena.proximity();
        assert!(ring[0] > 500.0 && ring[7] > 500.0 && ring[4] < 100.0, "{ring:?}");
        let red = arena.picture().pixels.iter().filter(|p| p[0] > 150 && p[1] < 60).count();
        assert!(red > 200, "{red} red pixels");
    }
}
