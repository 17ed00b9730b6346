//! The e-puck2 over Wi-Fi (TCP port 1000 of the robot, selector 15).
//!
//! Attention is two bits of each command: a picture that nobody attends to saves 38 400 bytes.

use super::part;
use super::real::{self, OnLine};
use crate::body::{About, Body, Feelings, INFRARED, InfraredScale, Wheels};
use crate::epuck::wifi::{Answer, Command, MOST_STEPS, Wanted};
use crate::epuck::{Sensors, metres_per_second};
use crate::error::{BodyError, ProtocolError};
use crate::link::{Line, Meter, Opener, Patience};
use crate::picture::{Picture, WIFI_COLUMNS, decode_565, shrink};
use metal_worlds::highway::camera::Window;

/// An e-puck2 on the network.
pub struct Epuck2 {
    line: Line,
    speeds: [i16; 2],
    /// Bits of LED1, 3, 5 and 7.
    lights: u8,
    /// Colours of LED2, 4, 6 and 8, 0 to 100.
    colours: [[u8; 3]; 4],
}

impl Epuck2 {
    /// Finds the robot behind `opener` and stops it.
    ///
    /// # Errors
    /// If nobody answers.
    pub fn connect(opener: Opener, patience: Patience) -> Result<Self, BodyError> {
        let line = Line::new(opener, patience);
        let mut robot = Self { line, speeds: [0; 2], lights: 0, colours: [[0; 3]; 4] };
        robot.line.open()?;
        robot.enter()?;
        Ok(robot)
    }

    /// Sends the speeds and asks for what is wanted; opens the line again if it is lost.
    fn ask(&mut self, wanted: Wanted) -> Result<Answer, BodyError> {
        self.persist(|robot| robot.ask_once(wanted))
    }

    fn ask_once(&mut self, wanted: Wanted) -> Result<Answer, BodyError> {
        self.drop_old_answers()?;
        let (lights, colours) = (self.lights, self.colours);
        let command = Command { lights, colours, ..Command::drive(self.speeds, wanted) };
        self.line.send(&command.encode())?;
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

impl OnLine for Epuck2 {
    fn line(&mut self) -> &mut Line {
        &mut self.line
    }

    fn enter(&mut self) -> Result<(), BodyError> {
        // Speeds go with every command: whoever only looks, after a loss, must not set the wheels going again.
        self.speeds = [0; 2];
        self.ask_once(Wanted::default()).map(|_| ())
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
        real::INFRARED_SCALE
    }

    fn drive(&mut self, wheels: Wheels) -> Result<(), BodyError> {
        let speeds = real::steps(wheels, MOST_STEPS);
        self.persist(|robot| {
            robot.speeds = speeds;
            robot.ask_once(Wanted::default()).map(|_| ())
        })
    }

    fn pass(&mut self, secs: f64) -> Result<(), BodyError> {
        real::pass(secs);
        Ok(())
    }

    fn tick_secs(&self) -> f64 {
        real::TICK_SECS
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

    fn feel(&mut self) -> Result<Feelings, BodyError> {
        let sensors = self.sensors()?;
        Ok(Feelings {
            rolled_m: Some(real::rolled_m(sensors.steps)),
            ambient: Some(sensors.ambient.map(f64::from)),
            acceleration_mps2: Some(real::acceleration_mps2(sensors.acceleration_raw, 0.0, 760.0)),
            turn_radps: Some(real::turn_radps(sensors.gyro_raw)),
            ground: Some(sensors.ground.map(f64::from)),
            ahead_m: Some(f64::from(sensors.distance_mm) / 1000.0),
        })
    }

    fn light(&mut self, which: usize, rgb: [u8; 3]) -> Result<(), BodyError> {
        // The robot numbers its ring from 1: the even ones of ours have one colour, the odd ones three.
        match which {
            0 | 2 | 4 | 6 => {
                let bit = 1 << (which / 2);
                self.lights = if rgb == [0; 3] { self.lights & !bit } else { self.lights | bit };
            }
            1 | 3 | 5 | 7 => self.colours[which / 2] = rgb.map(|c| (u16::from(c) * 100 / 255) as u8),
            _ => return Ok(()),
        }
        self.ask(Wanted::default()).map(|_| ())
    }

    fn meter(&self) -> Meter {
        self.line.meter()
    }

    fn about(&mut self) -> Result<About, BodyError> {
        let sensors = self.sensors()?;
        Ok(vec![
            // The language has no question for a version: its blocks have the lengths of this one, or nothing works.
            ("firmware".to_owned(), "speaks the Wi-Fi protocol with 104 bytes of sensors".to_owned()),
            ("battery".to_owned(), sensors.battery_raw.to_string()),
            ("selector".to_owned(), sensors.selector.to_string()),
            ("temperature".to_owned(), format!("{} °C", sensors.temperature_c)),
            ("time of flight".to_owned(), format!("{} mm", sensors.distance_mm)),
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link::Link;
    use std::io;
    use std::sync::{Arc, Mutex};

    /// Keeps the commands and answers each with nothing.
    struct Deaf(Arc<Mutex<Vec<Command>>>, usize);

    impl Link for Deaf {
        fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
            self.0.lock().unwrap().push(Command::decode(bytes).unwrap());
            self.1 += 1;
            Ok(())
        }

        fn receive(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            self.1 -= 1;
            buffer[0] = 3;
            Ok(1)
        }

        fn waiting(&mut self) -> io::Result<bool> {
            Ok(false)
        }
    }

    #[test]
    fn lights_stay_as_they_were_set_and_beside_the_wheels() {
        let said = Arc::new(Mutex::new(Vec::new()));
        let seen = Arc::clone(&said);
        let opener: Opener = Box::new(move || Ok(Box::new(Deaf(Arc::clone(&seen), 0))));
        let mut robot = Epuck2::connect(opener, Patience::default()).unwrap();
        robot.light(4, [9, 9, 9]).unwrap();
        robot.light(3, [255, 0, 128]).unwrap();
        robot.light(9, [255; 3]).unwrap();
        robot.drive(Wheels { left_mps: 0.1, right_mps: 0.1 }).unwrap();
        robot.light(4, [0; 3]).unwrap();
        let said = said.lock().unwrap();
        let states: Vec<(u8, [u8; 3])> = said.iter().map(|c| (c.lights, c.colours[1])).collect();
        let purple = [100, 0, 50];
        assert_eq!(states, [(0, [0; 3]), (4, [0; 3]), (4, purple), (4, purple), (0, purple)]);
    }
}
