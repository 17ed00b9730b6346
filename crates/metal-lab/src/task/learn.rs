//! Learning a task: demonstration, full observer, fusion, attention, one after the other in the one loop.

use super::Task;
use super::method::AttentionMethod;
use super::mind::{Controller, Learned};
use super::recipe::Recipe;
use crate::teach::Pool;
use crate::train::RunError;
use metal_rl::counterfactual::{self, Alone, CounterfactualConfig, Workers, iterate};
use metal_rl::environment::Environment;
use metal_rl::learner::Rate;
use metal_rl::observe::Observer;
use metal_rl::phase::{Budget, Lessons, Phase, Sensing, Teaching};
use metal_rl::policies::{Advisor, Attention, Counterfactual, Fusion, Solo};
use metal_rl::policy::Policy;
use metal_rl::random::Streams;
use metal_rl::run::{Stage, run};
use metal_rl::set::IndexSet;

/// Learns `task` after `recipe`; all randomness comes from `streams`.
///
/// # Errors
/// If the recipe or the task is impossible, or the world fails.
pub fn learn(
    task: &dyn Task,
    recipe: &Recipe,
    streams: &Streams,
    observer: &mut dyn Observer,
) -> Result<Learned, RunError> {
    let mut environment = task.training()?;
    let recipe = &recipe.clone().for_task(task, environment.as_ref());
    let mut mind = Learned::newborn(environment.spec(), &task.opinions(), recipe, streams)?;
    let mut school = School { task, environment: environment.as_mut(), streams, observer };
    if recipe.demonstration > 0 {
        School { environment: task.watching()?.as_mut(), observer: &mut *school.observer, ..school }
            .demonstration(&mut mind)?;
    }
    school.full_observer(&mut mind)?;
    school.fusion(&mut mind)?;
    school.attention(&mut mind)?;
    Ok(mind)
}

/// Who learns where, from which randomness, and who watches.
struct School<'a> {
    task: &'a dyn Task,
    environment: &'a mut dyn Environment,
    streams: &'a Streams,
    observer: &'a mut dyn Observer,
}

impl School<'_> {
    /// Phase I, where the world has an advisor.
    fn demonstration(&mut self, mind: &mut Learned) -> Result<(), RunError> {
        self.environment.reset(0)?;
        if self.environment.advise().is_none() {
            return Ok(());
        }
        let mut phase = phase("demonstration", mind.everybody(), &mind.recipe, mind.recipe.demonstration);
        phase.sensing = Sensing::Everyone;
        phase.lessons.rate = Rate::Full;
        phase.lessons.demonstrated = true;
        self.run(mind, &phase, &mut Advisor)
    }

    fn full_observer(&mut self, mind: &mut Learned) -> Result<(), RunError> {
        let mut phase = phase("foa", IndexSet::EMPTY.with(mind.observer()), &mind.recipe, mind.recipe.foa);
        phase.exploration = mind.recipe.exploration;
        self.run(mind, &phase, &mut Solo::new(mind.observer(), mind.spec.actions.len()))
    }

    /// Phase II.
    fn fusion(&mut self, mind: &mut Learned) -> Result<(), RunError> {
        let mut phase = phase("fusion", mind.everybody(), &mind.recipe, mind.recipe.fusion.unwrap_or(0));
        phase.exploration = mind.recipe.exploration;
        phase.lessons.bootstrap = Some(mind.observer());
        let mut policy = Fusion::new(mind.recipe.fuser.clone(), mind.everybody(), mind.spec.actions.len());
        self.run(mind, &phase, &mut policy)
    }

    /// Phase III: the full observer is gone.
    fn attention(&mut self, mind: &mut Learned) -> Result<(), RunError> {
        let mut phase = phase("attention", mind.tiny_agents(), &mind.recipe, mind.recipe.attention);
        phase.exploration = mind.recipe.attention_exploration;
        let controller = match &mind.recipe.method {
            AttentionMethod::Counterfactual(config) => {
                let config = config.clone();
                Controller::Counterfactual(Box::new(self.counterfactual(mind, &config, &phase)?))
            }
            AttentionMethod::Auto
            | AttentionMethod::Critic
            | AttentionMethod::RollOuts
            | AttentionMethod::Values(_) => Controller::Values(Box::new(self.values(mind, phase)?)),
        };
        mind.controller = Some(controller);
        Ok(())
    }

    fn values(&mut self, mind: &mut Learned, mut phase: Phase) -> Result<Attention, RunError> {
        phase.policy_learns = true;
        if !mind.recipe.learn_on {
            phase.lessons.teaching = Teaching::Nobody;
        }
        let mut attention = mind.newborn_attention(self.streams)?;
        self.run(mind, &phase, &mut attention)?;
        Ok(attention)
    }

    /// Iterates are compared in the world of learning itself, whatever was imagined: the test stays unseen.
    fn counterfactual(
        &mut self,
        mind: &mut Learned,
        config: &CounterfactualConfig,
        phase: &Phase,
    ) -> Result<Counterfactual, RunError> {
        let mut validation = self.task.training()?;
        let imagining = mind.recipe.imagination;
        let streams = self.streams.child("imagination");
        let mut imagined = if imagining { self.environment.imagine(&streams) } else { None };
        let workers: &dyn Workers = if self.task.is_parallel() { &Pool } else { &Alone };
        let mut school = counterfactual::School {
            environment: imagined.as_deref_mut().unwrap_or(&mut *self.environment),
            validation: validation.as_mut(),
            roster: mind.roster(),
            members: &mut mind.members,
            scaling: mind.recipe.scaling,
            workers,
            interrupted: &|| false,
            ear: &mut |_| {},
        };
        let streams = self.streams.child("phase").child(&phase.name);
        Ok(iterate(&mut school, config, phase, &streams, self.observer)?.policy)
    }

    fn run(&mut self, mind: &mut Learned, phase: &Phase, policy: &mut dyn Policy) -> Result<(), RunError> {
        let streams = self.streams.child("phase").child(&phase.name);
        let scaling = mind.recipe.scaling;
        let mut stage =
            Stage { environment: &mut *self.environment, members: &mut mind.members, policy, scaling };
        run(&mut stage, phase, &streams, self.observer)?;
        Ok(())
    }
}

/// A phase in which the roster learns what it attended, `steps` motor steps long.
pub(crate) fn phase(name: &str, roster: IndexSet, recipe: &Recipe, steps: usize) -> Phase {
    Phase {
        lessons: Lessons {
            teaching: Teaching::Attended,
            rate: recipe.rate,
            credit: recipe.credit,
            bootstrap: None,
            demonstrated: false,
        },
        budget: Budget::Steps(steps),
        ..Phase::evaluation(name, roster, 0)
    }
}
