//! Whether everybody can play the part they are given: rosters, drivers, phases, policies, subsets.

use super::check::Plan;
use super::error::PlanError;
use super::file::{Acting, AttentionFile, PhaseFile, PolicyFile, SubsetsFile};
use super::limits::{self, unknown};
use super::rival::Rival;
use metal_rl::counterfactual::{CounterfactualConfig, JudgeConfig, UnknownMember};
use metal_rl::decision::DecisionDims;
use metal_rl::learner::{Dims, LearnerError};
use metal_rl::phase::{Sensing, Teaching};
use metal_rl::policies::attention::{AttentionConfig, learner_dims};

impl Plan {
    /// Sizes of the decision state.
    fn decision_dims(&self) -> DecisionDims {
        let features = |s: &usize| self.spec.sensors[*s].features.len();
        let inputs = |sensors: &[usize]| sensors.iter().map(features).sum();
        DecisionDims {
            member_inputs: self.members.iter().map(|m| inputs(&m.sensors)).collect(),
            actions: self.spec.actions.len(),
        }
    }

    /// Learners refuse some shapes, and they do so before anything is trained.
    pub(super) fn check_members(&self) -> Result<(), PlanError> {
        let dims = self.decision_dims();
        for (member, &inputs) in self.members.iter().zip(&dims.member_inputs) {
            let fits = member.learner.build(Dims { inputs, choices: dims.actions }, 0);
            fits.map_err(|e| PlanError::at(format!("member.{}.learner", member.name), e.to_string()))?;
        }
        Ok(())
    }

    fn check_roster(&self, field: &str, roster: &[String]) -> Result<(), PlanError> {
        let field = format!("{field}.roster");
        for name in roster {
            if self.member(name).is_none() {
                return Err(unknown(field, "member", name, self.members.iter().map(|m| m.name.as_str())));
            }
        }
        limits::once(&field, roster)
    }

    fn check_acting(&self, field: &str, acting: &Acting, roster: &[String]) -> Result<(), PlanError> {
        let field = format!("{field}.acting");
        match acting {
            Acting::Solo(name) if !roster.contains(name) => {
                Err(unknown(format!("{field}.solo"), "member", name, roster.iter().map(String::as_str)))
            }
            Acting::Fusion(_) | Acting::RandomLooks(_) if roster.is_empty() => {
                Err(PlanError::at(field, "needs somebody on the roster"))
            }
            Acting::Fusion(fuser) => {
                fuser.check(roster.len()).map_err(|e| PlanError::at(format!("{field}.fusion"), e.to_string()))
            }
            Acting::RandomLooks(mean) if !(*mean >= 1.0 && mean.is_finite()) => {
                let message = format!("{mean}: at least 1 look on average, and finite");
                Err(PlanError::at(format!("{field}.random_looks"), message))
            }
            Acting::Attention(name) if !self.file.attention.contains_key(name) => {
                let known = self.file.attention.keys().map(String::as_str);
                Err(unknown(format!("{field}.attention"), "attention controller", name, known))
            }
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

    pub(super) fn learner_exists(&self, field: &str, name: &str) -> Result<(), PlanError> {
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

    pub(super) fn check_phase(&self, field: &str, row: &PhaseFile) -> Result<(), PlanError> {
        if row.roster.is_empty() {
            return Err(PlanError::at(
                format!("{field}.roster"),
                "empty: at least one member takes part in a phase",
            ));
        }
        self.check_roster(field, &row.roster)?;
        self.check_acting(field, &row.acting, &row.roster)?;
        check_attendance(field, row)?;
        limits::rate(&format!("{field}.rate"), row.rate)?;
        limits::credit(&format!("{field}.credit"), row.credit)?;
        limits::schedule(&format!("{field}.exploration"), row.exploration)?;
        limits::budget(&format!("{field}.budget"), row.budget)?;
        check_bootstrap(&format!("{field}.bootstrap"), row)?;
        match &row.acting {
            Acting::Attention(name) => self.check_attention_phase(field, name, row),
            _ => Ok(()),
        }
    }

    /// An attention controller is born for one roster: its looks are numbered by it.
    fn check_attention_phase(&self, field: &str, name: &str, row: &PhaseFile) -> Result<(), PlanError> {
        self.check_same_roster(field, name, &row.roster)?;
        let controller = &self.file.attention[name];
        if controller.counterfactual.is_some() {
            return self.check_counterfactual_phase(field, name, row);
        }
        let members: Vec<usize> = self.roster(&row.roster).iter().collect();
        let dims = learner_dims(&controller.settings, &self.decision_dims(), &members);
        let refuse = |e: LearnerError| PlanError::at(format!("attention.{name}.learner"), e.to_string());
        let learner = controller.learner.as_deref().unwrap_or_default();
        self.file.learner[learner].build(dims, 0).map(drop).map_err(refuse)
    }

    /// Either a learner and its settings, or counterfactual policy iteration.
    pub(super) fn check_attention(&self, field: &str, row: &AttentionFile) -> Result<(), PlanError> {
        match (&row.learner, &row.counterfactual) {
            (Some(_), Some(_)) => {
                let message = "counterfactual policy iteration brings its own networks: leave `learner` out";
                Err(PlanError::at(format!("{field}.learner"), message))
            }
            (None, None) => {
                let message = "missing field `learner` (or `counterfactual`, to learn without one)";
                Err(PlanError::at(field, message))
            }
            (Some(learner), None) => {
                self.learner_exists(field, learner)?;
                limits::attention(&format!("{field}.settings"), &row.settings)
            }
            (None, Some(_)) if row.settings != AttentionConfig::default() => {
                let message =
                    "belong to a learner; those of counterfactual policy iteration stand in its own table";
                Err(PlanError::at(format!("{field}.settings"), message))
            }
            (None, Some(config)) => config.validate().map_err(|e| {
                let LearnerError::Setting { field: below, value, allowed, .. } = e else {
                    return PlanError::at(format!("{field}.counterfactual"), e.to_string());
                };
                PlanError::at(format!("{field}.counterfactual.{below}"), format!("{value}: {allowed}"))
            }),
        }
    }

    /// Roll-outs need copies of the world, and members who do not change under them.
    fn check_counterfactual_phase(&self, field: &str, name: &str, row: &PhaseFile) -> Result<(), PlanError> {
        let Some(config) = &self.file.attention[name].counterfactual else { return Ok(()) };
        if row.teaching != Teaching::Nobody {
            let message = "members must rest while roll-outs speak for them; write teaching = \"nobody\"";
            return Err(PlanError::at(format!("{field}.teaching"), message));
        }
        if row.sensing != Sensing::OnDemand {
            let message = "everyone: looks are for the attention controller to choose; leave it out";
            return Err(PlanError::at(format!("{field}.sensing"), message));
        }
        let copies = || self.file.environment.build().is_ok_and(|world| world.fork().is_some());
        if config.judge == JudgeConfig::RollOuts && !copies() {
            let message = format!(
                "{} cannot be copied, and roll-outs need copies of it; write judge = {{ critic = {{}} }}",
                self.spec.id
            );
            return Err(PlanError::at(format!("{field}.acting.attention"), message));
        }
        let refuse = |e: UnknownMember| {
            let roster = row.roster.iter().map(String::as_str);
            unknown(format!("attention.{name}.counterfactual.looks"), "member", &e.0, roster)
        };
        config.looks.resolve(&row.roster).map(drop).map_err(refuse)
    }

    fn check_same_roster(&self, field: &str, name: &str, roster: &[String]) -> Result<(), PlanError> {
        let trained = self.file.phase.iter().filter(|(_, p)| p.acting == Acting::Attention(name.to_owned()));
        for (phase, other) in trained {
            if self.roster(&other.roster) != self.roster(roster) {
                let message = format!(
                    "attention `{name}` was born for the roster of phase `{phase}` ({}), and can work with no other",
                    other.roster.join(", ")
                );
                return Err(PlanError::at(format!("{field}.roster"), message));
            }
        }
        Ok(())
    }

    pub(super) fn check_policy(&self, field: &str, row: &PolicyFile) -> Result<(), PlanError> {
        if let Some(after) = row.after.as_ref().filter(|a| !self.file.phase.contains_key(*a)) {
            let known = self.file.phase.keys().map(String::as_str);
            return Err(unknown(format!("{field}.after"), "phase", after, known));
        }
        self.check_roster(field, &row.roster)?;
        self.check_acting(field, &row.acting, &row.roster)?;
        if let Acting::Demonstrations(_) = row.acting {
            let message = "demonstrations: only a phase can watch them, nobody can be tested in a recording";
            return Err(PlanError::at(format!("{field}.acting"), message));
        }
        let Acting::Attention(name) = &row.acting else { return Ok(()) };
        if !self.is_trained_by(row.after.as_deref(), name) {
            let message = match &row.after {
                Some(after) => format!("attention `{name}` is not trained in phase `{after}` or before it"),
                None => format!("missing: which phase trained attention `{name}`?"),
            };
            return Err(PlanError::at(format!("{field}.after"), message));
        }
        self.check_same_roster(field, name, &row.roster)
    }

    /// Whether attention controller `name` acts in `phase` or in one it starts from.
    #[must_use]
    pub fn is_trained_by(&self, phase: Option<&str>, name: &str) -> bool {
        let Some(row) = phase.and_then(|p| self.file.phase.get(p)) else { return false };
        row.acting == Acting::Attention(name.to_owned()) || self.is_trained_by(row.after.as_deref(), name)
    }

    pub(super) fn check_evaluation(&self) -> Result<(), PlanError> {
        let known = self.file.environment.scenarios();
        let scenarios = &self.file.evaluation.scenarios;
        if let Some(strange) = scenarios.iter().find(|s| !known.contains(s)) {
            return Err(unknown(
                "evaluation.scenarios",
                "scenario",
                strange,
                known.iter().map(String::as_str),
            ));
        }
        limits::once("evaluation.scenarios", scenarios)?;
        limits::count("evaluation.runs", self.file.evaluation.runs, "runs")
    }

    pub(super) fn check_subsets(&self, subsets: &SubsetsFile) -> Result<(), PlanError> {
        self.check_subset_phases(subsets)?;
        self.check_subset_rules(subsets)?;
        limits::part("subsets.screening_share", subsets.screening_share)?;
        limits::count("subsets.screening_seeds", subsets.screening_seeds, "seeds")?;
        limits::count("subsets.screening_runs", subsets.screening_runs, "runs")?;
        limits::count("subsets.confirmed", subsets.confirmed, "subsets")?;
        let Some(learner) = &subsets.learner else { return Ok(()) };
        self.learner_exists("subsets", learner)?;
        let everything = self.spec.sensors.iter().map(|s| s.features.len());
        for inputs in everything.clone().chain([everything.sum()]) {
            let fits = self.file.learner[learner].build(Dims { inputs, choices: self.spec.actions.len() }, 0);
            fits.map_err(|e| PlanError::at("subsets.learner", e.to_string()))?;
        }
        Ok(())
    }

    /// The settings of counterfactual policy iteration in phase `name`, if it learns that way.
    #[must_use]
    pub fn counterfactual(&self, name: &str) -> Option<(&str, &CounterfactualConfig)> {
        let Acting::Attention(controller) = &self.file.phase.get(name)?.acting else { return None };
        let config = self.file.attention.get(controller)?.counterfactual.as_ref()?;
        Some((controller, config))
    }

    fn check_subset_rules(&self, subsets: &SubsetsFile) -> Result<(), PlanError> {
        let recipe = self.counterfactual(&subsets.like).is_some();
        if recipe && subsets.learner.is_some() {
            let message =
                format!("phase `{}` learns without one, so the subsets do: leave it out", subsets.like);
            return Err(PlanError::at("subsets.learner", message));
        }
        if !recipe && subsets.learner.is_none() {
            return Err(PlanError::at("subsets", "missing field `learner`"));
        }
        limits::once("subsets.among", &subsets.among)?;
        for words in &subsets.among {
            let rival = Rival::parse(self, "subsets.among", words)?;
            if !recipe && rival.every != 1 {
                let message =
                    format!("`{words}`: only by counterfactual policy iteration may one look now and then");
                return Err(PlanError::at("subsets.among", message));
            }
        }
        if subsets.every.is_empty() || subsets.every.contains(&0) {
            return Err(PlanError::at("subsets.every", "motor steps from look to look, each at least 1"));
        }
        if !recipe && subsets.every != [1] {
            let message = "only subsets that learn by counterfactual policy iteration may look now and then";
            return Err(PlanError::at("subsets.every", message));
        }
        if recipe && self.single_eyes(&subsets.like).is_none() {
            let message =
                format!("phase `{}` needs a member for every sensor that sees it alone", subsets.like);
            return Err(PlanError::at("subsets.like", message));
        }
        Ok(())
    }

    /// For every sensor, the member on the roster of `phase` that sees it and nothing else.
    #[must_use]
    pub fn single_eyes(&self, phase: &str) -> Option<Vec<String>> {
        let roster = self.roster(&self.file.phase.get(phase)?.roster);
        let eye = |sensor: usize| {
            let member = roster.iter().map(|m| &self.members[m]).find(|m| m.sensors == [sensor])?;
            Some(member.name.clone())
        };
        (0..self.spec.sensors.len()).map(eye).collect()
    }

    fn check_subset_phases(&self, subsets: &SubsetsFile) -> Result<(), PlanError> {
        let phases = || self.file.phase.keys().map(String::as_str);
        if !self.file.phase.contains_key(&subsets.like) {
            return Err(unknown("subsets.like", "phase", &subsets.like, phases()));
        }
        if let Some(strange) = subsets.budget_of.iter().find(|name| !self.file.phase.contains_key(*name)) {
            return Err(unknown("subsets.budget_of", "phase", strange, phases()));
        }
        limits::once("subsets.budget_of", &subsets.budget_of)?;
        if subsets.budget_of.iter().all(|name| self.file.phase[name].acting.is_watched()) {
            let message =
                "names no phase in which the mind acts by itself: a subset would have nothing to learn from";
            return Err(PlanError::at("subsets.budget_of", message));
        }
        Ok(())
    }
}

/// Somebody must look, or nobody learns.
fn check_attendance(field: &str, row: &PhaseFile) -> Result<(), PlanError> {
    match row.acting {
        Acting::Blind => {
            let message = "blind: only a policy can be blind, its action is chosen after training";
            Err(PlanError::at(format!("{field}.acting"), message))
        }
        Acting::Advisor | Acting::Demonstrations(_) if row.sensing == Sensing::OnDemand => {
            let message =
                "on_demand: an advisor consults nobody, so nobody would learn; write sensing = \"everyone\"";
            Err(PlanError::at(format!("{field}.sensing"), message))
        }
        _ => Ok(()),
    }
}

/// Whoever lends a value must have looked before every move.
fn check_bootstrap(field: &str, row: &PhaseFile) -> Result<(), PlanError> {
    let Some(name) = &row.bootstrap else { return Ok(()) };
    if !row.roster.contains(name) {
        return Err(unknown(field, "member", name, row.roster.iter().map(String::as_str)));
    }
    let looks = match &row.acting {
        Acting::Fusion(_) => true,
        Acting::Solo(driver) => driver == name,
        _ => false,
    };
    if looks || row.sensing == Sensing::Everyone {
        return Ok(());
    }
    let message =
        format!("`{name}` does not look before every move of this phase, so it has no value to lend");
    Err(PlanError::at(field, message))
}
