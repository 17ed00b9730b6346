//! The driver: the recipe's own student, made to look at everybody before every move.

use super::{CeilingOptions, subject::Subject};
use crate::mind::Mind;
use crate::progress::Progress;
use crate::registry::Roads;
use crate::teach::Pool;
use crate::train::RunError;
use metal_rl::counterfactual::{School, Student, iterate};
use metal_rl::environment::Environment;
use metal_rl::explore::Schedule;
use metal_rl::observe::{Observer, Step};
use metal_rl::phase::{Budget, Phase};
use metal_rl::random::Streams;

/// Tells how far it is, after every episode.
pub(super) struct Counting<'a> {
    pub progress: &'a dyn Progress,
    pub steps: usize,
}

impl Observer for Counting<'_> {
    fn on_step(&mut self, _step: &Step<'_>) {
        self.steps += 1;
    }

    fn on_episode(&mut self, _episode: usize, _progress: f64) {
        self.progress.steps(std::mem::take(&mut self.steps));
    }
}

/// Lets `teach` have the subject's world with its validation world and newborn members.
pub(super) fn in_school<T>(
    subject: &Subject<'_>,
    streams: &Streams,
    progress: &dyn Progress,
    teach: impl FnOnce(&mut School<'_>) -> Result<T, RunError>,
) -> Result<T, RunError> {
    let plan = subject.plan;
    let mut world = plan.file.environment.build()?;
    let scenario = plan.file.environment.training_scenario();
    let mut validation = plan.environment(&scenario, Some(&Roads::Validation)).build()?;
    let mut mind = Mind::newborn(plan, streams)?;
    teach(&mut School {
        environment: world.as_mut() as &mut dyn Environment,
        validation: validation.as_mut(),
        members: &mut mind.members,
        roster: subject.slots.clone(),
        scaling: plan.file.scaling,
        workers: &Pool,
        interrupted: &|| progress.interrupted(),
        ear: &mut |_| {},
    })
}

/// A driver that was taught anew.
pub(super) fn taught(
    subject: &Subject<'_>,
    options: &CeilingOptions,
    streams: &Streams,
    progress: &dyn Progress,
) -> Result<Student, RunError> {
    let phase = Phase {
        exploration: Schedule::Random { from: 0.5, to: 0.1, until: 0.6 },
        budget: Budget::Steps(options.driver_steps),
        ..Phase::evaluation("driver", subject.roster(), 0)
    };
    let config = subject.driver_config(options);
    let mut counting = Counting { progress, steps: 0 };
    in_school(subject, streams, progress, |school| {
        let graduate = iterate(school, &config, &phase, &streams.child("driver"), &mut counting)?;
        Ok(graduate.policy.student().clone())
    })
}
