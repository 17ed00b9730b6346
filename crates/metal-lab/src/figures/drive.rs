//! Fig. 11: reward, moving average (5) and accumulated reward of one drive on a test road.

use super::Figure;
use super::chart::{Ink, LineChart, LinePoint, Series};
use crate::results::Results;

/// Draws the three quantities of Fig. 11.
#[must_use]
pub fn draw(results: &Results) -> Option<Figure> {
    let drive = results.figures.fig11.as_ref().filter(|d| !d.reward.is_empty())?;
    let panels = vec![
        panel("Received reward", &drive.reward),
        panel("Average over a moving window (5)", &drive.moving_average),
        panel("Accumulated reward", &drive.accumulated),
    ];
    let caption = format!(
        "Attention control (the training of median cost) drives on a road it was not trained on ({}), looks included \
         (paper: Fig. 11, on the real miniature road).",
        drive.road
    );
    Some(Figure { id: "fig11", caption, panels })
}

fn panel(title: &str, values: &[f64]) -> String {
    let points = values.iter().enumerate().map(|(i, &y)| LinePoint { x: (i + 1) as f64, y, band: None });
    let series =
        Series { label: String::new(), ink: Ink("acl"), width: 1.4, dashed: false, points: points.collect() };
    LineChart {
        title: title.to_owned(),
        x_label: "motor steps".to_owned(),
        y_label: "reward".to_owned(),
        series: vec![series],
    }
    .draw()
}
