//! The e-puck2 over Wi-Fi (TCP port 1000 of the robot, selector 15).
//!
//! Attention is two bits of each command: a picture that nobody attends to saves 38 400 bytes.

use super::{may_come_back, part};
use crate::body::{About, Body, INFRARED, InfraredScale, Wheels};
use crate::epuck::wifi::{Answer, Command, MOST_STEPS, Wanted};
use crate::epuck::{Sensors, metres_per_second, steps_per_second};
use crate::error::{BodyError, ProtocolError};
use crate::link::{Line, Meter, Opener, Patience};
use crate::picture::{Picture, WIFI_COLUMNS, decode_565, shrink};
use metal_worlds::highway::camera::Window;
use std::time::Duration;

/// An e-puck2 on the network.
pub struct Epuck2 {
    line: Line,
    speeds: [i16; 2],
}

impl Epuck2 {
    /// Finds the robot behind `opener` and stops it.
    ///
    /// # Errors
    /// If nobody answers.
    pub fn connect(opener: Opener, patience: Patience) -> Result<Self, BodyError> {
        let mut robot = Self { line: Line::new(opener, patience), speeds: [0; 2] };
        robot.line.open()?;
        robot.ask_once(Wanted::default())?;
        Ok(robot)
    }

    /// Sends the speeds and asks for what is wanted; opens the line again if it is lost.
    fn ask(&mut self, wanted: Wanted) -> Result<Answer, BodyError> {
        if !self.line.is_open() {
            self.line.reopen()?;
        }
        match self.ask_once(wanted) {
            Err(error) if may_come_back(&error) => {
                self.line.reopen()?;
                self.ask_once(wanted)
            }
            outcome => outcome,
        }
    }

    fn ask_once(&mut self, wanted: Wanted) -> Result<Answer, BodyError> {
        self.drop_old_answers()?;
        self.line.send(&Command::drive(self.speeds, wanted).encode())?;
        loop {
            let answer = self.line.receive(next_answer)?;
            // Some servers stream what was once wanted: pass over what is not.
            let fits = match answer {
                Answer::Picture(_) => wanted.picture,
                Answer::Sensors(_) => wanted.sensors,
                Answer::Nothing => wanted == Wanted::default(),
            };
            if fits {
                return Ok(answer);
            }
        }
    }

    /// Drops whole answers that came unasked, but never half of one: the next byte must be a name.
    fn drop_old_answers(&mut self) -> Result<(), BodyError> {
        self.line.collect()?;
        while next_answer(self.line.pending()).is_ok() {
            self.line.receive(next_answer)?;
        }
        Ok(())
    }

    fn sensors(&mut self) -> Result<Sensors, BodyError> {
        match self.ask(Wanted { picture: false, sensors: true })? {
            Answer::Sensors(sensors) => Ok(*sensors),
            _ => Err(ProtocolError::Unexpected("an answer that holds no sensors".to_owned()).into()),
        }
    }
}

fn next_answer(bytes: &[u8]) -> Result<(Answer, usize), ProtocolError> {
    let Some((&name, payload)) = bytes.split_first() else {
        return Err(ProtocolError::Truncated { wanted: 1, left: 0 });
    };
    let length = Answer::length(name)?;
    Ok((Answer::decode(name, payload)?, 1 + length))
}

impl Body for Epuck2 {
    fn name(&self) -> &str {
        "epuck2"
    }

    fn fastest_mps(&self) -> f64 {
        metres_per_second(MOST_STEPS)
    }

    fn infrared_scale(&self) -> InfraredScale {
        InfraredScale { idle: 0.0, factor: 1.0 }
    }

    fn drive(&mut self, wheels: Wheels) -> Result<(), BodyError> {
        self.speeds = [wheels.left_mps, wheels.right_mps].map(|s| steps_per_second(s, MOST_STEPS));
        self.ask(Wanted::default()).map(|_| ())
    }

    fn pass(&mut self, secs: f64) -> Result<(), BodyError> {
        std::thread::sleep(Duration::from_secs_f64(secs));
        Ok(())
    }

    fn tick_secs(&self) -> f64 {
        0.05
    }

    fn picture(&mut self, window: Window) -> Result<Picture, BodyError> {
        match self.ask(Wanted { picture: true, sensors: false })? {
            Answer::Picture(bytes) => Ok(part(&shrink(&decode_565(WIFI_COLUMNS, &bytes)?)?, window)),
            _ => Err(ProtocolError::Unexpected("an answer that holds no picture".to_owned()).into()),
        }
    }

    fn proximity(&mut self) -> Result<[f64; INFRARED], BodyError> {
        Ok(self.sensors()?.proximity.map(f64::from))
    }

    fn meter(&self) -> Meter {
        self.line.meter()
    }

    fn about(&mut self) -> Result<About, BodyError> {
        let sensors = self.sensors()?;
        Ok(vec![
            ("battery".to_owned(), sensors.battery_raw.to_string()),
            ("selector".to_owned(), sensors.selector.to_string()),
            ("temperature".to_owned(), format!("{} °C", sensors.temperature_c)),
            ("time of flight".to_owned(), format!("{} mm", sensors.distance_mm)),
        ])
    }
}
