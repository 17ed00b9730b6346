//! A rectangle with axes, grid and labels.

use super::paint::{Ink, Paint};
use super::scale::{Scale, ticks};
use super::svg::{Anchor, Svg};
use crate::figures::number;

/// A rectangle in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Area {
    /// Left edge.
    pub x: f64,
    /// Top edge.
    pub y: f64,
    /// Width.
    pub width: f64,
    /// Height.
    pub height: f64,
}

impl Area {
    /// The pixel of the right edge.
    #[must_use]
    pub fn right(&self) -> f64 {
        self.x + self.width
    }

    /// The pixel of the bottom edge.
    #[must_use]
    pub fn bottom(&self) -> f64 {
        self.y + self.height
    }

    /// Whether two rectangles share a point.
    #[must_use]
    pub fn meets(&self, other: &Self) -> bool {
        self.x < other.right() && other.x < self.right() && self.y < other.bottom() && other.y < self.bottom()
    }
}

/// Mean width of a digit at the size of a mark, in pixels.
const LETTER: f64 = 7.4;

/// One axis: what it says and which values it spans.
#[derive(Clone, Debug)]
pub struct Axis {
    /// What is shown, with its unit.
    pub label: String,
    /// Where the marks are; the first and last are the ends.
    pub marks: Vec<f64>,
}

impl Axis {
    /// An axis with round marks around the values.
    #[must_use]
    pub fn around(label: &str, values: impl IntoIterator<Item = f64>) -> Self {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for v in values.into_iter().filter(|v| v.is_finite()) {
            low = low.min(v);
            high = high.max(v);
        }
        let (low, high) = if low <= high { (low, high) } else { (0.0, 1.0) };
        Self { label: label.to_owned(), marks: ticks(low, high, 5) }
    }

    /// Room in pixels for the marks' texts and the label, left of a vertical axis.
    #[must_use]
    pub fn room(&self) -> f64 {
        let letters = self.marks.iter().map(|&m| number::tick(m, &self.marks).chars().count()).max();
        36.0 + LETTER * letters.unwrap_or(0) as f64
    }

    fn ends(&self) -> (f64, f64) {
        (self.marks.first().copied().unwrap_or(0.0), self.marks.last().copied().unwrap_or(1.0))
    }
}

/// A plot area with its two scales.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// The rectangle between the axes.
    pub area: Area,
    /// Values to pixels, left to right.
    pub x: Scale,
    /// Values to pixels, bottom to top.
    pub y: Scale,
}

impl Frame {
    /// Draws grid, marks and labels, and returns the scales.
    pub fn draw(svg: &mut Svg, area: Area, x_axis: &Axis, y_axis: &Axis) -> Self {
        let x = Scale::new(x_axis.ends(), (area.x, area.right()));
        let y = Scale::new(y_axis.ends(), (area.bottom(), area.y));
        for &mark in &y_axis.marks {
            let at = y.at(mark);
            svg.line((area.x, at), (area.right(), at), Paint::line(Ink::GRID, 1.0));
            let text = number::tick(mark, &y_axis.marks);
            svg.text((area.x - 7.0, at + 4.0), Anchor::End, "tick", &text);
        }
        for &mark in &x_axis.marks {
            let at = x.at(mark);
            svg.line((at, area.bottom()), (at, area.bottom() + 4.0), Paint::line(Ink::MUTED, 1.0));
            let text = number::tick(mark, &x_axis.marks);
            svg.text((at, area.bottom() + 18.0), Anchor::Middle, "tick", &text);
        }
        svg.line((area.x, area.bottom()), (area.right(), area.bottom()), Paint::line(Ink::MUTED, 1.0));
        let middle = area.x + area.width / 2.0;
        svg.text((middle, area.bottom() + 37.0), Anchor::Middle, "label", &x_axis.label);
        svg.upward_text((area.x - y_axis.room() + 14.0, area.y + area.height / 2.0), "label", &y_axis.label);
        Self { area, x, y }
    }

    /// The pixel of a pair of values.
    #[must_use]
    pub fn at(&self, x: f64, y: f64) -> (f64, f64) {
        (self.x.at(x), self.y.at(y))
    }
}
