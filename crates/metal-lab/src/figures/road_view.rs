//! Fig. 6: the road from above, and what the camera sees with the regions of interest.

use super::chart::{Anchor, Area, Ink, PIXELS_HEIGHT, PIXELS_WIDTH, Paint, Svg, pixels, region};
use super::road::Ground;
use super::{Figure, policy};
use crate::results::{CameraRegion, Pose, Results, RoadView};

/// Draws the two pictures.
#[must_use]
pub fn draw(results: &Results) -> Option<Figure> {
    let view = results.figures.fig6.as_ref()?;
    let panels = vec![from_above(view)?, camera(view, &results.figures.camera_regions)];
    let caption = "Left: the training road from above; the learner is yellow, the other cars red (drawn larger than \
                   they are). Right: what the learner's camera sees at this moment, with the six regions, each seen \
                   by one tiny agent (paper: Fig. 6).";
    Some(Figure { id: "fig6", caption: caption.to_owned(), panels })
}

const WIDTH: f64 = 460.0;
const HEIGHT: f64 = 340.0;
/// Radius of a robot on the map, in pixels; at true scale it would hardly be seen.
const ROBOT: f64 = 7.0;

fn from_above(view: &RoadView) -> Option<String> {
    let mut svg = Svg::new(WIDTH, HEIGHT);
    let whole = Area { x: 0.0, y: 0.0, width: WIDTH, height: HEIGHT };
    let ground =
        Ground::fit(&view.road, Area { x: 14.0, y: 14.0, width: WIDTH - 28.0, height: HEIGHT - 28.0 })?;
    svg.rect(whole, Paint::fill(Ink("px-side")));
    ground.draw_road(&mut svg, &view.road, (Ink("px-road"), Ink("px-line")));
    for car in &view.cars {
        draw_robot(&mut svg, &ground, (car, Ink("px-car")));
    }
    draw_robot(&mut svg, &ground, (&view.learner, Ink("px-mark")));
    Some(svg.finish("The road from above"))
}

fn draw_robot(svg: &mut Svg, ground: &Ground, (pose, ink): (&Pose, Ink)) {
    let (x, y) = ground.at(pose.x, pose.y);
    svg.circle((x, y), ROBOT, Paint::fill(ink).outlined(Ink("px-line"), 1.5));
    let (sin, cos) = metal_rl::num::sin_cos(pose.heading_rad);
    let nose = (x + 2.2 * ROBOT * cos, y - 2.2 * ROBOT * sin);
    svg.line((x, y), nose, Paint::line(Ink("px-line"), 2.0));
}

fn camera(view: &RoadView, regions: &[CameraRegion]) -> String {
    let origin = ((WIDTH - PIXELS_WIDTH) / 2.0, (HEIGHT - PIXELS_HEIGHT) / 2.0);
    let mut svg = Svg::new(WIDTH, HEIGHT);
    pixels(&mut svg, origin, &view.image);
    for r in regions {
        let area = region(origin, r);
        svg.rect(area, Paint::line(Ink("px-mark"), 1.6));
        let centre = (area.x + area.width / 2.0, area.y + area.height / 2.0 + 4.0);
        svg.text(centre, Anchor::Middle, "onpicture", &r.name);
    }
    let names: Vec<&str> = policy::SENSORS.iter().map(|(name, _)| *name).collect();
    let note = format!("52 × 39 pixels; tiny agents {}", names.join(", "));
    svg.text((WIDTH / 2.0, origin.1 + PIXELS_HEIGHT + 22.0), Anchor::Middle, "label", &note);
    svg.finish("The robot's view with the regions of interest")
}
