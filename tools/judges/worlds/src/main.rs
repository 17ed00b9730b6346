//! The world and the car that `metal world` writes, in the eyes of the crate `webots-proto` (schema of Webots R2025a).

use metal_rl::random::Streams;
use metal_robots::world::files;
use metal_worlds::highway::{RoadSet, Scenario};
use std::process::ExitCode;
use webots_proto::{Proto, ProtoExt, Severity};

/// The validator's one false error: it takes the brackets of `centerOfMass [ 0 0 0.015 ]` for a list of vectors, but
/// Webots' own PROTOs write it so.
const FALSE_ALARM: [&str; 2] = ["Type mismatch: expected SFVec3f, found Array", "Float(0.015"];

fn main() -> ExitCode {
    let grounds = RoadSet::Seeds(vec![1]).build();
    let start = Scenario::Mix.start(grounds[0].road(), &Streams::new(1));
    let mut complaints = 0;
    for file in files(&grounds[0], &start) {
        let Ok(text) = String::from_utf8(file.bytes) else { continue };
        let proto: Proto = match text.parse() {
            Ok(proto) => proto,
            Err(error) => {
                println!("  {}: {error}", file.path);
                complaints += 1;
                continue;
            }
        };
        let found = match proto.validate() {
            Ok(found) => found,
            Err(error) => {
                println!("  {}: {error}", file.path);
                complaints += 1;
                continue;
            }
        };
        let (mut errors, mut excused) = (0, 0);
        for diagnostic in found.iter() {
            let known = FALSE_ALARM.iter().all(|part| diagnostic.message.contains(part));
            if known || diagnostic.severity != Severity::Error {
                excused += 1;
            } else {
                errors += 1;
                println!("  {}: {}", file.path, diagnostic.message);
            }
        }
        println!("  {}: {errors} errors, {excused} warnings or known false alarms", file.path);
        complaints += errors;
    }
    if complaints == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
