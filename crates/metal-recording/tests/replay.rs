//! A run that was recorded, replayed; and a mind that learns from the recording what it would have learned live.
#![allow(clippy::unwrap_used)]

use metal_recording::{Beliefs, Recorder, Replay, Tape, TapeError};
use metal_rl::environment::{End, Environment, Outcome};
use metal_robots::bodies::Webots;
use metal_robots::{Calibration, Emergency, Guard, Limits, RobotConfig, RobotEnvironment};
use metal_worlds::highway::{Highway, HighwayConfig, RoadSet, Scenario, Steering};
use std::path::PathBuf;

fn highway() -> Highway {
    let config = HighwayConfig { horizon: 5, ..HighwayConfig::new(RoadSet::Seeds(vec![1]), Scenario::Mix) };
    Highway::new(config, Steering::Scripted)
}

fn file(name: &str) -> PathBuf {
    std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}

/// Readings and outcomes of two episodes in which the expert drives and everything is looked at.
fn demonstrate(world: &mut dyn Environment) -> Vec<(Vec<f64>, usize, Outcome)> {
    let mut seen = Vec::new();
    for seed in [3, 4] {
        world.reset(seed).unwrap();
        loop {
            let mut readings = Vec::new();
            for sensor in 0..world.spec().sensors.len() {
                let mut out = vec![0.0; world.spec().sensors[sensor].features.len()];
                world.sense(sensor, &mut out).unwrap();
                readings.extend(out);
            }
            let action = world.advise().unwrap();
            let outcome = world.step(action).unwrap();
            readings.extend_from_slice(world.measures());
            seen.push((readings, action, outcome));
            if outcome.end != End::Running {
                break;
            }
        }
    }
    seen
}

#[test]
fn a_replay_is_the_recorded_run_to_the_bit() {
    let path = file("highway.mcap");
    let world = highway();
    let tape = Tape::create(&path, world.spec()).unwrap();
    let mut recorder = Recorder::new(world, tape.clone());
    let live = demonstrate(&mut recorder);
    tape.finish().unwrap();
    let mut replay = Replay::open(&path).unwrap();
    assert_eq!(replay.spec(), highway().spec());
    assert_eq!(replay.episodes().iter().map(Vec::len).collect::<Vec<_>>(), [5, 5]);
    assert_eq!(replay.episodes()[0][0].attended, [0, 1, 2, 3, 4, 5, 6]);
    assert_eq!(demonstrate(&mut replay), live);
    // From the beginning again, as training over several epochs does.
    assert_eq!(demonstrate(&mut replay), live);
}

#[test]
fn a_replay_that_is_recorded_is_the_recording_byte_by_byte() {
    let (first, second) = (file("first.mcap"), file("second.mcap"));
    let record = |world: Box<dyn Environment>, path: &PathBuf| {
        let tape = Tape::create(path, world.spec()).unwrap();
        let mut recorder = Recorder::new(world, tape.clone());
        demonstrate(&mut recorder);
        tape.finish().unwrap();
    };
    record(Box::new(highway()), &first);
    record(Box::new(Replay::open(&first).unwrap()), &second);
    let bytes = std::fs::read(&first).unwrap();
    assert!(mcap_topics(&bytes).iter().any(|t| t == "/image_raw"), "pictures, too");
    assert!(bytes == std::fs::read(&second).unwrap());
}

#[test]
fn what_was_not_recorded_is_not_made_up() {
    let path = file("glance.mcap");
    let world = highway();
    let tape = Tape::create(&path, world.spec()).unwrap();
    let mut recorder = Recorder::new(world, tape.clone());
    recorder.reset(1).unwrap();
    recorder.sense(6, &mut [0.0; 8]).unwrap();
    recorder.step(2).unwrap();
    tape.finish().unwrap();
    let mut replay = Replay::open(&path).unwrap();
    replay.reset(0).unwrap();
    assert!(replay.sense(0, &mut [0.0; 4]).unwrap_err().to_string().contains("nobody attended"));
    assert!(replay.step(0).unwrap_err().to_string().contains("Slow Down"));
    assert_eq!(replay.step(2).unwrap().end, End::TimeLimit);
    assert!(replay.step(2).unwrap_err().to_string().contains("is over"));
}

#[test]
fn a_thorough_recorder_reads_what_nobody_attended_to_and_what_lies_behind_the_end() {
    let path = file("thorough.mcap");
    let world = highway();
    let tape = Tape::create(&path, world.spec()).unwrap();
    let mut recorder = Recorder::thorough(world, tape.clone());
    let mut plain = highway();
    recorder.reset(1).unwrap();
    plain.reset(1).unwrap();
    recorder.sense(6, &mut [0.0; 8]).unwrap();
    let outcomes = [recorder.step(2).unwrap(), plain.step(2).unwrap()];
    assert_eq!(outcomes[0], outcomes[1]);
    while recorder.step(1).unwrap().end == End::Running {
        plain.step(1).unwrap();
    }
    plain.step(1).unwrap();
    drop(recorder.into_inner());
    tape.finish().unwrap();
    let mut replay = Replay::open(&path).unwrap();
    let steps = replay.episodes()[0].clone();
    assert_eq!(steps.len(), 6, "five steps, and what lies behind them");
    assert_eq!(steps.iter().map(|s| s.attended.len()).collect::<Vec<_>>(), [1, 0, 0, 0, 0, 0]);
    assert!(steps.iter().all(|s| s.readings.iter().all(Option::is_some)));
    let mut last = [0.0; 4];
    plain.sense(2, &mut last).unwrap();
    assert_eq!(steps[5].readings[2].as_deref(), Some(&last[..]));
    replay.reset(0).unwrap();
    for action in [2, 1, 1, 1, 1] {
        assert_eq!(replay.advise(), Some(action));
        replay.step(action).unwrap();
    }
    let mut seen = [0.0; 4];
    replay.sense(2, &mut seen).unwrap();
    assert_eq!(seen, last);
    assert!(replay.step(1).is_err());
}

#[test]
fn a_stubborn_replay_goes_its_own_way() {
    let path = file("stubborn.mcap");
    let tape = Tape::create(&path, highway().spec()).unwrap();
    let mut recorder = Recorder::new(highway(), tape.clone());
    let live = demonstrate(&mut recorder);
    tape.finish().unwrap();
    let mut replay = Replay::open(&path).unwrap().stubborn();
    replay.reset(0).unwrap();
    for (_, action, outcome) in &live[..5] {
        assert_eq!(replay.step(4 - action).unwrap(), *outcome);
    }
}

#[test]
fn a_foreign_file_is_refused() {
    assert!(Replay::of(b"hello").is_err());
    let path = file("empty.mcap");
    Tape::create(&path, highway().spec()).unwrap().finish().unwrap();
    assert!(matches!(Replay::open(&path), Err(TapeError::Foreign(_))));
}

#[test]
fn a_damaged_recording_is_refused_wherever_a_byte_is_wrong_and_never_panics() {
    let path = file("damaged.mcap");
    let tape = Tape::create(&path, highway().spec()).unwrap();
    let mut recorder = Recorder::new(highway(), tape.clone());
    recorder.reset(1).unwrap();
    recorder.sense(6, &mut [0.0; 8]).unwrap();
    recorder.step(2).unwrap();
    tape.finish().unwrap();
    let whole = std::fs::read(&path).unwrap();
    let (mut refused, mut tried) = (0, 0);
    for at in (0..whole.len()).step_by(3) {
        for flipped in [0x01, 0x80, 0xFF] {
            let mut bytes = whole.clone();
            bytes[at] ^= flipped;
            // Behind the data stands only what seeking needs.
            refused += usize::from(Replay::of(&bytes).is_err());
            tried += 1;
            // Without the checksums, as whoever forges a file would set them.
            bytes[at] = flipped;
            let _ = metal_recording::tape::index(&bytes);
        }
        assert!(Replay::of(&whole[..at]).is_err(), "cut at {at}");
    }
    assert!(refused > tried * 3 / 4, "{refused} of {tried}");
}

#[test]
fn beliefs_and_a_robots_run_are_recorded_too() {
    use metal_robots::arena::{Arena, ArenaConfig, Traffic};
    let grounds = RoadSet::Seeds(vec![1]).build();
    let (scenario, rgb) = (Scenario::Mix, metal_worlds::highway::RgbConfig::default());
    let config = ArenaConfig { grounds: grounds.clone(), scenario, traffic: Traffic::Standing, rgb, seed: 1 };
    let arena = std::sync::Arc::new(std::sync::Mutex::new(Arena::new(config)));
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let end = Emergency::default();
    let (world, button) = (arena, end.clone());
    let server = std::thread::spawn(move || metal_robots::serve::webots::serve(&listener, &world, &button));
    let body = Webots::connect(metal_robots::link::tcp::opener(address), Default::default(), None).unwrap();
    let calibration = Calibration::of(metal_robots::Body::infrared_scale(&body));
    let guard = Guard::new(Box::new(body), Limits::default(), Emergency::default()).unwrap();
    let highway = HighwayConfig { horizon: 3, ..HighwayConfig::new(RoadSet::Seeds(vec![1]), scenario) };
    let robot =
        RobotEnvironment::new(guard, RobotConfig { highway, calibration, grounds: Some(grounds) }).unwrap();
    let path = file("robot.mcap");
    let tape = Tape::create(&path, robot.spec()).unwrap();
    let mut recorder = Recorder::new(robot, tape.clone());
    let live = demonstrate(&mut recorder);
    let _ = Beliefs(tape.clone());
    tape.finish().unwrap();
    drop(recorder);
    end.press();
    server.join().unwrap().unwrap();
    assert_eq!(demonstrate(&mut Replay::open(&path).unwrap()), live);
    let bytes = std::fs::read(&path).unwrap();
    let pictures = mcap_topics(&bytes).into_iter().filter(|t| t == "/image_raw").count();
    assert_eq!(pictures, 6, "a picture that was taken is on the tape, once a step");
}

fn mcap_topics(bytes: &[u8]) -> Vec<String> {
    metal_recording::tape::index(bytes).unwrap().into_iter().map(|(topic, _)| topic).collect()
}
