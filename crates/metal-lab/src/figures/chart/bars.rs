//! Horizontal bars in two stacked parts, with an interval for the whole.

use super::frame::Area;
use super::paint::{Ink, Paint};
use super::scale::{Scale, ticks};
use super::svg::{Anchor, Svg};
use crate::figures::number;

/// One bar.
#[derive(Clone, Debug)]
pub struct Bar {
    /// Its name, to the left.
    pub label: String,
    /// Its colour.
    pub ink: Ink,
    /// The two parts; the first is painted solid, the second faded.
    pub parts: [f64; 2],
    /// Interval of the sum.
    pub band: Option<(f64, f64)>,
    /// A value from elsewhere to mark on the bar (the paper's).
    pub reference: Option<f64>,
}

/// A chart of bars, one under the other, growing from zero to the right.
#[derive(Clone, Debug)]
pub struct BarChart {
    /// What the chart shows.
    pub title: String,
    /// Label of the value axis.
    pub axis: String,
    /// The value at the right edge; all charts that stand side by side share it.
    pub end: f64,
    /// The bars, from above.
    pub bars: Vec<Bar>,
}

const WIDTH: f64 = 460.0;
const LEFT: f64 = 150.0;
const ROW: f64 = 28.0;
const TOP: f64 = 34.0;

impl BarChart {
    /// The chart as an `<svg>` element.
    #[must_use]
    pub fn draw(&self) -> String {
        let height = self.bars.len() as f64 * ROW;
        let mut svg = Svg::new(WIDTH, TOP + height + 46.0);
        svg.text((8.0, 18.0), Anchor::Start, "title", &self.title);
        let scale = self.draw_axis(&mut svg, TOP + height);
        for (i, bar) in self.bars.iter().enumerate() {
            draw_bar(&mut svg, &scale, bar, TOP + i as f64 * ROW + 5.0);
        }
        svg.finish(&self.title)
    }

    fn draw_axis(&self, svg: &mut Svg, bottom: f64) -> Scale {
        let marks = ticks(self.end.min(0.0), self.end.max(0.0), 4);
        let far = if self.end < 0.0 { marks.first() } else { marks.last() };
        let scale = Scale::new((0.0, far.copied().unwrap_or(self.end)), (LEFT, WIDTH - 52.0));
        for &mark in &marks {
            let x = scale.at(mark);
            svg.line((x, TOP), (x, bottom), Paint::line(Ink::GRID, 1.0));
            svg.text((x, bottom + 16.0), Anchor::Middle, "tick", &number::tick(mark, &marks));
        }
        svg.text(((LEFT + WIDTH - 52.0) / 2.0, bottom + 36.0), Anchor::Middle, "label", &self.axis);
        scale
    }
}

fn draw_bar(svg: &mut Svg, scale: &Scale, bar: &Bar, y: f64) {
    let height = ROW - 10.0;
    let (first, sum) = (bar.parts[0], bar.parts[0] + bar.parts[1]);
    let (zero, middle, end) = (scale.at(0.0), scale.at(first), scale.at(sum));
    let part = |from: f64, to: f64| Area { x: from.min(to), y, width: (to - from).abs(), height };
    svg.rect(part(zero, middle), Paint::fill(bar.ink));
    svg.rect(part(middle, end), Paint::fill(bar.ink).faded(0.4));
    let centre = y + height / 2.0;
    if let Some((lo, hi)) = bar.band {
        draw_whisker(svg, scale, (lo, hi), centre);
    }
    if let Some(reference) = bar.reference {
        draw_diamond(svg, (scale.at(reference), centre));
    }
    svg.text((LEFT - 8.0, centre + 4.0), Anchor::End, "key", &bar.label);
    // In a column of their own: beside the diamond our number would be taken for the paper's.
    svg.text((WIDTH - 4.0, centre + 4.0), Anchor::End, "value", &number::fixed(sum, 1));
}

/// An interval; where it leaves the chart it is cut and has no cap.
fn draw_whisker(svg: &mut Svg, scale: &Scale, (lo, hi): (f64, f64), y: f64) {
    let paint = Paint::line(Ink::TEXT, 1.4);
    svg.line((scale.at(scale.inside(lo)), y), (scale.at(scale.inside(hi)), y), paint);
    for end in [lo, hi].into_iter().filter(|&end| scale.inside(end) == end) {
        svg.line((scale.at(end), y - 4.0), (scale.at(end), y + 4.0), paint);
    }
}

fn draw_diamond(svg: &mut Svg, (x, y): (f64, f64)) {
    let corners = [(x, y - 6.0), (x + 6.0, y), (x, y + 6.0), (x - 6.0, y)];
    svg.path(&corners, true, Paint::fill(Ink::PAGE).outlined(Ink::TEXT, 1.6));
}
