//! Bodies for METAL minds.
//!
//! [`epuck`] and [`webots`] are languages: bytes in, meaning out, no link.

pub mod bytes;
pub mod epuck;
pub mod error;
pub mod picture;
pub mod webots;

pub use error::{BodyError, ProtocolError};
pub use picture::Picture;
