//! Return against cost: what an additional look is worth, and how much of the way to the full observer is made for how
//! much of its price.

use super::rows::{ALL, BLIND, METAL};
use super::{Row, Static};
use crate::task::Score;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A driver as a point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Who.
    pub name: String,
    /// Price of the looks of an episode, at the task's own prices.
    pub cost: f64,
    /// Motor reward of an episode.
    pub motor: f64,
}

/// METAL's front and that of the fixed subsets.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Front {
    /// METAL at the task's prices and at others.
    pub metal: Vec<Point>,
    /// Fixed subsets, screened with a share of the budget, and the confirmed best.
    pub fixed: Vec<Point>,
    /// Normalised area below METAL's front.
    pub metal_area: f64,
    /// Normalised area below the front of the fixed subsets.
    pub fixed_area: f64,
}

fn point(name: &str, scores: &[Score]) -> Point {
    let mean = |f: fn(&Score) -> f64| scores.iter().map(f).sum::<f64>() / scores.len().max(1) as f64;
    Point { name: name.to_owned(), cost: mean(Score::mean_price), motor: mean(Score::mean_motor) }
}

/// Both fronts. `extra`: METAL at other prices, with its cost at the task's own.
pub(super) fn front(rows: &BTreeMap<String, Row>, statics: &[Static], extra: &[(f64, Vec<Score>)]) -> Front {
    let (blind, all) = (point(BLIND, &rows[BLIND].scores), point(ALL, &rows[ALL].scores));
    let mut metal = vec![point(METAL, &rows[METAL].scores)];
    metal.extend(extra.iter().map(|(factor, scores)| point(&format!("{METAL}, prices x {factor}"), scores)));
    let mut fixed: Vec<Point> =
        statics.iter().map(|s| point(&s.name, std::slice::from_ref(&s.score))).collect();
    fixed.push(point(super::rows::STATIC, &rows[super::rows::STATIC].scores));
    let metal_area = area(&metal, &blind, &all);
    let fixed_area = area(&fixed, &blind, &all);
    Front { metal, fixed, metal_area, fixed_area }
}

/// Area below the best motor reward that can be had for at most a given cost, with cost from 0 to that of all sensors
/// and motor reward from blind (0) to all sensors (1). Blind is always to be had. Can exceed 1 if somebody beats the
/// full observer.
fn area(points: &[Point], blind: &Point, all: &Point) -> f64 {
    let (width, height) = (all.cost, all.motor - blind.motor);
    if width <= 0.0 || height <= 0.0 {
        return f64::NAN;
    }
    let mut sorted: Vec<&Point> = points.iter().filter(|p| p.cost <= width).collect();
    sorted.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let (mut best, mut at, mut sum) = (0.0_f64, 0.0, 0.0);
    for p in sorted {
        sum += best * (p.cost / width - at);
        at = p.cost / width;
        best = best.max((p.motor - blind.motor) / height);
    }
    sum + best * (1.0 - at)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(cost: f64, motor: f64) -> Point {
        Point { name: String::new(), cost, motor }
    }

    #[test]
    fn the_area_is_that_of_the_steps() {
        let (blind, all) = (at(0.0, -10.0), at(4.0, 0.0));
        assert!((area(&[at(1.0, 0.0)], &blind, &all) - 0.75).abs() < 1e-12);
        assert!((area(&[at(1.0, -5.0), at(2.0, 0.0)], &blind, &all) - (0.125 + 0.5)).abs() < 1e-12);
        assert_eq!(area(&[], &blind, &all), 0.0);
        assert_eq!(area(&[at(9.0, 0.0)], &blind, &all), 0.0);
        assert!(area(&[], &blind, &blind).is_nan());
    }
}
