//! `metal serve webots`: Webots' side of the language of external controllers (the layouts of R2023b, or of R2025a), so
//! that any controller for an E-puck in Webots can drive on our highway, in C, C++, Python or Rust.
//!
//! The simulation waits for its controller: time passes only in its steps.

mod robot;

use super::{Shared, is_pause, look_into, wait_for_somebody};
use crate::arena::Arena;
use crate::bodies::webots::{CAR, LEARNER};
use crate::body::Wheels;
use crate::bytes::Writer;
use crate::epuck::WHEEL_RADIUS_M;
use crate::guard::Emergency;
use crate::picture::encode_bgra;
use crate::webots::device::Kind;
use crate::webots::frame::{Answer, Image, Request, Welcome, read_hello};
use crate::webots::news::{write_fact, write_reading, write_time};
use crate::webots::order::{self, Order};
use crate::webots::robot::{Device, Robot};
use crate::webots::supervisor::{Fact, Field, Node, Value, Wish};
use crate::webots::{ROBOT, Release};
use metal_rl::num;
use metal_worlds::highway::Pose;
use metal_worlds::highway::kinematics::{AXLE_M, WHEEL_LIMIT_MPS};
use std::io::{self, Read, Write};
use std::net::{TcpListener, TcpStream};

/// Name of the robot.
pub const NAME: &str = "learner";
/// Length of a step of the simulation, in milliseconds.
pub const BASIC_STEP_MS: u64 = 32;
/// Node number of the learner; the cars follow.
const FIRST_NODE: u32 = 100;
/// The fastest a wheel turns, in radians per second.
const FASTEST_RADPS: f64 = WHEEL_LIMIT_MPS / WHEEL_RADIUS_M;
/// Node type of a robot.
const ROBOT_TYPE: i32 = 34;

/// Serves one controller after the other until `end` is pressed, in the language of R2023b, for which there is a library
/// of other people that can be built without Webots.
///
/// # Errors
/// If nobody can be accepted any more.
pub fn serve(listener: &TcpListener, arena: &Shared, end: &Emergency) -> io::Result<()> {
    serve_as(Release::R2023b, listener, arena, end)
}

/// As [`serve`], in the language of any release that is known.
///
/// # Errors
/// If nobody can be accepted any more.
pub fn serve_as(release: Release, listener: &TcpListener, arena: &Shared, end: &Emergency) -> io::Result<()> {
    while let Some(stream) = wait_for_somebody(listener, end)? {
        // A controller that breaks off is no reason to end.
        let _ = Session::new(arena, release).talk(stream, end);
        look_into(arena).drive(Wheels::STILL);
    }
    Ok(())
}

struct Session<'a> {
    arena: &'a Shared,
    robot: Robot,
    periods_ms: Vec<u16>,
    next_ms: Vec<u64>,
    tracked: Vec<[u32; 2]>,
    described: bool,
}

/// What is to be said to the controller.
#[derive(Default)]
struct Reply {
    news: Writer,
    leaves: bool,
}

impl<'a> Session<'a> {
    fn new(arena: &'a Shared, release: Release) -> Self {
        let robot = Robot { release, ..robot::robot(&look_into(arena)) };
        let slots = robot.devices.len() + 1;
        let (periods_ms, next_ms) = (vec![0; slots], vec![0; slots]);
        Self { arena, robot, periods_ms, next_ms, tracked: Vec::new(), described: false }
    }

    fn talk(mut self, mut stream: TcpStream, end: &Emergency) -> io::Result<()> {
        if !self.welcome(&mut stream, end)? {
            return Ok(());
        }
        let (mut pending, mut buffer) = (Vec::new(), [0; 65_536]);
        while !end.pressed() {
            match stream.read(&mut buffer) {
                Ok(0) => return Ok(()),
                Ok(count) => pending.extend_from_slice(&buffer[..count]),
                Err(e) if is_pause(&e) => continue,
                Err(e) => return Err(e),
            }
            while let Some(used) = self.serve_one(&pending, &mut stream)? {
                pending.drain(..used);
                if used == 0 {
                    return Ok(());
                }
            }
        }
        // Webots ends, so its controllers end.
        let mut quit = Writer::new();
        quit.u16(ROBOT).u8(2);
        stream.write_all(&Answer { news: quit.into_bytes(), ..Answer::default() }.encode())
    }

    /// Reads the greeting and answers it; whether the controller may go on.
    fn welcome(&self, stream: &mut TcpStream, end: &Emergency) -> io::Result<bool> {
        let mut buffer = [0; 1024];
        let count = loop {
            match stream.read(&mut buffer) {
                Ok(count) => break count,
                Err(e) if is_pause(&e) && !end.pressed() => {}
                Err(e) => return Err(e),
            }
        };
        let welcome = match read_hello(&buffer[..count]) {
            Ok(None) => Welcome::Connected,
            Ok(Some(name)) if name == NAME => Welcome::Connected,
            Ok(Some(_)) => Welcome::Failed,
            Err(_) => Welcome::Forbidden,
        };
        stream.write_all(welcome.word().as_bytes())?;
        Ok(welcome == Welcome::Connected)
    }

    /// Answers the first request in `pending`: bytes used, 0 if the controller leaves, `None` if it is not whole.
    fn serve_one(&mut self, pending: &[u8], stream: &mut TcpStream) -> io::Result<Option<usize>> {
        let (request, used) = match Request::decode(pending) {
            Ok((Some(request), used)) => (request, used),
            Ok((None, _)) => return Ok(Some(0)),
            Err(error) if error.wants_more() => return Ok(None),
            Err(error) => return Err(io::Error::new(io::ErrorKind::InvalidData, error)),
        };
        let (answer, leaves) = self.obey(&request)?;
        stream.write_all(&answer.encode())?;
        Ok(Some(if leaves { 0 } else { used }))
    }

    fn obey(&mut self, request: &Request) -> io::Result<(Answer, bool)> {
        let arena = self.arena;
        let mut arena = look_into(arena);
        let mut reply = Reply::default();
        if !self.described {
            self.described = true;
            self.robot.time_s = arena.time_ms() as f64 / 1000.0;
            reply.news.raw(&self.robot.encode());
        }
        for (tag, payload) in &request.orders {
            let kind = self.robot.kind(*tag);
            if kind.is_none() && *tag != ROBOT {
                return Err(io::Error::new(io::ErrorKind::InvalidData, format!("no device has tag {tag}")));
            }
            let orders = order::read_all(kind, self.robot.release, payload);
            for order in orders.map_err(|e| io::Error::new(io::ErrorKind::InvalidData, e))? {
                self.carry_out((*tag, order), &mut arena, &mut reply);
            }
        }
        let mut images = Vec::new();
        if request.step_ms > 0 {
            arena.pass(request.step_ms.into());
            write_time(arena.time_ms() as f64 / 1000.0, &mut reply.news);
            images = self.report(&arena, &mut reply.news);
        }
        Ok((Answer { delay_ms: 0, news: reply.news.into_bytes(), images }, reply.leaves))
    }

    fn carry_out(&mut self, (tag, order): (u16, Order), arena: &mut Arena, reply: &mut Reply) {
        match order {
            Order::Sample(period_ms) => {
                let slot = usize::from(tag);
                self.periods_ms[slot] = period_ms;
                self.next_ms[slot] = arena.time_ms() + u64::from(period_ms);
            }
            Order::Velocity(radps) => {
                let mut wheels = arena.wheels();
                // The motors are the first two devices.
                match tag {
                    1 => wheels.left_mps = radps * WHEEL_RADIUS_M,
                    _ => wheels.right_mps = radps * WHEEL_RADIUS_M,
                }
                arena.drive(wheels);
            }
            Order::Wish(wish) => {
                if let Some(fact) = self.grant(wish, arena) {
                    write_fact(&fact, self.robot.release, &mut reply.news);
                }
            }
            Order::Leave => reply.leaves = true,
            Order::Position(_) | Order::Light(_) | Order::Other(_) => {}
        }
    }

    /// Readings and pictures of everybody whose time has come.
    fn report(&mut self, arena: &Arena, news: &mut Writer) -> Vec<Image> {
        let now = arena.time_ms();
        let proximity = arena.proximity();
        let mut images = Vec::new();
        for (tag, device) in (1_u16..).zip(&self.robot.devices) {
            let slot = usize::from(tag);
            let period = u64::from(self.periods_ms[slot]);
            if period == 0 || self.next_ms[slot] > now {
                continue;
            }
            self.next_ms[slot] = now + period;
            if device.kind == Kind::Camera {
                images.push(Image { tag, segments: false, bgra: encode_bgra(&arena.picture()) });
            } else {
                write_reading(tag, device.kind, &values(device, arena, &proximity), news);
            }
        }
        for &[from, to] in &self.tracked {
            if let Some(fact) = pose_fact([from, to], arena) {
                write_fact(&fact, self.robot.release, news);
            }
        }
        images
    }

    /// Carries out a supervisor's wish; what there is to say to it.
    fn grant(&mut self, wish: Wish, arena: &mut Arena) -> Option<Fact> {
        match wish {
            Wish::NodeByDef(def) => {
                let uid = body_by_def(&def, arena).map_or(0, |i| FIRST_NODE + i as u32);
                Some(Fact::NodeByDef(node(uid)))
            }
            Wish::NodeById(uid) => {
                let body = body(u32::try_from(uid).ok()?, arena);
                let def = body.map_or_else(String::new, def_of);
                Some(Fact::NodeById(node(body.map_or(0, |i| FIRST_NODE + i as u32)), false, def))
            }
            Wish::FieldByName(_, name) => Some(match name.as_str() {
                "translation" => Fact::Field(0, 5, false, -1, name),
                "rotation" => Fact::Field(1, 6, false, -1, name),
                "name" => Fact::Field(2, 8, false, -1, name),
                _ => Fact::Field(-1, 0, false, -1, name),
            }),
            Wish::Get(field) => Some(Fact::Value(value(field, arena))),
            Wish::Set(field, value) => {
                set(field, &value, arena);
                None
            }
            Wish::Position(uid) => {
                let pose = arena.bodies()[body(uid, arena)?];
                Some(Fact::Position([pose.x_m, pose.y_m, 0.0]))
            }
            Wish::Orientation(uid) => {
                let m = matrix(&arena.bodies()[body(uid, arena)?]);
                Some(Fact::Orientation([m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]]))
            }
            Wish::Pose(nodes) => pose_fact(nodes, arena),
            Wish::Velocity(uid) => Some(Fact::Velocity(velocity(body(uid, arena)?, arena))),
            Wish::SetVelocity(..) | Wish::RestartController(_) | Wish::Mode(_) | Wish::Quit(_) => None,
            Wish::ResetPhysics(_) => None,
            Wish::Track(nodes, period) => {
                self.tracked.retain(|t| *t != nodes);
                if period.is_some() {
                    self.tracked.push(nodes);
                }
                None
            }
            Wish::Reset => {
                arena.restart();
                None
            }
        }
    }
}

/// What a device reads; lights, radios and speakers read nothing.
fn values(device: &Device, arena: &Arena, proximity: &[f64]) -> Vec<f64> {
    let digit = device.name.bytes().last().map_or(0, |b| usize::from(b.saturating_sub(b'0')));
    match device.kind {
        Kind::DistanceSensor => vec![proximity[digit.min(7)]],
        Kind::LightSensor => vec![4095.0],
        Kind::PositionSensor => {
            let [left, right] = arena.rolled_m().map(|m| m / WHEEL_RADIUS_M);
            vec![if device.name.starts_with("left") { left } else { right }]
        }
        Kind::Accelerometer => vec![0.0, 0.0, 9.81],
        Kind::Gyro => vec![0.0, 0.0, velocity(0, arena)[5]],
        _ => Vec::new(),
    }
}

fn velocity(index: usize, arena: &Arena) -> [f64; 6] {
    if index != 0 {
        return [0.0; 6];
    }
    let wheels = arena.wheels();
    let speed = 0.5 * (wheels.left_mps + wheels.right_mps);
    let turn = (wheels.right_mps - wheels.left_mps) / AXLE_M;
    let (sin, cos) = num::sin_cos(arena.bodies()[0].heading_rad);
    [speed * cos, speed * sin, 0.0, 0.0, 0.0, turn]
}

/// Index of the body whose node this is.
fn body(uid: u32, arena: &Arena) -> Option<usize> {
    uid.checked_sub(FIRST_NODE).map(|i| i as usize).filter(|&i| i < arena.bodies().len())
}

fn def_of(index: usize) -> String {
    if index == 0 { LEARNER.to_owned() } else { format!("{CAR}{index}") }
}

fn body_by_def(def: &str, arena: &Arena) -> Option<usize> {
    (0..arena.bodies().len()).find(|&i| def_of(i) == def)
}

fn node(uid: u32) -> Node {
    Node { uid: uid as i32, node_type: ROBOT_TYPE, proto: uid != 0, ..Node::default() }
}

fn value(field: Field, arena: &Arena) -> Option<(i32, i32, Value)> {
    let index = body(field.node, arena)?;
    let pose = arena.bodies()[index];
    let value = match field.field {
        0 => Value::Vec3([pose.x_m, pose.y_m, 0.0]),
        1 => Value::Rotation([0.0, 0.0, 1.0, pose.heading_rad]),
        _ => Value::Text(if index == 0 { NAME.to_owned() } else { format!("car {index}") }),
    };
    Some((field.node as i32, field.field as i32, value))
}

fn set(field: Field, value: &Value, arena: &mut Arena) {
    let Some(index) = body(field.node, arena) else { return };
    let mut pose = arena.bodies()[index];
    match (field.field, value) {
        (0, Value::Vec3([x_m, y_m, _])) => (pose.x_m, pose.y_m) = (*x_m, *y_m),
        // Bodies stand upright, so only the turn about the vertical counts.
        (1, Value::Rotation([_, _, z, angle])) => pose.heading_rad = num::wrap_angle(z * angle),
        _ => return,
    }
    arena.place(index, pose);
}

fn pose_fact([from, to]: [u32; 2], arena: &Arena) -> Option<Fact> {
    let pose = arena.bodies()[body(to, arena)?];
    Some(Fact::Pose([from as i32, to as i32], matrix(&pose)))
}

/// The pose in the world as a matrix, row by row.
fn matrix(pose: &Pose) -> [f64; 16] {
    let (sin, cos) = num::sin_cos(pose.heading_rad);
    [cos, -sin, 0.0, pose.x_m, sin, cos, 0.0, pose.y_m, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]
}
