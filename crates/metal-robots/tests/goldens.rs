//! Every message of every language, byte by byte, against bytes that `golden/layouts.py` puts together from the documented
//! layouts without us; and each is understood as what it was.
#![allow(clippy::unwrap_used)]

use metal_robots::bytes::{Reader, Writer};
use metal_robots::epuck::ascii::{self, Camera};
use metal_robots::epuck::binary::{self, Answer, Firmware, RawPicture, Request};
use metal_robots::epuck::{Sensors, wifi};
use metal_robots::webots::Release;
use metal_robots::webots::device::{self, Kind, Motor, Radio, Settings};
use metal_robots::webots::frame::{self, Image, Welcome};
use metal_robots::webots::news::{write_reading, write_time};
use metal_robots::webots::order::Order;
use metal_robots::webots::robot::{Device, Robot, Texts};
use metal_robots::webots::supervisor::{Fact, Field, Me, Node, Value, Wish};
use std::fmt::Write;

/// What is said, as the lines of the golden file.
#[derive(Default)]
struct Said(String);

impl Said {
    fn row(&mut self, name: &str, bytes: &[u8]) {
        let hex: Vec<String> = bytes.iter().map(|b| format!("{b:02x}")).collect();
        writeln!(self.0, "{name}: {}", hex.join(" ")).unwrap();
    }
}

/// The golden lines whose names begin with one of `names`.
fn golden(names: &[&str]) -> String {
    let lines = include_str!("golden/layouts.txt").lines();
    lines.filter(|l| names.iter().any(|n| l.starts_with(n))).map(|l| format!("{l}\n")).collect()
}

#[test]
fn the_lines_of_the_serial_language_are_those_of_the_table() {
    use ascii::Command::*;
    let camera = ascii::Camera { coloured: true, size: [52, 39], zoom: 8, corner: None };
    let rows = [
        ("version", Version),
        ("speeds", Speeds([-100, 1000])),
        ("stop", Stop),
        ("get speeds", GetSpeeds),
        ("get steps", GetSteps),
        ("set steps", SetSteps([7, -7])),
        ("proximity", Proximity),
        ("ambient", Ambient),
        ("acceleration", Acceleration),
        ("ground", Ground),
        ("calibrate", Calibrate),
        ("get camera", GetCamera),
        ("camera", Camera(camera)),
        (
            "camera window",
            Camera(self::Camera { coloured: false, size: [18, 13], corner: Some([248, 240]), ..camera }),
        ),
        ("selector", Selector),
        ("light", Light([3, 2])),
        ("body", Body(1)),
        ("front", Front(0)),
        ("battery", Battery),
    ];
    let mut said = Said::default();
    for (name, command) in rows {
        said.row(&format!("sercom line {name}"), command.encode().as_bytes());
        assert_eq!(ascii::Command::decode(command.encode().trim_end()), Ok(command));
    }
    assert_eq!(said.0, golden(&["sercom line"]));
}

#[test]
fn the_bytes_of_the_serial_language_are_those_of_the_table() {
    use Request::*;
    let run = [
        Speeds([300, -2]),
        Light { which: 8, state: 1 },
        SetSteps([-5, 6]),
        Proximity,
        Ambient,
        RawAcceleration,
        Acceleration,
        GetSpeeds,
        GetSteps,
        Ground,
        Microphones,
        Gyro,
        Battery,
        Temperature,
        Picture,
        Everything,
    ];
    let mut said = Said::default();
    said.row("sercom request", &binary::encode_run(&run));
    assert_eq!(binary::decode_run(&binary::encode_run(&run)).unwrap().0, run);
    let picture = RawPicture { coloured: true, size: [2, 1], bytes: vec![0xF8, 0, 0x07, 0xE0] };
    let (first, second) = (Firmware::First, Firmware::Second);
    let answers = [
        ("proximity", Proximity, first, Answer::Levels((1..9).collect())),
        ("raw acceleration", RawAcceleration, first, Answer::Signed(vec![2000, 1999, -3])),
        ("acceleration", Acceleration, first, Answer::Polar([1.5, -2.25, 90.0])),
        ("counters", GetSteps, first, Answer::Signed(vec![-2, 258])),
        ("ground of the first", Ground, first, Answer::Levels(vec![1, 2, 3])),
        ("ground of the second", Ground, second, Answer::Levels(vec![1, 2, 3, 4])),
        ("temperature", Temperature, second, Answer::Temperature(-7)),
        ("picture", Picture, first, Answer::Picture(picture)),
    ];
    for (name, request, firmware, answer) in answers {
        let bytes = binary::encode_answer(&answer);
        said.row(&format!("sercom answer {name}"), &bytes);
        assert_eq!(binary::decode_answers(&[request], firmware, &bytes).unwrap(), [answer]);
    }
    assert_eq!(said.0, golden(&["sercom request", "sercom answer"]));
}

#[test]
fn the_bytes_of_the_wifi_language_are_those_of_the_table() {
    use wifi::{Answer, Command, Habits, Motion, Wanted};
    let speeds = Command {
        lights: 0x31,
        colours: [[1, 2, 3], [4, 5, 6], [7, 8, 9], [10, 11, 12]],
        sound: 0x20,
        ..Command::drive([-300, 600], Wanted { picture: true, sensors: true })
    };
    let habits = Habits { calibrate: true, avoid_obstacles: true };
    let wanted = Wanted { picture: false, sensors: true };
    let steps = Command { habits, motion: Motion::Steps([1, -1]), ..Command::drive([0; 2], wanted) };
    let mut said = Said::default();
    for (name, command) in [("speeds", speeds), ("steps", steps)] {
        said.row(&format!("wifi command {name}"), &command.encode());
        assert_eq!(Command::decode(&command.encode()).unwrap(), command);
    }
    let sensors = Sensors {
        acceleration_raw: [1, -2, 3],
        acceleration: 4.5,
        orientation_deg: 5.5,
        inclination_deg: 6.5,
        gyro_raw: [-7, 8, -9],
        magnetic_ut: [10.5, 11.5, 12.5],
        temperature_c: -13,
        proximity: std::array::from_fn(|i| 14 + i as u16),
        ambient: std::array::from_fn(|i| 22 + i as u16),
        distance_mm: 30,
        microphones: [31, 32, 33, 34],
        steps: [-35, 36],
        battery_raw: 37,
        memory_card: 38,
        remote: [39, 40, 41],
        selector: 15,
        ground: [42, 43, 44],
        ground_ambient: [45, 46, 47],
        button: 1,
    };
    for (name, answer) in [("sensors", Answer::Sensors(Box::new(sensors))), ("nothing", Answer::Nothing)] {
        let bytes = answer.encode();
        said.row(&format!("wifi answer {name}"), &bytes);
        assert_eq!(Answer::decode(bytes[0], &bytes[1..]).unwrap(), answer);
    }
    assert_eq!(said.0, golden(&["wifi"]));
}

#[test]
fn the_frames_and_readings_of_webots_are_the_documented_bytes() {
    let mut said = Said::default();
    for (name, robot) in [("", None), (" by name", Some("my robot"))] {
        said.row(&format!("webots hello{name}"), &frame::hello(robot));
        assert_eq!(frame::read_hello(&frame::hello(robot)).unwrap().as_deref(), robot);
    }
    for welcome in [Welcome::Connected, Welcome::Failed, Welcome::Processing, Welcome::Forbidden] {
        said.row(&format!("webots welcome {}", welcome.word()), welcome.word().as_bytes());
        assert_eq!(Welcome::read(welcome.word().as_bytes()).unwrap(), welcome);
    }
    let (mut velocity, mut sample) = (Writer::new(), Writer::new());
    Order::Velocity(2.5).write(Release::R2023b, &mut velocity);
    Order::Sample(32).write(Release::R2023b, &mut sample);
    let orders = vec![(1, velocity.into_bytes()), (21, sample.into_bytes())];
    let request = frame::Request { step_ms: 32, orders };
    said.row("webots request", &request.encode());
    assert_eq!(frame::Request::decode(&request.encode()).unwrap().0, Some(request));
    said.row("webots goodbye", &frame::GOODBYE);
    let mut news = Writer::new();
    write_time(0.064, &mut news);
    let images = vec![Image { tag: 21, segments: false, bgra: vec![3, 2, 1, 255] }];
    let answer = frame::Answer { delay_ms: -1, news: news.into_bytes(), images };
    said.row("webots answer", &answer.encode());
    assert_eq!(frame::Answer::decode(&answer.encode()).unwrap().0, answer);
    let readings: [(&str, Kind, &[f64]); 5] = [
        ("distance", Kind::DistanceSensor, &[67.19]),
        ("light", Kind::LightSensor, &[3.0]),
        ("position", Kind::PositionSensor, &[0.5]),
        ("acceleration", Kind::Accelerometer, &[0.0, 0.0, 9.81]),
        ("gyro", Kind::Gyro, &[1.0, 2.0, 3.0]),
    ];
    for (tag, (name, kind, values)) in (3..).zip(readings) {
        let mut w = Writer::new();
        write_reading(tag, kind, values, &mut w);
        said.row(&format!("webots reading {name}"), &w.into_bytes());
    }
    let names =
        ["hello", "welcome", "request", "goodbye", "answer", "reading"].map(|n| format!("webots {n}"));
    assert_eq!(said.0, golden(&names.each_ref().map(String::as_str)));
}

fn devices() -> Vec<Device> {
    let table = vec![[0.0, 4095.0, 0.002], [0.07, 67.19, 0.04897]];
    let numbers = [0.0, 0.0, 7.536, -1.0, 10.0, 10.0, 0.0, 0.0, 0.0, 7.536, 1.0];
    let camera = device::Camera {
        uid: 17,
        size: [52, 39],
        field_of_view_rad: 0.84,
        near_m: 0.0055,
        planar_recognising_segmenting: [true, false, true],
        field_of_view_range_rad: [0.84; 2],
        optics: [1.0, 2.0, 3.0, 4.0, 5.0],
    };
    let receiver = Radio { buffer_channel: [4096, 1], rate_range: None, allowed: vec![1, 2] };
    let emitter = Radio { buffer_channel: [-1, 1], rate_range: Some([1e4, 1.0, -1.0]), allowed: vec![] };
    let rows = [
        (
            Kind::Motor,
            "left wheel motor",
            Some(Settings::Motor(Motor { kind: 0, numbers, coupled: vec![2] })),
        ),
        (Kind::PositionSensor, "left wheel sensor", Some(Settings::Position(0))),
        (Kind::DistanceSensor, "ps0", Some(Settings::Distance(1, [67.0, 4095.0, 0.1], table.clone()))),
        (Kind::LightSensor, "ls0", Some(Settings::Table(table.clone()))),
        (Kind::Camera, "camera", Some(Settings::Camera(camera))),
        (Kind::Led, "led0", None),
        (Kind::Accelerometer, "accelerometer", Some(Settings::Table(table))),
        (Kind::Gyro, "gyro", Some(Settings::Table(Vec::new()))),
        (Kind::Receiver, "receiver", Some(Settings::Radio(receiver))),
        (Kind::Emitter, "emitter", Some(Settings::Radio(emitter))),
        (Kind::Speaker, "speaker", None),
    ];
    let device = |(kind, name, settings): (Kind, &str, _)| Device {
        kind,
        name: name.to_owned(),
        model: String::new(),
        settings,
    };
    rows.map(device).to_vec()
}

fn robot(release: Release) -> Robot {
    Robot {
        name: "learner".to_owned(),
        release,
        synchronised: true,
        time_s: 0.25,
        devices: devices(),
        basic_step_ms: 32.0,
        texts: Texts {
            all: ["p", "w", "m", "<none>", "r", "<extern>", "d"].map(str::to_owned),
            windows: [false, true],
        },
        mode: 2,
        supervisor: Some(Me {
            uid: 7,
            parent: 1,
            proto_internal: [true, false],
            ancestor: ancestor(release),
            model: "e-puck".to_owned(),
            def: "LEARNER".to_owned(),
        }),
    }
}

/// R2023b says nothing about it.
fn ancestor(release: Release) -> i32 {
    if release == Release::R2025a { -1 } else { 0 }
}

fn wishes() -> Vec<(&'static str, Wish)> {
    let place = Field { node: 101, field: 0, internal: false };
    let rotation = Field { field: 1, ..place };
    vec![
        ("node by def", Wish::NodeByDef("RED1".to_owned())),
        ("node by id", Wish::NodeById(101)),
        ("field", Wish::FieldByName(101, "translation".to_owned())),
        ("get", Wish::Get(place)),
        ("set place", Wish::Set(place, Value::Vec3([1.0, 2.0, 0.0]))),
        ("set rotation", Wish::Set(rotation, Value::Rotation([0.0, 0.0, 1.0, 1.5]))),
        ("position", Wish::Position(101)),
        ("orientation", Wish::Orientation(101)),
        ("pose", Wish::Pose([0, 101])),
        ("velocity", Wish::Velocity(101)),
        ("set velocity", Wish::SetVelocity(101, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0])),
        ("reset physics", Wish::ResetPhysics(101)),
        ("restart controller", Wish::RestartController(101)),
        ("track", Wish::Track([0, 101], Some(32))),
        ("track no longer", Wish::Track([0, 101], None)),
        ("reset", Wish::Reset),
        ("mode", Wish::Mode(2)),
        ("quit", Wish::Quit(0)),
    ]
}

fn facts(release: Release) -> Vec<(&'static str, Fact)> {
    let node = Node {
        uid: 101,
        node_type: 34,
        tag: 0,
        parent: 1,
        proto: true,
        ancestor: ancestor(release),
        model: "e-puck".to_owned(),
    };
    vec![
        ("node by def", Fact::NodeByDef(node.clone())),
        ("node by id", Fact::NodeById(node, false, "RED1".to_owned())),
        ("field", Fact::Field(0, 5, false, -1, "translation".to_owned())),
        ("value", Fact::Value(Some((101, 0, Value::Vec3([1.0, 2.0, 0.0]))))),
        ("position", Fact::Position([1.0, 2.0, 0.0])),
        ("orientation", Fact::Orientation(std::array::from_fn(|i| i as f64))),
        ("pose", Fact::Pose([0, 101], std::array::from_fn(|i| i as f64))),
        ("velocity", Fact::Velocity(std::array::from_fn(|i| i as f64))),
    ]
}

#[test]
fn what_webots_says_and_is_asked_has_the_documented_bytes_in_both_releases() {
    let mut said = Said::default();
    for release in [Release::R2023b, Release::R2025a] {
        let (name, robot) = (release.name(), robot(release));
        said.row(&format!("webots {name} configure"), &robot.encode());
        assert_eq!(Robot::decode(&robot.encode()).unwrap().0, robot);
        for (what, wish) in wishes() {
            let mut w = Writer::new();
            wish.write(release, &mut w);
            let bytes = w.into_bytes();
            said.row(&format!("webots {name} wish {what}"), &bytes);
            let again = Wish::read(bytes[0], release, &mut Reader::new(&bytes[1..])).unwrap();
            assert_eq!(again, Some(wish));
        }
        for (what, fact) in facts(release) {
            let mut w = Writer::new();
            fact.write(release, &mut w);
            let bytes = w.into_bytes();
            said.row(&format!("webots {name} fact {what}"), &bytes);
            let again = Fact::read(bytes[0], release, &mut Reader::new(&bytes[1..])).unwrap();
            assert_eq!(again, Some(fact));
        }
    }
    assert_eq!(said.0, golden(&["webots R2023b", "webots R2025a"]));
}
