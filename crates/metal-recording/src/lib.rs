//! Runs as MCAP files: what was sensed, attended to, commanded, paid and believed.
//!
//! [`Recorder`] stands between a mind and any environment and writes everything that passes; [`Beliefs`] is an observer
//! that adds what the members said. Foxglove opens the files, ROS 2 tools read their messages (`ros2msg`, CDR), and
//! [`Replay`] is the recording as an environment: a demonstration recorded on a robot trains Phase I in simulation, and
//! the other way round.

pub mod cdr;
mod reader;
pub mod recorder;
pub mod replay;
pub mod tape;

pub use mcap::MAGIC;
pub use recorder::{Beliefs, Recorder};
pub use replay::Replay;
pub use tape::{Tape, TapeError};
