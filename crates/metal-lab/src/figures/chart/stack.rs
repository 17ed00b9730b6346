//! Columns of stacked shares.

use super::frame::{Area, Axis, Frame};
use super::legend::{Key, legend_height, rows};
use super::paint::{Ink, Paint};
use super::svg::{Anchor, Svg};

/// One column: shares from the bottom up, one per layer.
#[derive(Clone, Debug)]
pub struct StackColumn {
    /// Its name, below.
    pub label: String,
    /// The shares; they sum to one.
    pub shares: Vec<f64>,
}

/// Columns of stacked shares.
#[derive(Clone, Debug)]
pub struct StackChart {
    /// What the chart shows.
    pub title: String,
    /// Label of the x axis.
    pub x_label: String,
    /// Name and colour of each layer, from the bottom up.
    pub layers: Vec<(String, Ink)>,
    /// The columns, from the left.
    pub columns: Vec<StackColumn>,
    /// Width of the drawing, in pixels.
    pub width: f64,
}

const HEIGHT: f64 = 240.0;

impl StackChart {
    /// The chart as an `<svg>` element.
    #[must_use]
    pub fn draw(&self) -> String {
        let left = 70.0;
        let keys = self.keys();
        let legend = Area { x: left, y: 28.0, width: self.width - left - 10.0, height: 0.0 };
        let top = 38.0 + legend_height(legend.width, &keys);
        let mut svg = Svg::new(self.width, top + HEIGHT + 48.0);
        svg.text((left, 18.0), Anchor::Start, "title", &self.title);
        rows(&mut svg, legend, &keys);
        let area = Area { x: left, y: top, width: self.width - left - 16.0, height: HEIGHT };
        let x_axis = Axis { label: self.x_label.clone(), marks: Vec::new() };
        let y_axis = Axis::around("share of decisions, %", [0.0, 100.0]);
        let frame = Frame::draw(&mut svg, area, &x_axis, &y_axis);
        for (i, column) in self.columns.iter().enumerate() {
            self.draw_column(&mut svg, &frame, (i, column));
        }
        svg.finish(&self.title)
    }

    fn keys(&self) -> Vec<Key> {
        let key = |(label, ink): &(String, Ink)| Key {
            label: label.clone(),
            paint: Paint::fill(*ink),
            is_line: false,
        };
        self.layers.iter().map(key).collect()
    }

    fn draw_column(&self, svg: &mut Svg, frame: &Frame, (i, column): (usize, &StackColumn)) {
        let pitch = frame.area.width / self.columns.len() as f64;
        let gap = if pitch > 12.0 { 3.0 } else { 0.5 };
        let x = frame.area.x + i as f64 * pitch;
        let mut below = 0.0;
        for (share, &(_, ink)) in column.shares.iter().zip(&self.layers) {
            let (bottom, top) = (frame.y.at(below * 100.0), frame.y.at((below + share) * 100.0));
            let area = Area { x: x + gap / 2.0, y: top, width: pitch - gap, height: bottom - top };
            if *share > 0.0 {
                svg.rect(area, Paint::fill(ink));
            }
            below += share;
        }
        // Thin columns cannot all be named.
        let every = (48.0 / pitch).ceil().max(1.0) as usize;
        if (i + 1) % every == 0 || self.columns.len() <= 2 {
            let at = (x + pitch / 2.0, frame.area.bottom() + 18.0);
            svg.text(at, Anchor::Middle, "tick", &column.label);
        }
    }
}
