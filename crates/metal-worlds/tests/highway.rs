//! Laws of the highway as an environment.
#![allow(clippy::float_cmp, reason = "the laws hold bit for bit")]

use metal_rl::environment::{End, Environment};
use metal_rl::random::Rng;
use metal_worlds::highway::{
    Class, Driver, Grid, Highway, HighwayConfig, Pixels, RgbConfig, RoadSet, Scenario, Senses, Situation,
    Start, Steering, VISION,
};
use proptest::prelude::*;
use std::sync::{Arc, LazyLock};

static WORLD: LazyLock<Highway> =
    LazyLock::new(|| Highway::new(HighwayConfig::default(), Steering::Scripted));

fn world(change: impl FnOnce(&mut HighwayConfig)) -> Highway {
    let mut config = HighwayConfig::default();
    change(&mut config);
    Highway::on_roads(config, WORLD.grounds(), Steering::Scripted)
}

fn look(world: &mut Highway, sensor: usize) -> Vec<f64> {
    let mut out = vec![f64::NAN; world.spec().sensors[sensor].features.len()];
    world.sense(sensor, &mut out).expect("a simulated sensor answers");
    out
}

/// Everything that can be known after each of `steps` random actions.
fn future(world: &mut Highway, seed: u64, steps: usize) -> Vec<u64> {
    let mut rng = Rng::new(seed);
    let mut bits = Vec::new();
    for _ in 0..steps {
        let outcome = world.step(rng.below(5)).expect("a simulated motor obeys");
        bits.push(outcome.motor_reward.to_bits());
        bits.extend(world.measures().iter().map(|m| m.to_bits()));
        for sensor in 0..7 {
            bits.extend(look(world, sensor).iter().map(|r| r.to_bits()));
        }
    }
    bits
}

#[test]
fn the_contract_is_the_papers() {
    let spec = WORLD.spec();
    let names: Vec<_> = spec.sensors.iter().map(|s| s.name.as_str()).collect();
    assert_eq!(names, ["MN", "LN", "RN", "MF", "LF", "RF", "IR"]);
    assert_eq!(spec.actions, ["Fast", "Medium", "Slow Down", "Turn Right", "Turn Left"]);
    assert_eq!(spec.sensors.iter().map(|s| s.price).sum::<f64>(), 12.0);
    assert_eq!((spec.id.as_str(), spec.horizon), ("Highway-v0", 50));
    assert_eq!(WORLD.measures().len(), spec.measures.len());
}

#[test]
fn the_same_seed_gives_the_same_bits_and_another_does_not() {
    let run = |seed: u64| {
        let mut world = WORLD.clone();
        world.reset(seed).unwrap();
        future(&mut world, 1, 50)
    };
    assert_eq!(run(3), run(3));
    assert_ne!(run(3), run(4));
}

#[test]
fn the_clock_stops_the_episode_and_nothing_else_does() {
    let mut world = WORLD.clone();
    for seed in 0..20 {
        world.reset(seed).unwrap();
        for step in 1..=50 {
            let end = world.step(0).unwrap().end;
            assert_eq!(end, if step == 50 { End::TimeLimit } else { End::Running });
        }
    }
}

#[test]
fn readings_stay_in_range_and_no_feature_or_measure_of_the_pose_is_constant() {
    let mut world = WORLD.clone();
    let spec = world.spec().clone();
    let mut low = vec![vec![f64::INFINITY; 8]; 7];
    let mut high = vec![vec![f64::NEG_INFINITY; 8]; 7];
    let mut rng = Rng::new(8);
    for seed in 0..150 {
        world.reset(seed).unwrap();
        for _ in 0..50 {
            // Mostly as the expert says: random driving leaves the road and sees nothing but grass.
            let action = if rng.chance(0.3) { rng.below(5) } else { world.advise().unwrap() };
            let outcome = world.step(action).unwrap();
            assert!((-50.0..=0.0).contains(&outcome.motor_reward));
            assert!(world.measures().iter().all(|m| m.is_finite()));
            for (s, sensor) in spec.sensors.iter().enumerate() {
                for (f, (value, feature)) in look(&mut world, s).iter().zip(&sensor.features).enumerate() {
                    assert!((feature.low..=feature.high).contains(value), "{} {}", sensor.name, feature.name);
                    low[s][f] = low[s][f].min(*value);
                    high[s][f] = high[s][f].max(*value);
                }
            }
        }
    }
    for (s, sensor) in spec.sensors.iter().enumerate() {
        for (f, feature) in sensor.features.iter().enumerate() {
            assert!(high[s][f] > low[s][f], "{} {} is constant", sensor.name, feature.name);
        }
    }
}

#[test]
fn fractions_of_a_region_sum_to_one() {
    let mut world = WORLD.clone();
    for seed in 0..50 {
        world.reset(seed).unwrap();
        for sensor in 0..6 {
            assert!((look(&mut world, sensor).iter().sum::<f64>() - 1.0).abs() < 1e-12);
        }
    }
}

#[test]
fn the_situations_of_table_1_look_as_described() {
    let mut world = WORLD.clone();
    let mut see = |situation: Situation, sensor: usize| {
        world.reset_to(0, situation);
        look(&mut world, sensor)
    };
    let (mn, ln, mf) = (0, 1, 3);
    assert_eq!(see(Situation::FreeLeft, mn)[0], 1.0, "all pixels in MN are black");
    assert!(see(Situation::FreeMiddle, mn)[1] > 0.2, "white pixels are seen in MN");
    let red = see(Situation::Blocked, mn)[2];
    assert!(red > 0.0 && red < 0.3, "MN contains a few red pixels: {red}");
    let red = see(Situation::ObstacleLeft, mn)[2];
    assert!(red > 0.0 && red < 0.3, "MN contains a few red pixels: {red}");
    assert!(see(Situation::ObstacleLeft, ln)[2] > red);
    assert!(see(Situation::Blocked, mf)[2] > 0.5);
    assert!(see(Situation::Perpendicular, mf)[3] > 0.3, "grass across the road");
    assert!(see(Situation::CurveFromRoadside, mf)[3] > 0.3, "grass ahead");
    for sensor in 0..6 {
        assert_eq!(see(Situation::FreeLeft, sensor)[2], 0.0);
    }
}

#[test]
fn a_red_car_sees_red_cars_as_red_and_the_learner_as_black() {
    /// Turns left where it sees red, else goes straight.
    struct RedMeansLeft;
    impl Driver for RedMeansLeft {
        fn drive(&self, vision: &[f64; VISION]) -> usize {
            assert!(vision.chunks(4).all(|region| (region.iter().sum::<f64>() - 1.0).abs() < 1e-12));
            if vision.chunks(4).any(|region| region[2] > 0.0) { 4 } else { 0 }
        }
    }
    let mut world =
        Highway::on_roads(HighwayConfig::default(), WORLD.grounds(), Steering::Mind(Arc::new(RedMeansLeft)));
    world.reset_to(0, Situation::Blocked);
    let Start { learner, cars, .. } = Situation::Blocked.start(world.road());
    let mut turned = |car_ahead_is_red: bool| {
        let ahead = learner;
        let mut behind = cars[0];
        // The watcher stands where the learner is ahead of it, or where the other red car is.
        behind.heading_rad = 0.0;
        let at = |x: f64| metal_worlds::highway::Pose { x_m: behind.x_m + x, ..behind };
        let far = metal_worlds::highway::Pose { x_m: ahead.x_m + 50.0, ..ahead };
        let start = Start {
            learner: if car_ahead_is_red { far } else { at(0.2) },
            cars: [at(0.0), if car_ahead_is_red { at(0.2) } else { far }],
            car_count: 2,
        };
        world.place(&start);
        world.step(2).unwrap();
        world.cars()[0].heading_rad.abs() > 1e-9
    };
    assert!(turned(true));
    assert!(!turned(false));
}

#[test]
fn copies_of_a_world_drive_alike_whether_or_not_red_cars_remember_what_they_decided() {
    /// Steers by what it sees.
    struct ByColour {
        asked_each_time: bool,
    }
    impl Driver for ByColour {
        fn drive(&self, vision: &[f64; VISION]) -> usize {
            (vision.iter().zip(1..).map(|(share, k)| share * f64::from(k)).sum::<f64>() * 100.0) as usize % 5
        }
        fn decides_by_sight(&self) -> bool {
            !self.asked_each_time
        }
    }
    fn drive_both(one: &mut Highway, other: &mut Highway, action: usize) {
        let rewards = [&mut *one, other].map(|world| world.step(action).unwrap().motor_reward);
        assert_eq!(rewards[0], rewards[1]);
        assert_eq!((one.learner(), one.cars()), (other.learner(), other.cars()));
    }
    let [mut remembers, mut thinks] = [false, true].map(|asked_each_time| {
        let steering = Steering::Mind(Arc::new(ByColour { asked_each_time }));
        Highway::on_roads(HighwayConfig::default(), WORLD.grounds(), steering)
    });
    for seed in 0..12 {
        remembers.reset(seed).unwrap();
        thinks.reset(seed).unwrap();
        for step in 0..20 {
            // Every action from here, as somebody who judges them does.
            for action in 0..5 {
                let (mut one, mut other) = (remembers.clone(), thinks.clone());
                for k in 0..4 {
                    drive_both(&mut one, &mut other, (action + k) % 5);
                }
            }
            drive_both(&mut remembers, &mut thinks, step % 5);
        }
    }
}

#[test]
fn the_expert_drives_without_accident_and_almost_free() {
    for scenario in Scenario::ALL {
        let mut world = world(|config| config.scenario = scenario);
        let accident = world.spec().measure("accident").unwrap();
        let (mut cost, mut accidents) = (0.0, 0);
        for seed in 0..40 {
            world.reset(seed).unwrap();
            let mut hit = false;
            for _ in 0..50 {
                let action = world.advise().unwrap();
                cost -= world.step(action).unwrap().motor_reward / 2000.0;
                hit |= world.measures()[accident] > 0.0;
            }
            accidents += usize::from(hit);
        }
        assert!(accidents <= 1 && cost < 1.5, "{scenario:?}: {accidents} accidents, cost {cost}");
    }
}

#[test]
fn test_roads_are_longer_and_bend_more_than_the_road_of_learning() {
    let sharpest = |set: RoadSet| -> f64 {
        let grounds = set.build();
        let bend = |g: &metal_worlds::highway::Ground| {
            let arc = g.road().sharpest_arc_m();
            let pose = g.road().pose_at(arc, 0.0, metal_worlds::highway::road::Direction::Along);
            g.road().locate(pose.x_m, pose.y_m).curvature.abs()
        };
        grounds.iter().map(bend).sum::<f64>() / grounds.len() as f64
    };
    assert!(sharpest(RoadSet::Test) > sharpest(RoadSet::Training));
    assert!(RoadSet::Test.build()[0].road().length_m() > WORLD.road().length_m() + 1.0);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn looking_never_changes_the_future(
        seed: u64, looks in prop::collection::vec(prop::collection::vec(0..7_usize, 0..9), 30),
    ) {
        let mut quiet = WORLD.clone();
        quiet.reset(seed).unwrap();
        let mut nosy = quiet.fork().unwrap();
        let mut rng = Rng::new(seed);
        for sensors in &looks {
            let mut out = [0.0; 8];
            for &sensor in sensors {
                let n = nosy.spec().sensors[sensor].features.len();
                nosy.sense(sensor, &mut out[..n]).unwrap();
            }
            let action = rng.below(5);
            prop_assert_eq!(nosy.step(action).unwrap(), quiet.step(action).unwrap());
            prop_assert_eq!(nosy.measures(), quiet.measures());
        }
        for sensor in 0..7 {
            let expected = look(&mut quiet, sensor);
            let mut seen = vec![0.0; expected.len()];
            nosy.sense(sensor, &mut seen).unwrap();
            prop_assert_eq!(expected, seen);
        }
    }

    #[test]
    fn a_fork_has_the_same_future_and_a_life_of_its_own(seed: u64, steps in 0..40_usize) {
        let mut world = WORLD.clone();
        world.reset(seed).unwrap();
        future(&mut world, 2, steps);
        let mut copy = world.clone();
        let expected = future(&mut world.clone(), 3, 8);
        prop_assert_eq!(future(&mut copy, 3, 8), expected.clone());
        prop_assert_eq!(future(&mut world, 3, 8), expected);
    }

    #[test]
    fn both_pixel_paths_agree_to_the_pixel(seed: u64, steps in 0..30_usize) {
        let mut plain = WORLD.clone();
        let mut colour = world(|config| config.pixels = Pixels::Rgb(RgbConfig::default()));
        plain.reset(seed).unwrap();
        colour.reset(seed).unwrap();
        prop_assert_eq!(future(&mut plain, seed, steps), future(&mut colour, seed, steps));
        prop_assert_eq!(plain.class_image(), colour.class_image());
    }

    #[test]
    fn noise_in_the_picture_is_the_same_at_every_look(seed: u64) {
        let rgb = RgbConfig { noise: 0.05, blur: 0.5, light: 0.9, ..RgbConfig::default() };
        let mut world = world(|config| config.pixels = Pixels::Rgb(rgb));
        world.reset(seed).unwrap();
        let first = world.rgb_image();
        for sensor in [3, 0, 3, 5] {
            prop_assert_eq!(look(&mut world, sensor), look(&mut world, sensor));
        }
        prop_assert_eq!(&world.rgb_image(), &first);
        world.step(0).unwrap();
        prop_assert_ne!(&world.rgb_image(), &first);
    }
}

#[test]
fn a_region_and_the_whole_picture_show_the_same_under_blur_and_noise() {
    let rgb = RgbConfig { noise: 0.05, blur: 0.5, ..RgbConfig::default() };
    let mut world = world(|config| config.pixels = Pixels::Rgb(rgb));
    for seed in 0..5 {
        world.reset(seed).unwrap();
        let image = world.class_image();
        for (sensor, region) in metal_worlds::highway::camera::Region::ALL.iter().enumerate() {
            let w = region.window();
            let red = (w.top..w.bottom)
                .flat_map(|r| (w.left..w.right).map(move |c| r * 52 + c))
                .filter(|&i| image[i] == Class::Green)
                .count();
            assert_eq!(look(&mut world, sensor)[3], red as f64 / w.pixels() as f64);
        }
    }
}

#[test]
fn cells_say_together_what_regions_say_and_nothing_else_changes() {
    for rgb in [None, Some(RgbConfig { noise: 0.05, ..RgbConfig::default() })] {
        let pixels = rgb.map_or(Pixels::Classes, Pixels::Rgb);
        let mut regions = world(|config| config.pixels = pixels);
        let mut cells = world(|config| {
            config.pixels = pixels;
            config.senses = Senses::Cells(Grid::default());
        });
        assert_eq!((regions.spec().id.as_str(), cells.spec().id.as_str()), ("Highway-v0", "HighwayCells-v0"));
        let windows = Grid::default().windows();
        for step in 0..30 {
            if step % 10 == 0 {
                for world in [&mut regions, &mut cells] {
                    world.reset(100 + step).unwrap();
                }
            }
            // Pixels of each colour in the whole picture, counted in both ways.
            let counted = |world: &mut Highway, areas: &[usize]| {
                let mut sum = [0.0; 4];
                for (sensor, &pixels) in areas.iter().enumerate() {
                    let shares = look(world, sensor);
                    sum.iter_mut().zip(shares).for_each(|(s, x)| *s += x * pixels as f64);
                }
                sum.map(f64::round)
            };
            let coarse: Vec<usize> =
                metal_worlds::highway::camera::Region::ALL.iter().map(|r| r.window().pixels()).collect();
            let fine: Vec<usize> = windows.iter().map(|w| w.pixels()).collect();
            assert_eq!(counted(&mut regions, &coarse), counted(&mut cells, &fine));
            let ring: Vec<f64> = (24..32).flat_map(|sensor| look(&mut cells, sensor)).collect();
            assert_eq!(look(&mut regions, 6), ring);
            assert_eq!(regions.advise(), cells.advise());
            let action = regions.advise().unwrap();
            assert_eq!(regions.step(action).unwrap(), cells.step(action).unwrap());
            assert_eq!(regions.measures(), cells.measures());
        }
    }
}
