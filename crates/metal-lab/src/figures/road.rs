//! A road from above, to scale.

use super::chart::{Area, Ink, Paint, Svg};
use crate::results::RoadOutline;

/// From metres to pixels: the same scale both ways, y upwards.
#[derive(Clone, Copy, Debug)]
pub struct Ground {
    origin: (f64, f64),
    corner: (f64, f64),
    /// Pixels per metre.
    pub pixels_per_metre: f64,
}

impl Ground {
    /// Fits the whole road into `area`; `None` if the road has no points.
    #[must_use]
    pub fn fit(road: &RoadOutline, area: Area) -> Option<Self> {
        let first = *road.middle.first()?;
        let (mut low, mut high) = (first, first);
        for point in &road.middle {
            for axis in 0..2 {
                low[axis] = low[axis].min(point[axis]);
                high[axis] = high[axis].max(point[axis]);
            }
        }
        let size = [0, 1].map(|axis| high[axis] - low[axis] + road.width_m * 1.3);
        let pixels_per_metre = (area.width / size[0]).min(area.height / size[1]);
        let origin = ((low[0] + high[0]) / 2.0, (low[1] + high[1]) / 2.0);
        let corner = (area.x + area.width / 2.0, area.y + area.height / 2.0);
        Some(Self { origin, corner, pixels_per_metre })
    }

    /// The pixel of a point in metres.
    #[must_use]
    pub fn at(&self, x: f64, y: f64) -> (f64, f64) {
        let scale = self.pixels_per_metre;
        (self.corner.0 + (x - self.origin.0) * scale, self.corner.1 - (y - self.origin.1) * scale)
    }

    /// Draws both lanes with `ink` and the middle line with `middle`.
    pub fn draw_road(&self, svg: &mut Svg, road: &RoadOutline, (ink, middle): (Ink, Ink)) {
        let points: Vec<_> = road.middle.iter().map(|p| self.at(p[0], p[1])).collect();
        let width = road.width_m * self.pixels_per_metre;
        svg.path(&points, true, Paint::line(middle, width + 2.0));
        svg.path(&points, true, Paint::line(ink, width - 1.0));
        svg.path(&points, true, Paint::line(middle, 1.2).dashed());
    }
}
