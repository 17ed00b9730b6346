//! The binary half of "sercom", the E-puck's serial language: requests begin with the negative of their letter, a zero
//! ends the run, and the answers follow each other in the order of the requests, without headers.

use super::sensors::{self, Sensors};
use crate::bytes::{Reader, Writer};
use crate::error::ProtocolError;

/// The fastest a wheel of the first E-puck turns, in steps per second.
pub const MOST_STEPS: i16 = 1000;
/// Most bytes of pixels that the first E-puck can send: 52×39 in RGB565.
pub const MOST_PICTURE_BYTES: usize = 4056;
/// Bytes before the pixels of a picture.
pub const PICTURE_HEADER_BYTES: usize = 3;

/// Which program answers; they differ in the length of one answer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Firmware {
    /// BTcom on the first E-puck.
    #[default]
    First,
    /// The e-puck2's, which has cliff sensors beside the ground sensors.
    Second,
}

/// One request of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Request {
    /// Turn the wheels, left and right, in steps per second.
    Speeds([i16; 2]),
    /// Switch a light: 0 to 7 the ring, 8 the body, 9 the front; 0 off, 1 on, 2 the other way round.
    Light {
        /// Which light.
        which: u8,
        /// Its new state.
        state: u8,
    },
    /// Set the step counters.
    SetSteps([i16; 2]),
    /// Infra-red reflection of ps0 … ps7.
    Proximity,
    /// Ambient light of ps0 … ps7.
    Ambient,
    /// Raw acceleration.
    RawAcceleration,
    /// Acceleration as length, orientation and inclination.
    Acceleration,
    /// Speeds of the wheels.
    GetSpeeds,
    /// Step counters.
    GetSteps,
    /// Ground sensors.
    Ground,
    /// Microphones.
    Microphones,
    /// Raw turning rates (e-puck2).
    Gyro,
    /// Battery (e-puck2).
    Battery,
    /// Temperature (e-puck2).
    Temperature,
    /// A picture in the mode that was set last.
    Picture,
    /// All sensors but the camera at once (e-puck2).
    Everything,
}

/// What a request is answered with.
#[derive(Clone, Debug, PartialEq)]
pub enum Answer {
    /// No bytes at all.
    Nothing,
    /// Readings without sign.
    Levels(Vec<u16>),
    /// Readings with sign.
    Signed(Vec<i16>),
    /// Length, orientation and inclination.
    Polar([f32; 3]),
    /// Degrees Celsius.
    Temperature(i8),
    /// A picture.
    Picture(RawPicture),
    /// All sensors but the camera.
    Everything(Box<Sensors>),
}

/// A picture as it came.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RawPicture {
    /// Whether it has colours (RGB565) or only greys.
    pub coloured: bool,
    /// Columns and rows.
    pub size: [u8; 2],
    /// The pixels' bytes.
    pub bytes: Vec<u8>,
}

/// The byte that stands for a letter in a run.
const fn code(letter: u8) -> u8 {
    letter.wrapping_neg()
}

impl Request {
    fn letter(self) -> u8 {
        match self {
            Self::Speeds(_) => b'D',
            Self::Light { .. } => b'L',
            Self::SetSteps(_) => b'P',
            Self::Proximity => b'N',
            Self::Ambient => b'O',
            Self::RawAcceleration => b'a',
            Self::Acceleration => b'A',
            Self::GetSpeeds => b'E',
            Self::GetSteps => b'Q',
            Self::Ground => b'M',
            Self::Microphones => b'u',
            Self::Gyro => b'g',
            Self::Battery => b'b',
            Self::Temperature => b't',
            Self::Picture => b'I',
            Self::Everything => 8,
        }
    }

    fn write(self, w: &mut Writer) {
        w.u8(code(self.letter()));
        match self {
            Self::Speeds([left, right]) | Self::SetSteps([left, right]) => w.i16(left).i16(right),
            Self::Light { which, state } => w.u8(which).u8(state),
            _ => w,
        };
    }

    fn read(r: &mut Reader) -> Result<Option<Self>, ProtocolError> {
        let first = r.u8()?;
        Ok(Some(match code(first) {
            0 => return Ok(None),
            b'D' => Self::Speeds(r.many(Reader::i16)?),
            b'L' => Self::Light { which: r.u8()?, state: r.u8()? },
            b'P' => Self::SetSteps(r.many(Reader::i16)?),
            b'N' => Self::Proximity,
            b'O' => Self::Ambient,
            b'a' => Self::RawAcceleration,
            b'A' => Self::Acceleration,
            b'E' => Self::GetSpeeds,
            b'Q' => Self::GetSteps,
            b'M' => Self::Ground,
            b'u' => Self::Microphones,
            b'g' => Self::Gyro,
            b'b' => Self::Battery,
            b't' => Self::Temperature,
            b'I' => Self::Picture,
            8 => Self::Everything,
            _ => return Err(ProtocolError::Unexpected(format!("a request that begins with 0x{first:02X}"))),
        }))
    }
}

/// Whether a run (and no line of text) begins with this byte.
#[must_use]
pub fn begins_run(first: u8) -> bool {
    first >= 0x80
}

/// The bytes of a run of requests, the closing zero included.
#[must_use]
pub fn encode_run(requests: &[Request]) -> Vec<u8> {
    let mut w = Writer::new();
    requests.iter().for_each(|r| r.write(&mut w));
    w.u8(0);
    w.into_bytes()
}

/// The requests of a run and its length in bytes.
///
/// # Errors
/// [`ProtocolError::Truncated`] while the closing zero is missing; another error if the run means nothing.
pub fn decode_run(bytes: &[u8]) -> Result<(Vec<Request>, usize), ProtocolError> {
    let mut r = Reader::new(bytes);
    let mut requests = Vec::new();
    while let Some(request) = Request::read(&mut r)? {
        requests.push(request);
    }
    Ok((requests, bytes.len() - r.remaining()))
}

/// The answers to `requests`, in order.
///
/// # Errors
/// [`ProtocolError::Truncated`] while something is missing; another error if a picture's header means nothing.
pub fn decode_answers(
    requests: &[Request],
    firmware: Firmware,
    bytes: &[u8],
) -> Result<Vec<Answer>, ProtocolError> {
    let mut r = Reader::new(bytes);
    requests.iter().map(|request| decode_answer(*request, firmware, &mut r)).collect()
}

fn decode_answer(request: Request, firmware: Firmware, r: &mut Reader) -> Result<Answer, ProtocolError> {
    Ok(match request {
        Request::Speeds(_) | Request::SetSteps(_) | Request::Light { .. } => Answer::Nothing,
        Request::Proximity | Request::Ambient => Answer::Levels(r.many::<_, 8>(Reader::u16)?.to_vec()),
        Request::Ground if firmware == Firmware::Second => {
            Answer::Levels(r.many::<_, 4>(Reader::u16)?.to_vec())
        }
        Request::Ground | Request::Microphones => Answer::Levels(r.many::<_, 3>(Reader::u16)?.to_vec()),
        Request::Battery => Answer::Levels(vec![r.u16()?]),
        Request::RawAcceleration | Request::Gyro => Answer::Signed(r.many::<_, 3>(Reader::i16)?.to_vec()),
        Request::GetSpeeds | Request::GetSteps => Answer::Signed(r.many::<_, 2>(Reader::i16)?.to_vec()),
        Request::Acceleration => Answer::Polar(r.many(Reader::f32)?),
        Request::Temperature => Answer::Temperature(i8::from_le_bytes([r.u8()?])),
        Request::Picture => Answer::Picture(decode_picture(r)?),
        // The layout is that of Wi-Fi but for its last byte, which is not sent.
        Request::Everything => {
            let mut block = r.take(sensors::BYTES - 1)?.to_vec();
            block.push(0);
            Answer::Everything(Box::new(Sensors::decode(&block)?))
        }
    })
}

fn decode_picture(r: &mut Reader) -> Result<RawPicture, ProtocolError> {
    let [mode, columns, rows] = r.many(Reader::u8)?;
    let pixels = usize::from(columns) * usize::from(rows);
    let coloured = match mode {
        0 => false,
        1 => true,
        _ => return Err(ProtocolError::Unexpected(format!("a picture of mode {mode}; 0 is grey, 1 colour"))),
    };
    let bytes = r.take(if coloured { 2 * pixels } else { pixels })?.to_vec();
    Ok(RawPicture { coloured, size: [columns, rows], bytes })
}

/// The bytes of an answer.
#[must_use]
pub fn encode_answer(answer: &Answer) -> Vec<u8> {
    let mut w = Writer::new();
    match answer {
        Answer::Nothing => {}
        Answer::Levels(levels) => levels.iter().for_each(|&v| {
            w.u16(v);
        }),
        Answer::Signed(values) => values.iter().for_each(|&v| {
            w.i16(v);
        }),
        Answer::Polar([length, orientation, inclination]) => {
            w.f32(*length).f32(*orientation).f32(*inclination);
        }
        Answer::Temperature(degrees) => {
            w.raw(&degrees.to_le_bytes());
        }
        Answer::Picture(picture) => {
            w.flag(picture.coloured).raw(&picture.size).raw(&picture.bytes);
        }
        Answer::Everything(sensors) => {
            w.raw(&sensors.encode()[..sensors::BYTES - 1]);
        }
    }
    w.into_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_run_has_the_bytes_of_the_table() {
        use Request::{Everything, Ground, Light, Picture, Proximity, Speeds};
        let run = [Speeds([300, -2]), Light { which: 8, state: 1 }, Proximity, Ground, Picture, Everything];
        let golden = [0xBC, 0x2C, 0x01, 0xFE, 0xFF, 0xB4, 8, 1, 0xB2, 0xB3, 0xB7, 0xF8, 0];
        assert_eq!(encode_run(&run), golden);
        assert_eq!(decode_run(&golden).unwrap(), (run.to_vec(), golden.len()));
    }

    #[test]
    fn a_zero_among_the_arguments_does_not_end_the_run() {
        let run = [Request::Speeds([0, 0]), Request::Proximity];
        assert_eq!(decode_run(&encode_run(&run)).unwrap().0, run);
    }

    #[test]
    fn the_ground_answer_is_longer_on_the_second_robot() {
        let bytes = [1, 0, 2, 0, 3, 0, 4, 0];
        let ask = |firmware| decode_answers(&[Request::Ground], firmware, &bytes).unwrap();
        assert_eq!(ask(Firmware::First), [Answer::Levels(vec![1, 2, 3])]);
        assert_eq!(ask(Firmware::Second), [Answer::Levels(vec![1, 2, 3, 4])]);
    }

    #[test]
    fn a_picture_says_its_size() {
        let picture = RawPicture { coloured: true, size: [2, 1], bytes: vec![1, 2, 3, 4] };
        let bytes = encode_answer(&Answer::Picture(picture.clone()));
        assert_eq!(bytes, [1, 2, 1, 1, 2, 3, 4]);
        let ask = |bytes: &[u8]| decode_answers(&[Request::Picture], Firmware::First, bytes);
        assert_eq!(ask(&bytes).unwrap(), [Answer::Picture(picture)]);
        assert!(matches!(ask(&bytes[..6]), Err(ProtocolError::Truncated { .. })));
        assert!(matches!(ask(&[9, 1, 1, 0]), Err(ProtocolError::Unexpected(_))));
    }

    fn any_request() -> impl Strategy<Value = Request> {
        use Request::*;
        prop_oneof![
            any::<[i16; 2]>().prop_map(Speeds),
            any::<[i16; 2]>().prop_map(SetSteps),
            any::<[u8; 2]>().prop_map(|[which, state]| Light { which, state }),
            prop::sample::select(vec![
                Proximity,
                Ambient,
                RawAcceleration,
                Acceleration,
                GetSpeeds,
                GetSteps,
                Ground,
                Microphones,
                Gyro,
                Battery,
                Temperature,
                Picture,
                Everything,
            ]),
        ]
    }

    proptest! {
        #[test]
        fn a_run_survives_the_wire(requests in proptest::collection::vec(any_request(), 0..12), tail: [u8; 3]) {
            let mut bytes = encode_run(&requests);
            let length = bytes.len();
            for cut in 0..length {
                prop_assert!(decode_run(&bytes[..cut]).unwrap_err().wants_more());
            }
            bytes.extend(tail);
            prop_assert_eq!(decode_run(&bytes).unwrap(), (requests, length));
        }

        #[test]
        fn answers_read_from_any_bytes_are_written_back(
            requests in proptest::collection::vec(any_request(), 0..6),
            bytes in proptest::collection::vec(any::<u8>(), 0..700),
        ) {
            if let Ok(answers) = decode_answers(&requests, Firmware::Second, &bytes) {
                let again: Vec<u8> = answers.iter().flat_map(encode_answer).collect();
                prop_assert_eq!(&again[..], &bytes[..again.len()]);
            }
        }
    }
}
