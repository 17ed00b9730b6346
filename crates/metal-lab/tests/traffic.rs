//! The red cars that ship with Highway-v0 are the ones their experiment trains, and they can drive.
#![allow(clippy::unwrap_used)]

use metal_lab::progress::Silent;
use metal_lab::{registry, traffic};
use metal_rl::environment::Environment;
use metal_worlds::highway::road::BORDER_M;
use metal_worlds::highway::{HighwayConfig, RoadSet, Scenario};

#[test]
fn the_shipped_mind_is_what_the_experiment_trains() {
    let shipped: &[u8] = include_bytes!("../assets/highway-v0-traffic.mind");
    assert!(
        traffic::train(&Silent).unwrap() == shipped,
        "run `metal train-traffic` only for a new version of the world"
    );
}

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
