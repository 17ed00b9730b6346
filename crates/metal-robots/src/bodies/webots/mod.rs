//! A robot in Webots (or in `metal serve webots`), driven as an external controller over TCP.
//!
//! Time in the simulator passes only when this body lets it. A device that nobody attends to is switched off: to look
//! switches it on for one step of the simulation, in which the wheels are as they were.
//!
//! As a supervisor the body knows where everybody is (DEF names [`LEARNER`], `RED1`, `RED2` …) and puts them elsewhere
//! for a new episode; as a plain robot it does neither.

mod supervise;

use super::{may_come_back, part};
use crate::body::{About, Body, Feelings, INFRARED, InfraredScale, Wheels};
use crate::bytes::Writer;
use crate::epuck::WHEEL_RADIUS_M;
use crate::error::{BodyError, ProtocolError};
use crate::link::{Line, Meter, Opener, Patience};
use crate::picture::{Picture, decode_bgra};
use crate::webots::ROBOT;
use crate::webots::device::Settings;
use crate::webots::frame::{Answer, GOODBYE, Image, Request, Welcome, hello};
use crate::webots::news::{self, News};
use crate::webots::order::Order;
use crate::webots::robot::Robot;
use crate::webots::supervisor::Fact;
use metal_worlds::highway::Pose;
use metal_worlds::highway::camera::{COLUMNS, ROWS, Window};
use metal_worlds::highway::kinematics::WHEEL_LIMIT_MPS;
use std::time::Duration;
use supervise::Placed;

/// DEF name of the robot that learns.
pub const LEARNER: &str = "LEARNER";
/// DEF names of the cars end with numbers from 1 on.
pub const CAR: &str = "RED";
/// Most cars that are looked for.
const MOST_CARS: usize = 8;
/// How often a world that still loads is asked again.
const LOADING: usize = 60;
/// Device of the left wheel.
pub const LEFT_MOTOR: &str = "left wheel motor";
/// Device of the right wheel.
pub const RIGHT_MOTOR: &str = "right wheel motor";
const MOTORS: [&str; 2] = [LEFT_MOTOR, RIGHT_MOTOR];

/// A robot in Webots.
pub struct Webots {
    line: Line,
    name: Option<String>,
    robot: Option<Robot>,
    motors: [u16; 2],
    ring: [u16; INFRARED],
    camera: u16,
    placed: Vec<Placed>,
    waiting: Vec<(u16, Order)>,
    goodbye: bool,
}

/// What one answer brought.
#[derive(Default)]
struct Heard {
    readings: Vec<(u16, f64)>,
    vectors: Vec<(u16, [f64; 3])>,
    facts: Vec<Fact>,
    images: Vec<Image>,
    quit: bool,
}

impl Heard {
    /// The last reading of a device, if there is such a device and it said something.
    fn reading(&self, tag: Option<u16>) -> Option<f64> {
        Some(self.readings.iter().rfind(|(t, _)| Some(*t) == tag)?.1)
    }
}

impl Webots {
    /// Finds the robot called `name` (none: the only one with an external controller) behind `opener` and stops it.
    ///
    /// # Errors
    /// If nobody answers, the robot has other devices than an E-puck, or Webots speaks another language.
    pub fn connect(opener: Opener, patience: Patience, name: Option<&str>) -> Result<Self, BodyError> {
        let mut body = Self {
            line: Line::new(opener, patience),
            name: name.map(str::to_owned),
            robot: None,
            motors: [0; 2],
            ring: [0; INFRARED],
            camera: 0,
            placed: Vec::new(),
            waiting: Vec::new(),
            goodbye: true,
        };
        body.enter()?;
        Ok(body)
    }

    /// What Webots said about the robot.
    #[must_use]
    pub fn robot(&self) -> Option<&Robot> {
        self.robot.as_ref()
    }

    /// Greets, learns what the robot is made of, and lets its wheels turn freely at no speed.
    fn enter(&mut self) -> Result<(), BodyError> {
        self.greet()?;
        self.robot = None;
        self.waiting.clear();
        self.placed.clear();
        self.line.send(&Request::default().encode())?;
        let answer = self.line.receive(Answer::decode)?;
        let (robot, used) = Robot::decode(&answer.news)?;
        news::read_all(&robot, &answer.news[used..], |_| {})?;
        self.adopt(&robot)?;
        let supervises = robot.supervisor.is_some();
        self.robot = Some(robot);
        for motor in self.motors {
            self.waiting.push((motor, Order::Position(f64::INFINITY)));
        }
        self.drive(Wheels::STILL)?;
        if supervises { self.find_everybody() } else { Ok(()) }
    }

    fn greet(&mut self) -> Result<(), BodyError> {
        for _ in 0..LOADING {
            self.line.reopen()?;
            self.line.send(&hello(self.name.as_deref()))?;
            match self.line.receive(|bytes| Welcome::read(bytes).map(|w| (w, bytes.len())))? {
                Welcome::Connected => return Ok(()),
                Welcome::Processing => std::thread::sleep(Duration::from_secs(1)),
                Welcome::Failed => {
                    let name = self.name.as_deref().unwrap_or("(no name given)");
                    let advice = "its field `controller` must be \"<extern>\"";
                    return Err(BodyError::Unsupported(format!(
                        "Webots has no free robot `{name}`; {advice}"
                    )));
                }
                Welcome::Forbidden => {
                    let advice = "another controller drives it, or this computer is not allowed to";
                    return Err(BodyError::Unsupported(format!("Webots refuses the robot: {advice}")));
                }
            }
        }
        Err(BodyError::Lost("Webots does not come to an end with loading its world".to_owned()))
    }

    /// Notes the tags of the devices that are used.
    fn adopt(&mut self, robot: &Robot) -> Result<(), BodyError> {
        let tag = |name: &str| {
            let missing = || BodyError::Unsupported(format!("robot `{}` has no device `{name}`", robot.name));
            robot.tag(name).ok_or_else(missing)
        };
        for (slot, name) in self.motors.iter_mut().zip(MOTORS) {
            *slot = tag(name)?;
        }
        for (i, slot) in self.ring.iter_mut().enumerate() {
            *slot = tag(&format!("ps{i}"))?;
        }
        self.camera = tag("camera")?;
        match &robot.devices[usize::from(self.camera) - 1].settings {
            Some(Settings::Camera(c)) if c.size == [COLUMNS as u16, ROWS as u16] => Ok(()),
            Some(Settings::Camera(c)) => {
                let [columns, rows] = c.size;
                Err(BodyError::Unsupported(format!(
                    "the camera has {columns}×{rows} pixels; set camera_width 52 and camera_height 39"
                )))
            }
            _ => Err(ProtocolError::Unexpected("a camera without settings".to_owned()).into()),
        }
    }

    /// Sends all orders that wait, lets the simulation run, and reads the news.
    fn exchange(&mut self, step_ms: u32) -> Result<Heard, BodyError> {
        let orders = self.payloads()?;
        self.line.send(&Request { step_ms, orders }.encode())?;
        let mut heard = Heard::default();
        loop {
            let answer = self.line.receive(Answer::decode)?;
            let robot = self.robot.as_ref().ok_or_else(unknown_robot)?;
            news::read_all(robot, &answer.news, |n| match n {
                News::Reading(tag, value) => heard.readings.push((tag, value)),
                News::Vector(tag, values) => heard.vectors.push((tag, values)),
                News::Fact(fact) => heard.facts.push(fact),
                News::Quit => heard.quit = true,
                _ => {}
            })?;
            heard.images.extend(answer.images);
            if heard.quit {
                self.goodbye = false;
                self.line.close();
                return Err(BodyError::Lost("Webots ended the controller".to_owned()));
            }
            // A negative delay: nobody asked for this, the answer is still to come.
            if answer.delay_ms >= 0 {
                return Ok(heard);
            }
        }
    }

    /// All waiting orders, one payload for each device.
    fn payloads(&mut self) -> Result<Vec<(u16, Vec<u8>)>, BodyError> {
        let release = self.robot.as_ref().ok_or_else(unknown_robot)?.release;
        let mut payloads: Vec<(u16, Writer)> = Vec::new();
        for (tag, order) in self.waiting.drain(..) {
            let place = payloads.iter().position(|(t, _)| *t == tag).unwrap_or_else(|| {
                payloads.push((tag, Writer::new()));
                payloads.len() - 1
            });
            order.write(release, &mut payloads[place].1);
        }
        Ok(payloads.into_iter().map(|(tag, w)| (tag, w.into_bytes())).collect())
    }

    fn basic_step_ms(&self) -> u16 {
        self.robot.as_ref().map_or(32, |r| r.basic_step_ms.round().clamp(1.0, 1000.0) as u16)
    }

    /// Switches `devices` on for one step of the simulation.
    fn look(&mut self, devices: &[u16]) -> Result<Heard, BodyError> {
        let period = self.basic_step_ms();
        self.waiting.extend(devices.iter().map(|&tag| (tag, Order::Sample(period))));
        let heard = self.exchange(u32::from(period))?;
        // Goes out with whatever is said next.
        self.waiting.extend(devices.iter().map(|&tag| (tag, Order::Sample(0))));
        Ok(heard)
    }

    /// Opens the line again after a loss; the robot stands still then.
    fn come_back(&mut self, error: BodyError) -> Result<(), BodyError> {
        if may_come_back(&error) && self.goodbye { self.enter() } else { Err(error) }
    }
}

fn unknown_robot() -> BodyError {
    BodyError::Lost("Webots has not described the robot".to_owned())
}

impl Body for Webots {
    fn name(&self) -> &str {
        "webots"
    }

    fn fastest_mps(&self) -> f64 {
        WHEEL_LIMIT_MPS
    }

    fn infrared_scale(&self) -> InfraredScale {
        InfraredScale { idle: 67.0, factor: 1.0 }
    }

    fn drive(&mut self, wheels: Wheels) -> Result<(), BodyError> {
        for (motor, speed) in self.motors.into_iter().zip([wheels.left_mps, wheels.right_mps]) {
            self.waiting.push((motor, Order::Velocity(speed / WHEEL_RADIUS_M)));
        }
        if wheels != Wheels::STILL {
            return Ok(());
        }
        // To enter again stops the wheels, too.
        self.exchange(0).map(|_| ()).or_else(|error| self.come_back(error))
    }

    fn pass(&mut self, secs: f64) -> Result<(), BodyError> {
        let basic = f64::from(self.basic_step_ms());
        let steps = (1000.0 * secs / basic).round().max(1.0);
        self.exchange((steps * basic) as u32).map(|_| ())
    }

    fn tick_secs(&self) -> f64 {
        f64::from(self.basic_step_ms()) / 1000.0
    }

    fn picture(&mut self, window: Window) -> Result<Picture, BodyError> {
        let camera = self.camera;
        let heard = self.look(&[camera])?;
        let nothing = || ProtocolError::Unexpected("no picture after one step".to_owned());
        let image = heard.images.into_iter().rfind(|i| i.tag == camera && !i.segments).ok_or_else(nothing)?;
        Ok(part(&decode_bgra(COLUMNS, &image.bgra)?, window))
    }

    fn proximity(&mut self) -> Result<[f64; INFRARED], BodyError> {
        let ring = self.ring;
        let heard = self.look(&ring)?;
        let mut out = [0.0; INFRARED];
        for (value, tag) in out.iter_mut().zip(ring) {
            let nothing = || ProtocolError::Unexpected(format!("no reading of device {tag} after one step"));
            *value = heard.reading(Some(tag)).ok_or_else(nothing)?;
        }
        Ok(out)
    }

    fn feel(&mut self) -> Result<Feelings, BodyError> {
        let robot = self.robot.as_ref().ok_or_else(unknown_robot)?;
        let tag = |name: &str| robot.tag(name);
        let wheels = ["left wheel sensor", "right wheel sensor"].map(tag);
        let lights: [Option<u16>; INFRARED] = std::array::from_fn(|i| tag(&format!("ls{i}")));
        let (felt, turned, ahead) = (tag("accelerometer"), tag("gyro"), tag("tof"));
        let all = wheels.iter().chain(&lights).chain([&felt, &turned, &ahead]);
        let devices: Vec<u16> = all.copied().flatten().collect();
        let heard = self.look(&devices)?;
        let vector = |tag: Option<u16>| Some(heard.vectors.iter().rfind(|(t, _)| Some(*t) == tag)?.1);
        let rolled = wheels.map(|tag| heard.reading(tag).map(|angle| angle * WHEEL_RADIUS_M));
        Ok(Feelings {
            rolled_m: rolled[0].zip(rolled[1]).map(|(left, right)| [left, right]),
            ambient: lights
                .iter()
                .map(|&tag| heard.reading(tag))
                .collect::<Option<Vec<f64>>>()
                .and_then(|v| v.try_into().ok()),
            acceleration_mps2: vector(felt),
            turn_radps: vector(turned),
            ground: None,
            // Its table gives millimetres.
            ahead_m: heard.reading(ahead).map(|mm| mm / 1000.0),
        })
    }

    fn light(&mut self, which: usize, rgb: [u8; 3]) -> Result<(), BodyError> {
        let robot = self.robot.as_ref().ok_or_else(unknown_robot)?;
        let Some(tag) = robot.tag(&format!("led{which}")) else { return Ok(()) };
        let [r, g, b] = rgb.map(i32::from);
        // Goes out with whatever is said next. A light of one colour takes everything but 0 for on.
        self.waiting.push((tag, Order::Light(r << 16 | g << 8 | b)));
        Ok(())
    }

    fn poses(&mut self) -> Result<Option<Vec<Pose>>, BodyError> {
        if self.placed.is_empty() {
            return Ok(None);
        }
        self.everybodys_poses().map(Some)
    }

    fn place(&mut self, poses: &[Pose]) -> Result<bool, BodyError> {
        if self.placed.is_empty() {
            return Ok(false);
        }
        self.order_places(poses);
        self.drive(Wheels::STILL)?;
        Ok(true)
    }

    fn meter(&self) -> Meter {
        self.line.meter()
    }

    fn about(&mut self) -> Result<About, BodyError> {
        let robot = self.robot.as_ref().ok_or_else(unknown_robot)?;
        let row = |name: &str, value: String| (name.to_owned(), value);
        Ok(vec![
            row("release", robot.release.name().to_owned()),
            row("robot", robot.name.clone()),
            row("devices", robot.devices.len().to_string()),
            row("basic step", format!("{} ms", robot.basic_step_ms)),
            row("supervisor", if robot.supervisor.is_some() { "yes" } else { "no" }.to_owned()),
            row("bodies found", self.placed.len().to_string()),
        ])
    }
}

impl Drop for Webots {
    /// A controller that simply vanishes would leave its wheels turning until Webots notices.
    fn drop(&mut self) {
        if self.goodbye && self.line.is_open() {
            self.waiting.clear();
            for motor in self.motors {
                self.waiting.push((motor, Order::Velocity(0.0)));
            }
            self.waiting.push((ROBOT, Order::Leave));
            if self.exchange(0).is_ok() {
                let _ = self.line.send(&GOODBYE);
            }
        }
    }
}
