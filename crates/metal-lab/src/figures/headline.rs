//! The headline: motor + perceptual cost of every named policy, one chart per scenario, the paper's totals marked.

use super::chart::{Bar, BarChart};
use super::{Figure, policy};
use crate::paper;
use crate::results::Results;

const SCENARIOS: [&str; 4] = ["mix", "free_road", "approaching", "from_behind"];

/// Draws the chart of each scenario that was measured, all on one scale.
#[must_use]
pub fn draw(results: &Results) -> Option<Figure> {
    let charts: Vec<(&str, Vec<Bar>)> =
        SCENARIOS.iter().map(|&s| (s, bars(results, s))).filter(|(_, bars)| !bars.is_empty()).collect();
    let end = charts.iter().flat_map(|(_, bars)| bars).map(farthest).fold(0.0, f64::min);
    let panel = |(scenario, bars): (&str, Vec<Bar>)| {
        let title = policy::scenario_label(scenario).to_owned();
        BarChart { title, axis: "mean cost per motor step (0 is perfect)".to_owned(), end, bars }.draw()
    };
    let panels: Vec<String> = charts.into_iter().map(panel).collect();
    let caption = "Cost per motor step: motor (solid) plus perceptual (pale). Shorter is better; the number at the right is our total. Whiskers: 95 % \
                   interval of the total, cut where it leaves the chart. Diamonds: the paper's Table 2 (10 runs of 50 steps in Webots).";
    (!panels.is_empty()).then(|| Figure { id: "headline", caption: caption.to_owned(), panels })
}

fn bars(results: &Results, scenario: &str) -> Vec<Bar> {
    policy::ORDER.iter().filter_map(|p| bar(results, p, scenario)).collect()
}

fn bar(results: &Results, policy: &str, scenario: &str) -> Option<Bar> {
    let cost = |measure| results.estimate(policy, scenario, measure);
    let (motor, perceptual, total) = (cost("motor")?, cost("perceptual")?, cost("total")?);
    Some(Bar {
        label: policy::short_label(policy),
        ink: policy::ink(policy),
        parts: [motor.mean, perceptual.mean],
        band: total.band(),
        reference: paper::cell(policy, scenario).map(|cell| cell.total),
    })
}

fn farthest(bar: &Bar) -> f64 {
    let sum = bar.parts[0] + bar.parts[1];
    // A huge interval must not press all bars together; it is cut instead.
    let low = bar.band.map_or(sum, |(lo, _)| lo.max(2.0 * sum));
    sum.min(low).min(bar.reference.unwrap_or(0.0))
}
