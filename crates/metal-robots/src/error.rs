//! What can go wrong between a mind and a body.

use std::time::Duration;

/// Bytes that do not mean what they should.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ProtocolError {
    /// The message ended too early.
    #[error("the message ends too early: {wanted} more bytes expected, {left} left")]
    Truncated {
        /// Bytes that were still expected.
        wanted: usize,
        /// Bytes that were there.
        left: usize,
    },
    /// Something else was said than the protocol allows.
    #[error("unexpected: {0}")]
    Unexpected(String),
    /// A Webots whose messages this program does not know.
    #[error("Webots {0} speaks a layout this program does not know; it knows R2023b and R2025a")]
    UnknownRelease(String),
    /// A device whose messages this program does not know; they carry no length, so none can be skipped.
    #[error(
        "device `{name}` is of Webots node type {node}, whose messages this program does not know; remove it from the robot"
    )]
    UnknownDevice {
        /// The device's name.
        name: String,
        /// Its node type in Webots' numbering.
        node: u16,
    },
}

impl ProtocolError {
    /// Whether more bytes may turn this into a message.
    #[must_use]
    pub fn wants_more(&self) -> bool {
        matches!(self, Self::Truncated { .. })
    }
}

/// What a body or its link may fail with.
#[derive(Debug, thiserror::Error)]
pub enum BodyError {
    /// Nobody answers at the address.
    #[error("cannot reach {address}: {reason}")]
    Unreachable {
        /// The address as it was given.
        address: String,
        /// What the system said.
        reason: String,
    },
    /// The link broke, and reconnecting did not help.
    #[error("the link is lost: {0}")]
    Lost(String),
    /// Nothing came in time.
    #[error("no answer within {0:?}")]
    Silent(Duration),
    /// What came does not mean anything.
    #[error(transparent)]
    Protocol(#[from] ProtocolError),
    /// Somebody pressed the emergency stop (Ctrl-C).
    #[error("stopped: the emergency stop was pressed")]
    Stopped,
    /// The body cannot do this.
    #[error("{0}")]
    Unsupported(String),
}

impl From<std::io::Error> for BodyError {
    fn from(error: std::io::Error) -> Self {
        Self::Lost(error.to_string())
    }
}
