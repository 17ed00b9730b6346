use super::*;
use proptest::prelude::*;

const ACTIONS: usize = 5;

fn every_fuser() -> Vec<Fuser> {
    vec![
        Fuser::MaxConfidence,
        Fuser::LogOpinionPool,
        Fuser::WeightedLogOpinionPool { weights: vec![1.0, 0.5, 2.0, 0.1, 1.0, 1.0, 0.7, 1.0] },
        Fuser::Sum,
        Fuser::Product,
        Fuser::Borda,
        Fuser::Majority,
        Fuser::Owa { weights: vec![0.5, 0.3, 0.2] },
    ]
}

fn support() -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(0.001..1.0_f64, ACTIONS).prop_map(|raw| {
        let total: f64 = raw.iter().sum();
        raw.iter().map(|p| p / total).collect()
    })
}

fn opinions(supports: &[Vec<f64>]) -> Vec<Opinion<'_>> {
    supports
        .iter()
        .enumerate()
        .map(|(agent, support)| Opinion { agent, proposal: num::argmax(support), support })
        .collect()
}

fn fuse(fuser: &Fuser, opinions: &[Opinion<'_>]) -> (usize, [f64; ACTIONS]) {
    let mut combined = [0.0; ACTIONS];
    (fuser.fuse(opinions, &mut combined), combined)
}

proptest! {
    #[test]
    fn the_order_of_agents_does_not_matter(
        supports in prop::collection::vec(support(), 1..8), turn in 0..8_usize
    ) {
        let forward = opinions(&supports);
        let mut turned: Vec<_> = forward.iter().rev().copied().collect();
        turned.rotate_left(turn % supports.len());
        for fuser in every_fuser() {
            let ((a, p), (b, q)) = (fuse(&fuser, &forward), fuse(&fuser, &turned));
            for (x, y) in p.iter().zip(&q) {
                prop_assert!((x - y).abs() < 1e-12, "{fuser:?}");
            }
            // Where sums differ in the last bit only, either action is a fair answer.
            prop_assert!(a == b || (p[a] - p[b]).abs() < 1e-12, "{fuser:?}");
        }
    }

    #[test]
    fn unanimous_agents_win(mut supports in prop::collection::vec(support(), 1..8), winner in 0..ACTIONS) {
        for s in &mut supports {
            let best = num::argmax(s);
            s.swap(best, winner);
        }
        for fuser in every_fuser() {
            prop_assert_eq!(fuse(&fuser, &opinions(&supports)).0, winner, "{:?}", fuser);
        }
    }

    #[test]
    fn the_combined_support_is_a_distribution(supports in prop::collection::vec(support(), 1..8)) {
        for fuser in every_fuser() {
            let (_, combined) = fuse(&fuser, &opinions(&supports));
            prop_assert!((combined.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            prop_assert!(combined.iter().all(|&p| (0.0..=1.0).contains(&p)));
        }
    }

    #[test]
    fn who_knows_nothing_changes_nothing_in_a_pool(supports in prop::collection::vec(support(), 1..7)) {
        let mut more = supports.clone();
        more.push(vec![1.0 / ACTIONS as f64; ACTIONS]);
        for fuser in [Fuser::LogOpinionPool, Fuser::Product, every_fuser().swap_remove(2)] {
            let ((_, p), (_, q)) = (fuse(&fuser, &opinions(&supports)), fuse(&fuser, &opinions(&more)));
            for (x, y) in p.iter().zip(&q) {
                prop_assert!((x - y).abs() < 1e-12);
            }
        }
    }
}

#[test]
fn the_most_confident_agent_wins_even_against_all_others() {
    let (sure, unsure) = ([0.1, 0.6, 0.1, 0.1, 0.1], [0.5, 0.2, 0.1, 0.1, 0.1]);
    let heard = [
        Opinion { agent: 0, proposal: 0, support: &unsure },
        Opinion { agent: 1, proposal: 0, support: &unsure },
        Opinion { agent: 4, proposal: 1, support: &sure },
    ];
    assert_eq!(fuse(&Fuser::MaxConfidence, &heard).0, 1);
    assert_eq!(fuse(&Fuser::Majority, &heard).0, 0);
}

#[test]
fn a_proposal_is_greedy_in_value_and_so_may_differ_from_the_best_supported_action() {
    let support = [0.7, 0.3, 0.0, 0.0, 0.0];
    let heard = [Opinion { agent: 0, proposal: 1, support: &support }];
    assert_eq!(fuse(&Fuser::MaxConfidence, &heard).0, 1);
    assert_eq!(fuse(&Fuser::Sum, &heard).0, 0);
}

#[test]
fn equally_confident_agents_the_lowest_wins_in_any_order() {
    let (a, b) = ([0.4, 0.6, 0.0, 0.0, 0.0], [0.6, 0.4, 0.0, 0.0, 0.0]);
    let first = Opinion { agent: 2, proposal: 1, support: &a };
    let second = Opinion { agent: 5, proposal: 0, support: &b };
    assert_eq!(fuse(&Fuser::MaxConfidence, &[first, second]).0, 1);
    assert_eq!(fuse(&Fuser::MaxConfidence, &[second, first]).0, 1);
}

#[test]
fn a_veto_binds_the_product_but_not_the_pool() {
    let (veto, sure) = ([0.0, 0.25, 0.25, 0.25, 0.25], [0.98, 0.005, 0.005, 0.005, 0.005]);
    let supports = [veto.to_vec(), sure.to_vec(), sure.to_vec()];
    assert_ne!(fuse(&Fuser::Product, &opinions(&supports)).0, 0);
    assert_eq!(fuse(&Fuser::LogOpinionPool, &opinions(&supports)).0, 0);
}

#[test]
fn if_everything_is_vetoed_the_sum_decides() {
    let supports = [vec![0.0, 1.0, 0.0, 0.0, 0.0], vec![0.4, 0.0, 0.2, 0.2, 0.2]];
    assert_eq!(fuse(&Fuser::Product, &opinions(&supports)).0, 1);
}

#[test]
fn an_ordered_average_knows_its_special_cases() {
    let supports =
        [vec![0.9, 0.1, 0.0, 0.0, 0.0], vec![0.0, 0.6, 0.4, 0.0, 0.0], vec![0.1, 0.5, 0.4, 0.0, 0.0]];
    let of = |weights: &[f64]| fuse(&Fuser::Owa { weights: weights.to_vec() }, &opinions(&supports));
    let (max, min, mean) = (of(&[1.0, 0.0, 0.0]), of(&[0.0, 0.0, 1.0]), of(&[1.0]));
    assert_eq!((max.0, min.0, mean.0), (0, 1, 1));
    for (x, y) in mean.1.iter().zip(fuse(&Fuser::Sum, &opinions(&supports)).1) {
        assert!((x - y).abs() < 1e-12);
    }
}

#[test]
fn equal_supports_share_their_borda_points() {
    let supports = [vec![0.5, 0.2, 0.2, 0.1, 0.0]];
    let (_, combined) = fuse(&Fuser::Borda, &opinions(&supports));
    assert_eq!(combined.to_vec(), [0.4, 0.25, 0.25, 0.1, 0.0]);
}

#[test]
fn bad_weights_are_refused() {
    let pool = |weights: &[f64]| Fuser::WeightedLogOpinionPool { weights: weights.to_vec() }.check(2);
    assert_eq!(pool(&[1.0, 0.5]), Ok(()));
    assert_eq!(pool(&[1.0]), Err(FuserError::Count { weights: 1, agents: 2 }));
    assert_eq!(pool(&[1.0, -1.0]), Err(FuserError::Weight { index: 1, value: -1.0 }));
    assert_eq!(Fuser::Owa { weights: vec![0.0, 0.0] }.check(2), Err(FuserError::NoWeight));
    assert_eq!(Fuser::Owa { weights: vec![] }.check(2), Err(FuserError::NoWeight));
}
