//! How to learn a task: budgets, learners, attention method, all of it data.

use super::method::AttentionMethod;
use crate::plan::PlanError;
use metal_rl::environment::Environment;
use metal_rl::explore::Schedule;
use metal_rl::fuse::Fuser;
use metal_rl::learner::Rate;
use metal_rl::learners::{LearnerConfig, MlpConfig, TileConfig};
use metal_rl::returns::Credit;
use metal_rl::view::Scaling;
use serde::{Deserialize, Serialize};

/// How a task is learned. Budgets are motor steps; a phase of 0 steps does not take place.
///
/// The defaults hold for every task: exploration is a share of random choices, which needs no scale of rewards.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Recipe {
    /// Phase I: steps watched, where the task has an expert advisor (Sec. 3.2.1).
    pub demonstration: usize,
    /// The full observer at the wheel before everybody is (none in the paper's way to attention).
    pub foa: usize,
    /// Phase II: everybody decides together (Sec. 3.2.2). Not said: a third of the steps of `attention` where attention is learned
    /// from what members support, none where it is learned from readings, since nobody would ask them (reading R142).
    pub fusion: Option<usize>,
    /// Phase III: attention control (Sec. 3.2.3), and Phase II where `fusion` is not said.
    pub attention: usize,
    /// How readings are scaled.
    pub scaling: Scaling,
    /// How credit flows back, for everybody.
    pub credit: Credit,
    /// Learner of tiny agents.
    pub tiny: LearnerConfig,
    /// Learner of the full observer and of fixed subsets.
    pub observer: LearnerConfig,
    /// Learning rate of members, where the learner uses one.
    pub rate: Rate,
    /// Whether tiny agents learn on in Phase III.
    pub learn_on: bool,
    /// Who decides in Phase II, Eq. (7).
    pub fuser: Fuser,
    /// How members at the wheel explore.
    pub exploration: Schedule,
    /// How attention control explores.
    pub attention_exploration: Schedule,
    /// Whether attention learns in a world imagined from what was seen, where there is one
    /// ([`metal_rl::environment::Environment::imagine`]), and is only compared in the real one.
    pub imagination: bool,
    /// How attention is learned.
    pub method: AttentionMethod,
}

/// Random choices: this share at first, this share from four fifths of the phase on.
fn random(from: f64, to: f64) -> Schedule {
    Schedule::Random { from, to, until: 0.8 }
}

impl Default for Recipe {
    fn default() -> Self {
        Self {
            demonstration: 200,
            foa: 0,
            fusion: None,
            attention: 60_000,
            scaling: Scaling::Linear,
            credit: Credit { gamma: 0.97, lambda: 0.7 },
            tiny: LearnerConfig::Tile(TileConfig::default()),
            observer: LearnerConfig::Mlp(MlpConfig { capacity: 20_000, ..MlpConfig::default() }),
            rate: Rate::Constant(0.1),
            learn_on: false,
            fuser: Fuser::MaxConfidence,
            exploration: random(0.5, 0.02),
            attention_exploration: random(0.3, 0.02),
            imagination: true,
            method: AttentionMethod::Auto,
        }
    }
}

/// Most motor steps of a phase.
const MOST: usize = 100_000_000;

impl Recipe {
    /// The default recipe with `steps` motor steps from Phase II on.
    #[must_use]
    pub fn of_steps(steps: usize) -> Self {
        Self { attention: steps, ..Self::default() }
    }

    /// Motor steps in which the mind acts by itself; every row of a comparison gets as many.
    #[must_use]
    pub fn steps(&self) -> usize {
        self.foa + self.fusion.unwrap_or(0) + self.attention
    }

    /// Refuses what cannot be carried out.
    ///
    /// # Errors
    /// The first impossible field, with what is allowed.
    pub fn check(&self) -> Result<(), PlanError> {
        let phases = [
            ("demonstration", self.demonstration),
            ("foa", self.foa),
            ("fusion", self.fusion.unwrap_or(0)),
            ("attention", self.attention),
        ];
        for (field, steps) in phases {
            if steps > MOST {
                return Err(PlanError::at(field, format!("{steps}: at most {MOST} motor steps")));
            }
        }
        if self.attention == 0 {
            return Err(PlanError::at(
                "attention",
                "0: attention needs at least one motor step to be learned in",
            ));
        }
        for (field, learner) in [("tiny", &self.tiny), ("observer", &self.observer)] {
            learner.validate().map_err(|e| PlanError::at(field, e.to_string()))?;
        }
        crate::plan::limits::credit("credit", self.credit)?;
        crate::plan::limits::rate("rate", self.rate)?;
        crate::plan::limits::schedule("exploration", self.exploration)?;
        crate::plan::limits::schedule("attention_exploration", self.attention_exploration)?;
        self.method.check()
    }

    /// The same recipe for a task and a world of it: how attention is learned, and whether members learn before, follow from
    /// them, if nobody said it.
    #[must_use]
    pub fn for_task(mut self, task: &dyn super::Task, world: &dyn Environment) -> Self {
        self.method = self.method.for_world(task, world, self.attention);
        if self.fusion.is_none() {
            let fusion = if self.method.asks_members() { self.attention / 3 } else { 0 };
            (self.fusion, self.attention) = (Some(fusion), self.attention - fusion);
        }
        self
    }

    /// The same recipe for a task of one step per episode: the future is worth nothing.
    #[must_use]
    pub fn for_horizon(mut self, horizon: usize) -> Self {
        if horizon == 1 {
            self.method = self.method.for_one_step();
            self.credit.lambda = 0.0;
        }
        self
    }
}
