//! Learning curves (Fig. 8) and histograms of looks over learning (Fig. 9), mean over seeds.

use super::table::over_seeds;
use crate::results::{CurvePoint, LooksBlock};
use crate::trace::{EpisodeRecord, Trace};
use metal_rl::measure::looks;

/// Blocks of a learning curve: enough to see the shape, few enough to average noise away.
pub const BLOCKS: usize = 24;

/// The learning curve of one policy over several seeds: the traces of its learning phases, one after the other.
#[must_use]
pub fn learning_curve(seeds: &[Vec<&Trace>]) -> Vec<CurvePoint> {
    let runs: Vec<Vec<&EpisodeRecord>> =
        seeds.iter().map(|traces| traces.iter().flat_map(|t| t.episodes.iter()).collect()).collect();
    let episodes = runs.iter().map(Vec::len).min().unwrap_or(0);
    let blocks = BLOCKS.min(episodes);
    (0..blocks)
        .filter_map(|b| {
            let range = b * episodes / blocks..(b + 1) * episodes / blocks;
            let mean = |f: &dyn Fn(&EpisodeRecord) -> f64| {
                let per_seed = runs.iter().map(|r| block_mean(&r[range.clone()], f));
                over_seeds(&per_seed.collect::<Vec<_>>())
            };
            let sums = runs.iter().map(|r| r[..range.end].iter().map(|e| e.motor + e.perceptual).sum());
            Some(CurvePoint {
                block: b as u32,
                episodes: range.end as u32,
                motor: mean(&|e| e.motor)?,
                perceptual: mean(&|e| e.perceptual)?,
                total: mean(&|e| e.motor + e.perceptual)?,
                accumulated: over_seeds(&sums.collect::<Vec<f64>>())?,
            })
        })
        .collect()
}

fn block_mean(block: &[&EpisodeRecord], f: &dyn Fn(&EpisodeRecord) -> f64) -> f64 {
    let steps: usize = block.iter().map(|e| e.steps()).sum();
    block.iter().map(|e| f(e)).sum::<f64>() / steps.max(1) as f64
}

/// Share of motor steps after 0, 1, 2 … looks, over `blocks` parts of learning, all seeds together. Fig. 9.
#[must_use]
pub fn looks_over_learning(traces: &[&Trace], blocks: usize, most: usize) -> Vec<LooksBlock> {
    let episodes = traces.iter().map(|t| t.episodes.len()).min().unwrap_or(0);
    let blocks = blocks.min(episodes);
    (0..blocks)
        .map(|b| {
            let range = b * episodes / blocks..(b + 1) * episodes / blocks;
            let of_block =
                traces.iter().flat_map(|t| t.episodes[range.clone()].iter().flat_map(|e| e.looks.iter()));
            let counts: Vec<usize> = of_block.map(|&l| usize::from(l)).collect();
            let share = looks::histogram(&counts, counts.len().max(1), most);
            let share = share.into_iter().next().map(|h| h.shares).unwrap_or_default();
            LooksBlock { block: b as u32, episodes: range.end as u32, share }
        })
        .collect()
}
