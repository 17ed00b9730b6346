//! The readers of the robots' languages, for cargo-fuzz.
#![forbid(unsafe_code)]

pub mod targets;
