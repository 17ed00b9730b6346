//! One car on the stage: a mind, a world of its own, and one decision after the other.

use crate::faults::Faulty;
use crate::frame::LaneFrame;
use crate::seated::Seated;
use crate::subject::{Subject, SubjectError};
use metal_lab::plan::Plan;
use metal_lab::registry::highway;
use metal_rl::environment::{End, Environment, EnvironmentError, Outcome};
use metal_rl::random::Streams;
use metal_worlds::highway::{Highway, HighwayConfig};

/// A car and who drives it.
pub struct Lane {
    /// Index among the drivers.
    pub driver: usize,
    /// The world, with its faults.
    pub world: Faulty,
    /// Motor steps of this episode.
    pub step: usize,
    /// Episodes of this drive.
    pub episode: usize,
    seated: Seated,
    seed: u64,
}

/// The highway of a plan.
///
/// # Errors
/// If the plan's world is none.
pub fn world_of(plan: &Plan, change: impl FnOnce(&mut HighwayConfig)) -> Result<Highway, SubjectError> {
    let Some((config, steering)) = plan.file.environment.as_highway() else {
        return Err(SubjectError::NoRoad(plan.spec.id.clone()));
    };
    let mut config = config.clone();
    change(&mut config);
    Ok(highway(&config, steering))
}

impl Lane {
    /// `driver` in `world`.
    ///
    /// # Errors
    /// If its mind cannot be read.
    pub fn new(subject: &mut Subject, driver: usize, world: Faulty) -> Result<Self, SubjectError> {
        Ok(Self { driver, world, step: 0, episode: 0, seated: Seated::new(subject, driver)?, seed: 0 })
    }

    /// Begins episode `seed` from its own start.
    ///
    /// # Errors
    /// If the world fails.
    pub fn reset(&mut self, seed: u64) -> Result<(), EnvironmentError> {
        (self.step, self.seed) = (0, seed);
        self.world.reset(seed)
    }

    /// What the driver looks at and would do where the world stands; nothing is carried out.
    ///
    /// # Errors
    /// If a sensor fails.
    pub fn think(&mut self) -> Result<LaneFrame, EnvironmentError> {
        let (mut frame, streams) = self.outset();
        self.seated.think(&mut self.world, &streams, &mut frame)?;
        Ok(frame)
    }

    /// A person moves, and everybody on the plan's first roster watches (Phase I).
    ///
    /// # Errors
    /// If a sensor fails.
    pub fn watch(&mut self, action: usize) -> Result<LaneFrame, EnvironmentError> {
        let (mut frame, streams) = self.outset();
        self.seated.watch(action, &mut self.world, &streams, &mut frame)?;
        frame.advice = self.world.advise();
        // Phase I pays for nothing: the prices of attention come later.
        frame.look_price = 0.0;
        Ok(frame)
    }

    /// Where the world stands, before anybody looked.
    fn outset(&mut self) -> (LaneFrame, Streams) {
        let mut frame = LaneFrame::default();
        frame.see(&mut self.world.world);
        frame.to.clone_from(&frame.from);
        (frame, Streams::new(self.seed).nth(self.step as u64))
    }

    /// Carries out what `frame` decided.
    ///
    /// # Errors
    /// If the world fails.
    pub fn act(&mut self, frame: &mut LaneFrame) -> Result<Outcome, EnvironmentError> {
        let outcome = self.world.step(frame.action)?;
        self.step += 1;
        frame.motor = outcome.motor_reward;
        frame.settle(&self.world.world);
        Ok(outcome)
    }

    /// Whether the next step needs a new episode.
    #[must_use]
    pub fn is_over(outcome: &Outcome) -> bool {
        outcome.end != End::Running
    }

    /// Everything all sensors say now, in their own units.
    ///
    /// # Errors
    /// If a sensor fails.
    pub fn readings(&mut self) -> Result<Vec<Vec<f64>>, EnvironmentError> {
        let shapes: Vec<usize> = self.world.spec().sensors.iter().map(|s| s.features.len()).collect();
        let mut read = |(sensor, n): (usize, &usize)| {
            let mut out = vec![0.0; *n];
            self.world.sense(sensor, &mut out).map(|()| out)
        };
        shapes.iter().enumerate().map(&mut read).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::subject::paper;
    use metal_worlds::highway::Situation;

    fn subject(name: &str) -> Subject {
        let out = std::env::temp_dir().join(format!("metal-studio-{name}-{}", std::process::id()));
        Subject::experiment(paper().unwrap(), &out).unwrap()
    }

    #[test]
    fn thinking_leaves_the_world_as_it_is_and_a_step_does_what_was_thought() {
        let mut subject = subject("think");
        let world = Faulty::new(world_of(&subject.plan, |_| {}).unwrap());
        let driver = subject.first_driver();
        let mut lane = Lane::new(&mut subject, driver, world).unwrap();
        lane.reset(4).unwrap();
        let (first, mut again) = (lane.think().unwrap(), lane.think().unwrap());
        assert_eq!(serde_json::to_string(&first).unwrap(), serde_json::to_string(&again).unwrap());
        assert_eq!(first.from, first.to);
        assert_eq!(first.image.len(), 39);
        lane.act(&mut again).unwrap();
        assert_ne!(again.from, again.to);
        assert!(again.motor <= 0.0);
        assert_eq!(lane.think().unwrap().from, again.to);
    }

    #[test]
    fn everybody_watches_a_person_and_nobody_pays() {
        let mut subject = subject("watch");
        let world = Faulty::new(world_of(&subject.plan, |_| {}).unwrap());
        let mut lane = Lane::new(&mut subject, 0, world).unwrap();
        lane.world.world.reset_to(0, Situation::Blocked);
        let frame = lane.watch(2).unwrap();
        assert_eq!((frame.action, frame.read.len(), frame.look_price), (2, 7, 0.0));
        assert!(frame.advice.is_some());
        assert_eq!(frame.opinions.iter().flatten().count(), 7);
        assert_eq!(lane.readings().unwrap().len(), 7);
    }
}
