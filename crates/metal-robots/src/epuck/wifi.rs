//! The e-puck2 over Wi-Fi (TCP port 1000): 21 bytes there, pictures and sensors back, each behind a byte that names it.

use super::sensors::{self, Sensors};
use crate::bytes::{Reader, Writer};
use crate::error::ProtocolError;
use crate::picture::{WIFI_COLUMNS, WIFI_ROWS};

/// Length of a command, in bytes.
pub const COMMAND_BYTES: usize = 21;
/// Length of a picture, in bytes.
pub const PICTURE_BYTES: usize = 2 * WIFI_COLUMNS * WIFI_ROWS;
/// The fastest a wheel of an e-puck2 turns, in steps per second.
pub const MOST_STEPS: i16 = 1200;

const COMMAND: u8 = 0x80;
const PICTURE: u8 = 1;
const SENSORS: u8 = 2;
const NOTHING: u8 = 3;

/// What the robot shall send. What is not wanted is not sent: attention saves real bytes here.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wanted {
    /// The camera's picture.
    pub picture: bool,
    /// The block of all other sensors.
    pub sensors: bool,
}

/// What the wheels shall do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// Turn at these speeds, left and right, in steps per second.
    Speed([i16; 2]),
    /// Go to these positions, in steps.
    Steps([i16; 2]),
}

/// What the robot shall do by itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Habits {
    /// Take the infra-red readings of now as those of free space.
    pub calibrate: bool,
    /// Avoid obstacles on board.
    pub avoid_obstacles: bool,
}

/// One command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Command {
    /// What the robot shall send.
    pub wanted: Wanted,
    /// What it shall do by itself.
    pub habits: Habits,
    /// What the wheels shall do.
    pub motion: Motion,
    /// Bits 0 to 3: LED1, 3, 5, 7; bit 4: body; bit 5: front.
    pub lights: u8,
    /// Red, green and blue (0 to 100) of LED2, 4, 6 and 8.
    pub colours: [[u8; 3]; 4],
    /// Bits of the sound to play.
    pub sound: u8,
}

impl Command {
    /// Speeds and wishes, everything else dark and silent.
    #[must_use]
    pub fn drive(speeds: [i16; 2], wanted: Wanted) -> Self {
        Self {
            wanted,
            habits: Habits::default(),
            motion: Motion::Speed(speeds),
            lights: 0,
            colours: [[0; 3]; 4],
            sound: 0,
        }
    }

    /// The 21 bytes.
    #[must_use]
    pub fn encode(&self) -> Vec<u8> {
        let (positions, [left, right]) = match self.motion {
            Motion::Speed(speeds) => (false, speeds),
            Motion::Steps(steps) => (true, steps),
        };
        let mut w = Writer::new();
        w.u8(COMMAND).u8(bits([self.wanted.picture, self.wanted.sensors, false]));
        w.u8(bits([self.habits.calibrate, self.habits.avoid_obstacles, positions]));
        w.i16(left).i16(right).u8(self.lights).raw(self.colours.as_flattened()).u8(self.sound);
        w.into_bytes()
    }

    /// The meaning of 21 bytes.
    ///
    /// # Errors
    /// If there are fewer, or they begin with another byte than 0x80.
    pub fn decode(bytes: &[u8]) -> Result<Self, ProtocolError> {
        let mut r = Reader::new(bytes);
        let first = r.u8()?;
        if first != COMMAND {
            return Err(ProtocolError::Unexpected(format!("a command that begins with 0x{first:02X}")));
        }
        let (wanted, habits) = (r.u8()?, r.u8()?);
        let wheels = r.many(Reader::i16)?;
        Ok(Self {
            wanted: Wanted { picture: wanted & 1 != 0, sensors: wanted & 2 != 0 },
            habits: Habits { calibrate: habits & 1 != 0, avoid_obstacles: habits & 2 != 0 },
            motion: if habits & 4 == 0 { Motion::Speed(wheels) } else { Motion::Steps(wheels) },
            lights: r.u8()?,
            colours: r.many(|r| r.many(Reader::u8))?,
            sound: r.u8()?,
        })
    }
}

fn bits(flags: [bool; 3]) -> u8 {
    flags.iter().enumerate().map(|(i, &flag)| u8::from(flag) << i).sum()
}

/// One answer.
#[derive(Clone, Debug, PartialEq)]
pub enum Answer {
    /// 160×120 pixels in RGB565.
    Picture(Vec<u8>),
    /// All sensors but the camera.
    Sensors(Box<Sensors>),
    /// Nothing was wanted.
    Nothing,
}

impl Answer {
    /// Number of bytes that follow the byte `name`.
    ///
    /// # Errors
    /// If no answer has this name.
    pub fn length(name: u8) -> Result<usize, ProtocolError> {
        match name {
            PICTURE => Ok(PICTURE_BYTES),
            SENSORS => Ok(sensors::BYTES),
            NOTHING => Ok(0),
            other => Err(ProtocolError::Unexpected(format!("an answer called 0x{other:02X}"))),
        }
    }

    /// The answer `name` with the bytes that follow it.
    ///
    /// # Errors
    /// If no answer has this name, or the bytes are too few.
    pub fn decode(name: u8, payload: &[u8]) -> Result<Self, ProtocolError> {
        let payload = Reader::new(payload).take(Self::length(name)?)?;
        Ok(match name {
            PICTURE => Self::Picture(payload.to_vec()),
            SENSORS => Self::Sensors(Box::new(Sensors::decode(payload)?)),
            _ => Self::Nothing,
        })
    }

    /// Name and payload.
    #[must_use]
    pub fn encode(&self) -> Vec<u8> {
        let (name, payload) = match self {
            Self::Picture(bytes) => (PICTURE, bytes.clone()),
            Self::Sensors(sensors) => (SENSORS, sensors.encode()),
            Self::Nothing => (NOTHING, Vec::new()),
        };
        let mut bytes = vec![name];
        bytes.extend(payload);
        bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_command_has_the_bytes_of_the_table() {
        let wanted = Wanted { picture: true, sensors: true };
        let mut command = Command::drive([-300, 600], wanted);
        command.lights = 0b11_0001;
        command.colours[3] = [1, 2, 3];
        command.sound = 0x20;
        let golden = [0x80, 3, 0, 0xD4, 0xFE, 0x58, 0x02, 0x31, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 2, 3, 0x20];
        assert_eq!(command.encode(), golden);
    }

    #[test]
    fn an_answer_that_nobody_knows_is_refused() {
        assert!(Answer::length(4).is_err());
        assert!(Answer::decode(2, &[0; 103]).is_err());
        assert_eq!(Answer::Nothing.encode(), [3]);
        assert!(Command::decode(&[0x81; 21]).is_err());
    }

    proptest! {
        #[test]
        fn a_command_survives_the_wire(
            wanted in (any::<bool>(), any::<bool>()),
            habits in (any::<bool>(), any::<bool>()),
            wheels: [i16; 2], by_steps: bool, rest in (any::<u8>(), any::<[[u8; 3]; 4]>(), any::<u8>()),
        ) {
            let command = Command {
                wanted: Wanted { picture: wanted.0, sensors: wanted.1 },
                habits: Habits { calibrate: habits.0, avoid_obstacles: habits.1 },
                motion: if by_steps { Motion::Steps(wheels) } else { Motion::Speed(wheels) },
                lights: rest.0, colours: rest.1, sound: rest.2,
            };
            let bytes = command.encode();
            prop_assert_eq!(bytes.len(), COMMAND_BYTES);
            prop_assert_eq!(Command::decode(&bytes).unwrap(), command);
        }

        #[test]
        fn no_bytes_make_the_decoders_fall(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
            let _ = Command::decode(&bytes);
            if let Some((&name, payload)) = bytes.split_first() {
                let _ = Answer::decode(name, payload);
            }
        }
    }
}
