//! What fuzzing found worth keeping, fed to the readers of foreign bytes again; see `fuzz/README.md`.

#[path = "../../../fuzz/src/targets.rs"]
mod targets;

/// Feeds the kept inputs of a target (a line each, in hex) to `read`.
fn feed(kept: &str, read: fn(&[u8])) {
    assert!(kept.lines().count() > 0, "{} inputs", kept.lines().count());
    for line in kept.lines() {
        read(&bytes(line));
    }
}

fn bytes(hex: &str) -> Vec<u8> {
    let digit = |d: u8| char::from(d).to_digit(16).expect("hex") as u8;
    hex.as_bytes().chunks(2).map(|pair| digit(pair[0]) << 4 | digit(pair[1])).collect()
}

#[test]
fn no_experiment_file_that_was_found_makes_its_reader_fall() {
    feed(include_str!("../../../fuzz/kept/experiment.txt"), targets::experiment);
}

#[test]
fn no_checkpoint_that_was_found_makes_its_reader_fall() {
    feed(include_str!("../../../fuzz/kept/checkpoint.txt"), targets::checkpoint);
}

#[test]
fn no_course_that_was_found_makes_its_reader_fall() {
    feed(include_str!("../../../fuzz/kept/course.txt"), targets::course::course);
}

#[test]
fn no_table_that_was_found_makes_its_reader_fall() {
    feed(include_str!("../../../fuzz/kept/csv.txt"), targets::csv);
}

#[test]
fn no_demonstration_that_was_found_makes_its_reader_fall() {
    feed(include_str!("../../../fuzz/kept/demonstration.txt"), targets::demonstration);
}

#[test]
fn no_recording_that_was_found_makes_its_reader_fall() {
    feed(include_str!("../../../fuzz/kept/recording.txt"), targets::recording);
}

#[test]
fn no_request_that_was_found_makes_the_studio_fall() {
    feed(include_str!("../../../fuzz/kept/request.txt"), targets::request);
}
