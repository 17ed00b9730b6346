//! From what was typed to what it means: every name resolved, every number possible.

use super::error::PlanError;
use super::file::{Acting, PhaseFile, PlanFile};
use super::limits::{self, unknown};
use crate::registry::{EnvironmentConfig, WorldError};
use metal_rl::environment::EnvironmentSpec;
use metal_rl::fuse::Fuser;
use metal_rl::learners::LearnerConfig;
use metal_rl::phase::{Budget, Lessons, Phase};
use metal_rl::set::IndexSet;
use std::collections::BTreeMap;

/// The policy name under which results repeat the best fixed subset.
const BEST_FIXED: &str = "best_fixed";

/// A member as planned.
#[derive(Clone, Debug, PartialEq)]
pub struct MemberPlan {
    /// Name.
    pub name: String,
    /// Sensors seen, as indices into the spec.
    pub sensors: Vec<usize>,
    /// How it learns.
    pub learner: LearnerConfig,
}

/// A checked experiment: only this can be run.
#[derive(Clone, Debug)]
pub struct Plan {
    /// As typed; only a pool's weights and its roster are put into the order of the members.
    pub file: PlanFile,
    /// The world's contract.
    pub spec: EnvironmentSpec,
    /// Members, tiny agents first (in the order of their sensors), then those who see more.
    pub members: Vec<MemberPlan>,
    /// Phase names, each after the phase it starts from.
    pub order: Vec<String>,
}

impl Plan {
    /// Checks a file.
    ///
    /// # Errors
    /// The first thing that is impossible, by field, with what is allowed.
    pub fn check(file: PlanFile) -> Result<Self, PlanError> {
        check_names(&file)?;
        let refuse = |e: WorldError| PlanError::at(format!("environment.{}", e.field), e.message);
        let spec = file.environment.build().map_err(refuse)?.spec().clone();
        for (name, learner) in &file.learner {
            learner.validate().map_err(|e| PlanError::at(format!("learner.{name}"), e.to_string()))?;
        }
        let members = members(&file, &spec)?;
        let order = phase_order(&file.phase)?;
        let mut plan = Self { file, spec, members, order };
        plan.check_everybody()?;
        plan.put_weights_in_order();
        Ok(plan)
    }

    fn check_everybody(&self) -> Result<(), PlanError> {
        self.check_members()?;
        for (name, row) in &self.file.attention {
            self.check_attention(&format!("attention.{name}"), row)?;
        }
        for (name, phase) in &self.file.phase {
            self.check_phase(&format!("phase.{name}"), phase)?;
        }
        for (name, policy) in &self.file.policy {
            self.check_policy(&format!("policy.{name}"), policy)?;
        }
        self.check_evaluation()?;
        self.file.subsets.as_ref().map_or(Ok(()), |subsets| self.check_subsets(subsets))
    }

    /// Weights of a pool are typed in the order of the roster; a mind knows only the order of its members.
    fn put_weights_in_order(&mut self) {
        let place: BTreeMap<String, usize> =
            self.members.iter().enumerate().map(|(i, m)| (m.name.clone(), i)).collect();
        let phases = self.file.phase.values_mut().map(|row| (&mut row.roster, &mut row.acting));
        let policies = self.file.policy.values_mut().map(|row| (&mut row.roster, &mut row.acting));
        for (roster, acting) in phases.chain(policies) {
            if let Acting::Fusion(Fuser::WeightedLogOpinionPool { weights }) = acting {
                let mut rows: Vec<(String, f64)> = roster.drain(..).zip(weights.drain(..)).collect();
                rows.sort_by_key(|(name, _)| place[name]);
                (*roster, *weights) = rows.into_iter().unzip();
            }
        }
    }

    /// Index of the member called `name`.
    #[must_use]
    pub fn member(&self, name: &str) -> Option<usize> {
        self.members.iter().position(|m| m.name == name)
    }

    /// The members called `names`.
    #[must_use]
    pub fn roster(&self, names: &[String]) -> IndexSet {
        names.iter().filter_map(|n| self.member(n)).collect()
    }

    /// The phase `name` as the loop wants it.
    #[must_use]
    pub fn phase(&self, name: &str) -> Phase {
        let row = &self.file.phase[name];
        Phase {
            name: name.to_owned(),
            roster: self.roster(&row.roster),
            sensing: row.sensing,
            lessons: Lessons {
                teaching: row.teaching,
                rate: row.rate,
                credit: row.credit,
                bootstrap: row.bootstrap.as_deref().and_then(|n| self.member(n)),
                demonstrated: row.acting.is_watched(),
            },
            policy_learns: matches!(row.acting, Acting::Attention(_)),
            exploration: row.exploration,
            budget: row.budget,
        }
    }

    /// Motor steps of the budget of phase `name` (an episode counts as its horizon).
    #[must_use]
    pub fn budget_steps(&self, name: &str) -> usize {
        match self.file.phase[name].budget {
            Budget::Steps(n) => n,
            Budget::Episodes(n) => n * self.spec.horizon,
        }
    }

    /// The scenarios of the evaluation.
    #[must_use]
    pub fn scenarios(&self) -> Vec<String> {
        let chosen = &self.file.evaluation.scenarios;
        if chosen.is_empty() { self.file.environment.scenarios() } else { chosen.clone() }
    }
}

/// Every name of the file.
fn check_names(file: &PlanFile) -> Result<(), PlanError> {
    let names = |table: &str, names: Vec<&String>| names.iter().try_for_each(|n| limits::name(table, n));
    names("learner", file.learner.keys().collect())?;
    names("member", file.member.keys().collect())?;
    names("attention", file.attention.keys().collect())?;
    names("phase", file.phase.keys().collect())?;
    names("policy", file.policy.keys().collect())?;
    if file.policy.contains_key(BEST_FIXED) {
        let message = "this name is kept for the fixed subset that did best";
        return Err(PlanError::at(format!("policy.{BEST_FIXED}"), message));
    }
    Ok(())
}

fn members(file: &PlanFile, spec: &EnvironmentSpec) -> Result<Vec<MemberPlan>, PlanError> {
    let mut members = Vec::new();
    for (name, row) in &file.member {
        let mut sensors = Vec::new();
        for sensor in &row.sensors {
            let Some(index) = spec.sensor(sensor) else {
                let known = spec.sensors.iter().map(|s| s.name.as_str());
                return Err(unknown(format!("member.{name}.sensors"), "sensor", sensor, known));
            };
            if sensors.contains(&index) {
                return Err(PlanError::at(format!("member.{name}.sensors"), format!("`{sensor}` twice")));
            }
            sensors.push(index);
        }
        if sensors.is_empty() {
            return Err(PlanError::at(
                format!("member.{name}.sensors"),
                "empty: a member sees at least one sensor",
            ));
        }
        let Some(learner) = file.learner.get(&row.learner) else {
            let known = file.learner.keys().map(String::as_str);
            return Err(unknown(format!("member.{name}.learner"), "learner", &row.learner, known));
        };
        members.push(MemberPlan { name: name.clone(), sensors, learner: learner.clone() });
    }
    members
        .sort_by(|a, b| (a.sensors.len(), &a.sensors, &a.name).cmp(&(b.sensors.len(), &b.sensors, &b.name)));
    if members.is_empty() || members.len() > IndexSet::CAPACITY {
        let message = format!("{} members: between 1 and {}", members.len(), IndexSet::CAPACITY);
        return Err(PlanError::at("member", message));
    }
    Ok(members)
}

/// Phases so that each comes after the one it starts from.
fn phase_order(phases: &BTreeMap<String, PhaseFile>) -> Result<Vec<String>, PlanError> {
    let known = || phases.keys().map(String::as_str);
    for (name, row) in phases {
        if let Some(after) = row.after.as_ref().filter(|a| !phases.contains_key(*a)) {
            return Err(unknown(format!("phase.{name}.after"), "phase", after, known()));
        }
        if starts_from_itself(phases, name) {
            let message =
                format!("`{}` starts, in the end, from `{name}` itself", row.after.as_deref().unwrap_or(""));
            return Err(PlanError::at(format!("phase.{name}.after"), message));
        }
    }
    let mut order: Vec<String> = Vec::new();
    while order.len() < phases.len() {
        for (name, row) in phases {
            let ready = row.after.as_ref().is_none_or(|a| order.contains(a));
            if ready && !order.contains(name) {
                order.push(name.clone());
            }
        }
    }
    Ok(order)
}

/// Whether following `after` from `name` leads back to it.
fn starts_from_itself(phases: &BTreeMap<String, PhaseFile>, name: &str) -> bool {
    let parent = |n: &str| phases.get(n).and_then(|row| row.after.as_deref());
    let ancestors = std::iter::successors(parent(name), |n| parent(n));
    // A cycle further up is found there; no line of ancestors is longer than there are phases.
    ancestors.take(phases.len()).any(|n| n == name)
}

/// The environment of a plan, elsewhere: other roads, another scenario.
impl Plan {
    /// The environment with another scenario and other roads, where it has them.
    #[must_use]
    pub fn environment(&self, scenario: &str, roads: Option<&crate::registry::Roads>) -> EnvironmentConfig {
        let mut config = self.file.environment.clone();
        config.set_scenario(scenario);
        if let Some(roads) = roads {
            config.set_roads(roads);
        }
        config
    }
}
