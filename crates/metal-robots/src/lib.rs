//! Bodies for METAL minds.
//!
//! [`epuck`] and [`webots`] are languages: bytes in, meaning out, no link. [`link`] carries bytes, [`bodies`] speak the
//! languages over links, and [`guard`] stands between a body and whoever drives it.

pub mod address;
pub mod arena;
pub mod bodies;
pub mod body;
pub mod bytes;
pub mod calibration;
pub mod doctor;
pub mod environment;
pub mod epuck;
pub mod error;
pub mod guard;
pub mod link;
pub mod picture;
pub mod serve;
pub mod webots;
pub mod world;

pub use address::Address;
pub use body::{Body, Wheels};
pub use calibration::Calibration;
pub use environment::{RobotConfig, RobotEnvironment};
pub use error::{BodyError, ProtocolError};
pub use guard::{Emergency, Guard, Limits};
pub use picture::Picture;
