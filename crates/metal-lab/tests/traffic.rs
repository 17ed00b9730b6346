//! The red cars that ship with Highway-v0 can drive, and so can those that their experiment trains today.
#![allow(clippy::unwrap_used)]

use metal_lab::progress::Silent;
use metal_lab::{registry, traffic};
use metal_rl::environment::Environment;
use metal_worlds::highway::road::BORDER_M;
use metal_worlds::highway::{HighwayConfig, RoadSet, Scenario, Steering};

/// At most one step in a hundred off roads that nobody has ever seen.
fn stay_on_the_road(steering: Steering) {
    let config = HighwayConfig::new(RoadSet::Test, Scenario::FromBehind);
    let mut world = registry::highway(&config, steering);
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
fn the_red_cars_stay_on_roads_they_have_never_seen() {
    stay_on_the_road(traffic::steering());
}

#[test]
fn red_cars_that_are_trained_today_drive_by_the_same_plan_and_stay_on_the_road_too() {
    let frozen = traffic::train(&Silent).unwrap();
    stay_on_the_road(traffic::steering_by(&frozen).unwrap());
    assert!(traffic::steering_by(&frozen[1..]).is_err());
}
