//! Who drives where, what is placed where, and which sensors fail.

use super::{Stage, StageError};
use crate::faults::Fault;
use crate::lane::{Lane, world_of};
use metal_rl::num;
use metal_worlds::highway::{Pose, Scenario, Situation, Start};

impl Stage {
    pub(super) fn watch(&mut self, driver: usize) -> Result<(), StageError> {
        if driver >= self.subject.drivers.len() {
            return Err(StageError::Request("there is no such driver"));
        }
        if let Some(body) = &mut self.body {
            body.seat(&mut self.subject, driver)?;
            return self.preview();
        }
        self.end_demonstration()?;
        let (world, step) = (self.lanes[0].world.clone(), self.lanes[0].step);
        let mut lane = Lane::new(&mut self.subject, driver, world)?;
        (lane.step, lane.episode) = (step, self.lanes[0].episode);
        self.lanes[0] = lane;
        self.hub.show_training(false);
        self.look_at_situations()?;
        self.preview()
    }

    /// A second mind, from the same start in the same traffic.
    pub(super) fn compare(&mut self, driver: Option<usize>) -> Result<(), StageError> {
        self.end_demonstration()?;
        self.lanes.truncate(1);
        if let Some(driver) = driver {
            if driver >= self.subject.drivers.len() {
                return Err(StageError::Request("there is no such driver"));
            }
            let world = self.lanes[0].world.clone();
            self.lanes.push(Lane::new(&mut self.subject, driver, world)?);
            self.begin_episode()?;
        }
        self.hub.show_training(false);
        self.preview()
    }

    pub(super) fn choose_scenario(&mut self, name: &str) -> Result<(), StageError> {
        let Some(&scenario) = Scenario::ALL.iter().find(|s| s.name() == name) else {
            return Err(StageError::Request("there is no such scenario"));
        };
        self.scenario = scenario;
        let world = world_of(&self.subject.plan, |config| config.scenario = scenario)?;
        for lane in &mut self.lanes {
            lane.world.world = world.clone();
        }
        self.reset()
    }

    pub(super) fn choose_scene(&mut self, index: usize) -> Result<(), StageError> {
        let Some(&situation) = Situation::ALL.get(index) else {
            return Err(StageError::Request("Table 1 has six situations"));
        };
        let start = situation.start(self.lanes[0].world.world.road());
        self.arrange(&start)?;
        self.clock.run(false);
        self.scene = Some(index);
        self.hub.show_training(false);
        self.preview()
    }

    /// Everybody to where `start` says: a demonstration that goes on begins a new episode there.
    pub(super) fn arrange(&mut self, start: &Start) -> Result<(), StageError> {
        if let Some(demonstration) = &mut self.demonstration {
            demonstration.close_episode(&mut self.lanes[0])?;
        }
        for lane in &mut self.lanes {
            lane.world.world.place(start);
            lane.step = 0;
        }
        Ok(())
    }

    pub(super) fn place(
        &mut self,
        body: usize,
        (x, y): (f64, f64),
        heading: Option<f64>,
    ) -> Result<(), StageError> {
        let world = &self.lanes[0].world.world;
        let mut cars = [Pose::default(); 2];
        let car_count = world.cars().len();
        cars[..car_count].copy_from_slice(world.cars());
        let mut start = Start { learner: world.learner(), cars, car_count };
        let [low, high] = world.road().bounds_m();
        let inside = (low[0]..=high[0]).contains(&x) && (low[1]..=high[1]).contains(&y);
        let moved = match body {
            0 => &mut start.learner,
            n if n <= car_count => &mut start.cars[n - 1],
            _ => return Err(StageError::Request("there is no such car")),
        };
        let heading_rad = heading.map_or(moved.heading_rad, num::wrap_angle);
        if !inside || !heading_rad.is_finite() {
            return Err(StageError::Request("that place is outside the world"));
        }
        *moved = Pose { x_m: x, y_m: y, heading_rad };
        self.clock.run(false);
        self.scene = None;
        self.arrange(&start)?;
        self.preview()
    }

    pub(super) fn set_fault(&mut self, sensor: usize, fault: Fault) -> Result<(), StageError> {
        if sensor >= self.subject.plan.spec.sensors.len() {
            return Err(StageError::Request("there is no such sensor"));
        }
        for lane in &mut self.lanes {
            lane.world.faults[sensor] = fault;
        }
        self.look_at_situations()?;
        self.preview()
    }
}
