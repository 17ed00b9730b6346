//! What the mind looks at where: the road coloured by the number of looks and by the sensor read first.

use super::chart::{Anchor, Area, Ink, Key, Paint, Svg, legend_height, legend_rows};
use super::road::Ground;
use super::{Figure, policy};
use crate::results::{LooksMap, MapPoint, Results};

/// Draws the two maps.
#[must_use]
pub fn draw(results: &Results) -> Option<Figure> {
    let map = results.figures.look_map.as_ref().filter(|m| !m.points.is_empty())?;
    let by_looks =
        panel(map, ("Number of looks", &looks_keys(map)), |p| policy::looks_ink(p.looks as usize))?;
    let by_first =
        panel(map, ("Sensor read first", &sensor_keys(map)), |p| policy::sensor_ink(p.first.as_deref()))?;
    let caption = "Where on the road attention control (the training of median cost) looks how often, and where it \
                   looks first. One point per motor decision.";
    Some(Figure { id: "look_map", caption: caption.to_owned(), panels: vec![by_looks, by_first] })
}

const WIDTH: f64 = 460.0;
const HEIGHT: f64 = 330.0;

fn panel(map: &LooksMap, (title, keys): (&str, &[Key]), ink: impl Fn(&MapPoint) -> Ink) -> Option<String> {
    let legend = Area { x: 10.0, y: 28.0, width: WIDTH - 20.0, height: 0.0 };
    let top = 38.0 + legend_height(legend.width, keys);
    let mut svg = Svg::new(WIDTH, top + HEIGHT);
    svg.text((10.0, 18.0), Anchor::Start, "title", title);
    legend_rows(&mut svg, legend, keys);
    let ground = Ground::fit(&map.road, Area { x: 8.0, y: top, width: WIDTH - 16.0, height: HEIGHT - 8.0 })?;
    ground.draw_road(&mut svg, &map.road, (Ink("road"), Ink::PAGE));
    for point in &map.points {
        svg.circle(ground.at(point.x, point.y), 3.2, Paint::fill(ink(point)).faded(0.85));
    }
    Some(svg.finish(title))
}

fn looks_keys(map: &LooksMap) -> Vec<Key> {
    let most = map.points.iter().map(|p| p.looks as usize).max().unwrap_or(0).min(7);
    (0..=most).map(|k| key(&k.to_string(), policy::looks_ink(k))).collect()
}

fn sensor_keys(map: &LooksMap) -> Vec<Key> {
    let is_used = |name: Option<&str>| map.points.iter().any(|p| p.first.as_deref() == name);
    let sensors = policy::SENSORS.iter().filter(|(name, _)| is_used(Some(name)));
    let mut keys: Vec<Key> = sensors.map(|&(name, ink)| key(name, ink)).collect();
    if is_used(None) {
        keys.push(key("none", policy::sensor_ink(None)));
    }
    keys
}

fn key(label: &str, ink: Ink) -> Key {
    Key { label: label.to_owned(), paint: Paint::fill(ink), is_line: false }
}
