//! The command `metal`: parses, calls the lab, prints. No logic lives here.
#![forbid(unsafe_code)]
#![allow(clippy::print_stderr, clippy::exit)]

mod args;
mod bar;
mod commands;
mod robots;
mod table;

use clap::Parser;

fn main() {
    let arguments = args::Arguments::parse();
    if let Err(error) = commands::run(arguments) {
        eprintln!("metal: {error:#}");
        std::process::exit(1);
    }
}
