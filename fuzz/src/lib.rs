//! Every reader of foreign bytes, for cargo-fuzz.
#![forbid(unsafe_code)]

pub mod targets;
