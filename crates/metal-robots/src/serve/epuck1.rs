//! `metal serve epuck`: an E-puck on a serial line, played over a pseudo-terminal.

use super::{RealTime, Shared, calibrated, is_pause, step_counters};
use crate::epuck::ascii::{self, Camera, Command};
use crate::epuck::binary::{self, Answer, MOST_PICTURE_BYTES, RawPicture, Request};
use crate::epuck::{metres_per_second, steps_per_second};
use crate::guard::Emergency;
use crate::link::serial::BITS_PER_BYTE;
use crate::picture::encode_565;
use metal_worlds::highway::camera::{COLUMNS, ROWS};
use serialport::{SerialPort, TTYPort};
use std::fs::{File, OpenOptions};
use std::io::{self, Read, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::time::Duration;

/// `O_NOCTTY` of Linux: the terminal shall not become that of this program.
const NO_CONTROL: i32 = 0o400;

/// A pseudo-terminal: the robot's end, and the path of the other one.
pub struct Terminal {
    robot: TTYPort,
    // Held so that the line does not hang up between two clients. No port of its own: that would lock clients out.
    _open: File,
    path: String,
}

impl Terminal {
    /// Opens one.
    ///
    /// # Errors
    /// If the system gives none.
    pub fn open() -> io::Result<Self> {
        let (mut robot, mut client) = TTYPort::pair()?;
        robot.set_timeout(super::ROUND)?;
        client.set_exclusive(false)?;
        let path = client.name().ok_or_else(|| io::Error::other("the pseudo-terminal has no name"))?;
        let open = OpenOptions::new().read(true).write(true).custom_flags(NO_CONTROL).open(&path)?;
        Ok(Self { robot, _open: open, path })
    }

    /// Where clients find the robot.
    #[must_use]
    pub fn path(&self) -> &str {
        &self.path
    }
}

/// The state of a robot on a serial line.
struct Robot {
    world: RealTime,
    camera: Camera,
}

/// Serves until `end` is pressed. `baud` (none: as fast as possible) is the speed that is imitated, in bits per second.
///
/// # Errors
/// If the terminal breaks.
pub fn serve(mut terminal: Terminal, arena: &Shared, baud: Option<u32>, end: &Emergency) -> io::Result<()> {
    // Power-on state of the camera: 40×40 pixels.
    let camera = Camera { coloured: true, size: [40, 40], zoom: 8, corner: None };
    let mut robot = Robot { world: RealTime::new(arena.clone()), camera };
    let (mut pending, mut buffer) = (Vec::new(), [0; 256]);
    while !end.pressed() {
        match terminal.robot.read(&mut buffer) {
            Ok(count) => {
                delay(baud, count);
                pending.extend_from_slice(&buffer[..count]);
            }
            Err(e) if is_pause(&e) => continue,
            Err(e) => return Err(e),
        }
        while let Some((answer, used)) = robot.understand(&pending) {
            pending.drain(..used);
            delay(baud, answer.len());
            terminal.robot.write_all(&answer)?;
        }
    }
    robot.world.stop();
    Ok(())
}

/// Waits as long as the bytes take on the imitated line.
fn delay(baud: Option<u32>, bytes: usize) {
    if let Some(baud) = baud {
        let bits = bytes as f64 * f64::from(BITS_PER_BYTE);
        std::thread::sleep(Duration::from_secs_f64(bits / f64::from(baud)));
    }
}

impl Robot {
    /// Carries out what the bytes begin with: the answer, and how many bytes were used. `None`: not whole yet.
    fn understand(&mut self, bytes: &[u8]) -> Option<(Vec<u8>, usize)> {
        if !binary::begins_run(*bytes.first()?) {
            let end = bytes.iter().position(|&b| b == b'\n' || b == b'\r')?;
            let text = String::from_utf8_lossy(&bytes[..end]);
            let answer = if text.is_empty() { String::new() } else { self.obey_line(&text) };
            return Some((answer.into_bytes(), end + 1));
        }
        match binary::decode_run(bytes) {
            Ok((requests, used)) => {
                Some((requests.iter().flat_map(|r| binary::encode_answer(&self.obey(*r))).collect(), used))
            }
            Err(error) if error.wants_more() => None,
            // The firmware passes over bytes that mean nothing.
            Err(_) => Some((Vec::new(), 1)),
        }
    }

    fn obey_line(&mut self, line: &str) -> String {
        let Ok(command) = Command::decode(line) else {
            return ascii::Answer::words('z', "Command not found").encode();
        };
        let letter = command.letter().to_ascii_lowercase();
        let wide = |values: &[u16]| values.iter().map(|&v| i32::from(v)).collect::<Vec<_>>();
        let numbers = match command {
            Command::Version => {
                return ascii::Answer::words('v', "Version 1.0 METAL (played by a simulator)").encode();
            }
            Command::Speeds(speeds) => {
                self.world.drive(speeds);
                Vec::new()
            }
            Command::Stop => {
                self.world.stop();
                Vec::new()
            }
            Command::SetSteps(steps) => {
                self.world.now(|arena| arena.set_rolled_m(steps.map(metres_per_second)));
                Vec::new()
            }
            Command::Camera(camera) => {
                self.camera = camera;
                Vec::new()
            }
            Command::GetCamera => {
                let [columns, rows] = self.camera.size;
                let mode = u16::from(self.camera.coloured);
                wide(&[mode, columns, rows, self.camera.zoom, 2 * columns * rows])
            }
            Command::Proximity => wide(&self.proximity()),
            Command::Ambient => wide(&[3000; 8]),
            Command::GetSteps => self.world.now(|a| step_counters(a)).map(i32::from).to_vec(),
            Command::GetSpeeds => self.speeds().map(i32::from).to_vec(),
            Command::Ground => wide(&[500; 3]),
            Command::Acceleration => vec![2000, 2000, 2800],
            Command::Selector => vec![3],
            Command::Battery => vec![927],
            Command::Calibrate | Command::Light(_) | Command::Body(_) | Command::Front(_) => Vec::new(),
        };
        ascii::Answer::of(letter, &numbers).encode()
    }

    fn obey(&mut self, request: Request) -> Answer {
        match request {
            Request::Speeds(speeds) => {
                self.world.drive(speeds);
                Answer::Nothing
            }
            Request::SetSteps(steps) => {
                self.world.now(|arena| arena.set_rolled_m(steps.map(metres_per_second)));
                Answer::Nothing
            }
            Request::Light { .. } => Answer::Nothing,
            Request::Proximity => Answer::Levels(self.proximity().to_vec()),
            Request::Ambient => Answer::Levels(vec![3000; 8]),
            Request::RawAcceleration => Answer::Signed(vec![2000, 2000, 2800]),
            Request::Gyro => Answer::Signed(vec![0; 3]),
            Request::Acceleration => Answer::Polar([800.0, 0.0, 0.0]),
            Request::GetSpeeds => Answer::Signed(self.speeds().to_vec()),
            Request::GetSteps => Answer::Signed(self.world.now(|a| step_counters(a)).to_vec()),
            Request::Ground | Request::Microphones => Answer::Levels(vec![500; 3]),
            Request::Battery => Answer::Levels(vec![927]),
            Request::Temperature => Answer::Temperature(25),
            Request::Picture => Answer::Picture(self.picture()),
            Request::Everything => Answer::Everything(Box::default()),
        }
    }

    fn proximity(&mut self) -> [u16; 8] {
        calibrated(self.world.now(|arena| arena.proximity()))
    }

    fn speeds(&mut self) -> [i16; 2] {
        let wheels = self.world.now(|arena| arena.wheels());
        [wheels.left_mps, wheels.right_mps].map(|s| steps_per_second(s, i16::MAX))
    }

    /// The camera's window of the scene. Outside of what our camera sees the picture repeats its edge.
    fn picture(&mut self) -> RawPicture {
        let whole = self.world.now(|arena| arena.picture());
        let Camera { size, zoom, corner, .. } = self.camera;
        let [columns, rows] = size.map(|s| s.min(255));
        let zoom = zoom.max(1);
        let centred =
            [(640_u16.saturating_sub(columns * zoom)) / 2, (480_u16.saturating_sub(rows * zoom)) / 2];
        let [x0, y0] = corner.unwrap_or(centred);
        let at = |offset: u16, corner: u16, middle: usize, most: usize| {
            let sensor = usize::from(corner) + usize::from(offset) * usize::from(zoom);
            (sensor.saturating_sub(middle) / usize::from(zoom)).min(most - 1)
        };
        let middle = [(640 - 8 * COLUMNS) / 2, (480 - 8 * ROWS) / 2];
        let pixel = |row: u16, column: u16| {
            whole.pixels[at(row, y0, middle[1], ROWS) * COLUMNS + at(column, x0, middle[0], COLUMNS)]
        };
        let pixels = (0..rows).flat_map(|r| (0..columns).map(move |c| (r, c))).map(|(r, c)| pixel(r, c));
        let picture = crate::Picture { columns: usize::from(columns), pixels: pixels.collect() };
        let mut bytes = if self.camera.coloured {
            encode_565(&picture)
        } else {
            picture.pixels.iter().map(|p| p[1]).collect()
        };
        bytes.truncate(MOST_PICTURE_BYTES);
        RawPicture { coloured: self.camera.coloured, size: [columns as u8, rows as u8], bytes }
    }
}
