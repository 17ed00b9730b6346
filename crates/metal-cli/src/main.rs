//! The command `metal`: parses, calls the lab, prints. No logic lives here.
#![forbid(unsafe_code)]
#![allow(clippy::print_stderr, clippy::exit)]

mod args;
mod bar;
mod ceiling;
mod check;
mod commands;
mod faults;
mod learn_on;
mod measuring;
mod partition;
mod prices;
mod robots;
mod table;
mod transfer;

use clap::Parser;

fn main() {
    let arguments = args::Arguments::parse();
    if let Err(error) = commands::run(arguments) {
        eprintln!("metal: {}", told(&error));
        std::process::exit(1);
    }
}

/// The error and its causes on one line, each said once: some errors tell their cause themselves.
fn told(error: &anyhow::Error) -> String {
    let causes = error.chain().map(ToString::to_string);
    let join = |text: String, cause: String| {
        if text.ends_with(&cause) { text } else { format!("{text}: {cause}") }
    };
    causes.reduce(join).unwrap_or_default()
}
