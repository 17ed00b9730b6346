//! A mind at the wheel of whatever world: one decision after the other, overheard.

use crate::frame::LaneFrame;
use crate::subject::{Subject, SubjectError};
use metal_lab::plan::Plan;
use metal_lab::watched::Overheard;
use metal_rl::environment::{Environment, EnvironmentError};
use metal_rl::member::Member;
use metal_rl::phase::{Phase, Sensing};
use metal_rl::policies::Blind;
use metal_rl::policy::{Heard, Policy};
use metal_rl::random::Streams;
use metal_rl::run::{Decided, Stage, decide};
use metal_rl::set::IndexSet;
use std::sync::Arc;

/// A driver with its mind.
pub struct Seated {
    plan: Arc<Plan>,
    members: Vec<Member>,
    policy: Box<dyn Policy>,
    roster: IndexSet,
    label: String,
}

impl Seated {
    /// Driver `driver` of `subject`.
    ///
    /// # Errors
    /// If its mind cannot be read.
    pub fn new(subject: &mut Subject, driver: usize) -> Result<Self, SubjectError> {
        let row = subject.drivers[driver].clone();
        let mind = subject.mind(&row)?;
        let policy = mind.policy(&subject.plan, &row.acting, row.roster, subject.blind());
        let (plan, members) = (subject.plan.clone(), mind.members.clone());
        Ok(Self { plan, members, policy, roster: row.roster, label: row.label })
    }

    /// What the driver looks at in `world` and would do, written into `frame`; nothing is carried out.
    ///
    /// # Errors
    /// If a sensor fails.
    pub fn think(
        &mut self,
        world: &mut dyn Environment,
        streams: &Streams,
        frame: &mut LaneFrame,
    ) -> Result<(), EnvironmentError> {
        let phase = Phase::evaluation("studio", self.roster, 1);
        frame.driver.clone_from(&self.label);
        self.ponder((world, &phase), None, streams, frame)
    }

    /// A person does `action`, and everybody on the plan's first roster watches (Phase I).
    ///
    /// # Errors
    /// If a sensor fails.
    pub fn watch(
        &mut self,
        action: usize,
        world: &mut dyn Environment,
        streams: &Streams,
        frame: &mut LaneFrame,
    ) -> Result<(), EnvironmentError> {
        let tiny = (0..self.plan.members.len()).filter(|&m| self.plan.members[m].sensors.len() == 1);
        let phase = Phase { sensing: Sensing::Everyone, ..Phase::evaluation("studio", tiny.collect(), 1) };
        "You".clone_into(&mut frame.driver);
        self.ponder((world, &phase), Some(action), streams, frame)
    }

    /// Sensors of member `member`.
    #[must_use]
    pub fn sensors_of(&self, member: usize) -> &[usize] {
        &self.plan.members[member].sensors
    }

    fn ponder(
        &mut self,
        (environment, phase): (&mut dyn Environment, &Phase),
        person: Option<usize>,
        streams: &Streams,
        frame: &mut LaneFrame,
    ) -> Result<(), EnvironmentError> {
        let plan = self.plan.clone();
        let mut ear = |heard: &Heard<'_>| {
            frame.overhear(heard);
            frame.hear(&plan, heard.state);
        };
        let mut pressed = person.map(|action| Blind { action });
        let wheel: &mut dyn Policy = match &mut pressed {
            Some(person) => person,
            None => self.policy.as_mut(),
        };
        let mut policy = Overheard::new(wheel, &mut ear);
        let scaling = self.plan.file.scaling;
        let mut stage = Stage { environment, members: &mut self.members, policy: &mut policy, scaling };
        let Decided { action, look_price, .. } = decide(&mut stage, phase, streams)?;
        (frame.action, frame.look_price) = (action, look_price);
        Ok(())
    }
}
