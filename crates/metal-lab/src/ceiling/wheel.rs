//! At the wheel: the students of the log drive themselves. What the ceiling leaves out, they meet.

use super::replay::Fixed;
use super::subject::Subject;
use crate::evaluate::measures;
use crate::mind::Mind;
use crate::progress::Progress;
use crate::trace::{Trace, Watcher};
use crate::train::RunError;
use metal_rl::counterfactual::Student;
use metal_rl::counterfactual::student::rule::Rule;
use metal_rl::environment::EnvironmentSpec;
use metal_rl::observe::{Observer, Step};
use metal_rl::phase::Phase;
use metal_rl::policies::Counterfactual;
use metal_rl::random::Streams;
use metal_rl::run::{Stage, run};
use std::collections::BTreeMap;

/// Where students drive.
pub(super) struct Wheel<'a> {
    pub subject: &'a Subject<'a>,
    pub runs: usize,
    /// The same episodes for everybody.
    pub streams: Streams,
    pub progress: &'a dyn Progress,
}

/// A test at the wheel, per motor step.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Drive {
    /// Motor reward.
    pub motor: f64,
    /// Price of looks.
    pub price: f64,
    /// Looks, in slots.
    pub looks: f64,
    /// Share of episodes with an accident.
    pub accidents: f64,
    /// What the motor cost is for, where the world says so.
    pub causes: BTreeMap<String, f64>,
}

impl Drive {
    /// Motor reward minus price.
    pub fn total(&self) -> f64 {
        self.motor - self.price
    }
}

impl Wheel<'_> {
    /// `student` under a fixed choice of looks, or with its own.
    pub fn drive(&self, student: &Student, choice: Option<Fixed>) -> Result<Drive, RunError> {
        let plan = self.subject.plan;
        let rule = choice.map(|c| Rule::Scheduled { slots: c.slots, every: c.every });
        let student = rule.map_or_else(|| student.clone(), |rule| student.under(rule));
        let mut policy = Counterfactual::new(student, self.subject.slots.clone());
        let mut world = plan.file.environment.build()?;
        let mut members = Mind::newborn(plan, &self.streams)?.members;
        let mut stage = Stage {
            environment: world.as_mut(),
            members: &mut members,
            policy: &mut policy,
            scaling: plan.file.scaling,
        };
        let watcher = Watcher { trace: Trace::new(&plan.spec), progress: self.progress };
        let mut witness = Witness { watcher, causes: causes(&plan.spec), looks: 0.0, steps: 0.0 };
        run(
            &mut stage,
            &Phase::evaluation("wheel", self.subject.roster(), self.runs),
            &self.streams,
            &mut witness,
        )?;
        if self.progress.interrupted() { Err(RunError::Interrupted) } else { Ok(witness.report()) }
    }
}

/// What a world says that its costs are for: its measures `cost_…`, by their column.
fn causes(spec: &EnvironmentSpec) -> Vec<(String, usize, f64)> {
    let cost = |(column, name): (usize, &String)| Some((name.strip_prefix("cost_")?.to_owned(), column, 0.0));
    spec.measures.iter().enumerate().filter_map(cost).collect()
}

struct Witness<'a> {
    watcher: Watcher<'a>,
    causes: Vec<(String, usize, f64)>,
    looks: f64,
    steps: f64,
}

impl Observer for Witness<'_> {
    fn on_step(&mut self, step: &Step<'_>) {
        self.watcher.on_step(step);
        self.steps += 1.0;
        self.looks += step.state.attended().len() as f64;
        for (_, column, sum) in &mut self.causes {
            *sum += step.measures[*column];
        }
    }

    fn on_episode(&mut self, episode: usize, progress: f64) {
        self.watcher.on_episode(episode, progress);
    }
}

impl Witness<'_> {
    fn report(self) -> Drive {
        let steps = self.steps.max(1.0);
        let episodes = &self.watcher.trace.episodes;
        let accident = measures(episodes).into_iter().find(|(name, _)| *name == "accident_rate");
        Drive {
            motor: episodes.iter().map(|e| e.motor).sum::<f64>() / steps,
            price: -episodes.iter().map(|e| e.perceptual).sum::<f64>() / steps,
            looks: self.looks / steps,
            accidents: accident.map_or(0.0, |(_, rate)| rate),
            causes: self.causes.into_iter().map(|(name, _, sum)| (name, sum / steps)).collect(),
        }
    }
}
