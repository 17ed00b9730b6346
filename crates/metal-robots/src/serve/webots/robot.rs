//! The robot that `metal serve webots` plays.

use super::{BASIC_STEP_MS, FASTEST_RADPS, FIRST_NODE, NAME};
use crate::arena::Arena;
use crate::bodies::webots::LEARNER;
use crate::webots::Release;
use crate::webots::device::{self, Kind, Settings};
use crate::webots::robot::{Device, Robot, Texts};
use crate::webots::supervisor::Me;
use metal_worlds::highway::camera::{COLUMNS, FIELD_OF_VIEW_RAD, ROWS};

/// An E-puck as Webots describes it: motors first.
pub(super) fn robot(arena: &Arena) -> Robot {
    let mut devices = Vec::new();
    let mut add = |kind: Kind, name: String, settings: Option<Settings>| {
        devices.push(Device { kind, name, model: String::new(), settings });
    };
    let motor = device::Motor {
        kind: 0,
        numbers: [0.0, 0.0, FASTEST_RADPS, -1.0, 10.0, 10.0, 0.0, 0.0, 0.0, FASTEST_RADPS, 1.0],
        coupled: Vec::new(),
    };
    for side in ["left", "right"] {
        add(Kind::Motor, format!("{side} wheel motor"), Some(Settings::Motor(motor.clone())));
    }
    for side in ["left", "right"] {
        add(Kind::PositionSensor, format!("{side} wheel sensor"), Some(Settings::Position(0)));
    }
    for i in 0..8 {
        add(Kind::DistanceSensor, format!("ps{i}"), Some(Settings::Distance(1, [67.0, 4095.0, 0.1], vec![])));
    }
    for i in 0..8 {
        add(Kind::LightSensor, format!("ls{i}"), Some(Settings::Table(vec![])));
    }
    add(Kind::Camera, "camera".to_owned(), Some(Settings::Camera(camera())));
    for i in 0..10 {
        add(Kind::Led, format!("led{i}"), None);
    }
    add(Kind::Accelerometer, "accelerometer".to_owned(), Some(Settings::Table(vec![])));
    add(Kind::Gyro, "gyro".to_owned(), Some(Settings::Table(vec![])));
    let radio = |rate_range| device::Radio { buffer_channel: [4096, 1], rate_range, allowed: Vec::new() };
    add(Kind::Receiver, "receiver".to_owned(), Some(Settings::Radio(radio(None))));
    add(Kind::Emitter, "emitter".to_owned(), Some(Settings::Radio(radio(Some([-1.0; 3])))));
    add(Kind::Speaker, "speaker".to_owned(), None);
    Robot {
        name: NAME.to_owned(),
        release: Release::R2023b,
        synchronised: true,
        time_s: arena.time_ms() as f64 / 1000.0,
        devices,
        basic_step_ms: BASIC_STEP_MS as f64,
        texts: Texts { all: texts(), windows: [false; 2] },
        mode: 2,
        supervisor: Some(Me { uid: FIRST_NODE as i32, def: LEARNER.to_owned(), ..Me::default() }),
    }
}

/// Project, world, model, window, remote control, controller, custom data. `<none>` and an
/// empty text keep libController from looking for libraries of a window and of a remote control.
fn texts() -> [String; 7] {
    ["", "metal-highway.wbt", "GCtronic e-puck", "<none>", "", "<extern>", ""].map(str::to_owned)
}

fn camera() -> device::Camera {
    device::Camera {
        uid: 1,
        size: [COLUMNS as u16, ROWS as u16],
        field_of_view_rad: FIELD_OF_VIEW_RAD,
        near_m: 0.0055,
        planar_recognising_segmenting: [true, false, false],
        field_of_view_range_rad: [FIELD_OF_VIEW_RAD; 2],
        optics: [1.0, 0.0, 0.0, 0.0, 0.0],
    }
}
