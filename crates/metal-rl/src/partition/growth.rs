//! Partition by optimisation: groups are grown, one after the other, each from the sensors that are left, as long as
//! the group gains by another sensor.
//!
//! # Formula
//! A group g is worth T(g) − λ·price(g), where T is what it tells of the expert's action ([`super::telling`]) and
//! λ = thrift · T(all) / price(all): at thrift 1 a group is worth something if it tells more for its price than
//! everything together does. Growing goes on while Σ over groups of their worth rises; what nobody wanted is the last group.
//!
//! Every group is judged by what *it* tells, not by what it adds to the others: a tiny agent has to decide from its own
//! sensors alone. With thrift 0 prices are ignored.

use super::telling::Telling;
use super::{Groups, in_order};

/// Gains below this are noise of the arithmetic.
const LEAST_GAIN: f64 = 1e-9;

/// What is weighed against what.
#[derive(Clone, Copy, Debug)]
pub struct Worth<'a> {
    telling: &'a Telling,
    prices: &'a [f64],
    exchange: f64,
}

impl<'a> Worth<'a> {
    /// Worth of groups of sensors with these prices.
    #[must_use]
    pub fn new(telling: &'a Telling, prices: &'a [f64], thrift: f64) -> Self {
        let all: Vec<usize> = (0..prices.len()).collect();
        let price: f64 = prices.iter().sum();
        let rate = if price > 0.0 { telling.of_group(&all).max(0.0) / price } else { 0.0 };
        Self { telling, prices, exchange: thrift * rate }
    }

    /// Worth of `group`.
    #[must_use]
    pub fn of_group(&self, group: &[usize]) -> f64 {
        let price: f64 = group.iter().map(|&s| self.prices[s]).sum();
        self.telling.of_group(group) - self.exchange * price
    }
}

/// At most `most` groups, the last of which may be what was left over.
#[must_use]
pub fn grown(worth: &Worth<'_>, most: usize) -> Groups {
    let mut left: Vec<usize> = (0..worth.prices.len()).collect();
    let mut groups = Groups::new();
    while groups.len() + 1 < most && !left.is_empty() {
        let group = grow(worth, &mut left);
        if group.is_empty() {
            break;
        }
        groups.push(group);
    }
    groups.push(left);
    in_order(groups)
}

/// One group, taken out of `left`; empty if nothing left is worth its price.
fn grow(worth: &Worth<'_>, left: &mut Vec<usize>) -> Vec<usize> {
    let (mut group, mut now) = (Vec::new(), 0.0);
    while let Some((place, better)) = best_addition(worth, &group, left) {
        if better < now + LEAST_GAIN {
            break;
        }
        group.push(left.remove(place));
        now = better;
    }
    group
}

/// Which of `left` makes the group worth most, and how much; of equals the first.
fn best_addition(worth: &Worth<'_>, group: &[usize], left: &[usize]) -> Option<(usize, f64)> {
    let mut best: Option<(usize, f64)> = None;
    for (place, &sensor) in left.iter().enumerate() {
        let with: Vec<usize> = group.iter().copied().chain([sensor]).collect();
        let value = worth.of_group(&with);
        if best.is_none_or(|(_, most)| value > most) {
            best = Some((place, value));
        }
    }
    best
}
