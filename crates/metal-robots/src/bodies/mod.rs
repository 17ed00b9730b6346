//! Bodies behind links.

pub mod epuck1;
pub mod epuck2;
mod real;
pub mod webots;

pub use epuck1::Epuck1;
pub use epuck2::Epuck2;
pub use webots::Webots;

use crate::error::BodyError;
use crate::picture::Picture;
use metal_worlds::highway::camera::{COLUMNS, Window};

/// The part of a whole picture that a window shows.
fn part(whole: &Picture, window: Window) -> Picture {
    whole.cropped([window.left, window.top], [window.right - window.left, window.bottom - window.top])
}

/// Whether a link that failed like this may work again after it was opened anew.
fn may_come_back(error: &BodyError) -> bool {
    matches!(error, BodyError::Lost(_) | BodyError::Silent(_) | BodyError::Unreachable { .. })
}

// The windows of the mind's regions are those of a picture of this width.
const _: () = assert!(COLUMNS == 52);
