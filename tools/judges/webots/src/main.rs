//! The real libController of Webots R2023b drives 200 steps in our server, with motors, camera, eight infra-red sensors,
//! wheel encoders and supervisor calls. After every step it must have seen exactly what the world shows, and a client of
//! our own protocol modules, doing the same in a second world, must have seen the same pictures, readings and poses.

use metal_robots::arena::{Arena, ArenaConfig, Traffic};
use metal_robots::bytes::Writer;
use metal_robots::serve::{Shared, look_into, webots as server};
use metal_robots::webots::frame::{Answer, Request, hello};
use metal_robots::webots::news::{self, News};
use metal_robots::webots::order::Order;
use metal_robots::webots::robot::Robot;
use metal_robots::webots::supervisor::{Fact, Wish};
use metal_robots::webots::{ROBOT, Release};
use metal_robots::{Emergency, Picture};
use metal_worlds::highway::{Pose, RgbConfig, RoadSet, Scenario};
use std::ffi::{CStr, CString};
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::{Arc, Mutex};
use webots_bindings as wb;

const STEPS: usize = 200;
const STEP_MS: i32 = 32;

/// A server in a thread, and a look into its world.
fn world() -> (Shared, String) {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let address = listener.local_addr().expect("a bound port").to_string();
    let config = ArenaConfig {
        grounds: RoadSet::Seeds(vec![1]).build(),
        scenario: Scenario::Mix,
        traffic: Traffic::Scripted,
        rgb: RgbConfig { light: 1.0, noise: 0.02, blur: 0.3, ..RgbConfig::default() },
        seed: 7,
    };
    let arena = Arc::new(Mutex::new(Arena::new(config)));
    let shared = Arc::clone(&arena);
    std::thread::spawn(move || server::serve(&listener, &shared, &Emergency::default()));
    (arena, address)
}

/// Wheel speeds of a step, in radians per second: straight, arcs, a turn on the spot.
fn wheels(step: usize) -> [f64; 2] {
    [[5.0, 5.0], [3.0, 4.5], [6.28, 5.0], [-2.0, 2.0], [0.0, 0.0]][step / 40]
}

/// What somebody saw in a step.
#[derive(Clone, Debug, PartialEq)]
struct Seen {
    picture: Vec<u8>,
    ring: [f64; 8],
    encoders: [f64; 2],
    place: [f64; 3],
}

fn shown(arena: &Shared) -> Seen {
    let arena = look_into(arena);
    let Picture { pixels, .. } = arena.picture();
    let pose = arena.bodies()[0];
    Seen {
        picture: pixels.iter().flat_map(|&[r, g, b]| [b, g, r, 255]).collect(),
        ring: arena.proximity(),
        encoders: arena.rolled_m().map(|m| m / 0.02),
        place: [pose.x_m, pose.y_m, 0.0],
    }
}

/// libController, one connection in the life of a process.
struct Library {
    camera: u16,
    ring: [u16; 8],
    encoders: [u16; 2],
    motors: [u16; 2],
    learner: wb::WbNodeRef,
}

fn device(name: &str) -> u16 {
    let name = CString::new(name).expect("no zero in a name");
    // SAFETY: libController was initialised; the text ends with a zero.
    unsafe { wb::wb_robot_get_device(name.as_ptr()) }
}

impl Library {
    fn connect(address: &str) -> Self {
        // SAFETY: nobody else reads the environment now: the only other thread waits for a connection.
        unsafe { std::env::set_var("WEBOTS_CONTROLLER_URL", format!("tcp://{address}/{}", server::NAME)) };
        // SAFETY: called once, before every other function of libController.
        assert!(unsafe { wb::wb_robot_init() } != 0, "libController did not connect");
        let library = Self {
            camera: device("camera"),
            ring: std::array::from_fn(|i| device(&format!("ps{i}"))),
            encoders: ["left wheel sensor", "right wheel sensor"].map(device),
            motors: ["left wheel motor", "right wheel motor"].map(device),
            learner: node("LEARNER"),
        };
        assert!(!library.learner.is_null(), "the learner's node was not found");
        assert!(node("NOBODY").is_null(), "a node that is not there was found");
        // SAFETY: all tags are those of devices of these kinds.
        unsafe {
            assert_eq!(
                (wb::wb_camera_get_width(library.camera), wb::wb_camera_get_height(library.camera)),
                (52, 39)
            );
            wb::wb_camera_enable(library.camera, STEP_MS);
            library.ring.iter().for_each(|&tag| wb::wb_distance_sensor_enable(tag, STEP_MS));
            library.encoders.iter().for_each(|&tag| wb::wb_position_sensor_enable(tag, STEP_MS));
            library.motors.iter().for_each(|&tag| wb::wb_motor_set_position(tag, f64::INFINITY));
        }
        library
    }

    fn step(&self, [left, right]: [f64; 2]) -> Seen {
        // SAFETY: all tags are those of devices of these kinds, and pointers are used before the next step.
        unsafe {
            wb::wb_motor_set_velocity(self.motors[0], left);
            wb::wb_motor_set_velocity(self.motors[1], right);
            assert!(wb::wb_robot_step(STEP_MS) != -1, "the server ended");
            let picture = std::slice::from_raw_parts(wb::wb_camera_get_image(self.camera), 52 * 39 * 4);
            let place = std::slice::from_raw_parts(wb::wb_supervisor_node_get_position(self.learner), 3);
            Seen {
                picture: picture.to_vec(),
                ring: self.ring.map(|tag| wb::wb_distance_sensor_get_value(tag)),
                encoders: self.encoders.map(|tag| wb::wb_position_sensor_get_value(tag)),
                place: [place[0], place[1], place[2]],
            }
        }
    }

    /// Puts the learner elsewhere, as a supervisor does for a new episode, and reads it back.
    fn place(&self, pose: Pose) -> [f64; 4] {
        let field = |name: &CStr| {
            // SAFETY: the node was found before.
            unsafe { wb::wb_supervisor_node_get_field(self.learner, name.as_ptr()) }
        };
        let (translation, rotation) = (field(c"translation"), field(c"rotation"));
        assert!(field(c"nonsense").is_null(), "a field that is not there was found");
        // SAFETY: the fields are of these types, the arrays as long as libController reads.
        unsafe {
            wb::wb_supervisor_field_set_sf_vec3f(translation, [pose.x_m, pose.y_m, 0.0].as_ptr());
            wb::wb_supervisor_field_set_sf_rotation(rotation, [0.0, 0.0, 1.0, pose.heading_rad].as_ptr());
            wb::wb_supervisor_node_reset_physics(self.learner);
            wb::wb_robot_step(STEP_MS);
            let matrix = std::slice::from_raw_parts(wb::wb_supervisor_node_get_orientation(self.learner), 9);
            let found = std::slice::from_raw_parts(wb::wb_supervisor_field_get_sf_vec3f(translation), 3);
            [found[0], found[1], matrix[0], matrix[3]]
        }
    }
}

fn node(def: &str) -> wb::WbNodeRef {
    let def = CString::new(def).expect("no zero in a name");
    // SAFETY: libController was initialised; the text ends with a zero.
    unsafe { wb::wb_supervisor_node_get_from_def(def.as_ptr()) }
}

/// Our own client, from our own protocol modules.
struct Ours {
    stream: TcpStream,
    robot: Robot,
    learner: u32,
}

impl Ours {
    fn connect(address: &str) -> Self {
        let mut stream = TcpStream::connect(address).expect("our server");
        stream.write_all(&hello(None)).expect("an open line");
        stream.read_exact(&mut [0; 9]).expect("a welcome");
        let answer = ask(&mut stream, &Request::default());
        let (robot, _) = Robot::decode(&answer.news).expect("a robot");
        let mut ours = Self { stream, robot, learner: 0 };
        let wish = Wish::NodeByDef("LEARNER".to_owned());
        let answer = ask(&mut ours.stream, &Request { step_ms: 0, orders: vec![supervise(wish)] });
        let mut found = 0;
        ours.hear(&answer, |n| {
            if let News::Fact(Fact::NodeByDef(node)) = n {
                found = node.uid;
            }
        });
        ours.learner = u32::try_from(found).expect("a number that is not negative");
        ours
    }

    fn hear(&self, answer: &Answer, heard: impl FnMut(News)) {
        news::read_all(&self.robot, &answer.news, heard).expect("news that mean something");
    }

    fn tag(&self, name: &str) -> u16 {
        self.robot.tag(name).expect("an E-puck's device")
    }

    fn step(&mut self, speeds: [f64; 2]) -> Seen {
        let mut orders = Vec::new();
        let names = (0..8)
            .map(|i| format!("ps{i}"))
            .chain(["camera", "left wheel sensor", "right wheel sensor"].map(str::to_owned));
        for name in names {
            let mut sample = Writer::new();
            sample.u8(1).u16(STEP_MS as u16);
            orders.push((self.tag(&name), sample.into_bytes()));
        }
        for (name, speed) in ["left wheel motor", "right wheel motor"].into_iter().zip(speeds) {
            let mut velocity = Writer::new();
            velocity.u16(2).f64(speed);
            orders.push((self.tag(name), velocity.into_bytes()));
        }
        let answer = ask(&mut self.stream, &Request { step_ms: STEP_MS as u32, orders });
        let (mut ring, mut encoders, mut place) = ([0.0; 8], [0.0; 2], [0.0; 3]);
        let first = self.tag("ps0");
        let left = self.tag("left wheel sensor");
        self.hear(&answer, |n| {
            if let News::Reading(tag, value) = n {
                match tag {
                    t if (first..first + 8).contains(&t) => ring[usize::from(t - first)] = value,
                    t if t == left => encoders[0] = value,
                    _ => encoders[1] = value,
                }
            }
        });
        // As libController: a question for itself, once time has passed.
        let orders = vec![supervise(Wish::Position(self.learner))];
        let asked = ask(&mut self.stream, &Request { step_ms: 0, orders });
        self.hear(&asked, |n| {
            if let News::Fact(Fact::Position(found)) = n {
                place = found;
            }
        });
        Seen { picture: answer.images[0].bgra.clone(), ring, encoders, place }
    }
}

/// A supervisor's wish as an order to the robot.
fn supervise(wish: Wish) -> (u16, Vec<u8>) {
    let mut payload = Writer::new();
    Order::Wish(wish).write(Release::R2023b, &mut payload);
    (ROBOT, payload.into_bytes())
}

fn ask(stream: &mut TcpStream, request: &Request) -> Answer {
    stream.write_all(&request.encode()).expect("an open line");
    let (mut bytes, mut buffer) = (Vec::new(), [0; 65_536]);
    loop {
        match Answer::decode(&bytes) {
            Ok((answer, _)) => return answer,
            Err(error) if error.wants_more() => {
                let count = stream.read(&mut buffer).expect("an open line");
                assert!(count > 0, "the server ended");
                bytes.extend_from_slice(&buffer[..count]);
            }
            Err(error) => panic!("{error}"),
        }
    }
}

fn main() {
    let ((theirs, address), (ours, own_address)) = (world(), world());
    let library = Library::connect(&address);
    let mut client = Ours::connect(&own_address);
    let start = std::time::Instant::now();
    for step in 0..STEPS {
        let (seen, own) = (library.step(wheels(step)), client.step(wheels(step)));
        assert_eq!(
            seen,
            shown(&theirs),
            "step {step}: libController saw something else than the world shows"
        );
        assert_eq!(own, shown(&ours), "step {step}: our client saw something else than its world shows");
        assert_eq!(seen, own, "step {step}: libController and our client saw different worlds");
    }
    let secs = start.elapsed().as_secs_f64();
    let found = library.place(Pose { x_m: 0.25, y_m: -0.5, heading_rad: 1.0 });
    let expected = [0.25, -0.5, 1.0_f64.cos(), 1.0_f64.sin()];
    assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
    // SAFETY: nothing of libController is used afterwards.
    unsafe { wb::wb_robot_cleanup() };
    println!(
        "  {STEPS} steps: pictures, eight sensors, encoders and poses are the same, to the bit ({:.0} steps/s)",
        STEPS as f64 / secs
    );
}
