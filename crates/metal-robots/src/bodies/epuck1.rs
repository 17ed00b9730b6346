//! The E-puck over its serial line: a cable, or Bluetooth as `/dev/rfcomm0`. Also the e-puck2 in its compatible mode.
//!
//! Attention is worth most here: a whole picture takes 0.35 s at 115 200 baud, the ring of infra-red sensors 1.6 ms. With
//! [`Options::crop`] the camera is set to the window of the attended region before each picture.
//!
//! Every speed is sent together with a question for the step counters, so that a dead link is noticed at once. What a
//! robot does alone when its link dies is up to its firmware: BTcom keeps the last speed, so keep within reach.

use super::part;
use super::real::{self, OnLine};
use crate::body::{About, Body, Feelings, INFRARED, InfraredScale, Wheels};
use crate::epuck::ascii::{self, Camera, Command};
use crate::epuck::binary::{self, Answer, Firmware, MOST_STEPS, Request};
use crate::epuck::metres_per_second;
use crate::error::{BodyError, ProtocolError};
use crate::link::{Line, Meter, Opener, Patience};
use crate::picture::{Picture, decode_565};
use metal_worlds::highway::camera::Window;

/// Sensor pixels per pixel of the picture.
const ZOOM: u16 = 8;
/// Upper left corner of the whole picture on the camera's sensor of 640×480 pixels, centred.
const CORNER: [u16; 2] = [(640 - 52 * ZOOM) / 2, (480 - 39 * ZOOM) / 2];
/// How often the version is asked for before nobody is believed to be there: the first answers may be garbled.
const GREETINGS: usize = 3;

/// What differs from robot to robot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// Which firmware answers.
    pub firmware: Firmware,
    /// Set the camera to the attended window before each picture.
    pub crop: bool,
}

/// An E-puck on a serial line.
pub struct Epuck1 {
    line: Line,
    options: Options,
    window: Option<Window>,
    version: String,
}

impl Epuck1 {
    /// Finds the robot behind `opener` and stops it.
    ///
    /// # Errors
    /// If nobody answers.
    pub fn connect(opener: Opener, patience: Patience, options: Options) -> Result<Self, BodyError> {
        let line = Line::new(opener, patience);
        let mut robot = Self { line, options, window: None, version: String::new() };
        robot.line.open()?;
        robot.enter()?;
        Ok(robot)
    }

    /// Asks who is there. Whatever was half said before is ended by the line feed and dropped.
    fn greet(&mut self) -> Result<String, BodyError> {
        self.line.send(b"\n")?;
        self.line.forget()?;
        self.say(Command::Version).map(|answer| answer.text)
    }

    /// Says a line and waits for the line that answers it.
    fn say(&mut self, command: Command) -> Result<ascii::Answer, BodyError> {
        self.line.send(command.encode().as_bytes())?;
        loop {
            let answer = self.line.receive(line_of_text)?;
            // Whoever was interrupted answers `z`; an answer to somebody else's question is no answer to ours.
            match answer {
                Some(answer) if answer.letter == command.letter().to_ascii_lowercase() => return Ok(answer),
                _ => {}
            }
        }
    }

    /// Sends a run of requests and reads the answers; opens the line again if it is lost.
    fn run(&mut self, requests: &[Request]) -> Result<Vec<Answer>, BodyError> {
        self.persist(|robot| robot.run_once(requests))
    }

    fn run_once(&mut self, requests: &[Request]) -> Result<Vec<Answer>, BodyError> {
        self.line.send(&binary::encode_run(requests))?;
        let firmware = self.options.firmware;
        self.line.receive(|bytes| {
            let answers = binary::decode_answers(requests, firmware, bytes)?;
            let used = answers.iter().map(|a| binary::encode_answer(a).len()).sum();
            Ok((answers, used))
        })
    }

    /// Sets the camera to `window`, unless it is.
    fn aim(&mut self, window: Window) -> Result<(), BodyError> {
        if self.window == Some(window) {
            return Ok(());
        }
        let corner = [CORNER[0] + ZOOM * window.left as u16, CORNER[1] + ZOOM * window.top as u16];
        let size = [(window.right - window.left) as u16, (window.bottom - window.top) as u16];
        let whole = window == Window::WHOLE;
        let corner = if whole { None } else { Some(corner) };
        self.say(Command::Camera(Camera { coloured: true, size, zoom: ZOOM, corner }))?;
        self.window = Some(window);
        Ok(())
    }

    fn shoot(&mut self, window: Window) -> Result<Picture, BodyError> {
        self.aim(window)?;
        let answers = self.run_once(&[Request::Picture])?;
        let Some(Answer::Picture(raw)) = answers.into_iter().next() else {
            return Err(ProtocolError::Unexpected("an answer that is no picture".to_owned()).into());
        };
        let [columns, rows] = raw.size.map(usize::from);
        if !raw.coloured || [columns, rows] != [window.right - window.left, window.bottom - window.top] {
            self.window = None;
            let found = format!("a picture of {columns}×{rows} (colours: {})", raw.coloured);
            return Err(ProtocolError::Unexpected(found).into());
        }
        Ok(decode_565(columns, &raw.bytes)?)
    }
}

impl OnLine for Epuck1 {
    fn line(&mut self) -> &mut Line {
        &mut self.line
    }

    /// Asks who is there, stops the wheels and forgets how the camera is set.
    fn enter(&mut self) -> Result<(), BodyError> {
        let mut greeted = self.greet();
        for _ in 1..GREETINGS {
            if greeted.is_ok() {
                break;
            }
            if !self.line.is_open() {
                self.line.open()?;
            }
            greeted = self.greet();
        }
        self.version = greeted?;
        self.window = None;
        self.say(Command::Speeds([0, 0])).map(|_| ())
    }
}

/// The first line of what came; `None` if it means nothing.
fn line_of_text(bytes: &[u8]) -> Result<(Option<ascii::Answer>, usize), ProtocolError> {
    let missing = ProtocolError::Truncated { wanted: 1, left: 0 };
    let end = bytes.iter().position(|&b| b == b'\n').ok_or(missing)?;
    let text = String::from_utf8_lossy(&bytes[..end]);
    Ok((ascii::Answer::decode(&text).ok(), end + 1))
}

impl Body for Epuck1 {
    fn name(&self) -> &str {
        "epuck"
    }

    fn fastest_mps(&self) -> f64 {
        metres_per_second(MOST_STEPS)
    }

    fn infrared_scale(&self) -> InfraredScale {
        real::INFRARED_SCALE
    }

    fn crops(&self) -> bool {
        self.options.crop
    }

    fn drive(&mut self, wheels: Wheels) -> Result<(), BodyError> {
        self.run(&[Request::Speeds(real::steps(wheels, MOST_STEPS)), Request::GetSteps]).map(|_| ())
    }

    fn pass(&mut self, secs: f64) -> Result<(), BodyError> {
        real::pass(secs);
        Ok(())
    }

    fn tick_secs(&self) -> f64 {
        real::TICK_SECS
    }

    fn picture(&mut self, window: Window) -> Result<Picture, BodyError> {
        let asked = if self.options.crop { window } else { Window::WHOLE };
        let picture = self.persist(|robot| robot.shoot(asked))?;
        Ok(if self.options.crop { picture } else { part(&picture, window) })
    }

    fn proximity(&mut self) -> Result<[f64; INFRARED], BodyError> {
        let answers = self.run(&[Request::Proximity])?;
        let Some(Answer::Levels(levels)) = answers.first() else {
            return Err(ProtocolError::Unexpected("an answer that is no reading".to_owned()).into());
        };
        Ok(std::array::from_fn(|i| f64::from(levels[i])))
    }

    fn feel(&mut self) -> Result<Feelings, BodyError> {
        let second = self.options.firmware == Firmware::Second;
        let mut requests =
            vec![Request::GetSteps, Request::RawAcceleration, Request::Ambient, Request::Ground];
        if second {
            requests.push(Request::Gyro);
        }
        let answers = self.run(&requests)?;
        let [
            Answer::Signed(steps),
            Answer::Signed(raw),
            Answer::Levels(light),
            Answer::Levels(ground),
            rest @ ..,
        ] = answers.as_slice()
        else {
            return Err(ProtocolError::Unexpected("answers that are no readings".to_owned()).into());
        };
        // The first robot's converter reads 2000 at no acceleration, the second one's is centred.
        let (zero, per_g) = if second { (0.0, 760.0) } else { (2000.0, 800.0) };
        let turn = match rest {
            [Answer::Signed(turn)] => Some(real::turn_radps(std::array::from_fn(|i| turn[i]))),
            _ => None,
        };
        Ok(Feelings {
            rolled_m: Some(real::rolled_m([steps[0], steps[1]])),
            ambient: Some(std::array::from_fn(|i| f64::from(light[i]))),
            acceleration_mps2: Some(real::acceleration_mps2(std::array::from_fn(|i| raw[i]), zero, per_g)),
            turn_radps: turn,
            ground: Some(std::array::from_fn(|i| f64::from(ground[i]))),
            ahead_m: None,
        })
    }

    fn light(&mut self, which: usize, rgb: [u8; 3]) -> Result<(), BodyError> {
        let Some(which) = u8::try_from(which).ok().filter(|&w| w < 8) else { return Ok(()) };
        let state = u8::from(rgb != [0; 3]);
        // A light is not answered; the counters are, so that a dead link is noticed.
        self.run(&[Request::Light { which, state }, Request::GetSteps]).map(|_| ())
    }

    fn meter(&self) -> Meter {
        self.line.meter()
    }

    fn about(&mut self) -> Result<About, BodyError> {
        let selector = self.say(Command::Selector)?.text;
        Ok(vec![("firmware".to_owned(), self.version.clone()), ("selector".to_owned(), selector)])
    }
}
