//! Every driver against its server: the same eyes, the same wheels, and nothing asked that nobody attends to.
#![allow(clippy::unwrap_used)]

mod common;

use common::*;
use metal_rl::environment::Environment;
use metal_robots::bodies::epuck1::Options;
use metal_robots::bodies::{Epuck1, Epuck2, Webots};
use metal_robots::link::{serial, tcp};
use metal_robots::serve::look_into;
use metal_robots::webots::Release;
use metal_robots::{Body, Calibration, Emergency, Guard, Limits, RobotConfig, RobotEnvironment, Wheels};
use metal_worlds::highway::camera::{Region, Window};
use metal_worlds::highway::kinematics::{ACTION_SECS, advance};
use metal_worlds::highway::{HighwayConfig, MotorAction, RoadSet, Scenario};
use std::time::Duration;

fn bodies() -> Vec<(Server, Box<dyn Body>)> {
    let world = || with_a_car_ahead(arena(Scenario::Mix));
    let (a, b, c, d) = (
        epuck2_server(world()),
        epuck_server(world(), None),
        epuck_server(world(), None),
        webots_server(world()),
    );
    let epuck2 = Epuck2::connect(tcp::opener(a.address.clone()), patience()).unwrap();
    let serial = |server: &Server, crop| {
        let options = Options { crop, ..Options::default() };
        Epuck1::connect(serial::opener(server.address.clone()), patience(), options).unwrap()
    };
    let (epuck, cropping) = (serial(&b, false), serial(&c, true));
    let webots = Webots::connect(tcp::opener(d.address.clone()), patience(), Some("learner")).unwrap();
    vec![(a, Box::new(epuck2)), (b, Box::new(epuck)), (c, Box::new(cropping)), (d, Box::new(webots))]
}

fn environment(server: &Server, body: Box<dyn Body>) -> RobotEnvironment {
    let calibration = Calibration::of(body.infrared_scale());
    let guard = Guard::new(body, Limits::default(), Emergency::default()).unwrap();
    let highway = HighwayConfig::new(RoadSet::Seeds(vec![1]), Scenario::Mix);
    let grounds = RoadSet::Seeds(vec![1]).build();
    assert_eq!(look_into(&server.arena).ground().size(), grounds[0].size());
    RobotEnvironment::new(guard, RobotConfig { highway, calibration, grounds: Some(grounds) }).unwrap()
}

#[test]
fn every_body_sees_what_its_servers_world_shows() {
    for (server, mut body) in bodies() {
        let shown = look_into(&server.arena).picture();
        for window in Region::ALL.map(|r| r.window()).into_iter().chain([Window::WHOLE]) {
            let seen = body.picture(window).unwrap();
            let size = [window.right - window.left, window.bottom - window.top];
            let part = shown.cropped([window.left, window.top], size);
            let expected = if body.name() == "webots" { part } else { metal_robots::picture::as_565(&part) };
            assert_eq!(seen, expected, "{} {window:?}", body.name());
        }
        let calibration = Calibration::of(body.infrared_scale());
        let ring = calibration.infrared(body.proximity().unwrap());
        assert!(ring[0] > 300.0 && ring[7] > 300.0, "{} {ring:?}", body.name());
        assert!((3..6).all(|i| ring[i] < 90.0), "{} {ring:?}", body.name());
        assert!(!body.about().unwrap().is_empty());
    }
}

#[test]
fn every_body_drives_the_arc_it_is_told_and_stands_then() {
    for (server, body) in bodies() {
        let name = body.name().to_owned();
        look_into(&server.arena).place(1, metal_worlds::highway::Pose { x_m: -9.0, ..Default::default() });
        look_into(&server.arena).place(2, metal_worlds::highway::Pose { x_m: 9.0, ..Default::default() });
        let before = learner(&server);
        let guard = Guard::new(body, Limits::default(), Emergency::default()).unwrap();
        let twist = MotorAction::TurnLeft.twist();
        guard.drive_for(Wheels::of(twist), ACTION_SECS).unwrap();
        let (after, expected) = (learner(&server), advance(before, twist, ACTION_SECS));
        // In real time a command is late by some milliseconds, on a busy machine by many.
        let tolerance = if name == "webots" { 1e-9 } else { 0.015 };
        assert!(after.distance_m(&expected) < tolerance, "{name}: {after:?} {expected:?}");
        std::thread::sleep(Duration::from_millis(60));
        assert_eq!(look_into(&server.arena).wheels(), Wheels::STILL, "{name}");
    }
}

#[test]
fn every_body_feels_its_wheels_and_that_it_stands() {
    for (server, mut body) in bodies() {
        let (name, before) = (body.name().to_owned(), body.feel().unwrap());
        let up = before.acceleration_mps2.unwrap()[2];
        assert!((up - 9.8).abs() < 0.1, "{name}: {up}");
        assert!(before.ambient.unwrap()[0] > 0.0, "{name}");
        assert_eq!(before.turn_radps.is_some(), name != "epuck", "{name}: the first E-puck has no gyro");
        assert_eq!(before.ahead_m, (name == "epuck2").then_some(2.0), "{name}");
        body.light(0, [255; 3]).unwrap();
        body.light(1, [255, 0, 128]).unwrap();
        body.drive(Wheels { left_mps: 0.05, right_mps: -0.02 }).unwrap();
        body.pass(0.32).unwrap();
        let after = body.feel().unwrap().rolled_m.unwrap();
        let ways = [0, 1].map(|i| after[i] - before.rolled_m.unwrap()[i]);
        assert!(ways[0] > 0.01 && (ways[0] / ways[1] + 2.5).abs() < 0.2, "{name}: {ways:?}");
        body.drive(Wheels::STILL).unwrap();
        assert_eq!(look_into(&server.arena).wheels(), Wheels::STILL);
    }
}

#[test]
fn what_nobody_attends_to_is_not_asked_for_and_the_record_says_so() {
    let mut rows = Vec::new();
    for (server, body) in bodies() {
        let name = body.name().to_owned();
        let crops = body.crops();
        let mut world = environment(&server, body);
        world.reset(3).unwrap();
        let mut shares = [0.0; 4];
        let mut ring = [0.0; 8];
        world.step(2).unwrap();
        let from = world.measures().len() - 2;
        assert!(world.measures()[from] > 4000.0, "{name}: a survey told what not looking saves");
        world.reset(3).unwrap();
        // All sensors; then the ring only, then nothing.
        (0..6).for_each(|i| world.sense(i, &mut shares).unwrap());
        world.sense(6, &mut ring).unwrap();
        let steps: Vec<[f64; 4]> = [true, true, false]
            .map(|ring_only| {
                if ring_only && !rows.is_empty() {
                    world.sense(6, &mut ring).unwrap();
                }
                world.step(2).unwrap();
                rows.push(0);
                let from = world.measures().len() - 4;
                world.measures()[from..].try_into().unwrap()
            })
            .to_vec();
        let [all, ring_only, nothing] = [steps[0], steps[1], steps[2]];
        assert!(all[0] > ring_only[0] && ring_only[0] > nothing[0], "{name}: {steps:?}");
        assert_eq!(nothing[0], 0.0, "{name}");
        assert_eq!(all[2], 0.0, "{name}: nothing was saved when everything was seen");
        let picture = match (name.as_str(), crops) {
            ("epuck2", _) => 38_401.0,
            ("webots", _) => 8112.0,
            (_, true) => 4056.0,
            _ => 4059.0,
        };
        assert!(ring_only[2] >= picture && nothing[2] > ring_only[2], "{name}: {steps:?}");
        assert!(all[1] > 0.0 && nothing[3] > 0.0, "{name}: {steps:?}");
    }
}

#[test]
fn one_region_of_a_cropping_body_costs_a_part_of_the_picture() {
    let server = epuck_server(arena(Scenario::FreeRoad), None);
    let options = Options { crop: true, ..Options::default() };
    let mut body = Epuck1::connect(serial::opener(server.address.clone()), patience(), options).unwrap();
    let before = body.meter();
    body.picture(Region::MiddleFar.window()).unwrap();
    let cost = body.meter().since(&before).bytes();
    assert!((468..560).contains(&cost), "18×13 pixels cost {cost} bytes");
}

#[test]
fn in_both_releases_of_webots_the_supervisor_places_judges_and_advises() {
    for release in [Release::R2023b, Release::R2025a] {
        let server = webots_server_as(release, arena(Scenario::Mix));
        let body = Webots::connect(tcp::opener(server.address.clone()), patience(), None).unwrap();
        let robot = body.robot().unwrap();
        assert_eq!((robot.devices.len(), robot.release), (36, release), "by the version text");
        let mut world = environment(&server, Box::new(body));
        let mut total = 0.0;
        for seed in 0..2 {
            world.reset(seed).unwrap();
            let streams = metal_rl::random::Streams::new(seed).child("highway");
            let start = Scenario::Mix.start(look_into(&server.arena).ground().road(), &streams);
            assert!(learner(&server).distance_m(&start.learner) < 1e-12);
            for _ in 0..10 {
                world.sense(0, &mut [0.0; 4]).unwrap();
                world.sense(6, &mut [0.0; 8]).unwrap();
                let advice = world.advise().expect("a supervisor knows enough to advise");
                total += world.step(advice).unwrap().motor_reward;
            }
            assert_eq!(world.measures()[0].to_bits(), learner(&server).x_m.to_bits());
        }
        assert!(total > -300.0 && total <= 0.0, "the expert drives decently: {total}");
    }
}

#[test]
fn a_body_and_the_simulators_colour_path_find_the_same_classes_in_the_same_place() {
    use metal_worlds::highway::classify::ColourThresholds;
    use metal_worlds::highway::{Highway, Pixels, RgbConfig, Steering};
    // Whatever the thresholds are: both go through the one classification.
    let greedy = ColourThresholds { white_from: 0.1, red_within_deg: 100.0, ..ColourThresholds::default() };
    for thresholds in [ColourThresholds::default(), greedy] {
        let server = webots_server(arena(Scenario::Mix));
        let body = Webots::connect(tcp::opener(server.address.clone()), patience(), None).unwrap();
        let calibration = Calibration { colours: thresholds, infrared: body.infrared_scale() };
        let guard = Guard::new(Box::new(body), Limits::default(), Emergency::default()).unwrap();
        let highway = HighwayConfig::new(RoadSet::Seeds(vec![1]), Scenario::Mix);
        let pixels = Pixels::Rgb(RgbConfig { thresholds, ..RgbConfig::default() });
        let mut simulated = Highway::new(HighwayConfig { pixels, ..highway.clone() }, Steering::Scripted);
        let grounds = Some(RoadSet::Seeds(vec![1]).build());
        let mut embodied =
            RobotEnvironment::new(guard, RobotConfig { highway, calibration, grounds }).unwrap();
        for seed in 0..6 {
            embodied.reset(seed).unwrap();
            simulated.reset(seed).unwrap();
            for region in 0..6 {
                let (mut ours, mut theirs) = ([0.0; 4], [0.0; 4]);
                embodied.sense(region, &mut ours).unwrap();
                simulated.sense(region, &mut theirs).unwrap();
                assert!(ours.iter().zip(theirs).all(|(a, b)| (a - b).abs() < 1e-12), "{ours:?} {theirs:?}");
            }
        }
    }
}

#[test]
fn where_nothing_is_near_every_ring_reads_the_same_after_its_own_normalisation() {
    let world = || arena(Scenario::FreeRoad);
    let (a, b, c) = (epuck2_server(world()), epuck_server(world(), None), webots_server(world()));
    let epuck2 = Epuck2::connect(tcp::opener(a.address.clone()), patience()).unwrap();
    let epuck = Epuck1::connect(serial::opener(b.address.clone()), patience(), Options::default()).unwrap();
    let webots = Webots::connect(tcp::opener(c.address.clone()), patience(), None).unwrap();
    let bodies: [(f64, Box<dyn Body>); 3] =
        [(0.0, Box::new(epuck2)), (0.0, Box::new(epuck)), (67.0, Box::new(webots))];
    for (idle, mut body) in bodies {
        let name = body.name().to_owned();
        let raw = body.proximity().unwrap();
        // Its own level, and 4.9 % noise of Webots' law.
        assert!(raw.iter().all(|r| (r - idle).abs() < 20.0), "{name}: {raw:?}");
        let seen = Calibration::of(body.infrared_scale()).infrared(raw);
        assert!(seen.iter().all(|s| (67.0..87.0).contains(s)), "{name}: {seen:?}");
    }
}

#[test]
fn a_link_that_breaks_comes_back_and_a_server_that_is_gone_is_named() {
    let server = epuck2_server(arena(Scenario::FreeRoad));
    let address = server.address.clone();
    let mut body = Epuck2::connect(tcp::opener(address.clone()), patience()).unwrap();
    body.drive(Wheels { left_mps: 0.05, right_mps: 0.05 }).unwrap();
    drop(server);
    let error = body.proximity().unwrap_err().to_string();
    assert!(error.contains(&address), "{error}");
    let listener = std::net::TcpListener::bind(&address).unwrap();
    let world = std::sync::Arc::new(std::sync::Mutex::new(arena(Scenario::FreeRoad)));
    let (end, button) = (Emergency::default(), Emergency::default());
    let handle = {
        let (world, end) = (world.clone(), end.clone());
        std::thread::spawn(move || metal_robots::serve::epuck2::serve(&listener, &world, &end).unwrap())
    };
    let guard = Guard::new(Box::new(body), Limits::default(), button).unwrap();
    assert!(guard.with(|b| b.proximity()).is_ok(), "the driver reconnects by itself");
    drop(guard);
    end.press();
    handle.join().unwrap();
}

#[test]
fn a_client_that_vanishes_leaves_a_standing_robot() {
    use metal_robots::bytes::Writer;
    use metal_robots::epuck::wifi::{Command, Wanted};
    use metal_robots::webots::frame::{Request, hello};
    use std::io::{Read, Write};
    let mut velocity = Writer::new();
    velocity.u16(2).f64(2.0);
    let webots = Request { step_ms: 32, orders: vec![(1, velocity.into_bytes())] }.encode();
    let epuck2 = Command::drive([300, 300], Wanted::default()).encode();
    let rows = [
        (epuck2_server(arena(Scenario::FreeRoad)), Vec::new(), epuck2),
        (webots_server(arena(Scenario::FreeRoad)), hello(None), webots),
    ];
    for (server, greeting, order) in rows {
        let mut stream = std::net::TcpStream::connect(&server.address).unwrap();
        let mut answer = [0; 1];
        if !greeting.is_empty() {
            stream.write_all(&greeting).unwrap();
            stream.read_exact(&mut answer).unwrap();
        }
        stream.write_all(&order).unwrap();
        stream.read_exact(&mut answer).unwrap();
        std::thread::sleep(Duration::from_millis(50));
        assert_ne!(look_into(&server.arena).wheels(), Wheels::STILL);
        drop(stream);
        std::thread::sleep(Duration::from_millis(300));
        assert_eq!(look_into(&server.arena).wheels(), Wheels::STILL);
    }
}
