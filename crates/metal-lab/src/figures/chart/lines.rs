//! Lines with bands.

use super::frame::{Area, Axis, Frame};
use super::legend::{Key, legend_height, rows};
use super::paint::{Ink, Paint};
use super::svg::{Anchor, Svg};

/// One point of a line, with its interval if it is known.
#[derive(Clone, Copy, Debug)]
pub struct LinePoint {
    /// Position.
    pub x: f64,
    /// Value.
    pub y: f64,
    /// Interval of the value.
    pub band: Option<(f64, f64)>,
}

/// One line.
#[derive(Clone, Debug)]
pub struct Series {
    /// Its name; an empty one stays out of the legend.
    pub label: String,
    /// Its colour.
    pub ink: Ink,
    /// Width in pixels.
    pub width: f64,
    /// Whether it is dashed.
    pub dashed: bool,
    /// Its points, from left to right.
    pub points: Vec<LinePoint>,
}

impl Series {
    fn paint(&self) -> Paint {
        let paint = Paint::line(self.ink, self.width);
        if self.dashed { paint.dashed() } else { paint }
    }
}

/// A chart of lines.
#[derive(Clone, Debug)]
pub struct LineChart {
    /// What the chart shows.
    pub title: String,
    /// Label of the x axis.
    pub x_label: String,
    /// Label of the y axis.
    pub y_label: String,
    /// The lines, the most important last (it is drawn on top).
    pub series: Vec<Series>,
}

const WIDTH: f64 = 460.0;
const PLOT_HEIGHT: f64 = 230.0;
/// How far bands may widen the chart beyond the lines, as a share of the lines' own range.
const BAND_ROOM: f64 = 0.5;

impl LineChart {
    /// The chart as an `<svg>` element.
    #[must_use]
    pub fn draw(&self) -> String {
        let keys = self.keys();
        let (x_axis, y_axis) = (self.x_axis(), self.y_axis());
        let left = y_axis.room();
        let legend = Area { x: left, y: 32.0, width: WIDTH - left - 10.0, height: 0.0 };
        let top = 40.0 + legend_height(legend.width, &keys);
        let mut svg = Svg::new(WIDTH, top + PLOT_HEIGHT + 48.0);
        svg.text((left, 18.0), Anchor::Start, "title", &self.title);
        rows(&mut svg, legend, &keys);
        let area = Area { x: left, y: top, width: WIDTH - left - 16.0, height: PLOT_HEIGHT };
        let frame = Frame::draw(&mut svg, area, &x_axis, &y_axis);
        for series in &self.series {
            draw_band(&mut svg, &frame, series);
        }
        for series in &self.series {
            let points: Vec<_> = series.points.iter().map(|p| frame.at(p.x, p.y)).collect();
            svg.path(&points, false, series.paint());
        }
        svg.finish(&self.title)
    }

    fn keys(&self) -> Vec<Key> {
        let named = self.series.iter().filter(|s| !s.label.is_empty());
        named.map(|s| Key { label: s.label.clone(), paint: s.paint(), is_line: true }).collect()
    }

    fn points(&self) -> impl Iterator<Item = &LinePoint> {
        self.series.iter().flat_map(|s| &s.points)
    }

    fn x_axis(&self) -> Axis {
        Axis::around(&self.x_label, self.points().map(|p| p.x))
    }

    /// Room for the lines, and for their bands as far as they do not press the lines together.
    fn y_axis(&self) -> Axis {
        let (low, high) =
            self.points().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p.y), h.max(p.y)));
        let room = BAND_ROOM * (high - low).max(0.1 * low.abs().max(high.abs()));
        let values = self.points().flat_map(move |p| {
            let (lo, hi) = p.band.unwrap_or((p.y, p.y));
            [lo.max(low - room), p.y, hi.min(high + room)]
        });
        Axis::around(&self.y_label, values)
    }
}

fn draw_band(svg: &mut Svg, frame: &Frame, series: &Series) {
    let banded = || series.points.iter().filter_map(|p| p.band.map(|band| (p.x, band)));
    let upper = banded().map(|(x, (_, hi))| frame.at(x, frame.y.inside(hi)));
    let mut outline: Vec<_> = upper.collect();
    let mut lower: Vec<_> = banded().map(|(x, (lo, _))| frame.at(x, frame.y.inside(lo))).collect();
    lower.reverse();
    outline.append(&mut lower);
    if outline.len() > 3 {
        svg.path(&outline, true, Paint::fill(series.ink).faded(0.18));
    }
}
