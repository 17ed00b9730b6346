//! What Webots says about the robot when a controller connects.

use super::device::{self, Kind, Settings};
use super::supervisor::{self, Me};
use super::{ROBOT, Release};
use crate::bytes::{Reader, Writer};
use crate::error::ProtocolError;

/// Node type of a robot.
const ROBOT_NODE: u16 = 34;
/// The operation that describes a robot or device.
pub const CONFIGURE: u8 = 0;

/// A device of a robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Device {
    /// Its kind.
    pub kind: Kind,
    /// Its name, e.g. `ps0`.
    pub name: String,
    /// Its model; most have none.
    pub model: String,
    /// What else is said about it; lights and speakers have nothing.
    pub settings: Option<Settings>,
}

/// Texts in which nobody here is interested but which are part of a description.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Texts {
    /// Paths of the project and of the world, model, window, remote control, controller and custom data.
    pub all: [String; 7],
    /// Whether a window is shown, and whether it is an HTML window.
    pub windows: [bool; 2],
}

/// A robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Robot {
    /// Its name.
    pub name: String,
    /// Which Webots speaks.
    pub release: Release,
    /// Whether the simulation waits for the controller.
    pub synchronised: bool,
    /// Time of the simulation, in seconds.
    pub time_s: f64,
    /// Devices; the first has tag 1.
    pub devices: Vec<Device>,
    /// Length of a step of the simulation, in milliseconds.
    pub basic_step_ms: f64,
    /// Other texts.
    pub texts: Texts,
    /// 0: paused, 1: real time, 2: fast.
    pub mode: i32,
    /// The robot's own node, if it is a supervisor.
    pub supervisor: Option<Me>,
}

impl Robot {
    /// Tag of the device called `name`.
    #[must_use]
    pub fn tag(&self, name: &str) -> Option<u16> {
        self.devices.iter().position(|d| d.name == name).and_then(|i| u16::try_from(i + 1).ok())
    }

    /// Kind of the device with `tag`.
    #[must_use]
    pub fn kind(&self, tag: u16) -> Option<Kind> {
        self.devices.get(usize::from(tag).checked_sub(1)?).map(|d| d.kind)
    }

    /// The news that describe the robot.
    #[must_use]
    pub fn encode(&self) -> Vec<u8> {
        let mut w = Writer::new();
        w.u16(ROBOT).u8(CONFIGURE).text(&self.name).text(self.release.name());
        w.flag(self.supervisor.is_some()).flag(self.synchronised);
        w.u16(1 + self.devices.len() as u16).u16(ROBOT_NODE).f64(self.time_s);
        for device in &self.devices {
            w.u16(device.kind.node()).text(&device.name).text(&device.model);
        }
        w.f64(self.basic_step_ms);
        self.texts.all.iter().for_each(|text| {
            w.text(text);
        });
        w.flag(self.texts.windows[0]).flag(self.texts.windows[1]).i32(self.mode);
        if let Some(me) = &self.supervisor {
            w.u16(ROBOT).u8(CONFIGURE);
            supervisor::write_me(me, self.release, &mut w);
        }
        for (tag, device) in (1..).zip(&self.devices) {
            if let Some(settings) = &device.settings {
                w.u16(tag).u8(CONFIGURE);
                device::write(settings, &mut w);
            }
        }
        w.into_bytes()
    }

    /// The robot described by the first news after a greeting; how many bytes that took.
    ///
    /// # Errors
    /// If the release or a device is not known, or the bytes are no description.
    pub fn decode(news: &[u8]) -> Result<(Self, usize), ProtocolError> {
        let mut r = Reader::new(news);
        if (r.u16()?, r.u8()?) != (ROBOT, CONFIGURE) {
            return Err(ProtocolError::Unexpected("news before the robot was described".to_owned()));
        }
        let (name, version) = (r.text()?, r.text()?);
        let release = Release::of(&version)?;
        let (is_supervisor, synchronised) = (r.u8()? != 0, r.u8()? != 0);
        let (count, node, time_s) = (r.u16()?, r.u16()?, r.f64()?);
        if node != ROBOT_NODE {
            return Err(ProtocolError::Unexpected(format!("a robot of node type {node}")));
        }
        let devices = (1..count).map(|_| read_device(&mut r)).collect::<Result<_, _>>()?;
        let mut robot = Self {
            name,
            release,
            synchronised,
            time_s,
            devices,
            basic_step_ms: r.f64()?,
            texts: read_texts(&mut r)?,
            mode: r.i32()?,
            supervisor: None,
        };
        robot.read_descriptions(is_supervisor, &mut r)?;
        Ok((robot, news.len() - r.remaining()))
    }

    /// Reads what follows: the supervisor's own node and each device's settings.
    fn read_descriptions(&mut self, is_supervisor: bool, r: &mut Reader) -> Result<(), ProtocolError> {
        if is_supervisor {
            expect(r, ROBOT)?;
            self.supervisor = Some(supervisor::read_me(self.release, r)?);
        }
        for (tag, device) in (1..).zip(&mut self.devices) {
            if !matches!(device.kind, Kind::Led | Kind::Speaker) {
                expect(r, tag)?;
                device.settings = device::read(device.kind, r)?;
            }
        }
        Ok(())
    }
}

fn expect(r: &mut Reader, tag: u16) -> Result<(), ProtocolError> {
    let found = (r.u16()?, r.u8()?);
    if found == (tag, CONFIGURE) {
        return Ok(());
    }
    Err(ProtocolError::Unexpected(format!(
        "message {} of device {} instead of the description of {tag}",
        found.1, found.0
    )))
}

fn read_device(r: &mut Reader) -> Result<Device, ProtocolError> {
    let (node, name, model) = (r.u16()?, r.text()?, r.text()?);
    match Kind::of(node) {
        Some(kind) => Ok(Device { kind, name, model, settings: None }),
        None => Err(ProtocolError::UnknownDevice { name, node }),
    }
}

fn read_texts(r: &mut Reader) -> Result<Texts, ProtocolError> {
    let mut texts = Texts::default();
    for text in &mut texts.all {
        *text = r.text()?;
    }
    texts.windows = [r.u8()? != 0, r.u8()? != 0];
    Ok(texts)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn device(kind: Kind, name: &str, settings: Option<Settings>) -> Device {
        Device { kind, name: name.to_owned(), model: String::new(), settings }
    }

    fn robot(release: Release) -> Robot {
        let infrared = Settings::Distance(1, [67.0, 4095.0, 0.1], vec![[0.0, 4095.0, 0.002]]);
        Robot {
            name: "learner".to_owned(),
            release,
            synchronised: true,
            time_s: 0.25,
            devices: vec![
                device(Kind::DistanceSensor, "ps0", Some(infrared)),
                device(Kind::Led, "led0", None),
                device(Kind::PositionSensor, "left wheel sensor", Some(Settings::Position(0))),
            ],
            basic_step_ms: 32.0,
            texts: Texts::default(),
            mode: 2,
            supervisor: Some(Me { uid: 7, parent: 1, ..Me::default() }),
        }
    }

    #[test]
    fn a_robot_survives_the_wire_in_both_releases() {
        let lengths = [Release::R2023b, Release::R2025a].map(|release| {
            let robot = robot(release);
            let mut bytes = robot.encode();
            let length = bytes.len();
            bytes.extend([0, 0, 4]);
            assert_eq!(Robot::decode(&bytes).unwrap(), (robot.clone(), length));
            assert_eq!((robot.tag("ps0"), robot.tag("ps9")), (Some(1), None));
            assert_eq!((robot.kind(2), robot.kind(0), robot.kind(9)), (Some(Kind::Led), None, None));
            length
        });
        assert_eq!(lengths[1], lengths[0] + 4, "R2025a adds one number");
    }

    #[test]
    fn a_description_begins_with_the_documented_bytes() {
        let bytes = robot(Release::R2023b).encode();
        assert_eq!(&bytes[..18], b"\0\0\0learner\0R2023b\0");
        assert_eq!(bytes[18..24], [1, 1, 4, 0, 34, 0]);
    }

    #[test]
    fn devices_and_releases_that_nobody_knows_are_named() {
        let bytes = robot(Release::R2023b).encode();
        let replaced = |from: &[u8], to: &[u8]| {
            let at = bytes.windows(from.len()).position(|w| w == from).unwrap();
            let mut changed = bytes.clone();
            changed[at..at + from.len()].copy_from_slice(to);
            Robot::decode(&changed).unwrap_err().to_string()
        };
        assert!(replaced(b"R2023b", b"R2019a").contains("R2019a"));
        assert!(replaced(b"\x2F\0led0", b"\x33\0led0").contains("led0"));
    }
}
