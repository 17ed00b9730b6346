//! Labels beside points that do not cover each other.

use super::frame::Area;
use super::svg::{Anchor, Svg};

/// A text that wants to stand beside a point.
#[derive(Clone, Debug)]
pub struct Label {
    /// The point, in pixels.
    pub at: (f64, f64),
    /// The text.
    pub text: String,
    /// Whether it may be left out when there is no room.
    pub optional: bool,
}

const LETTER: f64 = 6.2;
const HEIGHT: f64 = 14.0;

/// Writes each label to the right, left, above or below its point, at the first place inside `bounds` where it covers no
/// earlier label; an optional one without room is left out. Earlier labels take precedence.
pub fn place_labels(svg: &mut Svg, bounds: Area, labels: &[Label]) {
    let mut taken: Vec<Area> = labels.iter().map(|l| around(l.at)).collect();
    for (i, label) in labels.iter().enumerate() {
        let free = |area: &Area| {
            is_inside(area, &bounds) && taken.iter().enumerate().all(|(j, t)| j == i || !t.meets(area))
        };
        let places = places(label);
        let place = places.iter().find(|area| free(area));
        let Some(&place) = place.or(if label.optional { None } else { places.first() }) else { continue };
        taken.push(place);
        svg.text((place.x, place.bottom() - 3.0), Anchor::Start, "small", &label.text);
    }
}

fn around((x, y): (f64, f64)) -> Area {
    Area { x: x - 4.0, y: y - 4.0, width: 8.0, height: 8.0 }
}

fn is_inside(area: &Area, bounds: &Area) -> bool {
    area.x >= bounds.x
        && area.right() <= bounds.right()
        && area.y >= bounds.y
        && area.bottom() <= bounds.bottom()
}

fn places(label: &Label) -> Vec<Area> {
    let (x, y) = label.at;
    let width = LETTER * label.text.chars().count() as f64;
    let offsets = [
        (9.0, -HEIGHT / 2.0),
        (-9.0 - width, -HEIGHT / 2.0),
        (-width / 2.0, -9.0 - HEIGHT),
        (-width / 2.0, 9.0),
        (7.0, -6.0 - HEIGHT),
        (7.0, 6.0),
        (-7.0 - width, -6.0 - HEIGHT),
        (-7.0 - width, 6.0),
    ];
    offsets.iter().map(|(dx, dy)| Area { x: x + dx, y: y + dy, width, height: HEIGHT }).collect()
}
