//! How much a page slows a training run down: the same run alone, in the studio without a page, and with a page at
//! thirty frames a second, side by side. Also counts frames and bytes that reach the page.
//!
//! `cargo run --release -p metal-studio --example slow_down` (some two minutes; needs Linux, for the time that the
//! training thread was on a processor, which other work on the machine does not disturb).
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

const ROUNDS: usize = 8;

fn main() {
    let mut best = [[f64::INFINITY; 2]; 3];
    let mut seen = (0.0, 0.0);
    for round in 0..ROUNDS {
        let runs = [alone(), in_studio(round, false).0, {
            let (times, news) = in_studio(round, true);
            seen = news;
            times
        }];
        for (best, run) in best.iter_mut().zip(runs) {
            *best = [best[0].min(run[0]), best[1].min(run[1])];
        }
        println!("round {}: {runs:.3?} s on the processor and by the clock", round + 1);
    }
    println!("\n{:28} {:>12} {:>10} {:>10}", "best of all rounds", "processor, s", "slower", "clock, s");
    for (name, run) in ["alone", "studio, no page", "studio, page at 30 Hz"].iter().zip(&best) {
        let slower = 100.0 * (run[0] / best[0][0] - 1.0);
        println!("{name:28} {:12.3} {slower:9.2}% {:10.3}", run[0], run[1]);
    }
    println!("to the page: {:.1} frames/s, {:.0} kB/s", seen.0, seen.1 / 1e3);
}

fn plan() -> Plan {
    let mut file = paper().unwrap().file;
    metal_lab::reproduce::quick::cut(&mut file, 40, 100);
    let kept = ["demonstration", "fusion", "attention"];
    file.phase.retain(|name, _| kept.contains(&name.as_str()));
    file.policy.retain(|name, _| name == "acl" || name == "oracle");
    file.subsets = None;
    Plan::check(file).unwrap()
}

/// What the lab does without a studio, in a thread of its own.
fn alone() -> [f64; 2] {
    let work = || {
        let (plan, streams) = (plan(), Streams::new(1).child("report").nth(0));
        let newborn = Mind::newborn(&plan, &streams).unwrap();
        let mut mind = newborn.clone();
        for name in ["demonstration", "fusion", "attention"] {
            mind = train_phase(&plan, name, mind, &streams, &Silent).unwrap().mind;
        }
        let course = Course { scenario: "mix".to_owned(), roads: Roads::Validation, runs: 40 };
        best_blind_action(&plan, &newborn, &course, &Streams::new(1).child("blind"), &Silent).unwrap();
    };
    let start = Instant::now();
    let thread = std::thread::Builder::new().name("training".to_owned()).spawn(work).unwrap();
    let busy = on_processor(|| thread.is_finished());
    [busy, start.elapsed().as_secs_f64()]
}

/// The same through the studio: its times, then frames and bytes per second at the page.
fn in_studio(round: usize, stays: bool) -> ([f64; 2], (f64, f64)) {
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
    let start = Instant::now();
    let reader = stays.then(|| std::thread::spawn(move || listen(page)));
    let busy = on_processor(|| out.join("run.json").exists());
    let clock = start.elapsed().as_secs_f64();
    quit();
    server.join().unwrap().unwrap();
    let (frames, bytes) = reader.map_or((0, 0), |reader| reader.join().unwrap());
    std::fs::remove_dir_all(&out).unwrap();
    ([busy, clock], (frames as f64 / clock, bytes as f64 / clock))
}

/// Seconds the thread called `training` was on a processor until `done`.
fn on_processor(done: impl Fn() -> bool) -> f64 {
    let mut busy = 0.0;
    while !done() {
        busy = training_thread().and_then(|task| nanos(&task)).map_or(busy, |n| n / 1e9);
        std::thread::sleep(Duration::from_millis(2));
    }
    busy
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
