//! From what was typed to what it means: every name resolved, every number possible.

use super::error::PlanError;
use super::file::{Acting, AttentionFile, PhaseFile, PlanFile, PolicyFile, SubsetsFile};
use crate::registry::EnvironmentConfig;
use metal_rl::environment::EnvironmentSpec;
use metal_rl::explore::Schedule;
use metal_rl::learner::Rate;
use metal_rl::learners::LearnerConfig;
use metal_rl::phase::{Budget, Lessons, Phase};
use metal_rl::returns::Credit;
use metal_rl::set::IndexSet;
use std::collections::BTreeMap;

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
    /// As typed.
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
        let environment =
            file.environment.build().map_err(|e| PlanError::at("environment", e.to_string()))?;
        let spec = environment.spec().clone();
        for (name, learner) in &file.learner {
            learner.validate().map_err(|e| PlanError::at(format!("learner.{name}"), e.to_string()))?;
        }
        let members = members(&file, &spec)?;
        let order = phase_order(&file.phase)?;
        let plan = Self { file, spec, members, order };
        for (name, attention) in &plan.file.attention {
            plan.check_attention(&format!("attention.{name}"), attention)?;
        }
        for (name, phase) in &plan.file.phase {
            plan.check_phase(&format!("phase.{name}"), phase)?;
        }
        for (name, policy) in &plan.file.policy {
            plan.check_policy(&format!("policy.{name}"), policy)?;
        }
        plan.check_evaluation()?;
        if let Some(subsets) = &plan.file.subsets {
            plan.check_subsets(subsets)?;
        }
        Ok(plan)
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
                demonstrated: row.acting == Acting::Advisor,
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

    fn check_roster(&self, field: &str, roster: &[String]) -> Result<(), PlanError> {
        for name in roster {
            if self.member(name).is_none() {
                let names = self.members.iter().map(|m| m.name.as_str());
                return Err(unknown(format!("{field}.roster"), "member", name, names));
            }
        }
        Ok(())
    }

    fn check_acting(&self, field: &str, acting: &Acting, roster: &[String]) -> Result<(), PlanError> {
        let field = format!("{field}.acting");
        match acting {
            Acting::Solo(name) if !roster.contains(name) => {
                Err(unknown(field, "member", name, roster.iter().map(String::as_str)))
            }
            Acting::Fusion(_) | Acting::RandomLooks(_) if roster.is_empty() => {
                Err(PlanError::at(field, "needs somebody on the roster"))
            }
            Acting::RandomLooks(mean) if !(*mean >= 1.0) => {
                Err(PlanError::at(field, format!("random_looks = {mean}: at least 1 look on average")))
            }
            Acting::Attention(name) if !self.file.attention.contains_key(name) => Err(unknown(
                field,
                "attention controller",
                name,
                self.file.attention.keys().map(String::as_str),
            )),
            Acting::Advisor if !self.has_advisor() => {
                Err(PlanError::at(field, format!("{} has no expert advisor", self.spec.id)))
            }
            _ => Ok(()),
        }
    }

    fn has_advisor(&self) -> bool {
        let Ok(mut environment) = self.file.environment.build() else { return false };
        environment.reset(0).is_ok() && environment.advise().is_some()
    }

    fn check_attention(&self, field: &str, attention: &AttentionFile) -> Result<(), PlanError> {
        self.learner_exists(field, &attention.learner)?;
        let s = &attention.settings;
        check_credit(&format!("{field}.settings.credit"), s.credit)?;
        check_rate(&format!("{field}.settings.rate"), s.rate)?;
        if !(0.0..=1.0).contains(&s.price_ramp) {
            return Err(PlanError::at(
                format!("{field}.settings.price_ramp"),
                format!("{}: a share in [0, 1]", s.price_ramp),
            ));
        }
        if s.min_looks > s.max_looks {
            let message = format!("{} looks at least, but {} at most", s.min_looks, s.max_looks);
            return Err(PlanError::at(format!("{field}.settings.min_looks"), message));
        }
        Ok(())
    }

    fn learner_exists(&self, field: &str, name: &str) -> Result<(), PlanError> {
        if self.file.learner.contains_key(name) {
            return Ok(());
        }
        Err(unknown(
            format!("{field}.learner"),
            "learner",
            name,
            self.file.learner.keys().map(String::as_str),
        ))
    }

    fn check_phase(&self, field: &str, row: &PhaseFile) -> Result<(), PlanError> {
        self.check_roster(field, &row.roster)?;
        self.check_acting(field, &row.acting, &row.roster)?;
        check_rate(&format!("{field}.rate"), row.rate)?;
        check_credit(&format!("{field}.credit"), row.credit)?;
        check_schedule(&format!("{field}.exploration"), row.exploration)?;
        let (Budget::Episodes(n) | Budget::Steps(n)) = row.budget;
        if n == 0 {
            return Err(PlanError::at(format!("{field}.budget"), "0: at least one episode or step"));
        }
        match &row.bootstrap {
            Some(name) if !row.roster.contains(name) => Err(unknown(
                format!("{field}.bootstrap"),
                "member",
                name,
                row.roster.iter().map(String::as_str),
            )),
            _ => Ok(()),
        }
    }

    fn check_policy(&self, field: &str, row: &PolicyFile) -> Result<(), PlanError> {
        if let Some(after) = &row.after {
            if !self.file.phase.contains_key(after) {
                return Err(unknown(
                    format!("{field}.after"),
                    "phase",
                    after,
                    self.file.phase.keys().map(String::as_str),
                ));
            }
        }
        self.check_roster(field, &row.roster)?;
        self.check_acting(field, &row.acting, &row.roster)?;
        match &row.acting {
            Acting::Attention(name) if !self.is_trained_by(row.after.as_deref(), name) => {
                let message = format!(
                    "attention `{name}` is not trained in `{}` or before it",
                    row.after.as_deref().unwrap_or("")
                );
                Err(PlanError::at(format!("{field}.after"), message))
            }
            _ => Ok(()),
        }
    }

    /// Whether attention controller `name` acts in `phase` or in one it starts from.
    fn is_trained_by(&self, phase: Option<&str>, name: &str) -> bool {
        let Some(row) = phase.and_then(|p| self.file.phase.get(p)) else { return false };
        row.acting == Acting::Attention(name.to_owned()) || self.is_trained_by(row.after.as_deref(), name)
    }

    fn check_evaluation(&self) -> Result<(), PlanError> {
        let known = self.file.environment.scenarios();
        for scenario in &self.file.evaluation.scenarios {
            if !known.contains(scenario) {
                return Err(unknown(
                    "evaluation.scenarios".into(),
                    "scenario",
                    scenario,
                    known.iter().map(String::as_str),
                ));
            }
        }
        if self.file.evaluation.runs == 0 {
            return Err(PlanError::at("evaluation.runs", "0: at least one run"));
        }
        Ok(())
    }

    fn check_subsets(&self, subsets: &SubsetsFile) -> Result<(), PlanError> {
        self.learner_exists("subsets", &subsets.learner)?;
        let phases = || self.file.phase.keys().map(String::as_str);
        for name in subsets.budget_of.iter().chain([&subsets.like]) {
            if !self.file.phase.contains_key(name) {
                return Err(unknown("subsets".into(), "phase", name, phases()));
            }
        }
        if !(subsets.screening_share > 0.0 && subsets.screening_share <= 1.0) {
            let message = format!("{}: a share in (0, 1]", subsets.screening_share);
            return Err(PlanError::at("subsets.screening_share", message));
        }
        if subsets.screening_seeds == 0 || subsets.screening_runs == 0 {
            return Err(PlanError::at(
                "subsets.screening_seeds",
                "screening needs at least one seed and one run",
            ));
        }
        Ok(())
    }
}

fn unknown<'a>(field: String, kind: &str, found: &str, known: impl Iterator<Item = &'a str>) -> PlanError {
    let known: Vec<&str> = known.collect();
    PlanError::at(field, format!("unknown {kind} `{found}`; known: {}", known.join(", ")))
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
    let mut order: Vec<String> = Vec::new();
    while order.len() < phases.len() {
        let before = order.len();
        for (name, row) in phases {
            let ready = row.after.as_ref().is_none_or(|a| order.contains(a));
            if ready && !order.contains(name) {
                order.push(name.clone());
            }
        }
        if order.len() == before {
            let (name, row) = phases.iter().find(|(n, _)| !order.contains(n)).expect("some phase is left");
            let after = row.after.clone().unwrap_or_default();
            let field = format!("phase.{name}.after");
            if phases.contains_key(&after) {
                return Err(PlanError::at(
                    field,
                    format!("`{after}` starts, in the end, from `{name}` itself"),
                ));
            }
            return Err(unknown(field, "phase", &after, phases.keys().map(String::as_str)));
        }
    }
    Ok(order)
}

fn check_rate(field: &str, rate: Rate) -> Result<(), PlanError> {
    match rate {
        Rate::Constant(r) | Rate::Average(r) if !(r > 0.0 && r <= 1.0) => {
            Err(PlanError::at(field, format!("{r}: a step size in (0, 1]")))
        }
        _ => Ok(()),
    }
}

fn check_credit(field: &str, credit: Credit) -> Result<(), PlanError> {
    if !(0.0..1.0).contains(&credit.gamma) {
        return Err(PlanError::at(
            format!("{field}.gamma"),
            format!("{}: a discount in [0, 1)", credit.gamma),
        ));
    }
    if !(0.0..=1.0).contains(&credit.lambda) {
        return Err(PlanError::at(
            format!("{field}.lambda"),
            format!("{}: a share in [0, 1]", credit.lambda),
        ));
    }
    Ok(())
}

fn check_schedule(field: &str, schedule: Schedule) -> Result<(), PlanError> {
    let (from, to, until, most) = match schedule {
        Schedule::Greedy => return Ok(()),
        Schedule::SoftMax { from, to, until } => (from, to, until, f64::INFINITY),
        Schedule::Random { from, to, until } => (from, to, until, 1.0),
    };
    if !(from > 0.0 && from <= most && to > 0.0 && to <= most) {
        return Err(PlanError::at(field, format!("from {from} to {to}: both above 0 and at most {most}")));
    }
    if !(until > 0.0 && until <= 1.0) {
        return Err(PlanError::at(field, format!("until {until}: a share of the phase in (0, 1]")));
    }
    Ok(())
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
