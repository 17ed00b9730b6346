//! `metal serve`, `metal doctor`, `metal calibrate` and `metal drive`: bodies other than the simulated ones.

use crate::args::Studio;
use crate::commands::{keep_clear, say};
use crate::learn_on::Pupil;
use anyhow::{Context, bail, ensure};
use clap::{Args, Subcommand, ValueEnum};
use metal_lab::evaluate::{Candidate, drive};
use metal_lab::store::Store;
use metal_lab::trace::{Trace, Watcher};
use metal_recording::{Beliefs, Recorder, Replay, Tape};
use metal_rl::environment::Environment;
use metal_rl::observe::{Observer, Step};
use metal_rl::random::Streams;
use metal_robots::arena::{Arena, ArenaConfig, Traffic};
use metal_robots::body::INFRARED;
use metal_robots::environment::LINK_MEASURES;
use metal_robots::link::Patience;
use metal_robots::webots::Release;
use metal_robots::{
    Address, Body, Calibration, Emergency, Guard, Limits, Picture, RobotConfig, RobotEnvironment, doctor,
    serve,
};
use metal_studio::robot::Robot;
use metal_worlds::highway::camera::Window;
use metal_worlds::highway::{Ground, HighwayConfig, RgbConfig, RoadSet, Scenario};
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

pub const SERVE: &str = "\
Examples:
  metal serve epuck2                      then, elsewhere: metal doctor --robot epuck2://127.0.0.1:11000
  metal serve epuck --baud 115200         prints the path of its serial line
  metal serve webots                      then: WEBOTS_CONTROLLER_URL=tcp://127.0.0.1:1234/learner ./controller

Servers listen on this computer only, unless --bind says otherwise. Ctrl-C ends them.";

pub const DRIVE: &str = "\
Examples:
  metal drive --robot epuck2://192.168.1.10 --run runs/reproduce
  metal drive --robot epuck:///dev/rfcomm0?crop --run runs/reproduce --calibration room.toml
  metal drive --robot webots://localhost:1234/learner --run runs/reproduce --road-seed 1 --episodes 5
  metal drive --robot webots://localhost --run runs/reproduce --policy acl_phase3 --road-seed 1 --episodes 50 --learn runs/webots
  metal drive --robot webots://localhost --road-seed 1 --demonstrate --episodes 20 --record shown.mcap

Ctrl-C stops the wheels at once. Keep the robot within reach.";

/// `metal serve`
#[derive(Debug, Args)]
pub struct Serve {
    /// Which body to play
    #[command(subcommand)]
    what: Play,
}

#[derive(Debug, Subcommand)]
enum Play {
    /// An e-puck2 on the network (TCP)
    Epuck2 {
        /// Address and port to listen at
        #[arg(long, default_value = "127.0.0.1:11000")]
        bind: String,
        #[command(flatten)]
        world: World,
    },
    /// Webots, for external controllers of an E-puck (TCP)
    Webots {
        /// Whose language: that of the release of the controller's library
        #[arg(long, default_value = "R2023b", value_parser = ["R2023b", "R2025a"])]
        release: String,
        /// Address and port to listen at
        #[arg(long, default_value = "127.0.0.1:1234")]
        bind: String,
        #[command(flatten)]
        world: World,
    },
    /// An E-puck on a serial line (a pseudo-terminal)
    Epuck {
        /// Imitate the speed of a line, in bits per second (0: as fast as possible)
        #[arg(long, default_value_t = 0, value_name = "BAUD")]
        baud: u32,
        #[command(flatten)]
        world: World,
    },
}

#[derive(Debug, Args)]
struct World {
    /// What the episode is about
    #[arg(long, default_value = "mix", value_parser = ["mix", "free_road", "approaching", "from_behind"])]
    scenario: String,
    /// The road is grown from this seed
    #[arg(long, default_value_t = 1, value_name = "N")]
    road_seed: u64,
    /// Seed of starts and noise
    #[arg(long, default_value_t = 1, value_name = "N")]
    seed: u64,
    /// What the red cars do
    #[arg(long, value_enum, default_value_t = Cars::Standing)]
    traffic: Cars,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Cars {
    Standing,
    Scripted,
}

/// A body and its calibration.
#[derive(Debug, Args)]
pub struct Found {
    /// epuck:///dev/rfcomm0, epuck2://HOST:PORT or webots://HOST:PORT/NAME (port and name may be left out)
    #[arg(long, value_name = "ADDRESS")]
    robot: Address,
    /// A file that `metal calibrate` wrote
    #[arg(long, value_name = "FILE")]
    calibration: Option<PathBuf>,
}

/// `metal calibrate`
#[derive(Debug, Args)]
pub struct Calibrate {
    /// epuck:///dev/rfcomm0, epuck2://HOST:PORT or webots://HOST:PORT/NAME (port and name may be left out)
    #[arg(long, value_name = "ADDRESS")]
    robot: Address,
    /// File to write (TOML)
    #[arg(long, default_value = "calibration.toml")]
    out: PathBuf,
    /// Replace what is there
    #[arg(long)]
    force: bool,
    /// Frames to take: move the robot between them, so that road, line, red and grass are all seen
    #[arg(long, default_value_t = 8, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    frames: u32,
    /// Pause between two frames
    #[arg(long, default_value_t = 1.0, value_name = "SECONDS")]
    pause: f64,
}

/// `metal drive`
#[derive(Debug, Args)]
pub struct Drive {
    #[command(flatten)]
    robot: Found,
    /// A folder that `metal reproduce` or `metal run` wrote
    #[arg(long, required_unless_present = "demonstrate")]
    run: Option<PathBuf>,
    /// Show how it is done: every sensor is read before every step, so that others can learn from the recording. The
    /// expert drives, or the mind of --run
    #[arg(long, requires = "record")]
    demonstrate: bool,
    /// Who drives, as the run's plan names it
    #[arg(long, default_value = "acl")]
    policy: String,
    /// Which training's mind
    #[arg(long, default_value_t = 0, value_name = "N")]
    mind: usize,
    /// Episodes
    #[arg(long, default_value_t = 1, value_name = "N")]
    episodes: usize,
    /// Motor steps of an episode
    #[arg(long, default_value_t = 50, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    steps: u32,
    /// Learn on while driving, as the policy's phase ended, and write the run with the new mind to this folder
    #[arg(long, value_name = "FOLDER", conflicts_with = "demonstrate")]
    learn: Option<PathBuf>,
    /// Write what is seen, attended to, believed, done and paid to this file (MCAP, for Foxglove and ROS 2 tools)
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// Replace a recording, or a run of --learn, that is there
    #[arg(long)]
    force: bool,
    /// The body is on the road grown from this seed, and a supervisor may place and judge it
    #[arg(long, value_name = "N")]
    road_seed: Option<u64>,
}

/// `metal world`
#[derive(Debug, Args)]
pub struct Write {
    /// Folder of the Webots project to write
    #[arg(long, default_value = "webots")]
    out: PathBuf,
    /// Replace what is there
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    world: World,
}

pub fn write_world(request: &Write) -> anyhow::Result<()> {
    let arena = world(&request.world);
    let arena = serve::look_into(&arena);
    let files = metal_robots::world::files(arena.ground(), &arena.start());
    files.iter().try_for_each(|file| keep_clear(&request.out.join(file.path), request.force))?;
    for file in files {
        let path = request.out.join(file.path);
        let folder = path.parent().unwrap_or(&request.out);
        std::fs::create_dir_all(folder).with_context(|| format!("cannot create {}", folder.display()))?;
        std::fs::write(&path, file.bytes).with_context(|| format!("cannot write {}", path.display()))?;
        say(&format!("{}\n", path.display()))?;
    }
    Ok(())
}

/// Ctrl-C presses the emergency stop; a second one ends the program. So does whoever ends the program otherwise.
fn emergency() -> anyhow::Result<Emergency> {
    let (emergency, button) = (Emergency::default(), Emergency::default());
    let pressed = emergency.clone();
    ctrlc::set_handler(move || {
        if button.pressed() {
            std::process::exit(130);
        }
        button.press();
        pressed.press();
    })
    .context("cannot listen to Ctrl-C")?;
    let pressed = emergency.clone();
    on_termination(move || pressed.press())?;
    Ok(emergency)
}

/// Lets `act` happen when the system ends the program (SIGTERM), or its terminal is closed (SIGHUP): without it the program
/// would be gone at once, and wheels on a serial line would turn on.
#[cfg(unix)]
pub fn on_termination(act: impl Fn() + Send + 'static) -> anyhow::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGTERM};
    let mut signals =
        signal_hook::iterator::Signals::new([SIGTERM, SIGHUP]).context("cannot listen to signals")?;
    std::thread::spawn(move || signals.forever().for_each(|_| act()));
    Ok(())
}

/// Only Unix has such signals.
#[cfg(not(unix))]
pub fn on_termination(_: impl Fn() + Send + 'static) -> anyhow::Result<()> {
    Ok(())
}

fn world(options: &World) -> serve::Shared {
    let scenario = Scenario::ALL.into_iter().find(|s| s.name() == options.scenario).unwrap_or_default();
    let traffic = match options.traffic {
        Cars::Standing => Traffic::Standing,
        Cars::Scripted => Traffic::Scripted,
    };
    let (grounds, rgb) = (ground(options.road_seed), RgbConfig::default());
    let config = ArenaConfig { grounds, scenario, traffic, rgb, seed: options.seed };
    Arc::new(Mutex::new(Arena::new(config)))
}

fn ground(road_seed: u64) -> Arc<[Ground]> {
    RoadSet::Seeds(vec![road_seed]).build()
}

fn listen(bind: &str) -> anyhow::Result<TcpListener> {
    let listener = TcpListener::bind(bind).with_context(|| format!("cannot listen at {bind}"))?;
    say(&format!("listening at {}\n", listener.local_addr()?))?;
    Ok(listener)
}

pub fn serve(request: &Serve) -> anyhow::Result<()> {
    let end = emergency()?;
    match &request.what {
        Play::Epuck2 { bind, world: w } => Ok(serve::epuck2::serve(&listen(bind)?, &world(w), &end)?),
        Play::Webots { release, bind, world: w } => {
            Ok(serve::webots::serve_as(Release::of(release)?, &listen(bind)?, &world(w), &end)?)
        }
        Play::Epuck { baud, world: w } => serve_line(*baud, w, &end),
    }
}

#[cfg(target_os = "linux")]
fn serve_line(baud: u32, options: &World, end: &Emergency) -> anyhow::Result<()> {
    let terminal = serve::epuck1::Terminal::open().context("cannot open a pseudo-terminal")?;
    say(&format!("listening at {}\n", terminal.path()))?;
    Ok(serve::epuck1::serve(terminal, &world(options), (baud > 0).then_some(baud), end)?)
}

#[cfg(not(target_os = "linux"))]
fn serve_line(_: u32, _: &World, _: &Emergency) -> anyhow::Result<()> {
    bail!("`metal serve epuck` needs Linux")
}

fn calibration(file: Option<&Path>, body: &dyn Body) -> anyhow::Result<Calibration> {
    let Some(file) = file else { return Ok(Calibration::of(body.infrared_scale())) };
    let text = std::fs::read_to_string(file).with_context(|| format!("cannot read {}", file.display()))?;
    Calibration::from_toml(&text).with_context(|| file.display().to_string())
}

pub fn examine(request: &Found) -> anyhow::Result<()> {
    let mut body = request.robot.connect(Patience::default())?;
    let calibration = calibration(request.calibration.as_deref(), body.as_ref())?;
    let checks = doctor::examine(body.as_mut(), &calibration);
    say(&doctor::text(&checks))?;
    ensure!(checks.iter().all(|c| c.verdict != doctor::Verdict::Bad), "something is wrong, see above");
    Ok(())
}

pub fn calibrate(request: &Calibrate) -> anyhow::Result<()> {
    ensure!((0.0..=3600.0).contains(&request.pause), "--pause {}: 0 to 3600 seconds", request.pause);
    keep_clear(&request.out, request.force)?;
    let mut body = request.robot.connect(Patience::default())?;
    let (mut frames, mut free): (Vec<Picture>, Vec<[f64; INFRARED]>) = (Vec::new(), Vec::new());
    for frame in 0..request.frames {
        frames.push(body.picture(Window::WHOLE)?);
        free.push(body.proximity()?);
        if frame + 1 < request.frames {
            std::thread::sleep(std::time::Duration::from_secs_f64(request.pause));
        }
    }
    let text = Calibration::learn(&frames, &free)?.to_toml()?;
    std::fs::write(&request.out, &text).with_context(|| format!("cannot write {}", request.out.display()))?;
    say(&format!("{text}\nwritten to {}\n", request.out.display()))
}

/// The trace, and what the link has cost.
struct Log<'a> {
    watcher: Watcher<'a>,
    first: usize,
    sums: [f64; 4],
    steps: usize,
    beliefs: Option<Beliefs>,
}

impl Observer for Log<'_> {
    fn on_step(&mut self, step: &Step<'_>) {
        self.watcher.on_step(step);
        self.steps += 1;
        if let Some(beliefs) = &mut self.beliefs {
            beliefs.on_step(step);
        }
        for (sum, value) in self.sums.iter_mut().zip(&step.measures[self.first..]) {
            *sum += value;
        }
    }

    fn on_episode(&mut self, episode: usize, progress: f64) {
        self.watcher.on_episode(episode, progress);
    }
}

pub fn go(request: &Drive) -> anyhow::Result<()> {
    request.record.iter().chain(&request.learn).try_for_each(|path| keep_clear(path, request.force))?;
    match &request.run {
        Some(folder) => go_with(folder, request),
        None => demonstrate(request),
    }
}

fn go_with(folder: &Path, request: &Drive) -> anyhow::Result<()> {
    let store = Store::open(folder)?;
    let (plan, card) = store.read_run()?;
    let Some(row) = plan.file.policy.get(&request.policy) else {
        let names: Vec<&str> = plan.file.policy.keys().map(String::as_str).collect();
        bail!("--policy {}: one of {}", request.policy, names.join(", "));
    };
    let Some(phase) = &row.after else { bail!("--policy {}: it learned in no phase", request.policy) };
    ensure!(request.mind < card.seeds, "--mind {}: below {}", request.mind, card.seeds);
    let pupil = Pupil { store: &store, plan: &plan, card: &card, seed: request.mind, phase };
    if request.learn.is_some() {
        pupil.check()?;
    }
    let mind = store.read_mind(&plan, request.mind, phase)?;
    let environment = body(request)?;
    let spec = environment.spec().clone();
    ensure!(
        plan.spec.sensors == spec.sensors,
        "the mind of {} has other sensors than a body",
        folder.display()
    );
    let candidate = Candidate {
        plan: &plan,
        mind: &mind,
        acting: &row.acting,
        roster: plan.roster(&row.roster),
        blind: card.blind,
    };
    let first = spec.measures.len() - LINK_MEASURES.len();
    let watcher = Watcher { trace: Trace::new(&spec), progress: &metal_lab::progress::Silent };
    let mut log = Log { watcher, first, sums: [0.0; 4], steps: 0, beliefs: None };
    let rest = (request.episodes, &Streams::new(card.seed).child("drive"));
    let environment = recorded(request, environment, |world, tape| {
        log.beliefs = tape.map(Beliefs);
        let Some(out) = &request.learn else { return Ok(drive(&candidate, world, rest, &mut log)?) };
        pupil.learn_on((&mind, world), rest, &mut log, out)
    })?;
    say(&summary(&log, &environment))
}

/// The expert shows how it is done.
fn demonstrate(request: &Drive) -> anyhow::Result<()> {
    let streams = Streams::new(0).child("demonstrate");
    let rest = (request.episodes, &streams);
    recorded(request, body(request)?, |world, _| Ok(metal_lab::recorded::show(world, rest)?))?;
    say(&format!("{} episodes shown\n", request.episodes))
}

/// Lets `act` happen in the environment, recorded if that is wanted; the environment again, if all went well.
fn recorded(
    request: &Drive,
    mut environment: RobotEnvironment,
    act: impl FnOnce(&mut dyn Environment, Option<Tape>) -> anyhow::Result<()>,
) -> anyhow::Result<RobotEnvironment> {
    let Some(path) = &request.record else {
        act(&mut environment, None)?;
        return Ok(environment);
    };
    let tape = Tape::create(path, environment.spec())?;
    let start = if request.demonstrate { Recorder::thorough } else { Recorder::new };
    let mut recorder = start(environment, tape.clone());
    let outcome = act(&mut recorder, Some(tape.clone()));
    let environment = recorder.into_inner();
    // What was recorded until something failed is worth keeping.
    tape.finish()?;
    outcome.map(|()| environment)
}

/// `metal replay`
#[derive(Debug, Args)]
pub struct Replayed {
    /// A recording that `metal drive --record` or `metal run --record` wrote
    file: PathBuf,
}

/// What is on a recording, episode by episode.
pub fn replay(request: &Replayed) -> anyhow::Result<()> {
    let replay = Replay::open(&request.file).with_context(|| request.file.display().to_string())?;
    let mut text = format!("{}\nepisode  steps  motor reward  looks a step\n", replay.spec().id);
    for (i, steps) in replay.episodes().iter().enumerate() {
        let made = steps.iter().filter_map(|s| s.moved);
        let (count, reward) = (made.clone().count(), made.map(|(_, o)| o.motor_reward).sum::<f64>());
        let looks = steps.iter().map(|s| s.attended.len()).sum::<usize>() as f64 / count.max(1) as f64;
        text += &format!("{i:>7}  {count:>5}  {reward:>12.1}  {looks:>12.2}\n");
    }
    say(&text)
}

fn body(request: &Drive) -> anyhow::Result<RobotEnvironment> {
    let body = Wanted {
        robot: &request.robot.robot,
        calibration: request.robot.calibration.as_deref(),
        road_seed: request.road_seed,
        steps: request.steps,
    };
    guarded(&body, emergency()?)
}

/// Motor steps of an episode that the studio watches, as in `metal drive`.
const STUDIO_STEPS: u32 = 50;

/// The body that `metal studio` watches, if it was asked to. The emergency stop is the page's and that of Ctrl-C.
pub fn watched(request: &Studio) -> anyhow::Result<Option<Robot>> {
    let Some(robot) = &request.robot else { return Ok(None) };
    let calibration = request.calibration.as_deref();
    let body = Wanted { robot, calibration, road_seed: request.road_seed, steps: STUDIO_STEPS };
    let emergency = Emergency::default();
    Ok(Some(Robot { environment: guarded(&body, emergency.clone())?, emergency }))
}

/// A body and how it is used.
struct Wanted<'a> {
    robot: &'a Address,
    calibration: Option<&'a Path>,
    road_seed: Option<u64>,
    steps: u32,
}

fn guarded(wanted: &Wanted<'_>, emergency: Emergency) -> anyhow::Result<RobotEnvironment> {
    let body = wanted.robot.connect(Patience::default())?;
    let calibration = calibration(wanted.calibration, body.as_ref())?;
    let guard = Guard::new(body, Limits::default(), emergency)?;
    let grounds = wanted.road_seed.map(ground);
    let roads = RoadSet::Seeds(vec![wanted.road_seed.unwrap_or(1)]);
    let highway =
        HighwayConfig { horizon: wanted.steps as usize, ..HighwayConfig::new(roads, Scenario::Mix) };
    Ok(RobotEnvironment::new(guard, RobotConfig { highway, calibration, grounds })?)
}

fn summary(log: &Log<'_>, environment: &RobotEnvironment) -> String {
    let mut text = String::from("episode  motor reward  price of looks  looks a step\n");
    for (i, episode) in log.watcher.trace.episodes.iter().enumerate() {
        let steps = episode.steps().max(1) as f64;
        let looks = episode.look_count() as f64 / steps;
        text += &format!("{i:>7}  {:>12.1}  {:>14.1}  {looks:>12.2}\n", episode.motor, -episode.perceptual);
    }
    let [bytes, ms, saved_bytes, saved_ms] = log.sums.map(|s| s / log.steps.max(1) as f64);
    text += &format!("\na decision: {bytes:.0} bytes and {ms:.2} ms on the link, ");
    text += &format!("{saved_bytes:.0} bytes and {saved_ms:.2} ms less than looking at everything\n");
    for (sensor, bytes, ms) in environment.look_costs() {
        text += &format!("a look at {sensor}: {bytes:.0} bytes, {ms:.2} ms\n");
    }
    text
}
