//! Agglomerative clustering with average linkage: the two groups whose members are nearest to each other on average
//! become one, until as many are left as are wanted.

use super::{Groups, in_order};

/// Groups at every stage, from every sensor by itself down to one group of all.
///
/// Of pairs that are equally near the first in order is taken.
#[must_use]
pub fn stages(distances: &[Vec<f64>]) -> Vec<Groups> {
    let mut groups: Groups = (0..distances.len()).map(|i| vec![i]).collect();
    let mut stages = vec![groups.clone()];
    while groups.len() > 1 {
        let (first, second) = nearest(&groups, distances);
        let merged = groups.remove(second);
        groups[first].extend(merged);
        groups = in_order(groups);
        stages.push(groups.clone());
    }
    stages
}

fn nearest(groups: &Groups, distances: &[Vec<f64>]) -> (usize, usize) {
    let (mut best, mut pair) = (f64::INFINITY, (0, 1));
    for second in 1..groups.len() {
        for first in 0..second {
            let d = mean_distance(&groups[first], &groups[second], distances);
            if d < best {
                (best, pair) = (d, (first, second));
            }
        }
    }
    pair
}

/// Mean distance between the members of two groups.
fn mean_distance(first: &[usize], second: &[usize], distances: &[Vec<f64>]) -> f64 {
    let sum: f64 = first.iter().flat_map(|&i| second.iter().map(move |&j| distances[i][j])).sum();
    sum / (first.len() * second.len()) as f64
}

/// `count` groups, or as many as there are sensors.
#[must_use]
pub fn clustered(distances: &[Vec<f64>], count: usize) -> Groups {
    let mut stages = stages(distances);
    let wanted = stages.len().saturating_sub(count.max(1));
    if stages.is_empty() { Groups::new() } else { stages.swap_remove(wanted.min(stages.len() - 1)) }
}

/// Mean silhouette of a partition (Rousseeuw 1987), in [−1, 1]: how much nearer sensors are to their own group than to
/// the nearest other one. A sensor by itself counts 0.
#[must_use]
pub fn silhouette(groups: &Groups, distances: &[Vec<f64>]) -> f64 {
    let one = |(home, &sensor): (usize, &usize)| {
        let mates = groups[home].len() - 1;
        if mates == 0 {
            return 0.0;
        }
        // A sensor is no distance away from itself, so the sum is that over its mates.
        let own: f64 = groups[home].iter().map(|&j| distances[sensor][j]).sum::<f64>() / mates as f64;
        let others = groups.iter().enumerate().filter(|(g, _)| *g != home);
        let near = others.map(|(_, g)| mean_distance(&[sensor], g, distances)).fold(f64::INFINITY, f64::min);
        let widest = own.max(near);
        if widest > 0.0 && widest.is_finite() { (near - own) / widest } else { 0.0 }
    };
    let members = groups.iter().enumerate().flat_map(|(g, group)| group.iter().map(move |s| (g, s)));
    let (sum, count) = members.map(one).fold((0.0, 0), |(sum, n), x| (sum + x, n + 1));
    sum / f64::from(count.max(1))
}

/// The partition into at least 2 and at most `most` groups with the largest mean silhouette; of equals the one with
/// fewer groups.
#[must_use]
pub fn best_silhouette(distances: &[Vec<f64>], most: usize) -> Groups {
    let stages = stages(distances);
    let candidates = stages.iter().rev().filter(|groups| (2..=most.max(2)).contains(&groups.len()));
    let mut best: Option<(f64, &Groups)> = None;
    for groups in candidates {
        let width = silhouette(groups, distances);
        if best.is_none_or(|(widest, _)| width > widest) {
            best = Some((width, groups));
        }
    }
    best.map_or_else(|| clustered(distances, 1), |(_, groups)| groups.clone())
}
