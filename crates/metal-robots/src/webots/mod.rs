//! Webots' language for external controllers over TCP, without any link: frames, descriptions of devices, orders to the
//! simulator and news from it. Written from the layouts that Webots R2023b and R2025a document in their sources.
//!
//! The simulator's answers carry no lengths, so whoever reads them must know every message of every device of the robot.

pub mod device;
pub mod frame;
pub mod news;
pub mod order;
pub mod robot;
pub mod supervisor;
mod value;

use crate::error::ProtocolError;

/// Tag of the robot itself; its devices follow from 1 on.
pub const ROBOT: u16 = 0;

/// A release of Webots whose layouts are known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Release {
    /// R2023b, the layouts of the crate `webots` 0.8 and of `metal serve webots`.
    R2023b,
    /// R2025a: some supervisor messages have one more number.
    R2025a,
}

impl Release {
    /// The release of a version text such as `R2023b` or `R2025a revision 1`.
    ///
    /// # Errors
    /// If its layouts are not known.
    pub fn of(version: &str) -> Result<Self, ProtocolError> {
        match version.split_whitespace().next() {
            Some("R2023b") => Ok(Self::R2023b),
            Some("R2025a") => Ok(Self::R2025a),
            _ => Err(ProtocolError::UnknownRelease(format!("`{version}`"))),
        }
    }

    /// The version text.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::R2023b => "R2023b",
            Self::R2025a => "R2025a",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unknown_releases_are_refused_by_name() {
        assert_eq!(Release::of("R2023b").unwrap(), Release::R2023b);
        assert_eq!(Release::of("R2025a revision 1").unwrap(), Release::R2025a);
        let error = Release::of("R2022b").unwrap_err().to_string();
        assert!(error.contains("R2022b") && error.contains("R2023b"), "{error}");
        assert!(Release::of("").is_err());
    }
}
