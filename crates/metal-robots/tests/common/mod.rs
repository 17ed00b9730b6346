//! Our own servers, each in a thread, on ports that are free.

#![allow(dead_code, clippy::unwrap_used)]

use metal_robots::Emergency;
use metal_robots::arena::{Arena, ArenaConfig, Traffic};
use metal_robots::link::Patience;
use metal_robots::serve::{Shared, epuck2, look_into, webots};
use metal_robots::webots::Release;
use metal_worlds::highway::{Pose, RgbConfig, RoadSet, Scenario};
use std::net::TcpListener;
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::Duration;

pub struct Server {
    pub arena: Shared,
    pub address: String,
    pub end: Emergency,
    thread: Option<JoinHandle<()>>,
}

impl Drop for Server {
    fn drop(&mut self) {
        self.end.press();
        if let Some(thread) = self.thread.take() {
            thread.join().unwrap();
        }
    }
}

pub fn arena(scenario: Scenario) -> Arena {
    let grounds = RoadSet::Seeds(vec![1]).build();
    Arena::new(ArenaConfig {
        grounds,
        scenario,
        traffic: Traffic::Standing,
        rgb: RgbConfig::default(),
        seed: 1,
    })
}

/// A car 8 cm ahead of the learner (6 mm between them).
pub fn with_a_car_ahead(mut arena: Arena) -> Arena {
    let me = arena.bodies()[0];
    let (sin, cos) = metal_rl::num::sin_cos(me.heading_rad);
    let ahead = Pose { x_m: me.x_m + 0.08 * cos, y_m: me.y_m + 0.08 * sin, heading_rad: 0.0 };
    arena.place(1, ahead);
    arena
}

fn start(arena: Arena, address: String, run: impl FnOnce(Shared, Emergency) + Send + 'static) -> Server {
    let (arena, end) = (Arc::new(Mutex::new(arena)), Emergency::default());
    let (world, button) = (arena.clone(), end.clone());
    let thread = Some(std::thread::spawn(move || run(world, button)));
    Server { arena, address, end, thread }
}

pub fn epuck2_server(arena: Arena) -> Server {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    start(arena, address, move |arena, end| epuck2::serve(&listener, &arena, &end).unwrap())
}

pub fn webots_server(arena: Arena) -> Server {
    webots_server_as(Release::R2023b, arena)
}

pub fn webots_server_as(release: Release, arena: Arena) -> Server {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    start(arena, address, move |arena, end| webots::serve_as(release, &listener, &arena, &end).unwrap())
}

#[cfg(feature = "serial")]
pub fn epuck_server(arena: Arena, baud: Option<u32>) -> Server {
    let terminal = metal_robots::serve::epuck1::Terminal::open().unwrap();
    let address = terminal.path().to_owned();
    start(arena, address, move |arena, end| {
        metal_robots::serve::epuck1::serve(terminal, &arena, baud, &end).unwrap();
    })
}

pub fn patience() -> Patience {
    Patience { answer: Duration::from_secs(3), first_pause: Duration::from_millis(20), attempts: 4 }
}

pub fn learner(server: &Server) -> Pose {
    look_into(&server.arena).bodies()[0]
}
