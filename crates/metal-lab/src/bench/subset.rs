//! One mind that always reads the same sensors, taught as METAL is: by its own network of values, or by the same
//! counterfactual policy iteration with looks that are fixed.

use super::rows::{Desk, Teller};
use crate::task::{AttentionMethod, Learned, Recipe, Score, Seat, born, drive, learn, phase};
use crate::train::RunError;
use metal_rl::counterfactual::{CounterfactualConfig, LookRule};
use metal_rl::environment::Environment;
use metal_rl::learner::Rate;
use metal_rl::member::Member;
use metal_rl::phase::{Phase, Sensing};
use metal_rl::policies::{Advisor, Solo};
use metal_rl::policy::Policy;
use metal_rl::random::Streams;
use metal_rl::run::{Stage, run};
use metal_rl::set::IndexSet;

/// Who sees a fixed subset.
pub(super) enum Student {
    /// One learner of values.
    Values(Box<Pupil>),
    /// A student of counterfactual policy iteration.
    Counterfactual(Box<Learned>),
}

impl Student {
    /// A greedy drive of so many episodes.
    pub fn drive(&mut self, world: &mut dyn Environment, runs: (usize, &Streams)) -> Result<Score, RunError> {
        match self {
            Self::Values(pupil) => {
                let mut policy = Solo::new(0, pupil.actions);
                let scaling = pupil.recipe.scaling;
                drive(world, Seat { members: &mut pupil.member, policy: &mut policy, scaling }, runs)
            }
            Self::Counterfactual(mind) => {
                let Some(controller) = &mind.controller else { return Ok(Score::default()) };
                let (mut policy, scaling) = (controller.policy(), mind.recipe.scaling);
                drive(world, Seat { members: &mut mind.members, policy: policy.as_mut(), scaling }, runs)
            }
        }
    }
}

/// Trains a mind on `sensors` with `share` of the budget that everybody has.
pub(super) fn train_subset(
    desk: &Desk<'_>,
    sensors: IndexSet,
    share: f64,
    streams: &Streams,
) -> Result<Student, RunError> {
    let steps = ((desk.recipe.steps() as f64 * share) as usize).max(1);
    match &desk.recipe.method {
        AttentionMethod::Counterfactual(config) => {
            // Fits are most of the work: a share of the budget is a share of them, too.
            let config = CounterfactualConfig::clone(config).with_fits(share, usize::MAX);
            teach(desk, (&config, sensors), steps, streams)
        }
        AttentionMethod::Auto
        | AttentionMethod::Critic
        | AttentionMethod::RollOuts
        | AttentionMethod::Values(_) => {
            Ok(Student::Values(Box::new(Pupil::taught(desk, sensors, steps, streams)?)))
        }
    }
}

/// The recipe of METAL, but that looks are fixed.
fn teach(
    desk: &Desk<'_>,
    (config, sensors): (&CounterfactualConfig, IndexSet),
    steps: usize,
    streams: &Streams,
) -> Result<Student, RunError> {
    let names = sensors.iter().map(|s| desk.spec.sensors[s].name.clone()).collect();
    let config = CounterfactualConfig { looks: LookRule::Fixed(names), ..config.clone() };
    let method = AttentionMethod::Counterfactual(Box::new(config));
    let recipe = Recipe { foa: 0, fusion: Some(0), attention: steps, method, ..desk.recipe.clone() };
    let mind = learn(desk.task, &recipe, streams, &mut Teller(desk.progress))?;
    Ok(Student::Counterfactual(Box::new(mind)))
}

/// One learner that sees a fixed subset.
pub(super) struct Pupil {
    member: Vec<Member>,
    recipe: Recipe,
    actions: usize,
}

impl Pupil {
    fn taught(desk: &Desk<'_>, sensors: IndexSet, steps: usize, streams: &Streams) -> Result<Self, RunError> {
        let recipe = desk.recipe;
        let list: Vec<usize> = sensors.iter().collect();
        let member = born(desk.spec, ("subset", &list), &recipe.observer, streams)?;
        let actions = desk.spec.actions.len();
        let mut student = Self { member: vec![member], recipe: recipe.clone(), actions };
        let mut teller = Teller(desk.progress);
        let alone = IndexSet::first(1);
        let mut world = desk.task.watching()?;
        world.reset(0)?;
        if recipe.demonstration > 0 && world.advise().is_some() {
            let mut lesson = phase("demonstration", alone, recipe, recipe.demonstration);
            lesson.sensing = Sensing::Everyone;
            lesson.lessons.rate = Rate::Full;
            lesson.lessons.demonstrated = true;
            student.learn(world.as_mut(), &lesson, &mut Advisor, (streams, &mut teller))?;
        }
        let mut world = desk.task.training()?;
        let mut lesson = phase("alone", alone, recipe, steps);
        lesson.exploration = recipe.exploration;
        student.learn(world.as_mut(), &lesson, &mut Solo::new(0, actions), (streams, &mut teller))?;
        Ok(student)
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
