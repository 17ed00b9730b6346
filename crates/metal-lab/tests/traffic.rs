//! The red cars that ship with Highway-v0 are the ones their experiment trains, but for last digits, and they can drive.
#![allow(clippy::unwrap_used)]

use metal_lab::progress::Silent;
use metal_lab::{registry, traffic};
use metal_rl::environment::Environment;
use metal_rl::random::Rng;
use metal_worlds::highway::road::BORDER_M;
use metal_worlds::highway::{HighwayConfig, RoadSet, Scenario, Steering};

#[test]
fn the_red_cars_stay_on_roads_they_have_never_seen() {
    let config = HighwayConfig::new(RoadSet::Test, Scenario::FromBehind);
    let mut world = registry::highway(&config, traffic::steering());
    let (mut off, mut steps) = (0, 0);
    for seed in 0..40 {
        world.reset(seed).unwrap();
        for _ in 0..50 {
            let advice = world.advise().unwrap();
            world.step(advice).unwrap();
            let car = world.cars()[0];
            off += usize::from(world.road().locate(car.x_m, car.y_m).offset_m.abs() > BORDER_M);
            steps += 1;
        }
    }
    assert!(off * 100 <= steps, "{off} of {steps} steps off the road");
}

#[test]
fn red_cars_that_are_trained_again_decide_as_the_shipped_ones() {
    let frozen = traffic::train(&Silent).unwrap();
    let (Steering::Mind(shipped), Steering::Mind(again)) =
        (traffic::steering(), traffic::steering_by(&frozen).unwrap())
    else {
        panic!("minds drive red cars");
    };
    let mut rng = Rng::new(1);
    for _ in 0..10_000 {
        let vision = std::array::from_fn(|_| rng.uniform());
        assert_eq!(shipped.drive(&vision), again.drive(&vision), "{vision:?}");
    }
    assert!(traffic::steering_by(&frozen[1..]).is_err());
}
