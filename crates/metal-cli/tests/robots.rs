//! `metal` and bodies: a mind that was trained here drives a body that is played in another process.
#![allow(clippy::unwrap_used)]

use std::io::{BufRead, BufReader, Read};
use std::path::PathBuf;
use std::process::{Child, Command, Output, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

fn metal(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_metal"));
    command.args(arguments).current_dir(env!("CARGO_TARGET_TMPDIR"));
    command
}

fn text(output: &Output) -> String {
    format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
}

/// A server that ends with the test.
struct Server(Child, String);

impl Drop for Server {
    fn drop(&mut self) {
        self.0.kill().unwrap();
        self.0.wait().unwrap();
    }
}

fn serve(arguments: &[&str]) -> Server {
    let mut child = metal(&[&["serve"], arguments].concat()).stdout(Stdio::piped()).spawn().unwrap();
    let mut line = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
    let address = line.trim().strip_prefix("listening at ").unwrap().to_owned();
    Server(child, address)
}

/// A mind with next to no training, made once.
fn mind() -> &'static str {
    static FOLDER: OnceLock<String> = OnceLock::new();
    FOLDER.get_or_init(|| trained("driver", PLAN))
}

/// The folder of a run of `plan`.
fn trained(name: &str, plan: &str) -> String {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let file = folder.with_extension("toml");
    std::fs::write(&file, plan).unwrap();
    let _ = std::fs::remove_dir_all(&folder);
    let folder = folder.to_str().unwrap().to_owned();
    let run = ["run", file.to_str().unwrap(), "--out", &folder, "--seeds", "1", "--threads", "1"];
    let output = metal(&run).output().unwrap();
    assert!(output.status.success(), "{}", text(&output));
    folder
}

/// A phase more, in which the mind drives itself.
const DRIVING: &str = r#"
[phase.driving]
after = "demonstration"
roster = ["MN"]
acting = { solo = "MN" }
rate = { constant = 0.1 }
exploration = { random = { from = 0.5, to = 0.3, until = 0.5 } }
budget = { steps = 20 }
[policy.driven]
after = "driving"
roster = ["MN"]
acting = { solo = "MN" }
"#;

/// Two tiny agents, each with its own sensor, fused.
const PLAN: &str = r#"
title = "A driver for tests"
[environment.highway_scripted]
horizon = 10
[learner.tiny.mlp]
[member.MN]
sensors = ["MN"]
learner = "tiny"
[member.IR]
sensors = ["IR"]
learner = "tiny"
[phase.demonstration]
roster = ["MN", "IR"]
acting = "advisor"
sensing = "everyone"
rate = "full"
budget = { steps = 60 }
[policy.oracle]
acting = "advisor"
[policy.blind]
acting = "blind"
[policy.near]
after = "demonstration"
roster = ["MN"]
acting = { solo = "MN" }
[evaluation]
runs = 1
"#;

#[test]
fn a_trained_mind_drives_webots_and_an_epuck2_and_pays_only_for_what_it_looks_at() {
    let webots = serve(&["webots", "--bind", "127.0.0.1:0"]);
    let robot = format!("webots://{}/learner", webots.1);
    let drive = ["drive", "--robot", &robot, "--run", mind(), "--policy", "near", "--steps", "6"];
    let output = metal(
        &[&drive[..], &["--episodes", "2", "--road-seed", "1", "--record", "drive.mcap", "--force"]].concat(),
    )
    .output()
    .unwrap();
    let said = text(&output);
    assert!(output.status.success(), "{said}");
    assert!(said.contains("a look at MN: ") && !said.contains("a look at IR"), "{said}");
    assert_eq!(said.lines().filter(|l| l.trim_end().ends_with("1.00")).count(), 2, "{said}");

    let epuck2 = serve(&["epuck2", "--bind", "127.0.0.1:0"]);
    let robot = format!("epuck2://{}", epuck2.1);
    let drive = ["drive", "--robot", &robot, "--run", mind(), "--policy", "near", "--steps", "3"];
    let output = metal(&drive).output().unwrap();
    assert!(output.status.success(), "{}", text(&output));
    assert!(text(&output).contains("a look at MN: 38422 bytes"), "{}", text(&output));
    let output = metal(&["replay", "drive.mcap"]).output().unwrap();
    assert!(text(&output).contains("Highway-webots"), "{}", text(&output));
    assert_eq!(text(&output).lines().filter(|l| l.contains(" 6 ") && l.ends_with("1.00")).count(), 2);
}

#[test]
fn a_mind_learns_on_in_webots_and_drives_with_what_it_learned() {
    let webots = serve(&["webots", "--bind", "127.0.0.1:0"]);
    let robot = format!("webots://{}/learner", webots.1);
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("learned-on");
    let _ = std::fs::remove_dir_all(&folder);
    let folder = folder.to_str().unwrap();
    let home = trained("before", &format!("{PLAN}{DRIVING}"));
    let drive = |run: &str, more: &[&str]| {
        let drive = ["drive", "--robot", &robot, "--run", run, "--steps", "8", "--road-seed", "1"];
        let output = metal(&[&drive[..], more].concat()).output().unwrap();
        (output.status.success(), text(&output))
    };
    let (refused, said) = drive(&home, &["--policy", "near", "--learn", folder]);
    assert!(!refused && said.contains("phase `demonstration` the mind only watches"), "{said}");
    let learn = ["--policy", "driven", "--episodes", "4", "--learn", folder];
    let (learned, said) = drive(&home, &learn);
    assert!(learned, "{said}");
    let bytes = |run: &str| std::fs::read(PathBuf::from(run).join("minds/seed-0/driving.mind")).unwrap();
    assert_ne!(bytes(&home), bytes(folder), "thirty steps must leave a trace");
    let (drives, said) = drive(folder, &["--policy", "driven"]);
    assert!(drives && said.contains("a look at MN: "), "{said}");
    let (again, said) = drive(&home, &learn);
    assert!(!again && said.contains("exists; replace it with --force"), "{said}");
}

/// Trains the plan of these tests with more arguments, and returns what was said.
fn train(name: &str, more: &[&str]) -> String {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&folder);
    let plan = PathBuf::from(mind()).with_extension("toml");
    let run = ["run", plan.to_str().unwrap(), "--out", folder.to_str().unwrap(), "--seeds", "1"];
    let output = metal(&[&run[..], more].concat()).output().unwrap();
    assert!(output.status.success(), "{}", text(&output));
    text(&output)
}

#[cfg(target_os = "linux")]
#[test]
fn a_serial_robot_shows_for_the_simulation_and_learns_from_it() {
    let server = serve(&["epuck"]);
    let robot = format!("epuck://{}", server.1);
    let drive = ["drive", "--robot", &robot, "--steps", "3", "--force"];
    let show = ["--demonstrate", "--run", mind(), "--policy", "near", "--record", "serial.mcap"];
    let output = metal(&[&drive[..], &show].concat()).output().unwrap();
    assert!(output.status.success(), "{}", text(&output));
    let output = metal(&["replay", "serial.mcap"]).output().unwrap();
    assert!(text(&output).contains("Highway-epuck"), "{}", text(&output));
    // Phase I in simulation, from what the robot showed.
    let said = train("shown-on-a-line", &["--demonstrations", "serial.mcap"]);
    assert!(said.contains("learning from 3 steps that were shown"), "{said}");
    // Phase I from what the simulation showed, in the robot's own world; then that mind drives the robot.
    train("shows-for-a-line", &["--force", "--record", "phase.demonstration=for-a-line.mcap"]);
    let text_of = |body: &str| PLAN.replace("[environment.highway_scripted]\nhorizon = 10", body);
    let plan = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("on-a-line.toml");
    std::fs::write(&plan, text_of("[environment.replay]\nfile = \"serial.mcap\"")).unwrap();
    let run = ["run", plan.to_str().unwrap(), "--out", "on-a-line", "--seeds", "1", "--force"];
    let output = metal(&[&run[..], &["--demonstrations", "for-a-line.mcap"]].concat()).output().unwrap();
    assert!(text(&output).contains("learning from 60 steps that were shown"), "{}", text(&output));
    let back = ["--run", "on-a-line", "--policy", "near", "--record", "back.mcap"];
    let output = metal(&[&drive[..], &back].concat()).output().unwrap();
    assert!(output.status.success() && text(&output).contains("a look at MN: "), "{}", text(&output));
}

#[test]
fn what_robots_showed_teaches_in_simulation_and_the_other_way_round() {
    let webots = serve(&["webots", "--bind", "127.0.0.1:0"]);
    let robot = format!("webots://{}/learner", webots.1);
    let show = ["drive", "--robot", &robot, "--demonstrate", "--road-seed", "1", "--force", "--steps", "8"];
    let output =
        metal(&[&show[..], &["--episodes", "2", "--record", "expert.mcap"]].concat()).output().unwrap();
    assert!(output.status.success() && text(&output).contains("2 episodes shown"), "{}", text(&output));
    let said = train("shown-by-an-expert", &["--demonstrations", "expert.mcap"]);
    assert!(said.contains("learning from 16 steps that were shown"), "{said}");

    let epuck2 = serve(&["epuck2", "--bind", "127.0.0.1:0"]);
    let robot = format!("epuck2://{}", epuck2.1);
    let show = ["drive", "--robot", &robot, "--demonstrate", "--force", "--record", "mind.mcap"];
    let output = metal(&show).output().unwrap();
    assert!(text(&output).contains("--run"), "without a supervisor there is no expert: {}", text(&output));
    let more = ["--run", mind(), "--policy", "near", "--steps", "3"];
    let output = metal(&[&show[..], &more].concat()).output().unwrap();
    assert!(output.status.success(), "{}", text(&output));
    let said = train("shown-by-a-mind", &["--demonstrations", "mind.mcap"]);
    assert!(said.contains("learning from 3 steps that were shown"), "{said}");

    // The simulation shows, and learning on the robot's own recording begins with it.
    train("shows", &["--force", "--record", "phase.demonstration=simulated.mcap", "--record", "all.mcap"]);
    let text_of = |body: &str| PLAN.replace("[environment.highway_scripted]\nhorizon = 10", body);
    let plan = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("on-a-robot.toml");
    std::fs::write(&plan, text_of("[environment.replay]\nfile = \"expert.mcap\"")).unwrap();
    let run = ["run", plan.to_str().unwrap(), "--out", "on-a-robot", "--seeds", "1", "--force"];
    let output = metal(&[&run[..], &["--demonstrations", "simulated.mcap"]].concat()).output().unwrap();
    assert!(output.status.success(), "{}", text(&output));
    assert!(text(&output).contains("learning from 60 steps that were shown"), "{}", text(&output));
    let output = metal(&["replay", "all.mcap"]).output().unwrap();
    assert!(text(&output).contains("Highway-v0") && text(&output).lines().count() == 8, "{}", text(&output));
}

/// An E-puck on a serial line, played in this process so that its wheels can be watched. As BTcom it goes on for ever with
/// the last speed it was told: only a command stops it, and neither a closed line nor a lost program does.
#[cfg(target_os = "linux")]
struct Watched {
    arena: metal_robots::serve::Shared,
    address: String,
    end: metal_robots::Emergency,
    thread: Option<std::thread::JoinHandle<()>>,
}

#[cfg(target_os = "linux")]
impl Watched {
    fn start() -> Self {
        use metal_robots::arena::{Arena, ArenaConfig, Traffic};
        use metal_worlds::highway::{RgbConfig, RoadSet, Scenario};
        let grounds = RoadSet::Seeds(vec![1]).build();
        let (scenario, traffic) = (Scenario::FreeRoad, Traffic::Standing);
        let config = ArenaConfig { grounds, scenario, traffic, rgb: RgbConfig::default(), seed: 1 };
        let arena = std::sync::Arc::new(std::sync::Mutex::new(Arena::new(config)));
        let terminal = metal_robots::serve::epuck1::Terminal::open().unwrap();
        let address = format!("epuck://{}", terminal.path());
        let end = metal_robots::Emergency::default();
        let (world, button) = (arena.clone(), end.clone());
        let thread = std::thread::spawn(move || {
            metal_robots::serve::epuck1::serve(terminal, &world, None, &button).unwrap();
        });
        Self { arena, address, end, thread: Some(thread) }
    }

    fn turns(&self) -> bool {
        metal_robots::serve::look_into(&self.arena).wheels() != metal_robots::Wheels::STILL
    }

    /// Waits until the wheels turn, or stand; how long it took, at most ten seconds.
    fn wait(&self, turning: bool) -> Duration {
        let start = Instant::now();
        while self.turns() != turning && start.elapsed() < Duration::from_secs(10) {
            std::thread::sleep(Duration::from_millis(1));
        }
        start.elapsed()
    }
}

#[cfg(target_os = "linux")]
impl Drop for Watched {
    fn drop(&mut self) {
        self.end.press();
        self.thread.take().unwrap().join().unwrap();
    }
}

/// Sends `signal` to a driving program while the wheels turn: how long they went on turning, and what it said.
#[cfg(target_os = "linux")]
fn ended_by(signal: &str) -> (Duration, String) {
    let robot = Watched::start();
    let drive = ["drive", "--robot", &robot.address, "--run", mind(), "--policy", "near", "--steps", "1000"];
    let mut child = metal(&drive).stderr(Stdio::piped()).stdout(Stdio::null()).spawn().unwrap();
    // The middle of some action that is not the first one.
    for turning in [true, false, true] {
        assert!(robot.wait(turning) < Duration::from_secs(10), "it drives and stands by turns");
    }
    assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
    let took = robot.wait(false);
    let status = child.wait().unwrap();
    let mut said = String::new();
    child.stderr.take().unwrap().read_to_string(&mut said).unwrap();
    assert!(!status.success());
    std::thread::sleep(Duration::from_millis(100));
    assert!(!robot.turns(), "nothing started it again");
    (took, said)
}

#[cfg(target_os = "linux")]
#[test]
fn ctrl_c_and_whatever_else_ends_the_program_stops_the_wheels_at_once() {
    for signal in ["-INT", "-TERM", "-HUP"] {
        let (took, said) = ended_by(signal);
        // Sooner than an action ends by itself (500 ms) and than silence would stop it (500 ms).
        assert!(took < Duration::from_millis(400), "{signal}: {took:?}");
        assert!(said.contains("the emergency stop was pressed"), "{signal}: {said}");
    }
}

/// The other half of the proof: a program that is killed cannot stop anything, and this robot drives on.
#[cfg(target_os = "linux")]
#[test]
fn the_robot_of_these_tests_does_not_stop_by_itself() {
    let robot = Watched::start();
    let drive = ["drive", "--robot", &robot.address, "--run", mind(), "--policy", "near", "--steps", "1000"];
    let mut child = metal(&drive).stderr(Stdio::null()).stdout(Stdio::null()).spawn().unwrap();
    robot.wait(true);
    child.kill().unwrap();
    child.wait().unwrap();
    std::thread::sleep(Duration::from_millis(600));
    assert!(robot.turns());
}

#[test]
fn the_doctor_sees_what_is_wrong_and_calibration_says_what_it_lacks() {
    let server = serve(&["epuck2", "--bind", "127.0.0.1:0", "--scenario", "free_road"]);
    let robot = format!("epuck2://{}", server.1);
    let output = metal(&["doctor", "--robot", &robot]).output().unwrap();
    let said = text(&output);
    assert!(
        output.status.success() && said.contains("52×39 pixels") && said.contains("near: nothing"),
        "{said}"
    );
    let output = metal(&["calibrate", "--robot", &robot, "--frames", "1", "--force"]).output().unwrap();
    assert!(text(&output).contains("too little red was seen"), "{}", text(&output));
    drop(server);
    let output = metal(&["doctor", "--robot", &robot]).output().unwrap();
    assert!(!output.status.success() && text(&output).contains("cannot reach"), "{}", text(&output));
    let output = metal(&["doctor", "--robot", "robot"]).output().unwrap();
    assert!(text(&output).contains("epuck2://HOST"), "{}", text(&output));
}

#[cfg(target_os = "linux")]
#[test]
fn a_serial_robot_at_the_speed_of_its_line_is_slow_where_the_picture_is() {
    let server = serve(&["epuck", "--baud", "115200"]);
    let robot = format!("epuck://{}", server.1);
    let output = metal(&["doctor", "--robot", &robot]).output().unwrap();
    let said = text(&output);
    assert!(output.status.success() && said.contains("METAL (played by a simulator)"), "{said}");
    let ms = |line: &str| -> f64 {
        let line = said.lines().find(|l| l.contains(line)).unwrap();
        line.split(" ms a look").next().unwrap().rsplit(' ').next().unwrap().parse().unwrap()
    };
    // 4061 bytes at 115 200 baud take 352 ms.
    assert!(ms("camera") > 350.0 && ms("infra-red") < 0.3 * ms("camera"), "{said}");
}
