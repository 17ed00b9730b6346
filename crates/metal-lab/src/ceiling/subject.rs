//! What is measured: the members of a plan, their prices, and the recipe by which everybody learns.

use super::CeilingOptions;
use crate::mind::Mind;
use crate::plan::{Acting, Plan, PlanError};
use crate::registry::EnvironmentConfig;
use crate::train::RunError;
use metal_rl::counterfactual::iterate::student_shape;
use metal_rl::counterfactual::{
    CounterfactualConfig, FitConfig, JudgeConfig, LookRule, MemoryConfig, Student,
};
use metal_rl::decision::Content;
use metal_rl::random::Streams;
use metal_rl::set::IndexSet;

/// Members beyond which there are too many subsets to try all of them.
pub(super) const MOST_MEMBERS: usize = 10;

/// What the student with a memory remembers if the recipe has none: the last look of everybody, and the last move.
const MEMORY: MemoryConfig = MemoryConfig { looks: 1, steps: 10, actions: 1, recurrent: 0 };

/// Iterations over which the price of looking rises, far beyond those there are: the driver has no choice of looks, and
/// their price would only blur what its moves are worth.
const NEVER: usize = 10_000;

/// What is measured.
pub(super) struct Subject<'a> {
    pub plan: &'a Plan,
    /// Member of each slot.
    pub slots: Vec<usize>,
    /// Name of each slot's member.
    pub names: Vec<String>,
    recipe: CounterfactualConfig,
}

impl<'a> Subject<'a> {
    pub fn new(plan: &'a Plan, options: &CeilingOptions) -> Result<Self, RunError> {
        check_world(plan)?;
        let phase = phase(plan, options)?;
        let slots: Vec<usize> = plan.roster(&plan.file.phase[phase].roster).iter().collect();
        if slots.is_empty() || slots.len() > MOST_MEMBERS {
            let message = format!(
                "{} members: 1 to {MOST_MEMBERS}, because every subset is tried; --set a shorter roster",
                slots.len()
            );
            return Err(PlanError::at(format!("phase.{phase}.roster"), message).into());
        }
        let names = slots.iter().map(|&m| plan.members[m].name.clone()).collect();
        let recipe =
            plan.counterfactual(phase).map_or_else(CounterfactualConfig::default, |(_, c)| c.clone());
        Ok(Self { plan, slots, names, recipe })
    }

    /// Everybody.
    pub fn everybody(&self) -> IndexSet {
        IndexSet::first(self.slots.len())
    }

    /// Roster of the mind.
    pub fn roster(&self) -> IndexSet {
        self.slots.iter().copied().collect()
    }

    /// Price of looking through these slots, every sensor paid once. Fig. 7b.
    pub fn price(&self, looks: IndexSet) -> f64 {
        let sensors: IndexSet =
            looks.iter().flat_map(|s| &self.plan.members[self.slots[s]].sensors).copied().collect();
        sensors.iter().map(|s| self.plan.spec.sensors[s].price).sum()
    }

    /// `looks` in words.
    pub fn words(&self, looks: IndexSet) -> String {
        match looks {
            IndexSet::EMPTY => "nobody".to_owned(),
            all if all == self.everybody() && all.len() > 2 => "everybody".to_owned(),
            some => some.iter().map(|s| self.names[s].as_str()).collect::<Vec<_>>().join("+"),
        }
    }

    /// How the driver learns: it sees everything, and nobody's supports, so that members need not have learned.
    pub fn driver_config(&self, options: &CeilingOptions) -> CounterfactualConfig {
        CounterfactualConfig {
            looks: LookRule::All,
            judge: JudgeConfig::RollOuts,
            content: Content::Readings,
            judged: 1.0,
            iterations: options.driver_iterations,
            wide_eyed: 0,
            price_ramp: NEVER,
            dismissal: 0.0,
            patience: 0,
            validation_runs: self.recipe.validation_runs.min(options.runs),
            fit: FitConfig {
                batches: self.recipe.fit.batches.min(options.batches),
                ..self.recipe.fit.clone()
            },
            ..self.recipe.clone()
        }
    }

    /// How those learn who may look at anybody, by the same recipe.
    fn looker_config(&self, memory: MemoryConfig, options: &CeilingOptions) -> CounterfactualConfig {
        let fit = FitConfig {
            batches: options.batches,
            own_looks: 0.6,
            open_eyes: 0.0,
            more_than_allowed: true,
            ..self.recipe.fit.clone()
        };
        let looks = LookRule::Adaptive { min_looks: 0, max_looks: self.slots.len() };
        CounterfactualConfig { looks, content: Content::Readings, memory, fit, ..self.recipe.clone() }
    }

    /// A newborn student that may look at anybody, with or without a memory.
    pub fn looker(
        &self,
        remembers: bool,
        options: &CeilingOptions,
        streams: &Streams,
    ) -> Result<Student, RunError> {
        self.newborn(self.looker_config(self.memory(remembers), options), streams)
    }

    /// A newborn student whose looks are not its choice, with or without a memory.
    pub fn watcher(
        &self,
        remembers: bool,
        options: &CeilingOptions,
        streams: &Streams,
    ) -> Result<Student, RunError> {
        let memory = self.memory(remembers);
        let fit = FitConfig { batches: options.batches, ..self.recipe.fit.clone() };
        let config =
            CounterfactualConfig { memory, fit, judged: self.recipe.judged, ..self.driver_config(options) };
        self.newborn(config, streams)
    }

    fn memory(&self, remembers: bool) -> MemoryConfig {
        match (remembers, self.recipe.memory.looks) {
            (false, _) => MemoryConfig::default(),
            (true, 0) => MEMORY,
            // A recollection is of one student's drives; universal students live many.
            (true, _) => MemoryConfig { recurrent: 0, ..self.recipe.memory },
        }
    }

    fn newborn(&self, config: CounterfactualConfig, streams: &Streams) -> Result<Student, RunError> {
        let mind = Mind::newborn(self.plan, streams)?;
        let shape = student_shape(&config, &mind.members, &self.slots, &self.plan.spec);
        let shape = shape.map_err(|e| RunError::Counterfactual(e.into()))?;
        Ok(Student::new(&config, &shape, streams)?)
    }

    /// About how many motor steps are simulated.
    pub fn planned_steps(&self, options: &CeilingOptions) -> usize {
        let config = self.driver_config(options);
        let judged = 1 + self.plan.spec.actions.len() * (1 + config.horizon);
        let tests = options.runs * self.plan.spec.horizon;
        options.seeds * ((3 * options.driver_steps + options.log_steps) * judged + tests)
    }
}

/// Moves can only be judged in copies of a world that heeds them.
fn check_world(plan: &Plan) -> Result<(), RunError> {
    let deaf = matches!(plan.file.environment, EnvironmentConfig::Replay(_));
    if !deaf && plan.file.environment.build()?.fork().is_some() {
        return Ok(());
    }
    let why = if deaf { "is a recording, which goes on as it went then" } else { "cannot be copied" };
    let message = format!("{} {why}, so no move can be rolled out in it", plan.spec.id);
    Err(PlanError::at("environment", message).into())
}

/// The phase whose roster and recipe are taken.
fn phase<'a>(plan: &'a Plan, options: &'a CeilingOptions) -> Result<&'a str, PlanError> {
    if let Some(name) = &options.phase {
        let known = plan.order.iter().map(String::as_str);
        return match plan.file.phase.contains_key(name) {
            true => Ok(name),
            false => Err(crate::plan::limits::unknown("phase", "phase", name, known)),
        };
    }
    let attention = |name: &&String| matches!(plan.file.phase[*name].acting, Acting::Attention(_));
    let by_recipe = plan.order.iter().find(|name| plan.counterfactual(name).is_some());
    let any = by_recipe.or_else(|| plan.order.iter().find(attention));
    any.map(String::as_str).ok_or_else(|| PlanError::at("phase", "none of the plan learns attention"))
}
