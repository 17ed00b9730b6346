//! Sensitivity to seeds: one dot per training.

use super::chart::{Anchor, Area, Axis, Frame, Paint, Svg};
use super::{Figure, policy};
use crate::results::{Results, SeedPoint};

const WIDTH: f64 = 760.0;
const LEFT: f64 = 190.0;
const ROW: f64 = 32.0;

/// Draws one strip per policy.
#[must_use]
pub fn draw(results: &Results) -> Option<Figure> {
    let seeds = &results.figures.sensitivity;
    // The best subset stands for itself; the others are in the front.
    let has_best = seeds.contains_key("best_fixed");
    let policies: Vec<&str> = policy::ordered(seeds.keys())
        .into_iter()
        .filter(|&p| !(seeds[p].is_empty() || has_best && p.starts_with("fixed:")))
        .collect();
    if policies.is_empty() {
        return None;
    }
    let height = policies.len() as f64 * ROW;
    let mut svg = Svg::new(WIDTH, height + 62.0);
    let area = Area { x: LEFT, y: 10.0, width: WIDTH - LEFT - 20.0, height };
    let totals = seeds.values().flatten().map(|s| s.total);
    let x_axis = Axis::around("total cost per motor step, mix of all scenarios", totals);
    let frame = Frame::draw(&mut svg, area, &x_axis, &Axis { label: String::new(), marks: Vec::new() });
    for (i, policy) in policies.iter().enumerate() {
        let y = area.y + (i as f64 + 0.5) * ROW;
        svg.text((LEFT - 12.0, y + 4.0), Anchor::End, "key", &policy::label(policy, results));
        draw_strip(&mut svg, &frame, (y, policy, &seeds[*policy]));
    }
    let caption = "What each training reached: one dot per seed, the bar is their mean.";
    let panels = vec![svg.finish("Total cost by seed")];
    Some(Figure { id: "sensitivity", caption: caption.to_owned(), panels })
}

fn draw_strip(svg: &mut Svg, frame: &Frame, (y, policy, seeds): (f64, &str, &[SeedPoint])) {
    let ink = policy::ink(policy);
    for (i, seed) in seeds.iter().enumerate() {
        // A small shift keeps equal values apart.
        let shift = (i % 3) as f64 * 4.0 - 4.0;
        svg.circle((frame.x.at(seed.total), y + shift), 4.5, Paint::fill(ink).faded(0.65));
    }
    let mean = seeds.iter().map(|s| s.total).sum::<f64>() / seeds.len() as f64;
    let x = frame.x.at(mean);
    svg.line((x, y - 11.0), (x, y + 11.0), Paint::line(ink, 2.5));
}
