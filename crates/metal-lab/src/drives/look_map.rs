//! What is looked at where: many motor decisions on the road of learning.

use super::{Garage, picture, sensors_read};
use crate::evaluate::{Candidate, drive};
use crate::plan::Plan;
use crate::registry::Roads;
use crate::results::{LooksMap, MapPoint};
use crate::train::RunError;
use metal_rl::environment::End;
use metal_rl::observe::{Observer, Step};
use metal_worlds::highway::Scenario;

/// About how many decisions are drawn.
const POINTS: usize = 2000;

/// Drives until the map is full.
pub fn draw(garage: &Garage<'_>, driver: &Candidate<'_>) -> Result<LooksMap, RunError> {
    let mut world = garage.world(&Roads::Training, Scenario::Mix);
    let mut map = Map::new(driver.plan);
    let runs = POINTS.div_ceil(garage.config.horizon);
    drive(driver, &mut world, (runs, &garage.streams.child("look map")), &mut map)?;
    Ok(LooksMap { road: picture::outline(world.road()), points: map.points })
}

/// Collects decisions. A step reports where it led, so the place of a decision is where the step before it ended;
/// the first decision of an episode has no such step and is left out.
struct Map<'a> {
    plan: &'a Plan,
    columns: [Option<usize>; 2],
    here: Option<[f64; 2]>,
    points: Vec<MapPoint>,
}

impl<'a> Map<'a> {
    fn new(plan: &'a Plan) -> Self {
        let columns = ["x_m", "y_m"].map(|name| plan.spec.measure(name));
        Self { plan, columns, here: None, points: Vec::with_capacity(POINTS) }
    }

    fn place(&self, step: &Step<'_>) -> Option<[f64; 2]> {
        Some([step.measures[self.columns[0]?], step.measures[self.columns[1]?]])
    }
}

impl Observer for Map<'_> {
    fn on_step(&mut self, step: &Step<'_>) {
        if let Some([x, y]) = self.here {
            let looks = step.percept.read().len() as u32;
            let first = sensors_read(self.plan, step.state.order()).into_iter().next();
            self.points.push(MapPoint { x, y, looks, first });
        }
        self.here = if step.end == End::Running { self.place(step) } else { None };
    }
}
