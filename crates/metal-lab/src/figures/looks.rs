//! Fig. 9: how many looks are taken before a decision, over learning.

use super::chart::{StackChart, StackColumn};
use super::{Figure, number, policy};
use crate::results::{LooksBlock, Results};

/// Width of the drawing, in pixels.
const WIDTH: f64 = 760.0;

/// Draws one column per block of episodes.
#[must_use]
pub fn draw(results: &Results) -> Option<Figure> {
    let blocks = &results.figures.looks_histograms;
    let layers = blocks.iter().map(|b| b.share.len()).max()?;
    let chart = StackChart {
        title: "Looks before each motor decision".to_owned(),
        x_label: "episodes".to_owned(),
        layers: (0..layers).map(|k| (name(k), policy::looks_ink(k))).collect(),
        width: WIDTH,
        columns: blocks.iter().map(column).collect(),
    };
    let caption = format!(
        "Share of motor decisions taken after 0, 1, 2, … looks, from the start of attention control to its end \
         (paper: Fig. 9). Mean number of looks in the last block: {} of 7 (paper: 2.1).",
        number::fixed(mean_looks(blocks.last()?), 2)
    );
    Some(Figure { id: "fig9", caption, panels: vec![chart.draw()] })
}

fn name(looks: usize) -> String {
    match looks {
        0 => "no look".to_owned(),
        1 => "1 look".to_owned(),
        k => format!("{k} looks"),
    }
}

fn column(block: &LooksBlock) -> StackColumn {
    StackColumn { label: block.episodes.to_string(), shares: block.share.clone() }
}

fn mean_looks(block: &LooksBlock) -> f64 {
    block.share.iter().enumerate().map(|(k, share)| k as f64 * share).sum()
}
