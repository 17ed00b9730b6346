//! The pictures of Table 1: each situation as the robot sees it, the regions it attended numbered in their order.

use super::Figure;
use super::chart::{Anchor, Area, Ink, PIXELS_HEIGHT, PIXELS_WIDTH, Paint, Svg, pixels, region};
use crate::results::{CameraRegion, Results, SceneRow};

/// Draws one picture per situation.
#[must_use]
pub fn draw(results: &Results) -> Option<Figure> {
    let scenes = &results.figures.table1;
    let regions = &results.figures.camera_regions;
    let panels: Vec<String> = scenes.iter().map(|scene| picture(scene, regions)).collect();
    let caption = "The situations of Table 1 as the robot's camera sees them. Numbers: the order in which attention \
                   control looks; thin frames: regions it leaves alone.";
    (!panels.is_empty()).then(|| Figure { id: "table1", caption: caption.to_owned(), panels })
}

const STRIP: f64 = 34.0;

fn picture(scene: &SceneRow, regions: &[CameraRegion]) -> String {
    let mut svg = Svg::new(PIXELS_WIDTH, PIXELS_HEIGHT + STRIP);
    pixels(&mut svg, (0.0, 0.0), &scene.image);
    for r in regions {
        svg.rect(region((0.0, 0.0), r), Paint::line(Ink("px-line"), 0.8).faded(0.55));
    }
    for (order, sensor) in scene.learned.iter().enumerate() {
        match regions.iter().find(|r| r.name == *sensor) {
            Some(r) => draw_attended(&mut svg, region((0.0, 0.0), r), (order + 1, sensor)),
            None => draw_badge(&mut svg, (14.0, PIXELS_HEIGHT + 18.0), (order + 1, sensor)),
        }
    }
    svg.finish(&scene.situation)
}

fn draw_attended(svg: &mut Svg, area: Area, order: (usize, &str)) {
    let inner = Area { x: area.x + 1.5, y: area.y + 1.5, width: area.width - 3.0, height: area.height - 3.0 };
    svg.rect(inner, Paint::line(Ink("px-mark"), 3.0));
    draw_badge(svg, (area.x + 15.0, area.y + 15.0), (order.0, ""));
    let below = (area.x + area.width / 2.0 + 6.0, area.y + area.height / 2.0 + 6.0);
    svg.text(below, Anchor::Middle, "onpicture", order.1);
}

fn draw_badge(svg: &mut Svg, (x, y): (f64, f64), (order, name): (usize, &str)) {
    svg.circle((x, y), 10.0, Paint::fill(Ink("px-mark")).outlined(Ink("px-road"), 1.0));
    svg.text((x, y + 4.0), Anchor::Middle, "badge", &order.to_string());
    svg.text((x + 16.0, y + 4.0), Anchor::Start, "key", name);
}
