//! Our own world behind the languages of others, so that drivers are tested end to end and any existing controller of an
//! E-puck can drive on our highway.

#[cfg(all(target_os = "linux", feature = "serial"))]
pub mod epuck1;
pub mod epuck2;
pub mod webots;

use crate::arena::Arena;
use crate::body::{INFRARED, Wheels};
use crate::epuck::{metres_per_second, steps_per_second};
use crate::guard::Emergency;
use std::io::{self, ErrorKind};
use std::net::{TcpListener, TcpStream};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// An arena that a server drives and somebody else may look into.
pub type Shared = Arc<Mutex<Arena>>;

/// The arena, whatever happened to whoever held it before.
pub fn look_into(arena: &Shared) -> MutexGuard<'_, Arena> {
    arena.lock().unwrap_or_else(PoisonError::into_inner)
}

/// How long a server waits before it asks whether it shall end.
const ROUND: Duration = Duration::from_millis(5);

/// Waits for somebody to connect; `None` if the server shall end first.
fn wait_for_somebody(listener: &TcpListener, end: &Emergency) -> io::Result<Option<TcpStream>> {
    listener.set_nonblocking(true)?;
    while !end.pressed() {
        match listener.accept() {
            Ok((stream, _)) => {
                stream.set_nonblocking(false)?;
                stream.set_nodelay(true)?;
                stream.set_read_timeout(Some(ROUND))?;
                stream.set_write_timeout(Some(Duration::from_secs(5)))?;
                return Ok(Some(stream));
            }
            Err(e) if e.kind() == ErrorKind::WouldBlock => std::thread::sleep(ROUND),
            Err(e) => return Err(e),
        }
    }
    Ok(None)
}

/// Whether nothing has come yet, on a link that is whole.
fn is_pause(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted)
}

/// A robot in an arena whose time is the real one.
struct RealTime {
    arena: Shared,
    last: Instant,
}

impl RealTime {
    fn new(arena: Shared) -> Self {
        Self { arena, last: Instant::now() }
    }

    /// Lets the arena reach now, then does something in it.
    fn now<T>(&mut self, act: impl FnOnce(&mut Arena) -> T) -> T {
        let mut arena = look_into(&self.arena);
        let ms = self.last.elapsed().as_millis() as u64;
        self.last += Duration::from_millis(ms);
        arena.pass(ms);
        act(&mut arena)
    }

    fn drive(&mut self, steps: [i16; 2]) {
        let [left_mps, right_mps] = steps.map(metres_per_second);
        self.now(|arena| arena.drive(Wheels { left_mps, right_mps }));
    }

    /// A link that ends stops the wheels.
    fn stop(&mut self) {
        self.now(|arena| arena.drive(Wheels::STILL));
    }
}

/// Infra-red readings as a calibrated robot sends them: 0 if nothing is near.
fn calibrated(proximity: [f64; INFRARED]) -> [u16; INFRARED] {
    proximity.map(|p| (p - 67.0).clamp(0.0, 4095.0).round() as u16)
}

/// Step counters, which run over like the robot's.
fn step_counters(arena: &Arena) -> [i16; 2] {
    let per_metre = f64::from(steps_per_second(0.1, i16::MAX)) / 0.1;
    arena.rolled_m().map(|m| (m * per_metre).round() as i64 as i16)
}
