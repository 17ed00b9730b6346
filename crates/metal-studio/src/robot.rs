//! A body of wheels and wires, driven by a trained mind and watched from the page. A page may let it go, hold it and stop
//! it; it cannot steer it. The body is reached only through its guard, and it stands still while nobody watches.

use crate::frame::{LaneFrame, LinkFrame};
use crate::seated::Seated;
use crate::subject::{Subject, SubjectError};
use metal_lab::results::{PixelImage, Pose};
use metal_rl::environment::{Environment, EnvironmentError, Outcome};
use metal_rl::random::Streams;
use metal_robots::{Emergency, RobotEnvironment};
use metal_worlds::highway::Ground;
use metal_worlds::highway::camera::{COLUMNS, ROWS, Region};
use metal_worlds::highway::measures::NAMES;

/// A body under guard, and the button that stops it.
pub struct Robot {
    /// The body as an environment.
    pub environment: RobotEnvironment,
    /// Stops it at once, for good.
    pub emergency: Emergency,
}

/// A body and who drives it.
pub struct BodyLane {
    /// Index among the drivers.
    pub driver: usize,
    /// Motor steps of this episode.
    pub step: usize,
    /// Episodes so far.
    pub episode: usize,
    robot: Robot,
    seated: Seated,
    road: usize,
    infrared: Option<usize>,
    seed: u64,
}

impl BodyLane {
    /// `driver` at the wheel of `robot`.
    ///
    /// # Errors
    /// If the driver's mind cannot be read, knows other sensors than a body has, or is no mind but the scripted expert.
    pub fn new(subject: &mut Subject, driver: usize, robot: Robot) -> Result<Self, SubjectError> {
        if subject.plan.spec.sensors != robot.environment.spec().sensors {
            return Err(SubjectError::OtherSensors);
        }
        let (seated, infrared) = (mind_of(subject, driver)?, subject.plan.spec.sensor("IR"));
        let road = subject.road_count();
        Ok(Self { driver, step: 0, episode: 0, robot, seated, road, infrared, seed: 0 })
    }

    /// Somebody else takes the wheel; the body stands meanwhile.
    ///
    /// # Errors
    /// If the mind cannot be read, or it is none but the scripted expert.
    pub fn seat(&mut self, subject: &mut Subject, driver: usize) -> Result<(), SubjectError> {
        (self.seated, self.driver) = (mind_of(subject, driver)?, driver);
        Ok(())
    }

    /// The road it is on, where that is known.
    #[must_use]
    pub fn ground(&self) -> Option<&Ground> {
        self.robot.environment.grounds().and_then(|grounds| grounds.first())
    }

    /// Begins episode `seed`: the body halts; where a supervisor can, it is placed.
    ///
    /// # Errors
    /// If the body fails.
    pub fn reset(&mut self, seed: u64) -> Result<(), EnvironmentError> {
        (self.step, self.seed) = (0, seed);
        self.robot.environment.reset(seed)
    }

    /// What the driver looks at and would do. The body is asked for what the mind looks at and for nothing else.
    ///
    /// # Errors
    /// If the body fails.
    pub fn think(&mut self) -> Result<LaneFrame, EnvironmentError> {
        let mut frame = LaneFrame { road: self.road, from: self.poses(), ..LaneFrame::default() };
        frame.to.clone_from(&frame.from);
        let streams = Streams::new(self.seed).nth(self.step as u64);
        self.seated.think(&mut self.robot.environment, &streams, &mut frame)?;
        frame.image = picture(&self.robot.environment);
        frame.infrared = self.ring(&frame);
        Ok(frame)
    }

    /// Carries out what `frame` decided.
    ///
    /// # Errors
    /// If the body fails or was stopped.
    pub fn act(&mut self, frame: &mut LaneFrame) -> Result<Outcome, EnvironmentError> {
        let outcome = self.robot.environment.step(frame.action)?;
        self.step += 1;
        frame.motor = outcome.motor_reward;
        frame.to = self.poses();
        let measures = self.robot.environment.measures();
        frame.accident = NAMES.iter().position(|n| *n == "accident").is_some_and(|i| measures[i] > 0.5);
        if let [bytes, ms, saved_bytes, saved_ms] = measures[NAMES.len()..] {
            frame.link = Some(LinkFrame { bytes, ms, saved_bytes, saved_ms });
        }
        Ok(outcome)
    }

    /// Where everybody is, where somebody knows; a link that broke is reported by the next look or step.
    fn poses(&mut self) -> Vec<Pose> {
        let known = self.robot.environment.whereabouts().unwrap_or_default();
        let pose = |p: &metal_worlds::highway::Pose| Pose { x: p.x_m, y: p.y_m, heading_rad: p.heading_rad };
        known.map_or_else(Vec::new, |poses| poses.iter().map(pose).collect())
    }

    /// What the ring said, if it was asked.
    fn ring(&self, frame: &LaneFrame) -> Vec<f64> {
        let Some(sensor) = self.infrared.filter(|s| frame.read.contains(s)) else { return Vec::new() };
        let mut asked = frame.asked.iter().filter_map(|&m| frame.opinions[m].as_ref().map(|o| (m, o)));
        let alone = asked.find(|&(m, _)| self.seated.sensors_of(m) == [sensor]);
        alone.map_or_else(Vec::new, |(_, opinion)| opinion.reading.clone())
    }
}

/// A driver that a body can have: the expert's advice comes from the simulated world's truth, which no body knows.
fn mind_of(subject: &mut Subject, driver: usize) -> Result<Seated, SubjectError> {
    let row = &subject.drivers[driver];
    if row.acting.is_watched() {
        return Err(SubjectError::NoExpert(row.label.clone()));
    }
    Seated::new(subject, driver)
}

/// What was looked at, one digit per pixel; the rest nobody asked the body for.
fn picture(environment: &RobotEnvironment) -> PixelImage {
    let mut image = vec![vec![b'0'; COLUMNS]; ROWS];
    for (index, region) in Region::ALL.iter().enumerate() {
        let (Some(classes), window) = (environment.classes(index), region.window()) else { continue };
        for (row, part) in classes.chunks(window.right - window.left).enumerate() {
            let line = &mut image[window.top + row][window.left..window.right];
            line.iter_mut().zip(part).for_each(|(pixel, class)| *pixel = b"0123"[*class]);
        }
    }
    image.into_iter().map(|row| row.into_iter().map(char::from).collect()).collect()
}
