//! Links that break while the wheels turn, against a robot of a few lines that writes down every command.
#![allow(clippy::unwrap_used)]

mod common;

use common::patience;
use metal_robots::bodies::Epuck2;
use metal_robots::epuck::wifi::{Answer, Command, Motion};
use metal_robots::link::tcp;
use metal_robots::{Body, Emergency, Guard, Limits, Wheels};
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

const SLOW: Wheels = Wheels { left_mps: 0.05, right_mps: 0.05 };
const STILL: [i16; 2] = [0; 2];

/// An e-puck2 that drives on for ever with the last speed, and hangs up when it is told to.
struct Robot {
    address: String,
    /// Wheel speeds of each command, by connection.
    said: Arc<Mutex<Vec<Vec<[i16; 2]>>>>,
    hang_up: Emergency,
}

impl Robot {
    fn start() -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap().to_string();
        let (said, hang_up) = (Arc::new(Mutex::new(Vec::new())), Emergency::default());
        let (diary, button) = (Arc::clone(&said), hang_up.clone());
        std::thread::spawn(move || {
            for stream in listener.incoming() {
                diary.lock().unwrap().push(Vec::new());
                let only_first = diary.lock().unwrap().len() == 1;
                // Whoever hangs up, hangs up.
                let _ = listen(stream.unwrap(), &diary, only_first.then_some(&button));
            }
        });
        Self { address, said, hang_up }
    }

    fn body(&self) -> Epuck2 {
        Epuck2::connect(tcp::opener(self.address.clone()), patience()).unwrap()
    }

    fn said(&self, connection: usize) -> Vec<[i16; 2]> {
        self.said.lock().unwrap().get(connection).cloned().unwrap_or_default()
    }
}

fn listen(
    mut stream: TcpStream,
    diary: &Mutex<Vec<Vec<[i16; 2]>>>,
    hang_up: Option<&Emergency>,
) -> std::io::Result<()> {
    let mut bytes = [0; 21];
    loop {
        stream.read_exact(&mut bytes)?;
        if hang_up.is_some_and(Emergency::pressed) {
            return Ok(());
        }
        let command = Command::decode(&bytes).unwrap();
        let Motion::Speed(speeds) = command.motion else { panic!("nobody sets the counters here") };
        diary.lock().unwrap().last_mut().unwrap().push(speeds);
        let answer = if command.wanted.sensors { Answer::Sensors(Box::default()) } else { Answer::Nothing };
        stream.write_all(&answer.encode())?;
    }
}

#[test]
fn after_a_loss_the_first_thing_said_is_stop_and_looking_does_not_start_again() {
    let robot = Robot::start();
    let mut body = robot.body();
    body.drive(SLOW).unwrap();
    robot.hang_up.press();
    body.proximity().unwrap();
    body.proximity().unwrap();
    let before = robot.said(0);
    assert!(before.last().unwrap()[0] > 0, "{before:?}");
    assert_eq!(robot.said(1), [STILL; 3], "stop, and two looks");
}

#[test]
fn a_command_that_the_loss_swallowed_is_given_again_after_the_stop() {
    let robot = Robot::start();
    let mut body = robot.body();
    robot.hang_up.press();
    body.drive(SLOW).unwrap();
    let said = robot.said(1);
    assert_eq!((said.len(), said[0]), (2, STILL), "{said:?}");
    assert!(said[1][0] > 0);
}

#[test]
fn under_guard_a_lost_link_stops_within_half_a_second_of_its_return() {
    let robot = Robot::start();
    let guard = Guard::new(Box::new(robot.body()), Limits::default(), Emergency::default()).unwrap();
    guard.command(SLOW).unwrap();
    robot.hang_up.press();
    let start = Instant::now();
    // Nobody asks for anything any more: the watchdog finds the link broken, opens it again and says stop.
    while robot.said(1).is_empty() && start.elapsed() < Duration::from_secs(3) {
        std::thread::sleep(Duration::from_millis(5));
    }
    assert!(start.elapsed() < Duration::from_secs(1), "{:?}", start.elapsed());
    drop(guard);
    assert!(robot.said(1).iter().all(|&speeds| speeds == STILL), "{:?}", robot.said(1));
}
