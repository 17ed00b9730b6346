//! A legend in rows above or below a plot.

use super::frame::Area;
use super::paint::Paint;
use super::svg::{Anchor, Svg};

/// One entry of a legend.
#[derive(Clone, Debug)]
pub struct Key {
    /// What it says.
    pub label: String,
    /// How its sign is painted.
    pub paint: Paint,
    /// Whether the sign is a line rather than a square.
    pub is_line: bool,
}

const ROW: f64 = 19.0;
const SIGN: f64 = 18.0;
/// Mean width of a letter at the size of a legend, in pixels.
const LETTER: f64 = 6.6;

/// Draws the legend from `top` down, wrapping at the width of `area`.
pub fn rows(svg: &mut Svg, area: Area, keys: &[Key]) {
    for (key, (x, row)) in keys.iter().zip(positions(area.width, keys)) {
        let (x, y) = (area.x + x, area.y + row as f64 * ROW + ROW / 2.0);
        if key.is_line {
            svg.line((x, y), (x + SIGN, y), key.paint);
        } else {
            svg.rect(Area { x: x + 4.0, y: y - 6.0, width: 12.0, height: 12.0 }, key.paint);
        }
        svg.text((x + SIGN + 6.0, y + 4.0), Anchor::Start, "key", &key.label);
    }
}

/// Height of the legend in pixels at this width.
#[must_use]
pub fn legend_height(width: f64, keys: &[Key]) -> f64 {
    positions(width, keys).last().map_or(0.0, |&(_, row)| (row + 1) as f64 * ROW)
}

fn positions(width: f64, keys: &[Key]) -> Vec<(f64, usize)> {
    let (mut x, mut row) = (0.0, 0);
    let mut found = Vec::with_capacity(keys.len());
    for key in keys {
        let wide = SIGN + 16.0 + LETTER * key.label.chars().count() as f64;
        if x > 0.0 && x + wide > width {
            x = 0.0;
            row += 1;
        }
        found.push((x, row));
        x += wide;
    }
    found
}
