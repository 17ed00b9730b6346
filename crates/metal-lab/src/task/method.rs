//! How a task's attention is learned: the paper's values of looks, or counterfactual policy iteration.

use super::Task;
use crate::plan::PlanError;
use metal_rl::counterfactual::config::NetworkConfig;
use metal_rl::counterfactual::{
    CounterfactualConfig, CriticConfig, FitConfig, Inputs, JudgeConfig, LookRule, MemoryConfig, Unit,
};
use metal_rl::decision::Content;
use metal_rl::environment::Environment;
use metal_rl::learner::LearnerError;
use metal_rl::learners::{LearnerConfig, MlpConfig};
use metal_rl::policies::AttentionConfig;
use metal_rl::policies::attention::MotorTarget;
use metal_rl::returns::Credit;
use serde::{Deserialize, Serialize};

/// Motor steps that pay for a training step of each fit, and training steps that every fit has.
const STEPS_PER_BATCH: usize = 3;
const FEWEST_BATCHES: usize = 50;

/// Motor steps that pay for an iteration in tasks of many steps, and iterations that everybody has.
const STEPS_PER_ITERATION: usize = 1000;
const FEWEST_ITERATIONS: usize = 8;

/// Motor steps that `metal reproduce` spends on attention.
const BEST_STEPS: usize = 180_000;

/// How attention is learned.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AttentionMethod {
    /// What suits the task: counterfactual policy iteration, by roll-outs where the world can be copied, and by a critic where
    /// it cannot; the paper's values for tasks of one step, such as tables, whose world cannot be copied.
    Auto,
    /// Counterfactual policy iteration by a critic, with the settings of [`AttentionMethod::by_critic`].
    Critic,
    /// Counterfactual policy iteration by roll-outs in tasks of many steps, with the settings of
    /// [`AttentionMethod::by_roll_outs`].
    RollOuts,
    /// The paper's: values of looks and moves, Eqs. (8)-(11).
    Values(Box<ValuesMethod>),
    /// Counterfactual policy iteration with settings of one's own, its discount among them.
    Counterfactual(Box<CounterfactualConfig>),
}

/// Attention control by values of looks and moves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ValuesMethod {
    /// Learner of the values.
    pub learner: LearnerConfig,
    /// Settings; `credit` is taken from the recipe.
    pub settings: AttentionConfig,
}

impl Default for ValuesMethod {
    fn default() -> Self {
        let encoding = metal_rl::decision::Encoding { content: Content::Readings, ..Default::default() };
        Self {
            learner: LearnerConfig::Mlp(MlpConfig { capacity: 20_000, ..MlpConfig::default() }),
            // No ramp: what was learned under cheaper looks would be replayed for ever.
            settings: AttentionConfig { encoding, price_ramp: 0.0, ..AttentionConfig::default() },
        }
    }
}

impl ValuesMethod {
    /// The settings with the recipe's credit.
    pub(super) fn credited(&self, credit: Credit) -> AttentionConfig {
        AttentionConfig { credit, ..self.settings.clone() }
    }
}

impl AttentionMethod {
    /// Counterfactual policy iteration for tasks of one step per episode: roll-outs are exact, so labels never age, and
    /// judging every row costs nothing; so a few iterations do, and the time goes into long fits. On CUBE, at most ten
    /// looks were better, and twice as fast, than as many as there are: nobody who learns from thirty looks finds out
    /// which ten are worth their price. Where rows are imagined, the student is told what the model behind them believes.
    #[must_use]
    pub fn one_step() -> Self {
        const ITERATIONS: usize = 3;
        const BATCHES: usize = 6000;
        Self::Counterfactual(Box::new(CounterfactualConfig {
            looks: LookRule::Adaptive { min_looks: 0, max_looks: 10 },
            network: NetworkConfig { belief: true, ..NetworkConfig::default() },
            iterations: ITERATIONS,
            window: ITERATIONS,
            judged: 1.0,
            // Where an episode is one step, looks lead nowhere: open eyes would see no other rows.
            wide_eyed: 0,
            // Of many columns, each is rightly asked for few rows only: nobody is dismissed for that.
            dismissal: 0.0,
            price_ramp: 1,
            validation_runs: 1000,
            fit: FitConfig { batches: BATCHES, ..FitConfig::default() },
            ..CounterfactualConfig::default()
        }))
    }

    /// Counterfactual policy iteration by a critic, for tasks of many steps and worlds that nobody can copy, in a phase
    /// of so many motor steps, tests of iterates included. Settings were chosen on CartPole, seeds 1 and 2.
    #[must_use]
    pub fn by_critic(steps: usize, horizon: usize) -> Self {
        const ITERATIONS: usize = 40;
        // Half of an iteration is its test, which should see a whole run.
        let iterations = (steps / STEPS_PER_ITERATION.max(2 * horizon)).clamp(FEWEST_ITERATIONS, ITERATIONS);
        let fits =
            |most: usize| (steps * most / (ITERATIONS * STEPS_PER_ITERATION)).clamp(FEWEST_BATCHES, most);
        let critic = CriticConfig { batches: fits(3000), ..CriticConfig::default() };
        Self::Counterfactual(Box::new(CounterfactualConfig {
            looks: LookRule::Adaptive { min_looks: 0, max_looks: 10 },
            judge: JudgeConfig::Critic(critic),
            memory: MemoryConfig { looks: 1, steps: 8, actions: 1, recurrent: 0 },
            iterations,
            window: 5,
            astray: 0.0,
            gamma: 0.99,
            thrifty: true,
            // Whoever cannot drive with open eyes does not know what is worth looking at.
            wide_eyed: iterations * 3 / 10,
            first_price: -0.5,
            price_ramp: iterations * 9 / 20,
            // Tasks that are over only when something is reached are not learned in their first steps.
            first_drives: 0,
            dismissal: 0.0,
            fit: FitConfig {
                batches: fits(5000),
                looks_per_sample: 1,
                own_looks: 0.5,
                open_eyes: 0.8,
                relative: true,
                inputs: Inputs::Standardized,
                unit: Unit::MeanAbsolute,
                ..FitConfig::default()
            },
            ..CounterfactualConfig::default()
        }))
    }

    /// Counterfactual policy iteration by roll-outs, for tasks of many steps whose world can be copied, in a phase of so many
    /// motor steps: the recipe of `metal reproduce`. Where there are fewer steps there are fewer iterations and shorter fits,
    /// and eyes stay open and looks become dear for as many motor steps as there, if not for most of the phase. What copies
    /// do and tests of iterates are not counted as motor steps.
    #[must_use]
    pub fn by_roll_outs(steps: usize) -> Self {
        let memory = MemoryConfig { looks: 1, steps: 10, actions: 4, recurrent: 0 };
        let best = CounterfactualConfig { memory, dismissal: 0.2, ..CounterfactualConfig::default() };
        let iterations = (steps / STEPS_PER_ITERATION).clamp(FEWEST_ITERATIONS, best.iterations);
        let pay = best.iterations * STEPS_PER_ITERATION;
        let batches = (steps * best.fit.batches / pay).clamp(FEWEST_BATCHES, best.fit.batches);
        let longer = |some: usize| (some * BEST_STEPS * iterations).div_ceil(best.iterations * steps.max(1));
        let wide_eyed = longer(best.wide_eyed).clamp(1, iterations / 6);
        let price_ramp = longer(best.price_ramp).clamp(1, iterations * 5 / 12);
        let fit = FitConfig { batches, ..best.fit.clone() };
        Self::Counterfactual(Box::new(CounterfactualConfig {
            iterations,
            fit,
            wide_eyed,
            price_ramp,
            ..best
        }))
    }

    /// The method itself in place of [`AttentionMethod::Auto`], [`AttentionMethod::Critic`] and
    /// [`AttentionMethod::RollOuts`], for a phase of so many motor steps: whoever sees little need not fit long.
    pub(super) fn for_world(self, task: &dyn Task, world: &dyn Environment, steps: usize) -> Self {
        let horizon = world.spec().horizon;
        // Worlds that may be used by one thread only are somebody else's: roll-outs would read all their sensors, which may
        // cost real time.
        let copied = || task.is_parallel() && world.fork().is_some();
        match self {
            Self::Critic => Self::by_critic(steps, horizon),
            Self::RollOuts => Self::by_roll_outs(steps),
            Self::Auto if horizon > 1 && copied() => Self::by_roll_outs(steps),
            Self::Auto if horizon > 1 => Self::by_critic(steps, horizon),
            Self::Auto if !copied() => Self::Values(Box::default()),
            Self::Auto => {
                let mut method = Self::one_step();
                if let Self::Counterfactual(config) = &mut method {
                    config.fit.batches = (steps / STEPS_PER_BATCH).clamp(FEWEST_BATCHES, config.fit.batches);
                }
                method
            }
            chosen => chosen,
        }
    }

    /// Whether attention is learned from what members say of the readings, and not from the readings alone.
    pub(super) fn asks_members(&self) -> bool {
        let content = match self {
            Self::Auto | Self::Critic | Self::RollOuts => return false,
            Self::Values(values) => &values.settings.encoding.content,
            Self::Counterfactual(config) => &config.content,
        };
        *content != Content::Readings
    }

    /// Refuses what cannot be carried out.
    pub(super) fn check(&self) -> Result<(), PlanError> {
        match self {
            Self::Auto | Self::Critic | Self::RollOuts => Ok(()),
            Self::Values(values) => {
                let refuse = |e: LearnerError| PlanError::at("method.values.learner", e.to_string());
                values.learner.validate().map_err(refuse)?;
                crate::plan::limits::attention("method.values.settings", &values.settings)
            }
            Self::Counterfactual(config) => config.validate().map_err(|e| match e {
                LearnerError::Setting { field, value, allowed, .. } => {
                    PlanError::at(format!("method.counterfactual.{field}"), format!("{value}: {allowed}"))
                }
                other => PlanError::at("method.counterfactual", other.to_string()),
            }),
        }
    }

    /// In a task of one step per episode, values of looks need no returns, which would mix in what exploring moves
    /// earned, and there is nothing to remember.
    pub(super) fn for_one_step(self) -> Self {
        match self {
            Self::Auto | Self::Critic | Self::RollOuts => self,
            Self::Counterfactual(mut config) => {
                config.memory = MemoryConfig::default();
                Self::Counterfactual(config)
            }
            Self::Values(mut values) => {
                values.settings.motor_target = MotorTarget::Myopic;
                Self::Values(values)
            }
        }
    }

    /// The settings of the paper's method, those it has by itself where another one was chosen.
    pub(super) fn values(&self) -> ValuesMethod {
        match self {
            Self::Values(values) => ValuesMethod::clone(values),
            Self::Auto | Self::Critic | Self::RollOuts | Self::Counterfactual(_) => ValuesMethod::default(),
        }
    }
}
