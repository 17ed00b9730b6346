//! Where a mixture begins: components far from each other, at moments drawn by k-means++.

use super::density::{Component, Density};
use super::em::{Moments, Prior};
use crate::random::Rng;
use std::ops::Range;

/// Moments that are compared to find the first means, at most.
const COMPARED: usize = 4000;

/// What a moment without a block differs by from one with it, per feature: as two that have nothing to do with each
/// other, in variances.
const STRANGE: f64 = 2.0;

/// A density of `components` with `factors` directions over `blocks`, near `moments`.
pub(super) fn start(
    (blocks, factors, components): (Vec<Range<usize>>, usize, usize),
    moments: &Moments,
    prior: &Prior,
    rng: &mut Rng,
) -> Density {
    let seeds = spread_out((&blocks, components), moments, prior, rng);
    let weight = 1.0 / seeds.len() as f64;
    let components: Vec<Component> =
        seeds.iter().map(|&n| newborn((&blocks, factors, weight), moments.row(n), prior, rng)).collect();
    Density::new(blocks, factors, &components)
}

/// A component around one moment.
pub(super) fn newborn(
    (blocks, factors, weight): (&[Range<usize>], usize, f64),
    (x, seen): (&[f64], &[bool]),
    prior: &Prior,
    rng: &mut Rng,
) -> Component {
    let mut means = prior.means.clone();
    for block in blocks.iter().zip(seen).filter(|(_, seen)| **seen).map(|(block, _)| block.clone()) {
        means[block.clone()].copy_from_slice(&x[block]);
    }
    let noises = prior.variances.iter().map(|v| v * f64::max(0.3, prior.least)).collect();
    let stretch = |variance: &f64| 0.3 * (variance / factors as f64).sqrt();
    let loadings = prior.variances.iter().flat_map(|v| vec![stretch(v); factors]);
    let loadings = loadings.map(|scale| scale * rng.normal()).collect();
    Component { weight, means, noises, loadings }
}

/// Moments far from each other: each is drawn with a probability in proportion to the squared distance to the nearest
/// one before it.
fn spread_out(
    (blocks, wanted): (&[Range<usize>], usize),
    moments: &Moments,
    prior: &Prior,
    rng: &mut Rng,
) -> Vec<usize> {
    let compared = moments.count.min(COMPARED);
    let candidates: Vec<usize> = (0..compared).map(|i| i * moments.count / compared).collect();
    let mut chosen = vec![candidates[rng.below(compared)]];
    let mut nearest = vec![f64::INFINITY; compared];
    while chosen.len() < wanted.min(compared) {
        let last = moments.row(chosen[chosen.len() - 1]);
        for (nearest, &n) in nearest.iter_mut().zip(&candidates) {
            *nearest = nearest.min(distance(blocks, prior, last, moments.row(n)));
        }
        let sum: f64 = nearest.iter().sum();
        if sum <= 0.0 {
            break;
        }
        let mut left = rng.uniform() * sum;
        let at = nearest.iter().position(|&d| {
            left -= d;
            left < 0.0
        });
        chosen.push(candidates[at.unwrap_or(compared - 1)]);
    }
    chosen
}

/// Squared distance in variances.
fn distance(
    blocks: &[Range<usize>],
    prior: &Prior,
    (a, a_seen): (&[f64], &[bool]),
    (b, b_seen): (&[f64], &[bool]),
) -> f64 {
    let mut sum = 0.0;
    for (n, block) in blocks.iter().enumerate() {
        if a_seen[n] && b_seen[n] {
            let gap = |i: usize| (a[i] - b[i]) * (a[i] - b[i]) / prior.variances[i];
            sum += block.clone().map(gap).sum::<f64>();
        } else if a_seen[n] != b_seen[n] {
            sum += STRANGE * block.len() as f64;
        }
    }
    sum
}
