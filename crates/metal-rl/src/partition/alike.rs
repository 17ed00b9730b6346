//! How alike two sensors are: the normalised information distance between their readings.
//!
//! # Formula
//! d(X, Y) = 1 − I(X; Y) / H(X, Y), a metric between 0 (each follows from the other) and 1 (independent), known as
//! Rajski's distance. Unlike a correlation it sees every kind of dependence, and unlike I alone it does not call two sensors
//! alike only because both say much. Readings are cut into a few equal parts of their range.

use super::Shown;
use crate::num;
use std::collections::BTreeMap;

/// Parts into which each number of a reading is cut unless somebody says otherwise. With four parts of four colour
/// shares a cell says some ten different things, which a few hundred moments can count.
pub const LEVELS: usize = 4;

/// What each sensor says at every moment as a small number: equal numbers, equal readings up to `levels` parts.
#[must_use]
pub fn codes(shown: &Shown, levels: usize) -> Vec<Vec<usize>> {
    (0..shown.sensors()).map(|sensor| code(shown, sensor, levels)).collect()
}

fn code(shown: &Shown, sensor: usize, levels: usize) -> Vec<usize> {
    let place = shown.place(sensor);
    let part = |x: &f64| ((x * levels as f64) as usize).min(levels.saturating_sub(1));
    let mut known: BTreeMap<Vec<usize>, usize> = BTreeMap::new();
    (0..shown.len())
        .map(|at| {
            let said: Vec<usize> = shown.moment(at)[place.clone()].iter().map(part).collect();
            let next = known.len();
            *known.entry(said).or_insert(next)
        })
        .collect()
}

/// Entropy in nats of what occurs as often as `counts` say.
fn entropy(counts: impl Iterator<Item = usize>, all: usize) -> f64 {
    let term = |n: usize| {
        let p = n as f64 / all as f64;
        -p * num::ln(p)
    };
    counts.filter(|&n| n > 0).map(term).sum()
}

/// Entropy in nats of one sensor's codes.
#[must_use]
pub fn news(codes: &[usize]) -> f64 {
    let mut counts = vec![0; codes.iter().max().map_or(0, |most| most + 1)];
    codes.iter().for_each(|&code| counts[code] += 1);
    entropy(counts.into_iter(), codes.len())
}

/// Entropy in nats of two sensors' codes together.
#[must_use]
pub fn joint_news(first: &[usize], second: &[usize]) -> f64 {
    let mut counts: BTreeMap<(usize, usize), usize> = BTreeMap::new();
    first.iter().zip(second).for_each(|(&a, &b)| *counts.entry((a, b)).or_default() += 1);
    entropy(counts.into_values(), first.len())
}

/// The distance of two sensors' codes, in [0, 1]. Two sensors that never say anything new are alike.
#[must_use]
pub fn distance(first: &[usize], second: &[usize]) -> f64 {
    let joint = joint_news(first, second);
    if joint <= 0.0 {
        return 0.0;
    }
    let shared = news(first) + news(second) - joint;
    (1.0 - shared / joint).clamp(0.0, 1.0)
}

/// The distances of all sensors from each other, row by row.
#[must_use]
pub fn distances(shown: &Shown, levels: usize) -> Vec<Vec<f64>> {
    let codes = codes(shown, levels);
    let mut all = vec![vec![0.0; codes.len()]; codes.len()];
    for i in 0..codes.len() {
        for j in 0..i {
            let d = distance(&codes[i], &codes[j]);
            (all[i][j], all[j][i]) = (d, d);
        }
    }
    all
}
