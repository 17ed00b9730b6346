//! A transfer experiment as data, and what must hold for it.

use super::Arm;
use crate::plan::error::from_toml;
use crate::plan::file::PlanFile;
use crate::plan::{Plan, PlanError};
use crate::registry::EnvironmentConfig;
use crate::reproduce::quick;
use metal_rl::explore::Schedule;
use metal_rl::phase::Budget;
use serde::{Deserialize, Serialize};

/// The experiment that ships with the program.
pub const TRANSFER: &str = include_str!("../../../../experiments/transfer.toml");

/// A transfer experiment, as it is written.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TransferFile {
    /// What is transferred where.
    pub title: String,
    /// Phase I of the plan the minds come from: who watches, and how they learn.
    pub demonstration: String,
    /// Episodes of demonstration that are compared, in the other world.
    pub episodes: Vec<usize>,
    /// Policies of the plan that are tested; the first is the one of Fig. 11 and the one that learns on.
    pub policies: Vec<String>,
    /// Test runs per training.
    pub runs: usize,
    /// Learning on in the other world, after the demonstrations.
    pub learning: LearningFile,
    /// The worlds: the first is the one of the experiment; to the others the minds go as they are, to find out which
    /// difference matters.
    pub world: Vec<WorldFile>,
}

/// How learning goes on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LearningFile {
    /// Episodes of the phase of the first policy. Who learns from scratch explores as that phase says.
    pub episodes: usize,
    /// How minds that come with knowledge explore.
    pub exploration: Schedule,
}

/// A world minds are sent to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WorldFile {
    /// Its name in the report.
    pub name: String,
    /// The world; its sensors and actions must be those of the plan.
    pub environment: EnvironmentConfig,
}

/// A transfer experiment whose parts fit together.
#[derive(Clone, Debug)]
pub struct Transfer {
    /// As it was written.
    pub file: TransferFile,
    /// The plan of the world the minds come from, cut to what the tested policies need.
    pub source: Plan,
    /// The same in each world, in the order of the file.
    pub worlds: Vec<Plan>,
}

/// Reads a transfer experiment.
///
/// # Errors
/// With line, field and what is allowed.
pub fn parse(text: &str) -> Result<TransferFile, PlanError> {
    toml::from_str(text).map_err(|e| from_toml(&e, text))
}

impl TransferFile {
    /// The same with budgets that only show that everything works.
    #[must_use]
    pub fn shrunk(mut self) -> Self {
        self.runs = self.runs.min(2);
        self.learning.episodes = self.learning.episodes.min(6);
        self.world.truncate(2);
        self
    }

    /// Whoever is compared: minds with each number of demonstrations, and a newborn with the most.
    #[must_use]
    pub fn arms(&self) -> Vec<Arm> {
        let most = self.episodes.iter().copied().max().unwrap_or(0);
        let arms = self.episodes.iter().map(|&episodes| Arm { newborn: false, episodes });
        arms.chain([Arm { newborn: true, episodes: most }]).collect()
    }
}

impl Transfer {
    /// Puts the experiment and the plan of the minds together.
    ///
    /// # Errors
    /// If a name is unknown, a list empty, or a world has other sensors or actions than the plan.
    pub fn new(file: TransferFile, source: &Plan) -> Result<Self, PlanError> {
        check_names(&file, source)?;
        let source = Plan::check(needed(&file, source))?;
        let mut worlds = Vec::new();
        for (i, world) in file.world.iter().enumerate() {
            let mut moved = source.file.clone();
            moved.environment = world.environment.clone();
            let field = || format!("world[{i}].environment");
            let plan = Plan::check(moved).map_err(|e| PlanError::at(field(), e.to_string()))?;
            let (there, here) = (&plan.spec, &source.spec);
            if there.sensors != here.sensors || there.actions != here.actions {
                let message = format!("{}: other sensors, prices or actions than {}", there.id, here.id);
                return Err(PlanError::at(field(), message));
            }
            worlds.push(plan);
        }
        Ok(Self { file, source, worlds })
    }

    /// The same with a source that is trained for moments only.
    ///
    /// # Errors
    /// If the shrunk plan is refused.
    pub fn shrunk(self) -> Result<Self, PlanError> {
        let source = Plan::check(quick::shrink(self.source.file))?;
        Self::new(self.file.shrunk(), &source)
    }

    /// The policy of Fig. 11.
    #[must_use]
    pub fn lead(&self) -> &str {
        &self.file.policies[0]
    }

    /// The plan of the experiment's world, its demonstration `episodes` long.
    ///
    /// # Errors
    /// If it is refused.
    pub fn watching(&self, episodes: usize) -> Result<Plan, PlanError> {
        let mut file = self.worlds[0].file.clone();
        self.demonstration_of(&mut file).budget = Budget::Episodes(episodes);
        Plan::check(file)
    }

    fn demonstration_of<'f>(&self, file: &'f mut PlanFile) -> &'f mut crate::plan::file::PhaseFile {
        // The name was checked.
        file.phase.get_mut(&self.file.demonstration).expect("checked name")
    }

    /// The phase that the lead policy learned in last.
    ///
    /// # Panics
    /// Never: the names were checked.
    #[must_use]
    pub fn lead_phase(&self) -> &str {
        self.source.file.policy[self.lead()].after.as_deref().expect("checked policy")
    }

    /// The plan of the experiment's world in which the lead policy of an arm learns on.
    ///
    /// # Errors
    /// If it is refused.
    ///
    /// # Panics
    /// Never: the names were checked.
    pub fn learning(&self, arm: Arm) -> Result<Plan, PlanError> {
        let mut file = self.worlds[0].file.clone();
        let name = self.lead_phase().to_owned();
        let phase = file.phase.get_mut(&name).expect("checked name");
        phase.budget = Budget::Episodes(self.file.learning.episodes);
        if !arm.newborn {
            phase.exploration = self.file.learning.exploration;
        }
        Plan::check(file)
    }
}

fn check_names(file: &TransferFile, source: &Plan) -> Result<(), PlanError> {
    let phases: Vec<&str> = source.file.phase.keys().map(String::as_str).collect();
    let watched = source.file.phase.get(&file.demonstration).is_some_and(|p| p.acting.is_watched());
    if !watched {
        let message =
            format!("`{}`: one of {} in which an expert acts", file.demonstration, phases.join(", "));
        return Err(PlanError::at("demonstration", message));
    }
    for (i, name) in file.policies.iter().enumerate() {
        if source.file.policy.get(name).is_none_or(|row| row.after.is_none()) {
            let message = format!("`{name}`: a policy of the plan that has learned in a phase");
            return Err(PlanError::at(format!("policies[{i}]"), message));
        }
    }
    let empty = [
        ("policies", file.policies.is_empty()),
        ("episodes", file.episodes.is_empty()),
        ("world", file.world.is_empty()),
        ("runs", file.runs == 0),
        ("learning.episodes", file.learning.episodes == 0),
    ];
    match empty.iter().find(|(_, empty)| *empty) {
        Some((field, _)) => Err(PlanError::at(*field, "at least one")),
        None => Ok(()),
    }
}

/// The plan with the phases that the tested policies stand on, and no tests of its own.
fn needed(file: &TransferFile, source: &Plan) -> PlanFile {
    let mut plan = source.file.clone();
    plan.policy.retain(|name, _| file.policies.contains(name));
    let mut keep = vec![file.demonstration.clone()];
    keep.extend(plan.policy.values().filter_map(|row| row.after.clone()));
    let mut next = 0;
    while let Some(name) = keep.get(next) {
        let parent = plan.phase.get(name).and_then(|phase| phase.after.clone());
        keep.extend(parent);
        next += 1;
    }
    plan.phase.retain(|name, _| keep.contains(name));
    plan.evaluation.scenarios.clear();
    plan.subsets = None;
    plan
}
