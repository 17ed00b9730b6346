//! Fig. 11: reward of one drive on a road that nobody learned on.

use super::Garage;
use crate::evaluate::{Candidate, drive};
use crate::registry::{Roads, roads_name};
use crate::results::TestDrive;
use crate::train::RunError;
use metal_rl::measure::curve::{accumulated, moving_average};
use metal_rl::observe::{Observer, Step};
use metal_worlds::highway::{Highway, Scenario};

/// Motor steps of the drive, enough for the road's bends and more than one meeting.
const STEPS: usize = 150;
/// "Average reward in moving window (5)".
const WINDOW: usize = 5;

/// One drive towards a red car (the paper's road had red obstacles, too).
pub fn record(garage: &Garage<'_>, driver: &Candidate<'_>) -> Result<TestDrive, RunError> {
    let mut world = garage.longer_world(&Roads::Test, Scenario::Approaching, STEPS);
    let mut rewards = Rewards::default();
    drive(driver, &mut world, (1, &garage.streams.child("test drive")), &mut rewards)?;
    let Rewards(reward) = rewards;
    Ok(TestDrive {
        road: road_name(&world),
        moving_average: moving_average(&reward, WINDOW),
        accumulated: accumulated(&reward),
        reward,
    })
}

/// The road the world is on, counted from 1.
fn road_name(world: &Highway) -> String {
    let grounds = world.grounds();
    let index = grounds.iter().position(|ground| std::ptr::eq(ground.road(), world.road()));
    format!("{} {}", roads_name(&Roads::Test), index.map_or(0, |i| i + 1))
}

/// Reward of every motor step, looks included.
#[derive(Default)]
struct Rewards(Vec<f64>);

impl Observer for Rewards {
    fn on_step(&mut self, step: &Step<'_>) {
        self.0.push(step.motor_reward - step.look_price);
    }
}
