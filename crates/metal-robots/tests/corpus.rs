//! What fuzzing found worth keeping, fed to the readers again; see `fuzz/README.md`.

#[path = "../fuzz/src/targets.rs"]
mod targets;

use std::path::Path;

/// Feeds the seeds of `target` and what fuzzing found (`kept`, a line each, in hex) to `read`.
fn feed(target: &str, kept: &str, read: fn(&[u8])) {
    let seeds = std::fs::read_dir(Path::new("fuzz/seeds").join(target)).expect("seeds");
    let seeds = seeds.map(|entry| std::fs::read(entry.expect("an entry").path()).expect("a file"));
    let found: Vec<Vec<u8>> = seeds.chain(kept.lines().map(bytes)).collect();
    assert!(found.len() > 50, "{} inputs", found.len());
    for input in found {
        read(&input);
        // Half a message, too: on a line it is what is there until the rest has come.
        read(&input[..input.len() / 2]);
    }
}

fn bytes(hex: &str) -> Vec<u8> {
    let digit = |d: u8| char::from(d).to_digit(16).expect("hex") as u8;
    hex.as_bytes().chunks(2).map(|pair| digit(pair[0]) << 4 | digit(pair[1])).collect()
}

#[test]
fn nothing_that_was_found_on_a_serial_line_makes_its_reader_fall() {
    feed("sercom", include_str!("../fuzz/kept/sercom.txt"), targets::sercom);
}

#[test]
fn nothing_that_was_found_on_wifi_makes_its_reader_fall() {
    feed("wifi", include_str!("../fuzz/kept/wifi.txt"), targets::wifi);
}

#[test]
fn nothing_that_was_found_on_webots_line_makes_its_reader_fall() {
    feed("webots", include_str!("../fuzz/kept/webots.txt"), targets::webots);
}
