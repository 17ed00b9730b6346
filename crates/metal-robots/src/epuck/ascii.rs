//! The readable half of "sercom": a letter and numbers separated by commas, a line each.

use crate::error::ProtocolError;

/// A command in text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// Say who you are.
    Version,
    /// Turn the wheels, in steps per second.
    Speeds([i16; 2]),
    /// Stop the wheels and switch off the lights.
    Stop,
    /// Speeds of the wheels.
    GetSpeeds,
    /// Step counters.
    GetSteps,
    /// Set the step counters.
    SetSteps([i16; 2]),
    /// Infra-red reflection.
    Proximity,
    /// Ambient light.
    Ambient,
    /// Raw acceleration.
    Acceleration,
    /// Ground sensors.
    Ground,
    /// Take the infra-red readings of now as those of free space. Takes seconds.
    Calibrate,
    /// Mode of the camera.
    GetCamera,
    /// Set the mode of the camera.
    Camera(Camera),
    /// Position of the selector.
    Selector,
    /// Switch a light of the ring.
    Light([u8; 2]),
    /// Switch the light of the body.
    Body(u8),
    /// Switch the light in front.
    Front(u8),
    /// Battery (e-puck2).
    Battery,
}

/// What the camera shall deliver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Camera {
    /// Colours (RGB565) or greys.
    pub coloured: bool,
    /// Columns and rows.
    pub size: [u16; 2],
    /// Sensor pixels per pixel.
    pub zoom: u16,
    /// Upper left corner in pixels of the sensor (640×480); centred if absent.
    pub corner: Option<[u16; 2]>,
}

impl Command {
    /// The letter of its line.
    #[must_use]
    pub fn letter(&self) -> char {
        match self {
            Self::Version => 'V',
            Self::Speeds(_) => 'D',
            Self::Stop => 'S',
            Self::GetSpeeds => 'E',
            Self::GetSteps => 'Q',
            Self::SetSteps(_) => 'P',
            Self::Proximity => 'N',
            Self::Ambient => 'O',
            Self::Acceleration => 'A',
            Self::Ground => 'M',
            Self::Calibrate => 'K',
            Self::GetCamera => 'I',
            Self::Camera(_) => 'J',
            Self::Selector => 'C',
            Self::Light(_) => 'L',
            Self::Body(_) => 'B',
            Self::Front(_) => 'F',
            Self::Battery => 'b',
        }
    }

    fn numbers(&self) -> Vec<i32> {
        match self {
            Self::Speeds(pair) | Self::SetSteps(pair) => pair.map(i32::from).to_vec(),
            Self::Light(pair) => pair.map(i32::from).to_vec(),
            Self::Body(state) | Self::Front(state) => vec![i32::from(*state)],
            Self::Camera(camera) => {
                let [columns, rows] = camera.size;
                let mut numbers = vec![u16::from(camera.coloured), columns, rows, camera.zoom];
                numbers.extend(camera.corner.iter().flatten());
                numbers.into_iter().map(i32::from).collect()
            }
            _ => Vec::new(),
        }
    }

    /// The line, its end included.
    #[must_use]
    pub fn encode(&self) -> String {
        let numbers: String = self.numbers().iter().map(|n| format!(",{n}")).collect();
        format!("{}{numbers}\n", self.letter())
    }

    /// The meaning of a line.
    ///
    /// # Errors
    /// If it means nothing.
    pub fn decode(line: &str) -> Result<Self, ProtocolError> {
        let refuse = || ProtocolError::Unexpected(format!("the command `{}`", line.trim().escape_debug()));
        let Answer { letter, numbers, .. } = Answer::decode(line)?;
        let whole = |n: &i32| u16::try_from(*n).ok();
        let command = match (letter, numbers.as_slice()) {
            ('V', []) => Some(Self::Version),
            ('D', [l, r]) => pair(*l, *r).map(Self::Speeds),
            ('P', [l, r]) => pair(*l, *r).map(Self::SetSteps),
            ('S', []) => Some(Self::Stop),
            ('E', []) => Some(Self::GetSpeeds),
            ('Q', []) => Some(Self::GetSteps),
            ('N', []) => Some(Self::Proximity),
            ('O', []) => Some(Self::Ambient),
            ('A', []) => Some(Self::Acceleration),
            ('M', []) => Some(Self::Ground),
            ('K', []) => Some(Self::Calibrate),
            ('I', []) => Some(Self::GetCamera),
            ('C', []) => Some(Self::Selector),
            ('b', []) => Some(Self::Battery),
            ('B', [state]) => u8::try_from(*state).ok().map(Self::Body),
            ('F', [state]) => u8::try_from(*state).ok().map(Self::Front),
            ('L', [which, state]) => {
                u8::try_from(*which).ok().zip(u8::try_from(*state).ok()).map(|(w, s)| Self::Light([w, s]))
            }
            ('J', [mode @ (0 | 1), rest @ ..]) => {
                let rest: Option<Vec<u16>> = rest.iter().map(whole).collect();
                camera(*mode == 1, &rest.ok_or_else(refuse)?)
            }
            _ => None,
        };
        command.ok_or_else(refuse)
    }
}

fn pair(left: i32, right: i32) -> Option<[i16; 2]> {
    Some([i16::try_from(left).ok()?, i16::try_from(right).ok()?])
}

fn camera(coloured: bool, numbers: &[u16]) -> Option<Command> {
    let (size, zoom, corner) = match *numbers {
        [columns, rows, zoom] => ([columns, rows], zoom, None),
        [columns, rows, zoom, x, y] => ([columns, rows], zoom, Some([x, y])),
        _ => return None,
    };
    Some(Command::Camera(Camera { coloured, size, zoom, corner }))
}

/// A line that came back: the letter in small, then numbers or words.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Answer {
    /// The letter of the command, in small.
    pub letter: char,
    /// The numbers behind it, if there are only numbers.
    pub numbers: Vec<i32>,
    /// Everything behind the letter and its comma.
    pub text: String,
}

impl Answer {
    /// An answer of numbers.
    #[must_use]
    pub fn of(letter: char, numbers: &[i32]) -> Self {
        let text: Vec<String> = numbers.iter().map(i32::to_string).collect();
        Self { letter, numbers: numbers.to_vec(), text: text.join(",") }
    }

    /// An answer of words.
    #[must_use]
    pub fn words(letter: char, text: &str) -> Self {
        Self { letter, numbers: Vec::new(), text: text.to_owned() }
    }

    /// The line, its end included.
    #[must_use]
    pub fn encode(&self) -> String {
        let comma = if self.text.is_empty() { "" } else { "," };
        format!("{}{comma}{}\r\n", self.letter, self.text)
    }

    /// The meaning of a line.
    ///
    /// # Errors
    /// If it does not begin with a letter, followed by a comma or nothing.
    pub fn decode(line: &str) -> Result<Self, ProtocolError> {
        let line = line.trim_end_matches(['\r', '\n']);
        let refuse = || ProtocolError::Unexpected(format!("the line `{}`", line.escape_debug()));
        let mut rest = line.chars();
        let letter = rest.next().filter(char::is_ascii_alphabetic).ok_or_else(refuse)?;
        let text = match rest.next() {
            None => "",
            Some(',') => rest.as_str(),
            Some(_) => return Err(refuse()),
        };
        let numbers: Result<Vec<i32>, _> = text.split(',').map(|n| n.trim().parse()).collect();
        Ok(Self { letter, numbers: numbers.unwrap_or_default(), text: text.to_owned() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn lines_are_those_of_the_table() {
        let camera = Camera { coloured: true, size: [52, 39], zoom: 8, corner: None };
        assert_eq!(Command::Camera(camera).encode(), "J,1,52,39,8\n");
        let region = Camera { corner: Some([112, 84]), ..camera };
        assert_eq!(Command::Camera(region).encode(), "J,1,52,39,8,112,84\n");
        assert_eq!(Command::Speeds([-100, 1000]).encode(), "D,-100,1000\n");
        assert_eq!(Command::Version.encode(), "V\n");
        assert_eq!(Answer::of('n', &[1, 2]).encode(), "n,1,2\r\n");
        assert_eq!(Answer::of('d', &[]).encode(), "d\r\n");
    }

    #[test]
    fn answers_are_numbers_or_words() {
        let version = Answer::decode("v,Version 1.2.3 March 2010\r\n").unwrap();
        assert_eq!((version.letter, version.text.as_str()), ('v', "Version 1.2.3 March 2010"));
        assert_eq!(Answer::decode("e,-5,7\r\n").unwrap().numbers, [-5, 7]);
        assert!(Answer::decode("").is_err());
        assert!(Answer::decode("hello").is_err());
        assert!(Command::decode("D,1\n").is_err());
        assert!(Command::decode("J,2,1,1,1\n").is_err());
    }

    fn any_command() -> impl Strategy<Value = Command> {
        use Command::*;
        let camera = (any::<bool>(), any::<[u16; 2]>(), any::<u16>(), any::<Option<[u16; 2]>>())
            .prop_map(|(coloured, size, zoom, corner)| self::Camera { coloured, size, zoom, corner });
        prop_oneof![
            any::<[i16; 2]>().prop_map(Speeds),
            any::<[i16; 2]>().prop_map(SetSteps),
            camera.prop_map(Camera),
            any::<[u8; 2]>().prop_map(Light),
            any::<u8>().prop_map(Body),
            any::<u8>().prop_map(Front),
            prop::sample::select(vec![
                Version,
                Stop,
                GetSpeeds,
                GetSteps,
                Proximity,
                Ambient,
                Acceleration,
                Ground,
                Calibrate,
                GetCamera,
                Selector,
                Battery,
            ]),
        ]
    }

    proptest! {
        #[test]
        fn a_command_survives_the_wire(command in any_command()) {
            prop_assert_eq!(Command::decode(&command.encode()).unwrap(), command);
        }

        #[test]
        fn no_line_makes_the_decoders_fall(line in ".{0,40}") {
            let _ = Answer::decode(&line);
            let _ = Command::decode(&line);
        }
    }
}
