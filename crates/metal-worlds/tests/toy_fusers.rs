//! Fusion rules on the decision-space toy, everybody heard, against an independent implementation of both.

use metal_rl::environment::Environment;
use metal_rl::fuse::{Fuser, Opinion};
use metal_rl::num;
use metal_worlds::toy::{Toy, optimum};

const EPISODES: u64 = 20_000;
const EXPERTS: usize = 7;
const ACTIONS: usize = 5;

/// Mean motor reward and share of right decisions of `fuser`.
fn play(fuser: &Fuser) -> (f64, f64) {
    let mut toy = Toy::new();
    let (mut reward, mut right) = (0.0, 0.0);
    for seed in 0..EPISODES {
        toy.reset(seed).expect("the toy begins");
        let mut supports = [[0.0; ACTIONS]; EXPERTS];
        for (sensor, support) in supports.iter_mut().enumerate() {
            toy.sense(sensor, support).expect("the toy answers");
        }
        let opinions: [Opinion<'_>; EXPERTS] = std::array::from_fn(|agent| Opinion {
            agent,
            proposal: num::argmax(&supports[agent]),
            support: &supports[agent],
        });
        let action = fuser.fuse(&opinions, &mut [0.0; ACTIONS]);
        reward += toy.step(action).expect("the toy moves").motor_reward;
        right += toy.measures()[0];
    }
    (reward / EPISODES as f64, right / EPISODES as f64)
}

#[test]
fn rules_rank_as_they_did_elsewhere() {
    for (fuser, reward, accuracy) in [
        (Fuser::LogOpinionPool, -4.71, 0.824),
        (Fuser::MaxConfidence, -6.06, 0.755),
        (Fuser::Sum, -7.16, 0.750),
        (Fuser::Borda, -8.70, 0.675),
        (Fuser::Majority, -11.66, 0.521),
    ] {
        let ours = play(&fuser);
        // About four standard errors of the two samples' difference.
        assert!((ours.0 - reward).abs() < 0.4 && (ours.1 - accuracy).abs() < 0.02, "{fuser:?}: {ours:?}");
    }
}

#[test]
fn hearing_everybody_costs_more_than_the_optimum_earns() {
    let prices: f64 = Toy::new().spec().sensors.iter().map(|s| s.price).sum();
    assert!((prices - 12.0).abs() < 1e-12);
    assert!(play(&Fuser::LogOpinionPool).0 - prices < 3.0 * optimum().value);
}
