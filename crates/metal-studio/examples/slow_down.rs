//! How much a page slows a training run down: the same run alone, in the studio without a page, and with a page at
//! thirty frames a second, side by side. Also counts frames and bytes that reach the page.
//!
//! `cargo run --release -p metal-studio --example slow_down [ROUNDS]` (some two minutes; needs Linux, for the time that
//! the training thread was on a processor). The three arms take turns and do the same work to the bit; what counts is
//! each one's time against the run alone of the same round, so that whatever else the machine does cancels out.
#![allow(clippy::print_stdout, clippy::unwrap_used)]

use metal_lab::evaluate::{Course, best_blind_action};
use metal_lab::mind::Mind;
use metal_lab::plan::Plan;
use metal_lab::progress::Silent;
use metal_lab::registry::Roads;
use metal_lab::train::train_phase;
use metal_rl::random::Streams;
use metal_studio::server::{Options, Studio};
use metal_studio::subject::{Subject, paper};
use std::io::{Read, Write};
use std::net::{Ipv4Addr, TcpStream};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Rounds if no number is given on the command line.
const ROUNDS: usize = 40;
/// Episodes of each phase: some two seconds a run, so that beginning and end do not count.
const EPISODES: usize = 70;
const ARMS: [&str; 3] = ["alone", "studio, no page", "studio, page at 30 Hz"];

/// One run: seconds of the training thread on a processor, seconds by the clock, frames and bytes at the page.
#[derive(Clone, Copy, Debug, Default)]
struct Run {
    busy: f64,
    clock: f64,
    frames: f64,
    bytes: f64,
}

fn main() {
    let rounds = std::env::args().nth(1).map_or(ROUNDS, |n| n.parse().unwrap());
    let mut runs: [Vec<Run>; 3] = Default::default();
    for round in 0..=rounds {
        // Whoever comes first in a round is another one each time.
        let mut now = [Run::default(); 3];
        for arm in (0..3).map(|i| (i + round) % 3) {
            now[arm] = if arm == 0 { alone() } else { in_studio(round, arm == 2) };
        }
        let seconds = now.map(|run| run.busy);
        println!(
            "round {round}: {seconds:.3?} s on the processor{}",
            if round == 0 { " (not counted)" } else { "" }
        );
        if round > 0 {
            runs.iter_mut().zip(now).for_each(|(arm, run)| arm.push(run));
        }
    }
    report(&runs);
}

fn report(runs: &[Vec<Run>; 3]) {
    println!(
        "\nagainst the run alone of the same round: median of {} rounds and its 95 % interval",
        runs[0].len()
    );
    println!("{:24} {:>9} {:>28} {:>9} {:>28}", "", "s on cpu", "slower", "s by clock", "slower");
    for (name, arm) in ARMS.iter().zip(runs) {
        let column = |of: fn(&Run) -> f64| {
            let ratios = arm.iter().zip(&runs[0]).map(|(run, alone)| 100.0 * (of(run) / of(alone) - 1.0));
            let [low, middle, high] = interval(ratios.collect());
            let seconds = interval(arm.iter().map(of).collect())[1];
            format!("{seconds:9.3} {middle:9.2} % [{low:6.2}, {high:6.2}]")
        };
        println!("{name:24} {} {}", column(|run| run.busy), column(|run| run.clock));
    }
    let clock: f64 = runs[2].iter().map(|run| run.clock).sum();
    let per_sec = |of: fn(&Run) -> f64| runs[2].iter().map(of).sum::<f64>() / clock;
    let (frames, bytes) = (per_sec(|run| run.frames), per_sec(|run| run.bytes));
    println!(
        "to the page: {frames:.1} frames/s, {:.0} kB/s, {:.1} kB a frame",
        bytes / 1e3,
        bytes / frames / 1e3
    );
}

/// The median between the order statistics that enclose it with 95 % certainty, whatever the distribution.
fn interval(mut values: Vec<f64>) -> [f64; 3] {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    let away = (0.98 * (n as f64).sqrt()).ceil() as usize;
    let (low, high) = ((n / 2).saturating_sub(away), (n / 2 + away).min(n - 1));
    [values[low], 0.5 * (values[(n - 1) / 2] + values[n / 2]), values[high]]
}

fn plan() -> Plan {
    let mut file = paper().unwrap().file;
    metal_lab::reproduce::quick::cut(&mut file, EPISODES, 200);
    let kept = ["demonstration", "fusion", "attention"];
    file.phase.retain(|name, _| kept.contains(&name.as_str()));
    file.policy.retain(|name, _| name == "acl" || name == "oracle");
    file.subsets = None;
    Plan::check(file).unwrap()
}

/// What the lab does without a studio, in a thread of its own.
fn alone() -> Run {
    let plan = plan();
    let work = move || {
        let streams = Streams::new(1).child("report").nth(0);
        let newborn = Mind::newborn(&plan, &streams).unwrap();
        let mut mind = newborn.clone();
        for name in ["demonstration", "fusion", "attention"] {
            mind = train_phase(&plan, name, mind, &streams, &Silent).unwrap().mind;
        }
        let course = Course { scenario: "mix".to_owned(), roads: Roads::Validation, runs: 40 };
        best_blind_action(&plan, &newborn, &course, &Streams::new(1).child("blind"), &Silent).unwrap();
    };
    let thread = std::thread::Builder::new().name("training".to_owned()).spawn(work).unwrap();
    // A thread has its name only once it runs.
    while training_thread().is_none() {
        std::thread::yield_now();
    }
    let run = clocked();
    thread.join().unwrap();
    run
}

/// The same through the studio.
fn in_studio(round: usize, stays: bool) -> Run {
    let out = std::env::temp_dir().join(format!("metal-slow-down-{}-{round}-{stays}", std::process::id()));
    let subject = Subject::experiment(plan(), &out).unwrap();
    let options = Options { address: Ipv4Addr::LOCALHOST.into(), port: 0, seed: 1, keep_token: false };
    let studio = Studio::open(subject, options).unwrap();
    let (url, quit) = (studio.url(), studio.quitter());
    let server = std::thread::spawn(move || studio.serve());
    let mut page = connect(&url);
    send(&mut page, r#"{"do":"train","demonstrations":false}"#);
    // A page that goes before it was heard takes its request with it.
    while training_thread().is_none() {
        std::thread::sleep(Duration::from_millis(1));
    }
    let reader = stays.then(|| std::thread::spawn(move || listen(page)));
    let run = clocked();
    while !out.join("run.json").exists() {
        std::thread::sleep(Duration::from_millis(5));
    }
    quit();
    server.join().unwrap().unwrap();
    let (frames, bytes) = reader.map_or((0, 0), |reader| reader.join().unwrap());
    std::fs::remove_dir_all(&out).unwrap();
    Run { frames: frames as f64, bytes: bytes as f64, ..run }
}

/// How long the thread called `training` is there, and how much of that on a processor.
fn clocked() -> Run {
    let mut run = Run::default();
    let start = Instant::now();
    while let Some(task) = training_thread() {
        run.busy = nanos(&task).map_or(run.busy, |n| n / 1e9);
        run.clock = start.elapsed().as_secs_f64();
        std::thread::sleep(Duration::from_millis(2));
    }
    run
}

fn training_thread() -> Option<PathBuf> {
    let tasks = std::fs::read_dir("/proc/self/task").ok()?;
    let named = |task: &Path| std::fs::read_to_string(task.join("comm")).is_ok_and(|n| n == "training\n");
    tasks.flatten().map(|task| task.path()).find(|task| named(task))
}

fn nanos(task: &Path) -> Option<f64> {
    std::fs::read_to_string(task.join("schedstat")).ok()?.split_whitespace().next()?.parse().ok()
}

/// A page: a WebSocket by hand.
fn connect(url: &str) -> TcpStream {
    let rest = url.strip_prefix("http://").unwrap();
    let (host, path) = rest.split_once('/').unwrap();
    let mut page = TcpStream::connect(host).unwrap();
    let request = format!(
        "GET /{path}live HTTP/1.1\r\nHost: {host}\r\nOrigin: http://{host}\r\nConnection: Upgrade\r\n\
         Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
    );
    page.write_all(request.as_bytes()).unwrap();
    let mut answer = Vec::new();
    while !answer.ends_with(b"\r\n\r\n") {
        let mut byte = [0];
        page.read_exact(&mut byte).unwrap();
        answer.push(byte[0]);
    }
    assert!(answer.starts_with(b"HTTP/1.1 101"), "{}", String::from_utf8_lossy(&answer));
    page
}

/// One short text message, masked with zeros.
fn send(page: &mut TcpStream, text: &str) {
    let mut frame = vec![0x81, 0x80 | u8::try_from(text.len()).unwrap(), 0, 0, 0, 0];
    frame.extend_from_slice(text.as_bytes());
    page.write_all(&frame).unwrap();
}

/// Reads messages until the studio closes: how many were frames, and how many bytes all had.
fn listen(mut page: TcpStream) -> (usize, usize) {
    let (mut frames, mut bytes) = (0, 0);
    let mut head = [0; 2];
    while page.read_exact(&mut head).is_ok() {
        let length = match head[1] & 0x7f {
            126 => number(&mut page, 2),
            127 => number(&mut page, 8),
            short => usize::from(short),
        };
        let mut body = vec![0; length];
        if page.read_exact(&mut body).is_err() {
            break;
        }
        frames += usize::from(body.starts_with(b"{\"frame\""));
        bytes += length;
    }
    (frames, bytes)
}

fn number(page: &mut TcpStream, width: usize) -> usize {
    let mut digits = [0; 8];
    page.read_exact(&mut digits[8 - width..]).unwrap();
    usize::try_from(u64::from_be_bytes(digits)).unwrap()
}
