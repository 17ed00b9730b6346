//! Laws of proposals: what was planted is found, whatever the order; every sensor is in exactly one group.

use super::alike::{LEVELS, distance, distances, news};
use super::growth::{Worth, grown};
use super::linkage::{best_silhouette, clustered, silhouette, stages};
use super::telling::Telling;
use super::*;
use crate::random::Rng;
use proptest::prelude::*;

const MOMENTS: usize = 600;

/// Sensors of one number each: sensor i repeats cause `causes[i]` of independent ones, 1 time in 10 something else. The
/// expert acts by cause 0 alone.
fn planted(causes: &[usize], seed: u64) -> Shown {
    let mut rng = Rng::new(seed);
    let mut shown = Shown::of(vec![1; causes.len()]);
    let count = causes.iter().max().unwrap() + 1;
    for at in 0..MOMENTS {
        let truth: Vec<f64> = (0..count).map(|_| rng.below(4) as f64 / 4.0 + 0.1).collect();
        let noisy = |&c: &usize| if rng.below(10) == 0 { rng.below(4) as f64 / 4.0 + 0.1 } else { truth[c] };
        let readings: Vec<f64> = causes.iter().map(noisy).collect();
        shown.add(&readings, usize::from(truth[0] > 0.5), at / 10);
    }
    shown
}

/// The same demonstration with its sensors in another order: sensor i is now `order[i]`'s.
fn shuffled(shown: &Shown, order: &[usize]) -> Shown {
    let mut other = Shown::of(order.iter().map(|&s| shown.widths[s]).collect());
    for at in 0..shown.len() {
        let readings: Vec<f64> =
            order.iter().flat_map(|&s| shown.moment(at)[shown.place(s)].to_vec()).collect();
        other.add(&readings, shown.actions[at], shown.episodes[at]);
    }
    other
}

fn renamed(groups: &Groups, order: &[usize]) -> Groups {
    in_order(groups.iter().map(|g| g.iter().map(|&i| order[i]).collect()).collect())
}

fn by_cause(causes: &[usize]) -> Groups {
    let count = causes.iter().max().unwrap() + 1;
    let members = |c| causes.iter().enumerate().filter(move |(_, k)| **k == c).map(|(i, _)| i).collect();
    in_order((0..count).map(members).collect())
}

/// Two to four causes, each with two to four sensors, in any order.
fn causes() -> impl Strategy<Value = Vec<usize>> {
    prop::collection::vec(2..5_usize, 2..5)
        .prop_map(|sizes| sizes.iter().enumerate().flat_map(|(c, &n)| vec![c; n]).collect::<Vec<usize>>())
        .prop_shuffle()
}

fn order_of(n: usize, seed: u64) -> Vec<usize> {
    let mut rng = Rng::new(seed);
    dealt(n, n, &mut rng).concat().into_iter().rev().collect()
}

proptest! {
    #[test]
    fn planted_clusters_are_found_and_counted_in_any_order(causes in causes(), seed: u64) {
        let shown = planted(&causes, seed);
        let distances = distances(&shown, LEVELS);
        let wanted = by_cause(&causes);
        prop_assert_eq!(&clustered(&distances, wanted.len()), &wanted);
        prop_assert_eq!(&best_silhouette(&distances, causes.len()), &wanted);
        let order = order_of(causes.len(), seed);
        let again = clustered(&super::alike::distances(&shuffled(&shown, &order), LEVELS), wanted.len());
        prop_assert_eq!(renamed(&again, &order), wanted);
    }

    #[test]
    fn what_tells_the_action_is_grown_in_any_order_and_the_rest_is_left(causes in causes(), seed: u64) {
        let shown = planted(&causes, seed);
        let prices = vec![1.0; causes.len()];
        let telling = Telling::of(&shown);
        let groups = grown(&Worth::new(&telling, &prices, 1.0), 2);
        let useful = by_cause(&causes).into_iter().find(|g| causes[g[0]] == 0).unwrap();
        // One was grown, of sensors with a part in the action and no other; what is left may tell something, too.
        let pure = |group: &&Vec<usize>| group.iter().all(|s| useful.contains(s));
        prop_assert!(groups.iter().find(pure).is_some(), "{groups:?}, useful {useful:?}");
        let order = order_of(causes.len(), seed);
        let other = Telling::of(&shuffled(&shown, &order));
        let again = grown(&Worth::new(&other, &prices, 1.0), 2);
        prop_assert_eq!(renamed(&again, &order), groups);
    }

    #[test]
    fn every_sensor_is_in_exactly_one_group(n in 1..12_usize, count in 1..12_usize, seed: u64) {
        let mut rng = Rng::new(seed);
        let shown = planted(&(0..n).collect::<Vec<_>>(), seed);
        let distances = distances(&shown, LEVELS);
        let (telling, prices) = (Telling::of(&shown), vec![0.5; n]);
        let worth = Worth::new(&telling, &prices, 0.5);
        let random = dealt(n, count, &mut rng);
        for groups in [clustered(&distances, count), grown(&worth, count), random.clone()] {
            prop_assert!(groups.len() <= count.max(1));
            let mut all = groups.concat();
            all.sort_unstable();
            prop_assert_eq!(all, (0..n).collect::<Vec<_>>());
        }
        let sizes: Vec<usize> = random.iter().map(Vec::len).collect();
        prop_assert!(sizes.iter().max().unwrap() - sizes.iter().min().unwrap() <= 1);
    }

    #[test]
    fn the_distance_is_a_metric(raw in prop::collection::vec((0..4_usize, 0..3_usize, 0..3_usize), 1..60)) {
        let column = |f: fn(&(usize, usize, usize)) -> usize| raw.iter().map(f).collect::<Vec<_>>();
        let (a, b, c) = (column(|r| r.0), column(|r| r.1), column(|r| r.2));
        prop_assert!(distance(&a, &a) < 1e-9);
        prop_assert!((distance(&a, &b) - distance(&b, &a)).abs() < 1e-12);
        prop_assert!(distance(&a, &c) <= distance(&a, &b) + distance(&b, &c) + 1e-9);
    }

    #[test]
    fn silhouettes_lie_between_minus_one_and_one(causes in causes(), seed: u64) {
        let distances = distances(&planted(&causes, seed), LEVELS);
        for groups in stages(&distances) {
            prop_assert!((-1.0..=1.0).contains(&silhouette(&groups, &distances)));
        }
    }
}

#[test]
fn a_copy_is_no_distance_away_and_an_independent_coin_is_one() {
    let (coin, other): (Vec<usize>, Vec<usize>) = (0..4000).map(|i| (i % 2, i / 2 % 2)).unzip();
    assert!((news(&coin) - crate::num::ln(2.0)).abs() < 1e-12);
    assert!(distance(&coin, &coin) < 1e-12);
    assert!((distance(&coin, &other) - 1.0).abs() < 1e-12);
    assert_eq!(distance(&[0, 0, 0], &[0, 0, 0]), 0.0);
}

#[test]
fn who_shows_the_action_tells_all_of_it_and_noise_tells_nothing() {
    let mut rng = Rng::new(5);
    let mut shown = Shown::of(vec![2, 3]);
    for at in 0..2000 {
        let action = rng.below(2);
        let noise: Vec<f64> = (0..3).map(|_| rng.uniform()).collect();
        shown.add(&[&[action as f64, 0.0][..], &noise].concat(), action, at / 20);
    }
    let telling = Telling::of(&shown);
    assert!(telling.of_group(&[0]) > 0.999, "{}", telling.of_group(&[0]));
    assert!(telling.of_group(&[1]).abs() < 0.02, "{}", telling.of_group(&[1]));
    assert!(telling.of_group(&[]).abs() < 1e-12);
}

#[test]
fn two_halves_of_an_answer_are_put_together() {
    // The action is whether two readings together exceed 1: alone each tells little, together most.
    let mut rng = Rng::new(6);
    let mut shown = Shown::of(vec![1; 4]);
    for at in 0..4000 {
        let x: Vec<f64> = (0..4).map(|_| rng.uniform()).collect();
        shown.add(&x, usize::from(x[1] + x[3] > 1.0), at / 40);
    }
    let (telling, prices) = (Telling::of(&shown), [1.0; 4]);
    assert_eq!(grown(&Worth::new(&telling, &prices, 1.0), 3), [vec![0, 2], vec![1, 3]]);
}

#[test]
fn an_expert_that_never_changes_its_mind_tells_nothing_apart() {
    let mut shown = Shown::of(vec![1, 1]);
    (0..100).for_each(|at| shown.add(&[0.1 * (at % 7) as f64, 0.5], 0, at / 10));
    let (telling, prices) = (Telling::of(&shown), [1.0, 1.0]);
    assert_eq!(telling.of_group(&[0, 1]), 0.0);
    assert_eq!(grown(&Worth::new(&telling, &prices, 1.0), 2), [vec![0, 1]]);
    assert_eq!(grown(&Worth::new(&Telling::of(&Shown::of(vec![1, 1])), &prices, 1.0), 2), [vec![0, 1]]);
}
