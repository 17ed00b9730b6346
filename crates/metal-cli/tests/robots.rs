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
    FOLDER.get_or_init(|| {
        let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("driver");
        let plan = folder.with_extension("toml");
        std::fs::write(&plan, PLAN).unwrap();
        let _ = std::fs::remove_dir_all(&folder);
        let folder = folder.to_str().unwrap().to_owned();
        let run = ["run", plan.to_str().unwrap(), "--out", &folder, "--seeds", "1", "--threads", "1"];
        let output = metal(&run).output().unwrap();
        assert!(output.status.success(), "{}", text(&output));
        folder
    })
}

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

#[test]
fn ctrl_c_stops_the_wheels() {
    let server = serve(&["epuck2", "--bind", "127.0.0.1:0"]);
    let robot = format!("epuck2://{}", server.1);
    let mut child =
        metal(&["drive", "--robot", &robot, "--run", mind(), "--policy", "near", "--steps", "1000"])
            .stderr(Stdio::piped())
            .stdout(Stdio::null())
            .spawn()
            .unwrap();
    std::thread::sleep(Duration::from_millis(1500));
    assert!(child.try_wait().unwrap().is_none(), "it drives");
    let asked = Instant::now();
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let status = child.wait().unwrap();
    assert!(asked.elapsed() < Duration::from_secs(3));
    let mut said = String::new();
    child.stderr.take().unwrap().read_to_string(&mut said).unwrap();
    assert!(!status.success() && said.contains("the emergency stop was pressed"), "{said}");
    // The robot was told to stop before the line closed; whoever comes next finds it standing.
    assert_eq!(steps(&server), steps(&server));
}

/// Step counters of the robot, over its own language.
fn steps(server: &Server) -> [u8; 4] {
    use std::io::Write;
    let mut stream = std::net::TcpStream::connect(&server.1).unwrap();
    let mut command = [0; 21];
    command[..2].copy_from_slice(&[0x80, 2]);
    stream.write_all(&command).unwrap();
    let mut answer = [0; 105];
    stream.read_exact(&mut answer).unwrap();
    std::thread::sleep(Duration::from_millis(200));
    answer[80..84].try_into().unwrap()
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
