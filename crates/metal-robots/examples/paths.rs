//! What the judge `tools/judges/enki.py` compares with Enki: paths, a standstill before a disc, infra-red readings.
//!
//! Without an argument: our own body's, as JSON. With `AXLE_M SECS`: where a body with wheels so far apart goes, if its
//! wheels turn as each line of the standard input says (left and right, in metres per second) for so many seconds each.
#![allow(clippy::print_stdout)]

use std::io::BufRead;

use metal_rl::random::Streams;
use metal_worlds::highway::Pose;
use metal_worlds::highway::collision::settle;
use metal_worlds::highway::infrared::Infrared;
use metal_worlds::highway::kinematics::{AXLE_M, Twist, advance};

const STEP_SECS: f64 = 0.02;
const DISC_X_M: f64 = 0.3;
/// Left and right wheel in metres per second, and for how long in seconds.
const PROGRAM: [[f64; 3]; 6] = [
    [0.1, 0.1, 2.0],
    [0.0817, 0.0583, 2.0],
    [0.12, 0.12, 1.0],
    [0.05, 0.09, 3.0],
    [-0.03, 0.03, 1.0],
    [0.1, 0.1, 2.0],
];

fn twist(left: f64, right: f64, axle_m: f64) -> Twist {
    Twist { speed_mps: 0.5 * (left + right), turn_radps: (right - left) / axle_m }
}

fn path() -> Vec<Pose> {
    let mut path = vec![Pose::default()];
    for [left, right, secs] in PROGRAM {
        for _ in 0..(secs / STEP_SECS).round() as usize {
            path.push(advance(path[path.len() - 1], twist(left, right, AXLE_M), STEP_SECS));
        }
    }
    path
}

fn stop_distance_m() -> f64 {
    let disc = Pose { x_m: DISC_X_M, ..Pose::default() };
    let mut bodies = [Pose::default(), disc];
    for _ in 0..200 {
        let before = bodies;
        bodies[0] = advance(bodies[0], twist(0.1, 0.1, AXLE_M), STEP_SECS);
        settle(&before, &mut bodies, |_| {});
    }
    bodies[0].distance_m(&disc)
}

/// Mean reading of ps0 with a body straight ahead, `gap_m` between the two hulls.
fn infrared(gap_m: f64) -> f64 {
    let car = Pose { x_m: 0.074 + gap_m, ..Pose::default() };
    let ring = Infrared::new();
    let read = |k| {
        let mut out = [0.0; 8];
        ring.read(&Pose::default(), &[car], Streams::new(1).nth(k), &mut out);
        out[0]
    };
    (0..50).map(read).sum::<f64>() / 50.0
}

/// Follows wheels that somebody else's body has turned.
fn follow(axle_m: f64, secs: f64) -> Result<(), Box<dyn std::error::Error>> {
    let mut pose = Pose::default();
    for line in std::io::stdin().lock().lines() {
        let line = line?;
        let (left, right) = line.split_once(' ').ok_or("a line without two speeds")?;
        pose = advance(pose, twist(left.parse()?, right.parse()?, axle_m), secs);
        println!("{} {} {}", pose.x_m, pose.y_m, pose.heading_rad);
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [axle_m, secs] = arguments.as_slice() {
        return follow(axle_m.parse()?, secs.parse()?);
    }
    let path: Vec<String> =
        path().iter().map(|p| format!("[{},{},{}]", p.x_m, p.y_m, p.heading_rad)).collect();
    let gaps = [0.0, 0.005, 0.01, 0.015, 0.02, 0.03, 0.04, 0.06];
    let readings: Vec<String> = gaps.iter().map(|&g| format!("[{g},{}]", infrared(g))).collect();
    println!(
        "{{\"step_secs\":{STEP_SECS},\"program\":{PROGRAM:?},\"path\":[{}],\"disc_x_m\":{DISC_X_M},\"stop_distance_m\":{},\"infrared\":[{}]}}",
        path.join(","),
        stop_distance_m(),
        readings.join(",")
    );
    Ok(())
}
