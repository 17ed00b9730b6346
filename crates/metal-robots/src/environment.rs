//! A body as an environment: the same contract as the simulated highway's, so that every plan, phase and policy works.
//!
//! Attention is physical: a region or the ring of sensors is requested from the body when somebody consults it, and not
//! otherwise. What that saved is in the record: bytes exchanged and time waited in each step, beside what a full look
//! would have taken.

use crate::body::{INFRARED, Wheels};
use crate::calibration::Calibration;
use crate::error::BodyError;
use crate::guard::Guard;
use crate::link::Meter;
use crate::picture::Picture;
use metal_rl::environment::{End, Environment, EnvironmentError, EnvironmentSpec, Outcome};
use metal_rl::num;
use metal_rl::random::Streams;
use metal_worlds::highway::camera::{Region, Window};
use metal_worlds::highway::expert::{Knowledge, Paths, advise};
use metal_worlds::highway::kinematics::{ACTION_SECS, BODY_RADIUS_M, Twist};
use metal_worlds::highway::measures::{NAMES, Touch, collect};
use metal_worlds::highway::task::Facts;
use metal_worlds::highway::{Ground, HighwayConfig, MotorAction, Pose, Senses, contract};
use std::sync::Arc;

/// Names of the measures a body has beside those of the simulated highway.
pub const LINK_MEASURES: [&str; 4] = ["link_bytes", "link_ms", "saved_bytes", "saved_ms"];
/// Index of the infra-red ring, after the six regions.
const RING: usize = 6;
/// Reading, in the simulator's units, from which a car counts as touched: its side at 4 mm from a sensor.
const TOUCH: f64 = 2000.0;
/// Reading from which a car counts as dangerously near: some 2 cm from the body.
const NEAR: f64 = 150.0;

/// How a body is used.
#[derive(Clone, Debug)]
pub struct RobotConfig {
    /// Prices, weights, horizon and scenario; roads count only where a supervisor can place the body.
    pub highway: HighwayConfig,
    /// Colours and infra-red levels.
    pub calibration: Calibration,
    /// The road's truth, if the body's poses refer to it: rewards are exact then, and the expert can advise.
    pub grounds: Option<Arc<[Ground]>>,
}

/// A body under guard, as an environment.
pub struct RobotEnvironment {
    guard: Guard,
    config: RobotConfig,
    spec: EnvironmentSpec,
    measures: Vec<f64>,
    steps: usize,
    last_turn_radps: f64,
    whole: Option<Picture>,
    parts: [Option<Picture>; RING],
    crops: bool,
    looked: [bool; 7],
    look_costs: [Cost; 7],
    survey: [Cost; 7],
    spent: Cost,
}

/// The roads, and where everybody is on the first of them.
type Truth = (Arc<[Ground]>, Vec<Pose>);

/// What looks or steps have cost on the link.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Cost {
    bytes: f64,
    ms: f64,
    times: f64,
}

impl Cost {
    fn add(&mut self, meter: Meter) {
        self.bytes += meter.bytes() as f64;
        self.ms += 1000.0 * meter.waited.as_secs_f64();
        self.times += 1.0;
    }

    fn mean(&self) -> (f64, f64) {
        (self.bytes / self.times.max(1.0), self.ms / self.times.max(1.0))
    }
}

impl RobotEnvironment {
    /// The environment of a guarded body.
    ///
    /// # Errors
    /// If the body does not answer.
    pub fn new(guard: Guard, config: RobotConfig) -> Result<Self, BodyError> {
        let (name, crops) = guard.with(|body| Ok((body.name().to_owned(), body.crops())))?;
        // A body looks by regions, however the plan's world cuts its senses.
        let mut spec = contract(&HighwayConfig { senses: Senses::Regions, ..config.highway.clone() });
        spec.id = format!("Highway-{name}");
        spec.measures.extend(LINK_MEASURES.map(str::to_owned));
        let measures = vec![0.0; spec.measures.len()];
        Ok(Self {
            guard,
            config,
            spec,
            measures,
            steps: 0,
            last_turn_radps: 0.0,
            whole: None,
            parts: [const { None }; RING],
            crops,
            looked: [false; 7],
            look_costs: [Cost::default(); 7],
            survey: [Cost::default(); 7],
            spent: Cost::default(),
        })
        .and_then(Self::surveyed)
    }

    /// Looks at everything once, so that it is known what not looking saves.
    fn surveyed(mut self) -> Result<Self, BodyError> {
        let (mut colours, mut ring) = ([0.0; 4], [0.0; INFRARED]);
        (0..RING).try_for_each(|region| self.look(region, &mut colours))?;
        self.look(RING, &mut ring)?;
        self.survey = std::mem::take(&mut self.look_costs);
        self.forget();
        Ok(self)
    }

    /// Mean bytes and milliseconds of a look, by what was learned since, or else in the survey.
    fn price(&self, sensor: usize) -> (f64, f64) {
        let learned = &self.look_costs[sensor];
        if learned.times > 0.0 { learned.mean() } else { self.survey[sensor].mean() }
    }

    /// The guard, to stop the body or ask it something.
    #[must_use]
    pub fn guard(&self) -> &Guard {
        &self.guard
    }

    /// The whole picture of this motor step, if one was taken.
    #[must_use]
    pub fn seen(&self) -> Option<&Picture> {
        self.whole.as_ref()
    }

    /// What was seen of camera region `region` in this motor step, pixel by pixel, row by row: the colour class of each;
    /// none if nobody looked there.
    #[must_use]
    pub fn classes(&self, region: usize) -> Option<Vec<usize>> {
        let part = self.parts.get(region)?.as_ref()?;
        let colours = &self.config.calibration.colours;
        Some(part.pixels.iter().map(|&rgb| colours.classify(rgb) as usize).collect())
    }

    /// Where the learner and the cars are, the learner first, if a supervisor knows.
    ///
    /// # Errors
    /// If the link fails.
    pub fn whereabouts(&mut self) -> Result<Option<Vec<Pose>>, BodyError> {
        Ok(self.truth()?.map(|(_, poses)| poses))
    }

    /// The roads that poses refer to, if there are any.
    #[must_use]
    pub fn grounds(&self) -> Option<&Arc<[Ground]>> {
        self.config.grounds.as_ref()
    }

    /// Mean bytes and milliseconds of one look at each sensor that was looked at, in the order of the contract.
    #[must_use]
    pub fn look_costs(&self) -> Vec<(String, f64, f64)> {
        let rows = self.spec.sensors.iter().zip(&self.look_costs).filter(|(_, cost)| cost.times > 0.0);
        rows.map(|(sensor, cost)| (sensor.name.clone(), cost.mean().0, cost.mean().1)).collect()
    }

    /// The picture of `window`: one picture serves all regions of a step, unless the body crops.
    fn region(&mut self, window: Window) -> Result<Picture, BodyError> {
        if self.crops {
            return self.guard.with(|body| body.picture(window));
        }
        if self.whole.is_none() {
            self.whole = Some(self.guard.with(|body| body.picture(Window::WHOLE))?);
        }
        let size = [window.right - window.left, window.bottom - window.top];
        let whole = self.whole.as_ref().ok_or_else(|| BodyError::Lost("no picture".to_owned()))?;
        Ok(whole.cropped([window.left, window.top], size))
    }

    fn look(&mut self, sensor: usize, out: &mut [f64]) -> Result<(), BodyError> {
        let before = self.meter()?;
        if sensor == RING {
            let raw = self.guard.with(|body| body.proximity())?;
            out.copy_from_slice(&self.config.calibration.infrared(raw));
        } else {
            let part = self.region(Region::ALL[sensor].window())?;
            out.copy_from_slice(&self.config.calibration.shares(&part));
            self.parts[sensor] = Some(part);
        }
        let cost = self.meter()?.since(&before);
        self.spent.add(cost);
        self.looked[sensor] = true;
        // A region cut from a picture that is there already has cost nothing; it is no price of a look.
        if cost.bytes() > 0 {
            self.look_costs[sensor].add(cost);
        }
        Ok(())
    }

    fn meter(&self) -> Result<Meter, BodyError> {
        self.guard.with(|body| Ok(body.meter()))
    }

    /// Bytes and milliseconds that looking at everything would have cost more than what was looked at.
    fn saved(&self) -> (f64, f64) {
        let mut saved = (0.0, 0.0);
        let mut add = |(bytes, ms): (f64, f64)| saved = (saved.0 + bytes, saved.1 + ms);
        if !self.looked[RING] {
            add(self.price(RING));
        }
        if self.crops {
            (0..RING).filter(|&i| !self.looked[i]).for_each(|i| add(self.price(i)));
        } else if !self.looked[..RING].contains(&true) {
            // Whichever region is looked at first pays for the picture; in the survey that was region 0.
            let known = (0..RING).find(|&i| self.look_costs[i].times > 0.0);
            add(self.price(known.unwrap_or(0)));
        }
        saved
    }

    /// Where everybody is, and the road they are on, if somebody knows.
    fn truth(&mut self) -> Result<Option<Truth>, BodyError> {
        let Some(grounds) = self.config.grounds.clone() else { return Ok(None) };
        Ok(self.guard.with(|body| body.poses())?.filter(|p| !p.is_empty()).map(|poses| (grounds, poses)))
    }

    /// Rewards and measures of the step that was just made.
    fn judge(&mut self, twist: Twist) -> Result<f64, BodyError> {
        let saved = self.saved();
        let (bytes, ms) = (self.spent.bytes, self.spent.ms);
        let reward = match self.truth()? {
            Some((grounds, poses)) => self.judge_by_truth(twist, grounds[0].road(), &poses),
            None => self.judge_by_touch(twist)?,
        };
        self.measures[NAMES.len()..].copy_from_slice(&[bytes, ms, saved.0, saved.1]);
        Ok(reward)
    }

    fn judge_by_truth(&mut self, twist: Twist, road: &metal_worlds::highway::Road, poses: &[Pose]) -> f64 {
        let me = &poses[0];
        let place = road.locate(me.x_m, me.y_m);
        let gap = |car: &Pose| car.distance_m(me) - 2.0 * BODY_RADIUS_M;
        let nearest = poses[1..].iter().min_by(|a, b| gap(a).total_cmp(&gap(b)));
        let gap_m = nearest.map_or(f64::INFINITY, gap);
        let facts = Facts {
            contact: gap_m < 1e-3,
            gap_m,
            offset_m: place.direction(me.heading_rad).sign() * place.offset_m,
            ..self.facts(twist)
        };
        let bearing_rad = nearest.map_or(0.0, |car| me.bearing_rad(car));
        // Whoever has the other in front of it drove into it.
        let fault = facts.contact && bearing_rad.abs() < 0.5 * std::f64::consts::PI;
        let cost = self.config.highway.task.motor_cost(&facts);
        let touch = Touch { contact: facts.contact, fault, bearing_rad };
        self.measures[..NAMES.len()].copy_from_slice(&collect(me, &place, &touch, &facts, &cost));
        -cost.total()
    }

    /// Without truth, the judge feels for cars with the ring. Where the road is, it cannot know.
    fn judge_by_touch(&mut self, twist: Twist) -> Result<f64, BodyError> {
        let raw = self.guard.with(|body| body.proximity())?;
        let ring = self.config.calibration.infrared(raw);
        let strongest = num::max(&ring);
        let gap_m = if strongest >= NEAR { 0.0 } else { f64::INFINITY };
        let facts = Facts { contact: strongest >= TOUCH, gap_m, ..self.facts(twist) };
        let cost = self.config.highway.task.motor_cost(&facts);
        let mut set = |name: &str, value: f64| {
            if let Some(i) = NAMES.iter().position(|n| *n == name) {
                self.measures[i] = value;
            }
        };
        set("accident", f64::from(u8::from(facts.contact)));
        set("speed_mps", facts.speed_mps);
        set("turn_radps", facts.turn_radps);
        set("cost_accident", cost.accident);
        set("cost_smooth", cost.smooth);
        Ok(-cost.total())
    }

    /// What is known of a motion alone: in the middle of the lane, nobody near.
    fn facts(&self, twist: Twist) -> Facts {
        Facts {
            contact: false,
            gap_m: f64::INFINITY,
            offset_m: -0.5 * metal_worlds::highway::road::LANE_M,
            speed_mps: twist.speed_mps,
            turn_radps: twist.turn_radps,
            last_turn_radps: self.last_turn_radps,
        }
    }

    fn begin(&mut self, seed: u64) -> Result<(), BodyError> {
        self.guard.halt()?;
        self.forget();
        self.steps = 0;
        self.last_turn_radps = 0.0;
        if let Some((grounds, poses)) = self.truth()? {
            let streams = Streams::new(seed).child("highway");
            let start = self.config.highway.scenario.start(grounds[0].road(), &streams);
            self.guard.with(|body| body.place(&everybody(&start, poses.len())))?;
        }
        Ok(())
    }

    /// The next step begins: what was seen is old.
    fn forget(&mut self) {
        self.whole = None;
        self.parts = [const { None }; RING];
        self.looked = [false; 7];
        self.spent = Cost::default();
    }

    fn sensor_error(&self, sensor: usize, reason: &BodyError) -> EnvironmentError {
        EnvironmentError::Sensor {
            environment: self.spec.id.clone(),
            sensor: self.spec.sensors[sensor].name.clone(),
            reason: reason.to_string(),
        }
    }

    fn motor_error(&self, action: &str, reason: &BodyError) -> EnvironmentError {
        EnvironmentError::Motor {
            environment: self.spec.id.clone(),
            action: action.to_owned(),
            reason: reason.to_string(),
        }
    }
}

/// Poses for `count` bodies; cars that the scenario does not have stand far away from the road, one beside the other.
fn everybody(start: &metal_worlds::highway::scenario::Start, count: usize) -> Vec<Pose> {
    let far = |i: usize| Pose { x_m: -20.0, y_m: 0.5 * i as f64, heading_rad: 0.0 };
    let mut poses = vec![start.learner];
    poses.extend_from_slice(&start.cars[..start.car_count]);
    poses.truncate(count);
    poses.extend((poses.len()..count).map(far));
    poses
}

impl Environment for RobotEnvironment {
    fn spec(&self) -> &EnvironmentSpec {
        &self.spec
    }

    fn reset(&mut self, seed: u64) -> Result<(), EnvironmentError> {
        self.begin(seed).map_err(|e| self.motor_error("reset", &e))
    }

    fn sense(&mut self, sensor: usize, out: &mut [f64]) -> Result<(), EnvironmentError> {
        self.look(sensor, out).map_err(|e| self.sensor_error(sensor, &e))
    }

    /// Carries out one motor action: its arc, then a stand, for the world waits while the mind looks.
    ///
    /// # Panics
    /// If `action` is not one of the five of Eq. (12).
    fn step(&mut self, action: usize) -> Result<Outcome, EnvironmentError> {
        let motor = MotorAction::ALL[action];
        let twist = motor.twist();
        let drive = self.guard.drive_for(Wheels::of(twist), ACTION_SECS);
        let judged = drive.and_then(|()| self.judge(twist));
        let motor_reward = judged.map_err(|e| self.motor_error(motor.name(), &e))?;
        self.forget();
        self.steps += 1;
        self.last_turn_radps = twist.turn_radps;
        let end = if self.steps >= self.spec.horizon { End::TimeLimit } else { End::Running };
        Ok(Outcome { motor_reward, end })
    }

    fn measures(&self) -> &[f64] {
        &self.measures
    }

    /// The picture of this motor step, if somebody attended to the camera.
    fn picture(&self) -> Option<Picture> {
        self.whole.clone()
    }

    fn advise(&mut self) -> Option<usize> {
        // An advisor who cannot see gives no advice; the next sense or step reports the broken link.
        let (grounds, poses) = self.truth().ok()??;
        Some(advise(&Knowledge {
            road: grounds[0].road(),
            task: &self.config.highway.task,
            learner: poses[0],
            last_turn_radps: self.last_turn_radps,
            paths: Paths::lane_keepers(grounds[0].road(), &poses[1..]),
        }) as usize)
    }
}

// The ring of a body and that of the contract are the same eight sensors.
const _: () = assert!(INFRARED == metal_worlds::highway::infrared::SENSORS);
