//! What Webots says about a device when a controller connects.

use crate::bytes::{Reader, Writer};
use crate::error::ProtocolError;

/// Kind of a device, by its node type in Webots.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Accelerations along three axes.
    Accelerometer,
    /// Pictures.
    Camera,
    /// Distances; an E-puck's infra-red sensors.
    DistanceSensor,
    /// Radio, sending.
    Emitter,
    /// Turning rates about three axes.
    Gyro,
    /// A light.
    Led,
    /// Ambient light.
    LightSensor,
    /// Angle of a joint; an E-puck's wheel encoders.
    PositionSensor,
    /// Radio, receiving.
    Receiver,
    /// Turns a joint.
    Motor,
    /// Sounds.
    Speaker,
}

impl Kind {
    /// All kinds with their node types.
    pub const ALL: [(u16, Self); 11] = [
        (35, Self::Accelerometer),
        (38, Self::Camera),
        (42, Self::DistanceSensor),
        (43, Self::Emitter),
        (45, Self::Gyro),
        (47, Self::Led),
        (49, Self::LightSensor),
        (52, Self::PositionSensor),
        (56, Self::Receiver),
        (57, Self::Motor),
        (59, Self::Speaker),
    ];

    /// The kind with this node type, if its messages are known.
    #[must_use]
    pub fn of(node: u16) -> Option<Self> {
        Self::ALL.iter().find(|(n, _)| *n == node).map(|(_, kind)| *kind)
    }

    /// Its node type.
    #[must_use]
    pub fn node(self) -> u16 {
        Self::ALL.iter().find(|(_, kind)| *kind == self).map_or(0, |(node, _)| *node)
    }
}

/// A camera's settings.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Camera {
    /// Number of the node.
    pub uid: u32,
    /// Columns and rows.
    pub size: [u16; 2],
    /// Angle of view across, in radians.
    pub field_of_view_rad: f64,
    /// Distance of the near clipping plane, in metres.
    pub near_m: f64,
    /// Whether the projection is planar, and whether the camera recognises and segments.
    pub planar_recognising_segmenting: [bool; 3],
    /// Least and largest angle of view, in radians.
    pub field_of_view_range_rad: [f64; 2],
    /// Exposure, focal length, focal distance, least and largest focal distance.
    pub optics: [f64; 5],
}

/// A motor's settings.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Motor {
    /// 0: turning, 1: sliding.
    pub kind: i32,
    /// Least and largest position, largest velocity, acceleration, largest torque, P, I, D, target position, target
    /// velocity, multiplier.
    pub numbers: [f64; 11],
    /// Motors that turn along.
    pub coupled: Vec<u16>,
}

/// A radio's settings.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Radio {
    /// Size of its buffer in bytes (−1: no limit) and its channel.
    pub buffer_channel: [i32; 2],
    /// Bytes a second, range and largest range in metres (an emitter only).
    pub rate_range: Option<[f64; 3]>,
    /// Channels it may use.
    pub allowed: Vec<i32>,
}

/// What Webots says about a device.
#[derive(Clone, Debug, PartialEq)]
pub enum Settings {
    /// A camera's.
    Camera(Camera),
    /// A distance sensor's: kind (1: infra-red), least, largest reading and aperture, look-up table.
    Distance(i32, [f64; 3], Vec<[f64; 3]>),
    /// A light sensor's, accelerometer's or gyro's look-up table.
    Table(Vec<[f64; 3]>),
    /// A motor's.
    Motor(Motor),
    /// A position sensor's kind (0: turning).
    Position(i32),
    /// An emitter's or receiver's.
    Radio(Radio),
}

/// The settings of a device of `kind`; none for lights and speakers, which have none.
///
/// # Errors
/// If the bytes end too early.
pub fn read(kind: Kind, r: &mut Reader) -> Result<Option<Settings>, ProtocolError> {
    Ok(Some(match kind {
        Kind::Accelerometer | Kind::Gyro | Kind::LightSensor => Settings::Table(read_table(r)?),
        Kind::Camera => Settings::Camera(read_camera(r)?),
        Kind::DistanceSensor => Settings::Distance(r.i32()?, r.many(Reader::f64)?, read_table(r)?),
        Kind::Emitter => Settings::Radio(read_radio(r, true)?),
        Kind::Receiver => Settings::Radio(read_radio(r, false)?),
        Kind::Motor => Settings::Motor(read_motor(r)?),
        Kind::PositionSensor => Settings::Position(r.i32()?),
        Kind::Led | Kind::Speaker => return Ok(None),
    }))
}

/// Writes a device's settings.
pub fn write(settings: &Settings, w: &mut Writer) {
    match settings {
        Settings::Table(table) => write_table(table, w),
        Settings::Camera(camera) => write_camera(camera, w),
        Settings::Distance(kind, numbers, table) => {
            w.i32(*kind).f64s(numbers);
            write_table(table, w);
        }
        Settings::Radio(radio) => {
            w.i32(radio.buffer_channel[0]).i32(radio.buffer_channel[1]);
            w.f64s(radio.rate_range.as_ref().map_or(&[], |r| &r[..])).i32(radio.allowed.len() as i32);
            radio.allowed.iter().for_each(|&channel| {
                w.i32(channel);
            });
        }
        Settings::Motor(motor) => {
            w.i32(motor.kind).f64s(&motor.numbers).i32(motor.coupled.len() as i32);
            motor.coupled.iter().for_each(|&tag| {
                w.u16(tag);
            });
        }
        Settings::Position(kind) => {
            w.i32(*kind);
        }
    }
}

/// How often something repeats; a negative number means not at all.
fn count(r: &mut Reader) -> Result<usize, ProtocolError> {
    let count = usize::try_from(r.i32()?).unwrap_or(0);
    // Whatever repeats has at least two bytes, so more cannot be there: no memory for a lie.
    if count > r.remaining() {
        return Err(ProtocolError::Truncated { wanted: 2 * count, left: r.remaining() });
    }
    Ok(count)
}

fn read_table(r: &mut Reader) -> Result<Vec<[f64; 3]>, ProtocolError> {
    (0..count(r)?).map(|_| r.many(Reader::f64)).collect()
}

fn write_table(table: &[[f64; 3]], w: &mut Writer) {
    w.i32(table.len() as i32).f64s(table.as_flattened());
}

fn read_motor(r: &mut Reader) -> Result<Motor, ProtocolError> {
    let (kind, numbers) = (r.i32()?, r.many(Reader::f64)?);
    let coupled = (0..count(r)?).map(|_| r.u16()).collect::<Result<_, _>>()?;
    Ok(Motor { kind, numbers, coupled })
}

fn read_radio(r: &mut Reader, sends: bool) -> Result<Radio, ProtocolError> {
    let buffer_channel = r.many(Reader::i32)?;
    let rate_range = if sends { Some(r.many(Reader::f64)?) } else { None };
    let allowed = (0..count(r)?).map(|_| r.i32()).collect::<Result<_, _>>()?;
    Ok(Radio { buffer_channel, rate_range, allowed })
}

fn read_camera(r: &mut Reader) -> Result<Camera, ProtocolError> {
    let (uid, size) = (r.u32()?, r.many(Reader::u16)?);
    let (field_of_view_rad, near_m, planar) = (r.f64()?, r.f64()?, r.u8()? != 0);
    let field_of_view_range_rad = r.many(Reader::f64)?;
    let planar_recognising_segmenting = [planar, r.u8()? != 0, r.u8()? != 0];
    Ok(Camera {
        uid,
        size,
        field_of_view_rad,
        near_m,
        planar_recognising_segmenting,
        field_of_view_range_rad,
        optics: r.many(Reader::f64)?,
    })
}

fn write_camera(camera: &Camera, w: &mut Writer) {
    let [planar, recognising, segmenting] = camera.planar_recognising_segmenting;
    w.u32(camera.uid).u16(camera.size[0]).u16(camera.size[1]);
    w.f64(camera.field_of_view_rad).f64(camera.near_m).flag(planar);
    w.f64s(&camera.field_of_view_range_rad).flag(recognising).flag(segmenting).f64s(&camera.optics);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Settings of every kind that has some.
    pub(crate) fn samples() -> Vec<(Kind, Settings)> {
        let table = vec![[0.0, 4095.0, 0.002], [0.07, 67.19, 0.04897]];
        let camera = Camera {
            uid: 17,
            size: [52, 39],
            field_of_view_rad: 0.84,
            near_m: 0.0055,
            planar_recognising_segmenting: [true, false, true],
            field_of_view_range_rad: [0.84, 0.84],
            optics: [1.0, 2.0, 3.0, 4.0, 5.0],
        };
        let radio = |rate_range| Radio { buffer_channel: [-1, 1], rate_range, allowed: vec![1, 2] };
        vec![
            (Kind::Accelerometer, Settings::Table(table.clone())),
            (Kind::Gyro, Settings::Table(Vec::new())),
            (Kind::LightSensor, Settings::Table(table.clone())),
            (Kind::DistanceSensor, Settings::Distance(1, [67.0, 4095.0, 0.1], table)),
            (Kind::Camera, Settings::Camera(camera)),
            (Kind::Emitter, Settings::Radio(radio(Some([1e4, 1.0, -1.0])))),
            (Kind::Receiver, Settings::Radio(radio(None))),
            (Kind::Motor, Settings::Motor(Motor { kind: 0, numbers: [0.5; 11], coupled: vec![3] })),
            (Kind::PositionSensor, Settings::Position(0)),
        ]
    }

    #[test]
    fn settings_survive_the_wire_and_no_cut_is_taken_for_whole() {
        for (kind, settings) in samples() {
            let mut w = Writer::new();
            write(&settings, &mut w);
            let bytes = w.into_bytes();
            let mut r = Reader::new(&bytes);
            assert_eq!(read(kind, &mut r).unwrap(), Some(settings), "{kind:?}");
            assert_eq!(r.remaining(), 0, "{kind:?}");
            for cut in 0..bytes.len() {
                assert!(read(kind, &mut Reader::new(&bytes[..cut])).is_err(), "{kind:?} cut at {cut}");
            }
        }
    }

    #[test]
    fn a_table_longer_than_its_message_costs_no_memory() {
        let mut w = Writer::new();
        w.i32(i32::MAX).f64(1.0);
        let bytes = w.into_bytes();
        assert!(matches!(read_table(&mut Reader::new(&bytes)), Err(ProtocolError::Truncated { .. })));
    }

    #[test]
    fn kinds_and_node_types_belong_together() {
        assert!(Kind::ALL.iter().all(|&(node, kind)| Kind::of(node) == Some(kind) && kind.node() == node));
        assert_eq!(Kind::of(36), None);
    }
}
