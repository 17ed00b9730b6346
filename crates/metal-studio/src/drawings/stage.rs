//! The stage as a drawing for a talk: the road from above, what the camera saw and where the mind looked, and what
//! the tiny agents it asked had to say.

use super::{Studio, regions};
use crate::frame::{Frame, LaneFrame};
use metal_lab::figures::chart::{Anchor, Area, Ink, PIXELS_HEIGHT, PIXELS_WIDTH, Paint, Svg, pixels, region};
use metal_lab::figures::number;
use metal_lab::figures::road::Ground;
use metal_lab::plan::Plan;
use metal_lab::results::{Pose, RoadOutline};
use metal_worlds::highway::kinematics::BODY_RADIUS_M;

const WIDTH: f64 = 960.0;
/// Height of one mind's part.
const HEIGHT: f64 = 560.0;
const ROAD: Area = Area { x: 16.0, y: 52.0, width: 580.0, height: 470.0 };
const EYE: (f64, f64) = (624.0, 52.0);
/// A robot on the map is drawn this many times larger than it is, or it would hardly be seen.
const LARGER: f64 = 1.6;

/// Decision `n`, or the last one.
pub fn draw(studio: &Studio, n: Option<u64>) -> Option<String> {
    let frame = n.map_or_else(|| studio.hub.lately(1).into_iter().next(), |n| studio.hub.recall(n))?;
    let first = frame.lanes.first()?;
    let mut svg = Svg::new(WIDTH, HEIGHT * frame.lanes.len() as f64);
    // Two minds that are compared come one below the other.
    for (i, lane) in frame.lanes.iter().enumerate() {
        svg.raw(&format!("<g transform=\"translate(0,{})\">", HEIGHT * i as f64));
        draw_lane(&mut svg, studio, (&frame, lane));
        svg.raw("</g>");
    }
    Some(svg.finish(&title(&frame, first)))
}

fn draw_lane(svg: &mut Svg, studio: &Studio, (frame, lane): (&Frame, &LaneFrame)) {
    svg.text((16.0, 32.0), Anchor::Start, "title", &title(frame, lane));
    draw_road(svg, studio, lane);
    draw_eye(svg, &studio.plan, lane);
    draw_supports(svg, &studio.plan, lane);
    let cost = format!(
        "{}: motor {}, looks {}",
        studio.plan.spec.actions[lane.action],
        number::fixed(lane.motor, 2),
        number::fixed(-lane.look_price, 2)
    );
    svg.text((EYE.0, EYE.1 + PIXELS_HEIGHT + 20.0), Anchor::Start, "title", &cost);
}

fn title(frame: &Frame, lane: &LaneFrame) -> String {
    format!("{}: decision {}, step {} of episode {}", lane.driver, frame.n, frame.step + 1, frame.episode)
}

fn draw_road(svg: &mut Svg, studio: &Studio, lane: &LaneFrame) -> Option<()> {
    // A body on a floor is on no road that is known.
    let road: &RoadOutline = studio.roads.get(lane.road)?;
    let inner =
        Area { x: ROAD.x + 10.0, y: ROAD.y + 10.0, width: ROAD.width - 20.0, height: ROAD.height - 20.0 };
    let ground = Ground::fit(road, inner)?;
    svg.rect(ROAD, Paint::fill(Ink("px-side")));
    ground.draw_road(svg, road, (Ink("px-road"), Ink("px-line")));
    for (i, pose) in lane.to.iter().enumerate().rev() {
        draw_robot(svg, &ground, (pose, if i == 0 { Ink("px-mark") } else { Ink("px-car") }));
    }
    Some(())
}

fn draw_robot(svg: &mut Svg, ground: &Ground, (pose, ink): (&Pose, Ink)) {
    let (x, y) = ground.at(pose.x, pose.y);
    let radius = LARGER * BODY_RADIUS_M * ground.pixels_per_metre;
    let (sin, cos) = metal_rl::num::sin_cos(pose.heading_rad);
    svg.circle((x, y), radius, Paint::fill(ink).outlined(Ink("px-line"), 1.5));
    svg.line((x, y), (x + 1.9 * radius * cos, y - 1.9 * radius * sin), Paint::line(Ink("px-line"), 2.0));
}

/// The picture; what nobody looked at is dark.
fn draw_eye(svg: &mut Svg, plan: &Plan, lane: &LaneFrame) {
    pixels(svg, EYE, &lane.image);
    for (sensor, r) in regions().iter().enumerate() {
        let area = region(EYE, r);
        if !lane.read.contains(&sensor) {
            svg.rect(area, Paint::fill(Ink("px-shade")).faded(0.78));
        }
        svg.rect(area, Paint::line(Ink("px-line"), 0.8).faded(0.55));
    }
    let mut order = 0;
    for &member in &lane.asked {
        order += 1;
        for r in plan.members[member].sensors.iter().filter_map(|&s| regions().into_iter().nth(s)) {
            let area = region(EYE, &r);
            svg.rect(area, Paint::line(Ink("px-mark"), 2.5));
            svg.circle((area.x + 14.0, area.y + 14.0), 9.5, Paint::fill(Ink("px-mark")));
            let badge = order.to_string();
            svg.text((area.x + 14.0, area.y + 18.0), Anchor::Middle, "badge", &badge);
        }
    }
    let frame = Area { x: EYE.0, y: EYE.1, width: PIXELS_WIDTH, height: PIXELS_HEIGHT };
    svg.rect(frame, Paint::line(Ink::MUTED, 1.0));
}

/// One group of bars per member that was asked.
fn draw_supports(svg: &mut Svg, plan: &Plan, lane: &LaneFrame) {
    let top = EYE.1 + PIXELS_HEIGHT + 44.0;
    let letters: Vec<String> = plan.spec.actions.iter().map(|a| initials(a)).collect();
    for (i, &member) in lane.asked.iter().take(8).enumerate() {
        let Some(opinion) = &lane.opinions[member] else { continue };
        let (x, y) = (EYE.0 + (i % 4) as f64 * 80.0, top + (i / 4) as f64 * 92.0);
        svg.text((x, y), Anchor::Start, "key", &format!("{}. {}", i + 1, plan.members[member].name));
        for (a, support) in opinion.support.iter().enumerate() {
            let (left, height) = (x + a as f64 * 14.0, 46.0 * support);
            let bar = Area { x: left, y: y + 56.0 - height, width: 11.0, height };
            let ink = if a == lane.action { Ink("acl") } else { Ink("random") };
            svg.rect(bar, Paint::fill(ink));
            svg.text((left + 5.5, y + 69.0), Anchor::Middle, "small", &letters[a]);
        }
    }
}

/// The first letters of an action's words.
fn initials(action: &str) -> String {
    let last = action.split_whitespace().last().unwrap_or(action);
    last.chars().take(1).collect()
}
