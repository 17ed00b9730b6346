//! The timeline: one bar per decision, as high as its looks, with what it cost below.

use super::{Studio, Wishes, number};
use crate::frame::{Frame, LaneFrame};
use metal_lab::figures::chart::{Anchor, Area, Ink, Paint, Svg};
use metal_lab::figures::policy;
use std::sync::Arc;

/// Decisions on the strip.
pub const SHOWN: usize = 240;
/// Width of the strip in pixels if the page does not say its own; the page lays its slider over exactly this.
const WIDTH: f64 = 640.0;
/// Widths that a page may have, so that letters keep their size.
const WIDTHS: std::ops::RangeInclusive<f64> = 240.0..=2000.0;
const LOOKS: f64 = 42.0;
const COSTS: f64 = 26.0;
/// Most looks a bar has room for.
const MOST: f64 = 7.0;
/// Motor cost at which a bar is full.
const DEAR: f64 = 50.0;

/// The last decisions.
pub fn draw(studio: &Studio, wishes: &Wishes) -> Option<String> {
    let width = number(wishes, "width").filter(|width| WIDTHS.contains(width)).unwrap_or(WIDTH);
    let frames = studio.hub.lately(SHOWN);
    let first = frames.first()?.n;
    let mut svg = Svg::new(width, LOOKS + COSTS + 14.0);
    svg.line((0.0, LOOKS), (width, LOOKS), Paint::line(Ink::MUTED, 1.0));
    for frame in &frames {
        if let Some(lane) = frame.lanes.first() {
            draw_decision(&mut svg, (frame, lane), (first, width / SHOWN as f64));
        }
    }
    let bottom = LOOKS + COSTS + 11.0;
    svg.text((0.0, 10.0), Anchor::Start, "small", "looks");
    svg.text((0.0, bottom), Anchor::Start, "small", "cost of the move; ✕ accident");
    Some(svg.finish(&described(&frames)))
}

fn draw_decision(svg: &mut Svg, (frame, lane): (&Arc<Frame>, &LaneFrame), (first, pitch): (u64, f64)) {
    let x = (frame.n - first) as f64 * pitch;
    let looks = lane.read.len();
    let high = (LOOKS - 12.0) * (looks as f64 / MOST).min(1.0);
    let bar = |y: f64, height: f64| Area { x: x + 0.2, y, width: pitch - 0.4, height };
    svg.rect(bar(LOOKS - high - 1.5, high + 1.5), Paint::fill(policy::looks_ink(looks)));
    let deep = (COSTS - 4.0) * (-lane.motor / DEAR).clamp(0.0, 1.0).sqrt();
    svg.rect(bar(LOOKS + 1.0, deep), Paint::fill(Ink("fusion")));
    if lane.accident {
        svg.text((x + pitch / 2.0, LOOKS + COSTS), Anchor::Middle, "value", "✕");
    }
}

fn described(frames: &[Arc<Frame>]) -> String {
    let lanes = || frames.iter().filter_map(|f| f.lanes.first());
    let looks: usize = lanes().map(|l| l.read.len()).sum();
    let accidents = lanes().filter(|l| l.accident).count();
    let mean = looks as f64 / frames.len().max(1) as f64;
    format!("The last {} decisions: {mean:.1} looks each, {accidents} steps with an accident", frames.len())
}
