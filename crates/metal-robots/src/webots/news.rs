//! What the simulator reports after a step.

use super::device::{self, Kind, Settings};
use super::robot::{CONFIGURE, Robot};
use super::supervisor::Fact;
use super::{ROBOT, Release};
use crate::bytes::{Reader, Writer};
use crate::error::ProtocolError;

/// One piece of news.
#[derive(Clone, Debug, PartialEq)]
pub enum News {
    /// Time of the simulation, in seconds.
    Time(f64),
    /// The controller shall end.
    Quit,
    /// 0: paused, 1: real time, 2: fast.
    Mode(i32),
    /// A supervisor's fact.
    Fact(Fact),
    /// A reading of one number: a distance sensor's, light sensor's or position sensor's.
    Reading(u16, f64),
    /// A reading of three numbers: an accelerometer's or gyro's.
    Vector(u16, [f64; 3]),
    /// A device describes itself anew.
    Settings(u16, Settings),
    /// Something that changes nothing here.
    Other(u16, u8),
}

fn reading_op(kind: Kind) -> Option<u8> {
    match kind {
        Kind::DistanceSensor => Some(50),
        Kind::LightSensor => Some(55),
        Kind::PositionSensor => Some(1),
        Kind::Accelerometer => Some(51),
        Kind::Gyro => Some(53),
        _ => None,
    }
}

/// Appends the reading of the device with `tag`, of `kind`; kinds without readings have none to write.
pub fn write_reading(tag: u16, kind: Kind, values: &[f64], w: &mut Writer) {
    if let Some(op) = reading_op(kind) {
        w.u16(tag).u8(op).f64s(values);
    }
}

/// Appends the time of the simulation.
pub fn write_time(time_s: f64, w: &mut Writer) {
    w.u16(ROBOT).u8(4).f64(time_s);
}

/// Appends a supervisor's fact.
pub fn write_fact(fact: &Fact, release: Release, w: &mut Writer) {
    w.u16(ROBOT);
    fact.write(release, w);
}

/// Reads all news of `robot`; `hear` gets each.
///
/// # Errors
/// If a message is not known (it has no length, so nothing behind it can be read) or ends too early.
pub fn read_all(robot: &Robot, news: &[u8], mut hear: impl FnMut(News)) -> Result<(), ProtocolError> {
    let mut r = Reader::new(news);
    while r.remaining() > 0 {
        let (tag, op) = (r.u16()?, r.u8()?);
        let unknown = || ProtocolError::Unexpected(format!("message {op} of device {tag}"));
        hear(if tag == ROBOT {
            robots(robot.release, op, &mut r)?.ok_or_else(unknown)?
        } else {
            let kind = robot.kind(tag).ok_or_else(unknown)?;
            devices(kind, (tag, op), &mut r)?.ok_or_else(unknown)?
        });
    }
    Ok(())
}

fn robots(release: Release, op: u8, r: &mut Reader) -> Result<Option<News>, ProtocolError> {
    Ok(Some(match op {
        4 => News::Time(r.f64()?),
        2 => News::Quit,
        10 => News::Mode(r.i32()?),
        5 => {
            r.f64()?;
            News::Other(ROBOT, op)
        }
        9 | 14 => News::Other(ROBOT, op),
        11 | 13 => {
            r.text()?;
            News::Other(ROBOT, op)
        }
        12 | 16..=18 => {
            r.u8()?;
            News::Other(ROBOT, op)
        }
        20 => {
            r.i32()?;
            r.text()?;
            r.i32()?;
            News::Other(ROBOT, op)
        }
        19 => News::Other(ROBOT, op),
        81 => {
            let length = usize::try_from(r.i32()?).unwrap_or(0);
            r.take(length)?;
            News::Other(ROBOT, op)
        }
        _ => return Ok(Fact::read(op, release, r)?.map(News::Fact)),
    }))
}

fn devices(kind: Kind, (tag, op): (u16, u8), r: &mut Reader) -> Result<Option<News>, ProtocolError> {
    if Some(op) == reading_op(kind) {
        return Ok(Some(match kind {
            Kind::Accelerometer | Kind::Gyro => News::Vector(tag, r.many(Reader::f64)?),
            _ => News::Reading(tag, r.f64()?),
        }));
    }
    if op == CONFIGURE {
        return Ok(Some(device::read(kind, r)?.map_or(News::Other(tag, op), |s| News::Settings(tag, s))));
    }
    match (kind, op) {
        (Kind::Motor, 5) => {
            r.f64()?;
        }
        (Kind::Motor, 8) | (Kind::PositionSensor, 2) => {
            r.u16()?;
        }
        (Kind::Camera, 7) => {
            r.many::<_, 2>(Reader::f64)?;
            r.u8()?;
            r.many::<_, 2>(Reader::f64)?;
            r.u16()?;
            r.many::<_, 5>(Reader::f64)?;
        }
        (Kind::Receiver, 1) => {
            r.i32()?;
            r.many::<_, 4>(Reader::f64)?;
            let length = usize::try_from(r.i32()?).unwrap_or(0);
            r.take(length)?;
        }
        (Kind::Emitter, 1 | 3) => {
            r.i32()?;
        }
        (Kind::Emitter, 2) => {
            r.f64()?;
        }
        (Kind::Emitter, 4) => {
            let count = usize::try_from(r.i32()?).unwrap_or(0);
            r.take(count.saturating_mul(4))?;
        }
        (Kind::Speaker, 6) => {
            r.text()?;
        }
        (Kind::Speaker, 7) => {}
        _ => return Ok(None),
    }
    Ok(Some(News::Other(tag, op)))
}

#[cfg(test)]
mod tests {
    use super::super::robot::{Device, Texts};
    use super::*;
    use proptest::prelude::*;

    fn robot() -> Robot {
        let devices = Kind::ALL.map(|(_, kind)| Device {
            kind,
            name: format!("{kind:?}"),
            model: String::new(),
            settings: None,
        });
        Robot {
            name: "all".to_owned(),
            release: Release::R2023b,
            synchronised: true,
            time_s: 0.0,
            devices: devices.to_vec(),
            basic_step_ms: 32.0,
            texts: Texts::default(),
            mode: 2,
            supervisor: None,
        }
    }

    fn heard(news: &[u8]) -> Result<Vec<News>, ProtocolError> {
        let mut all = Vec::new();
        read_all(&robot(), news, |n| all.push(n)).map(|()| all)
    }

    #[test]
    fn every_reading_is_heard() {
        let robot = robot();
        let tag = |name: &str| robot.tag(name).unwrap();
        let mut w = Writer::new();
        write_time(0.064, &mut w);
        write_reading(tag("DistanceSensor"), Kind::DistanceSensor, &[67.0], &mut w);
        write_reading(tag("Gyro"), Kind::Gyro, &[1.0, 2.0, 3.0], &mut w);
        write_reading(tag("PositionSensor"), Kind::PositionSensor, &[0.5], &mut w);
        write_fact(&Fact::Position([1.0, 0.0, 0.0]), Release::R2023b, &mut w);
        w.u16(ROBOT).u8(2);
        let expected = [
            News::Time(0.064),
            News::Reading(tag("DistanceSensor"), 67.0),
            News::Vector(tag("Gyro"), [1.0, 2.0, 3.0]),
            News::Reading(tag("PositionSensor"), 0.5),
            News::Fact(Fact::Position([1.0, 0.0, 0.0])),
            News::Quit,
        ];
        assert_eq!(heard(&w.into_bytes()).unwrap(), expected);
    }

    #[test]
    fn an_unknown_message_is_an_error_with_its_place() {
        let error = heard(&[0, 0, 200]).unwrap_err().to_string();
        assert!(error.contains("message 200 of device 0"), "{error}");
        assert!(heard(&[99, 0, 1]).is_err());
        // A distance sensor answers with its own operation only: a light sensor's would be misread.
        let tag = robot().tag("DistanceSensor").unwrap() as u8;
        assert!(heard(&[tag, 0, 55, 0, 0, 0, 0, 0, 0, 0, 0]).is_err());
    }

    proptest! {
        #[test]
        fn no_bytes_make_the_decoder_fall(bytes in proptest::collection::vec(any::<u8>(), 0..80)) {
            let _ = heard(&bytes);
        }
    }
}
