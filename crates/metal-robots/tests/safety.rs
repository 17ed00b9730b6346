//! The guard: one test for each way in which the wheels must come to a stand.
#![allow(clippy::unwrap_used)]

use metal_robots::body::{About, INFRARED, InfraredScale};
use metal_robots::link::Meter;
use metal_robots::{Body, BodyError, Emergency, Guard, Limits, Picture, Wheels};
use metal_worlds::highway::camera::Window;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// What a body was told, and when.
#[derive(Default)]
struct Diary {
    commands: Vec<(Instant, Wheels)>,
    broken: bool,
    /// Commands that fail before the body is reached again.
    deaf: usize,
}

#[derive(Clone, Default)]
struct Dummy(Arc<Mutex<Diary>>);

impl Dummy {
    fn commands(&self) -> Vec<Wheels> {
        self.0.lock().unwrap().commands.iter().map(|(_, w)| *w).collect()
    }

    fn last(&self) -> Wheels {
        *self.commands().last().unwrap()
    }

    fn stopped_within(&self, most: Duration) -> bool {
        let start = Instant::now();
        while self.last() != Wheels::STILL && start.elapsed() < most {
            std::thread::sleep(Duration::from_millis(5));
        }
        self.last() == Wheels::STILL
    }

    fn guarded(&self, limits: Limits, emergency: &Emergency) -> Guard {
        Guard::new(Box::new(self.clone()), limits, emergency.clone()).unwrap()
    }
}

impl Body for Dummy {
    fn name(&self) -> &str {
        "dummy"
    }

    fn fastest_mps(&self) -> f64 {
        0.1256
    }

    fn infrared_scale(&self) -> InfraredScale {
        InfraredScale { idle: 0.0, factor: 1.0 }
    }

    fn drive(&mut self, wheels: Wheels) -> Result<(), BodyError> {
        let mut diary = self.0.lock().unwrap();
        if diary.deaf > 0 {
            diary.deaf -= 1;
            return Err(BodyError::Lost("deaf".to_owned()));
        }
        diary.commands.push((Instant::now(), wheels));
        Ok(())
    }

    fn pass(&mut self, secs: f64) -> Result<(), BodyError> {
        std::thread::sleep(Duration::from_secs_f64(secs));
        Ok(())
    }

    fn tick_secs(&self) -> f64 {
        0.01
    }

    fn picture(&mut self, _: Window) -> Result<Picture, BodyError> {
        let broken = self.0.lock().unwrap().broken;
        assert!(!broken, "the camera fell off");
        Err(BodyError::Silent(Duration::from_secs(1)))
    }

    /// As slow as a picture on a serial line.
    fn proximity(&mut self) -> Result<[f64; INFRARED], BodyError> {
        std::thread::sleep(Duration::from_millis(40));
        Ok([0.0; INFRARED])
    }

    fn meter(&self) -> Meter {
        Meter::default()
    }

    fn about(&mut self) -> Result<About, BodyError> {
        Ok(Vec::new())
    }
}

const SLOW: Wheels = Wheels { left_mps: 0.05, right_mps: 0.05 };

fn setup() -> (Dummy, Emergency, Guard) {
    let (dummy, emergency) = (Dummy::default(), Emergency::default());
    let guard = dummy.guarded(Limits::default(), &emergency);
    (dummy, emergency, guard)
}

#[test]
fn whoever_takes_over_a_body_stops_it_first() {
    let (dummy, _, _guard) = setup();
    assert_eq!(dummy.commands(), [Wheels::STILL]);
}

#[test]
fn an_error_stops() {
    let (dummy, _, guard) = setup();
    guard.command(SLOW).unwrap();
    assert_eq!(dummy.last(), SLOW);
    assert!(guard.with(|body| body.picture(Window::WHOLE)).is_err());
    assert_eq!(dummy.last(), Wheels::STILL);
}

#[test]
fn dropping_the_guard_stops() {
    let (dummy, _, guard) = setup();
    guard.command(SLOW).unwrap();
    drop(guard);
    assert_eq!(dummy.last(), Wheels::STILL);
}

#[test]
fn a_panic_stops_even_in_the_body_itself() {
    let (dummy, _, guard) = setup();
    guard.command(SLOW).unwrap();
    dummy.0.lock().unwrap().broken = true;
    let panicked = std::thread::spawn(move || drop(guard.with(|body| body.picture(Window::WHOLE)))).join();
    assert!(panicked.is_err(), "it unwound with the body locked");
    assert_eq!(dummy.last(), Wheels::STILL);
}

#[test]
fn a_panic_elsewhere_stops_after_the_silence() {
    let (dummy, _, guard) = setup();
    let guard = Arc::new(guard);
    let driver = Arc::clone(&guard);
    let start = Instant::now();
    let panicked = std::thread::spawn(move || {
        driver.command(SLOW).unwrap();
        // Without the hook: to write a backtrace may take longer than the silence that is waited for.
        std::panic::resume_unwind(Box::new("the driver is gone, and somebody else still holds the guard"));
    })
    .join();
    assert!(panicked.is_err());
    assert_eq!(dummy.last(), SLOW);
    assert!(dummy.stopped_within(Duration::from_secs(3)));
    assert!(start.elapsed() >= Duration::from_millis(500));
}

#[test]
fn the_emergency_stop_stops_at_once_and_nothing_starts_again() {
    let (dummy, emergency, guard) = setup();
    guard.command(SLOW).unwrap();
    emergency.press();
    std::thread::sleep(Duration::from_millis(100));
    assert_eq!(dummy.last(), Wheels::STILL);
    assert!(matches!(guard.command(SLOW), Err(BodyError::Stopped)));
    assert_eq!(dummy.last(), Wheels::STILL);
}

#[test]
fn the_emergency_stop_ends_an_action_in_the_middle() {
    let (dummy, emergency, guard) = setup();
    let button = emergency.clone();
    let presser = std::thread::spawn(move || {
        std::thread::sleep(Duration::from_millis(100));
        button.press();
    });
    let start = Instant::now();
    assert!(matches!(guard.drive_for(SLOW, 5.0), Err(BodyError::Stopped)));
    assert!(start.elapsed() < Duration::from_secs(1));
    presser.join().unwrap();
    assert_eq!(dummy.last(), Wheels::STILL);
}

#[test]
fn a_lost_link_is_tried_again_to_stop() {
    let (dummy, _, guard) = setup();
    guard.command(SLOW).unwrap();
    // The command and the first attempt to stop are lost; the second attempt finds the link again.
    dummy.0.lock().unwrap().deaf = 2;
    assert!(guard.command(SLOW).is_err());
    assert_eq!(dummy.last(), Wheels::STILL);
}

#[test]
fn silence_of_half_a_second_stops_and_less_does_not() {
    let (dummy, _, guard) = setup();
    let start = Instant::now();
    guard.command(SLOW).unwrap();
    std::thread::sleep(Duration::from_millis(250));
    assert_eq!(dummy.last(), SLOW, "a quarter of a second is no silence");
    assert!(dummy.stopped_within(Duration::from_secs(3)));
    assert!((Duration::from_millis(500)..Duration::from_secs(1)).contains(&start.elapsed()));
}

#[test]
fn whoever_looks_without_a_pause_is_stopped_after_the_silence_all_the_same() {
    let (dummy, _, guard) = setup();
    guard.command(SLOW).unwrap();
    let start = Instant::now();
    while dummy.last() == SLOW && start.elapsed() < Duration::from_secs(3) {
        guard.with(|body| body.proximity()).unwrap();
    }
    assert_eq!(dummy.last(), Wheels::STILL);
    assert!((Duration::from_millis(500)..Duration::from_secs(1)).contains(&start.elapsed()));
    assert_eq!(dummy.commands().len(), 3, "still, slow, still: nobody stopped it more often than needed");
}

#[test]
fn no_command_exceeds_the_limits_and_the_way_stays_the_same() {
    let (dummy, emergency) = (Dummy::default(), Emergency::default());
    let limits = Limits { speed_mps: 0.08, acceleration_mps2: 0.5 };
    let guard = dummy.guarded(limits, &emergency);
    let wheels = Wheels { left_mps: 0.10, right_mps: 0.12 };
    guard.drive_for(wheels, 0.3).unwrap();
    let commands = dummy.commands();
    let (mut way, mut before) = ([0.0, 0.0], 0.0);
    for command in &commands {
        assert!(command.fastest_mps() <= 0.08 + 1e-12, "{command:?}");
        assert!(command.fastest_mps() <= before + 0.5 * 0.01 + 1e-12, "from {before} to {command:?}");
        before = command.fastest_mps();
        way = [way[0] + 0.01 * command.left_mps, way[1] + 0.01 * command.right_mps];
    }
    assert_eq!(dummy.last(), Wheels::STILL);
    assert!((way[0] - 0.03).abs() < 1e-9 && (way[1] - 0.036).abs() < 1e-9, "{way:?}");
}

#[test]
fn a_wild_command_is_reached_step_by_step_and_never_exceeded() {
    let (dummy, emergency) = (Dummy::default(), Emergency::default());
    let limits = Limits { speed_mps: 0.08, acceleration_mps2: 0.5 };
    let guard = dummy.guarded(limits, &emergency);
    // Whoever stood for long may not jump either.
    std::thread::sleep(Duration::from_millis(150));
    for fastest in [0.05, 0.075, 0.08, 0.08] {
        guard.command(Wheels { left_mps: -9.0, right_mps: 9.0 }).unwrap();
        let last = dummy.last();
        assert_eq!(last.left_mps, -last.right_mps, "the same arc");
        // A busy machine may let more time pass between two commands: at most a tenth of a second counts.
        assert!(last.right_mps >= fastest - 1e-12 && last.right_mps <= 0.08 + 1e-12, "{last:?} {fastest}");
    }
    guard.command(Wheels { left_mps: 0.0, right_mps: 0.01 }).unwrap();
    assert_eq!(dummy.last(), Wheels { left_mps: 0.0, right_mps: 0.01 }, "braking is always allowed");
    let first = dummy.commands()[1];
    assert!(first.right_mps <= 0.05 + 1e-12, "{first:?}");
}
