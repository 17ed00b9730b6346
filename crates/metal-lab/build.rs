//! Tells the report which compiler and which revision made it.

use std::process::Command;

fn main() {
    let rustc = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".to_owned());
    println!("cargo:rustc-env=METAL_RUSTC_VERSION={}", first_line(&rustc, &["--version"]));
    println!(
        "cargo:rustc-env=METAL_GIT_REVISION={}",
        first_line("git", &["describe", "--always", "--dirty"])
    );
    println!("cargo:rerun-if-changed=../../.git/HEAD");
    println!("cargo:rerun-if-changed=../../.git/logs/HEAD");
    println!("cargo:rerun-if-changed=build.rs");
    // Whether the tree is as it was committed changes with every source, not only with commits.
    for source in ["src", "assets", "../metal-rl/src", "../metal-worlds/src", "../metal-recording/src"] {
        println!("cargo:rerun-if-changed={source}");
    }
}

/// First line a program prints, or `unknown` where there is no such program.
fn first_line(program: &str, arguments: &[&str]) -> String {
    let output = Command::new(program).args(arguments).output().ok().filter(|o| o.status.success());
    let text = output.map(|o| String::from_utf8_lossy(&o.stdout).into_owned()).unwrap_or_default();
    text.lines().next().map_or_else(|| "unknown".to_owned(), str::to_owned)
}
