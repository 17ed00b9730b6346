//! Fig. 8: accumulated reward and moving average over learning.

use super::chart::{LineChart, LinePoint, Series};
use super::{Figure, policy};
use crate::results::{CurvePoint, Estimate, Results};

/// Drawn from below to above; the most important comes last.
const DRAWN: [&str; 6] = ["acl_paper", "acl_phase3", "fusion_log_pool", "foa", "fusion", "acl"];

/// Draws the accumulated reward, the reward per block, and its motor part.
#[must_use]
pub fn draw(results: &Results) -> Option<Figure> {
    let curves = &results.figures.learning_curves;
    if curves.values().all(Vec::is_empty) {
        return None;
    }
    let panels = vec![
        panel(results, ("Accumulated reward", "sum since the start"), |p| &p.accumulated),
        panel(results, ("Moving average of the reward", "total per motor step"), |p| &p.total),
        panel(results, ("Motor part alone", "motor cost per motor step"), |p| &p.motor),
        panel(results, ("Price paid for looking", "perceptual cost per motor step"), |p| &p.perceptual),
    ];
    let caption = "Reward during learning, mean over trainings with its 95 % interval, cut where it leaves the chart (paper: Fig. 8, five runs). \
                   FOA and fusion always pay for all they see; attention control learns what to pay for.";
    Some(Figure { id: "fig8", caption: caption.to_owned(), panels })
}

fn panel(results: &Results, (title, y_label): (&str, &str), value: fn(&CurvePoint) -> &Estimate) -> String {
    let curves = &results.figures.learning_curves;
    let series = DRAWN.iter().filter_map(|&p| Some(series(results, p, curves.get(p)?, value)));
    LineChart {
        title: title.to_owned(),
        x_label: "episodes".to_owned(),
        y_label: y_label.to_owned(),
        series: series.collect(),
    }
    .draw()
}

fn series(
    results: &Results,
    policy: &str,
    curve: &[CurvePoint],
    value: fn(&CurvePoint) -> &Estimate,
) -> Series {
    let point = |p: &CurvePoint| {
        let estimate = value(p);
        LinePoint { x: f64::from(p.episodes), y: estimate.mean, band: estimate.band() }
    };
    Series {
        label: policy::label(policy, results),
        ink: policy::ink(policy),
        width: if policy == "acl" { 2.8 } else { 1.8 },
        dashed: policy == "fusion",
        points: curve.iter().map(point).collect(),
    }
}
