//! `metal serve epuck2`: an e-puck2 on the network.

use super::{RealTime, Shared, calibrated, is_pause, look_into, step_counters, wait_for_somebody};
use crate::epuck::Sensors;
use crate::epuck::wifi::{Answer, COMMAND_BYTES, Command, Motion};
use crate::guard::Emergency;
use crate::picture::{encode_565, enlarge};
use std::io::{self, Read, Write};
use std::net::{TcpListener, TcpStream};

/// Serves one client after the other until `end` is pressed.
///
/// # Errors
/// If nobody can be accepted any more.
pub fn serve(listener: &TcpListener, arena: &Shared, end: &Emergency) -> io::Result<()> {
    while let Some(stream) = wait_for_somebody(listener, end)? {
        let mut robot = RealTime::new(arena.clone());
        // A client that breaks off is no reason to end.
        let _ = talk(stream, &mut robot, end);
        robot.stop();
    }
    Ok(())
}

fn talk(mut stream: TcpStream, robot: &mut RealTime, end: &Emergency) -> io::Result<()> {
    let (mut bytes, mut filled) = ([0; COMMAND_BYTES], 0);
    while !end.pressed() {
        match stream.read(&mut bytes[filled..]) {
            Ok(0) => return Ok(()),
            Ok(count) => filled += count,
            Err(e) if is_pause(&e) => {}
            Err(e) => return Err(e),
        }
        if filled == COMMAND_BYTES {
            filled = 0;
            let Ok(command) = Command::decode(&bytes) else { return Err(io::ErrorKind::InvalidData.into()) };
            stream.write_all(&obey(command, robot))?;
        }
    }
    Ok(())
}

/// Carries a command out and collects what is wanted: the picture first, as the robot does.
fn obey(command: Command, robot: &mut RealTime) -> Vec<u8> {
    match command.motion {
        Motion::Speed(speeds) => robot.drive(speeds),
        Motion::Steps(steps) => robot.now(|arena| {
            let metres = steps.map(crate::epuck::metres_per_second);
            arena.set_rolled_m(metres);
        }),
    }
    let mut answers = Vec::new();
    if command.wanted.picture {
        let picture = robot.now(|arena| arena.picture());
        answers.extend(Answer::Picture(encode_565(&enlarge(&picture))).encode());
    }
    if command.wanted.sensors {
        answers.extend(Answer::Sensors(Box::new(sensors(&robot.arena))).encode());
    }
    if answers.is_empty() { Answer::Nothing.encode() } else { answers }
}

fn sensors(arena: &Shared) -> Sensors {
    let arena = look_into(arena);
    Sensors {
        acceleration_raw: [0, 0, 760],
        acceleration: 760.0,
        temperature_c: 25,
        proximity: calibrated(arena.proximity()),
        ambient: [3000; 8],
        // Nothing within two metres: the cars are lower than this sensor's beam is far.
        distance_mm: 2000,
        steps: step_counters(&arena),
        // 4.1 V by the firmware's own scale.
        battery_raw: 927,
        selector: 15,
        ground: [500; 3],
        ..Sensors::default()
    }
}
