use super::*;

/// Episodes of a test.
const EPISODES: u64 = 20;

/// Motor cost per step of a driver over the episodes from a seed on, and steps in contact.
fn drive(
    config: MiniatureConfig,
    from: u64,
    mut choose: impl FnMut(&mut Miniature) -> usize,
) -> (f64, usize) {
    let mut world = Miniature::new(config);
    let (mut cost, mut contacts) = (0.0, 0);
    for seed in from..from + EPISODES {
        world.reset(seed).unwrap();
        loop {
            let action = choose(&mut world);
            let outcome = world.step(action).unwrap();
            cost -= outcome.motor_reward;
            contacts += usize::from(world.measures()[9] > 0.5);
            if outcome.end != End::Running {
                break;
            }
        }
    }
    (cost / (50 * EPISODES) as f64, contacts)
}

#[test]
fn the_expert_passes_the_objects_and_straight_on_does_not() {
    // Measured on five sets of 20 episodes: the expert costs 3.0 to 4.6 and touches nothing, straight on costs 22.8 to 25.1.
    let config = MiniatureConfig::default();
    let (expert, touched) = drive(config.clone(), 1000, |world| world.advise().unwrap());
    assert!(expert < 6.0 && touched == 0, "{expert}, {touched} contacts");
    let (blind, _) = drive(config, 1000, |_| MotorAction::Medium as usize);
    assert!(blind > 3.0 * expert, "{blind} against {expert}");
}

#[test]
fn wheels_without_deviation_go_where_the_highway_goes_and_others_do_not() {
    for (wheels, same) in [(Wheels::exact(), true), (Wheels::default(), false)] {
        let mut world =
            Miniature::new(MiniatureConfig { obstacles: 0, wheels, ..MiniatureConfig::default() });
        let start = world.learner();
        world.step(MotorAction::TurnLeft as usize).unwrap();
        let end = advance(start, MotorAction::TurnLeft.twist(), crate::highway::kinematics::ACTION_SECS);
        assert_eq!(world.learner().distance_m(&end) < 1e-9, same);
    }
}

#[test]
fn objects_stay_where_they_are_even_when_run_into() {
    let mut world = Miniature::new(MiniatureConfig::default());
    let stand = world.obstacles().to_vec();
    let target = stand[0];
    world.learner = Pose { x_m: target.x_m - 0.1, y_m: target.y_m, heading_rad: 0.0 };
    for _ in 0..4 {
        world.step(MotorAction::Fast as usize).unwrap();
    }
    assert_eq!(world.obstacles(), stand);
    assert!(world.measures()[9] > 0.5, "it was touched");
    assert!(world.learner().distance_m(&target) >= 2.0 * BODY_RADIUS_M - 1e-9);
}
