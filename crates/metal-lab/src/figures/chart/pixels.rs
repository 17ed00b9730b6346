//! The camera's image as coloured squares, with regions drawn over it.

use super::frame::Area;
use super::paint::{Ink, Paint};
use super::svg::Svg;
use crate::results::{CAMERA_COLUMNS, CAMERA_ROWS, CameraRegion, PixelImage};

const PIXEL: f64 = 6.0;
/// Width of a drawn image in pixels.
pub const PIXELS_WIDTH: f64 = CAMERA_COLUMNS as f64 * PIXEL;
/// Height of a drawn image in pixels.
pub const PIXELS_HEIGHT: f64 = CAMERA_ROWS as f64 * PIXEL;

/// Draws the image with its top left corner at `origin`; runs of equal pixels become one rectangle.
pub fn pixels(svg: &mut Svg, origin: (f64, f64), image: &PixelImage) {
    svg.raw("<g shape-rendering=\"crispEdges\">");
    for (row, line) in image.iter().enumerate() {
        let classes = line.as_bytes();
        let mut start = 0;
        while start < classes.len() {
            let run = classes[start..].iter().take_while(|&&c| c == classes[start]).count();
            let area = cell_area(origin, (row, row + 1), (start, start + run));
            svg.rect(area, Paint::fill(class_ink(classes[start])));
            start += run;
        }
    }
    svg.raw("</g>");
}

/// The rectangle of a region on an image drawn at `origin`.
#[must_use]
pub fn region(origin: (f64, f64), region: &CameraRegion) -> Area {
    cell_area(origin, (region.top, region.bottom), (region.left, region.right))
}

fn cell_area(origin: (f64, f64), rows: (usize, usize), columns: (usize, usize)) -> Area {
    Area {
        x: origin.0 + columns.0 as f64 * PIXEL,
        y: origin.1 + rows.0 as f64 * PIXEL,
        width: columns.1.saturating_sub(columns.0) as f64 * PIXEL,
        height: rows.1.saturating_sub(rows.0) as f64 * PIXEL,
    }
}

fn class_ink(class: u8) -> Ink {
    match class {
        b'0' => Ink("px-road"),
        b'1' => Ink("px-line"),
        b'2' => Ink("px-car"),
        b'3' => Ink("px-side"),
        _ => Ink("px-sky"),
    }
}
