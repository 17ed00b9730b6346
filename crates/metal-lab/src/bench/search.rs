//! The best fixed subset of sensors: one learner that always reads the same ones.

use super::rows::{Desk, Teller, names};
use crate::task::{Recipe, Score};
use crate::train::RunError;
use metal_rl::environment::Environment;
use metal_rl::learner::Rate;
use metal_rl::member::Member;
use metal_rl::phase::{Phase, Sensing};
use metal_rl::policies::{Advisor, Solo};
use metal_rl::policy::Policy;
use metal_rl::random::Streams;
use metal_rl::run::{Stage, run};
use metal_rl::set::IndexSet;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// A screened subset.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Static {
    /// Its sensors.
    pub sensors: IndexSet,
    /// Their names.
    pub name: String,
    /// How it did in the world of learning.
    pub score: Score,
}

/// Screens subsets with a share of the budget: all of them where there are few sensors; otherwise all single ones,
/// then from the best on one more sensor at a time for as long as that pays.
pub(super) fn search(desk: &Desk<'_>) -> Result<Vec<Static>, RunError> {
    let n = desk.spec.sensors.len();
    if n <= desk.options.exhaustive {
        return screen(desk, &(1..1_u64 << n).map(IndexSet::from_bits).collect::<Vec<_>>());
    }
    let mut screened: Vec<Static> = Vec::new();
    let mut best = IndexSet::EMPTY;
    while best.len() < n {
        let larger: Vec<IndexSet> = IndexSet::first(n).minus(best).iter().map(|s| best.with(s)).collect();
        let found = screen(desk, &larger)?;
        let top = found.iter().max_by(|a, b| a.score.total().total_cmp(&b.score.total()));
        let top = top.map(|s| (s.sensors, s.score.total()));
        let before = screened.iter().map(|s| s.score.total()).fold(f64::NEG_INFINITY, f64::max);
        screened.extend(found);
        match top {
            Some((sensors, total)) if total > before => best = sensors,
            _ => break,
        }
    }
    Ok(screened)
}

fn screen(desk: &Desk<'_>, subsets: &[IndexSet]) -> Result<Vec<Static>, RunError> {
    let one = |&sensors: &IndexSet| {
        let streams = desk.streams.child("screening");
        let mut student = train_subset(desk, sensors, desk.options.screening_share, &streams)?;
        let mut world = desk.task.training()?;
        let score = student.drive(world.as_mut(), (desk.options.episodes, &streams.child("validation")))?;
        Ok(Static { sensors, name: names(desk.spec, sensors), score })
    };
    if desk.progress.interrupted() {
        return Err(RunError::Interrupted);
    }
    if desk.task.is_parallel() {
        return subsets.par_iter().map(one).collect();
    }
    subsets.iter().map(one).collect()
}

/// One learner that sees a fixed subset.
pub(super) struct Student {
    member: Vec<Member>,
    recipe: Recipe,
    actions: usize,
}

impl Student {
    /// A greedy drive of so many episodes.
    pub fn drive(&mut self, world: &mut dyn Environment, runs: (usize, &Streams)) -> Result<Score, RunError> {
        let mut policy = Solo::new(0, self.actions);
        let scaling = self.recipe.scaling;
        let seat = crate::task::Seat { members: &mut self.member, policy: &mut policy, scaling };
        crate::task::drive(world, seat, runs)
    }

    fn learn(
        &mut self,
        world: &mut dyn Environment,
        phase: &Phase,
        policy: &mut dyn Policy,
        (streams, teller): (&Streams, &mut Teller<'_>),
    ) -> Result<(), RunError> {
        let scaling = self.recipe.scaling;
        let mut stage = Stage { environment: world, members: &mut self.member, policy, scaling };
        run(&mut stage, phase, &streams.child("phase").child(&phase.name), teller)?;
        Ok(())
    }
}

/// Trains one learner on `sensors` with `share` of the budget that everybody has.
pub(super) fn train_subset(
    desk: &Desk<'_>,
    sensors: IndexSet,
    share: f64,
    streams: &Streams,
) -> Result<Student, RunError> {
    let recipe = desk.recipe;
    let list: Vec<usize> = sensors.iter().collect();
    let member = crate::task::born(desk.spec, ("subset", &list), &recipe.observer, streams)?;
    let actions = desk.spec.actions.len();
    let mut student = Student { member: vec![member], recipe: recipe.clone(), actions };
    let mut teller = Teller(desk.progress);
    let alone = IndexSet::first(1);
    let mut world = desk.task.watching()?;
    world.reset(0)?;
    if recipe.demonstration > 0 && world.advise().is_some() {
        let mut phase = crate::task::phase("demonstration", alone, recipe, recipe.demonstration);
        phase.sensing = Sensing::Everyone;
        phase.lessons.rate = Rate::Full;
        phase.lessons.demonstrated = true;
        student.learn(world.as_mut(), &phase, &mut Advisor, (streams, &mut teller))?;
    }
    let mut world = desk.task.training()?;
    let steps = ((recipe.steps() as f64 * share) as usize).max(1);
    let mut phase = crate::task::phase("alone", alone, recipe, steps);
    phase.exploration = recipe.exploration;
    student.learn(world.as_mut(), &phase, &mut Solo::new(0, actions), (streams, &mut teller))?;
    Ok(student)
}
