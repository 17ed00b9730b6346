//! The experiment with the proposed members: who is replaced, and where.

use super::{Criterion, Group, PartitionOptions, Proposal};
use crate::plan::file::MemberFile;
use crate::plan::limits::unknown;
use crate::plan::{Acting, Plan, PlanError};
use std::fmt::Write;

/// Whose places the groups take: the roster of one phase, with the sensors of all of them.
pub(super) struct Template {
    /// Sensors to be partitioned, in the order of the world.
    pub sensors: Vec<usize>,
    /// Members that go.
    replaced: Vec<String>,
    /// Names of the members that stay.
    kept: Vec<String>,
    learner: String,
}

impl Template {
    pub fn of(plan: &Plan, options: &PartitionOptions) -> Result<Self, PlanError> {
        let phase = phase(plan, options)?;
        let replaced = plan.file.phase[phase].roster.clone();
        let members = plan.members.iter().filter(|m| replaced.contains(&m.name));
        let mut sensors: Vec<usize> = members.flat_map(|m| m.sensors.iter().copied()).collect();
        sensors.sort_unstable();
        sensors.dedup();
        if sensors.len() < 2 {
            let message = "its members see one sensor, which cannot be partitioned";
            return Err(PlanError::at(format!("phase.{phase}.roster"), message));
        }
        let kept = plan.file.member.keys().filter(|name| !replaced.contains(name)).cloned().collect();
        let learner = plan.file.member[&replaced[0]].learner.clone();
        Ok(Self { sensors, replaced, kept, learner })
    }

    /// G1, G2, …, but for names of members that stay.
    pub fn free_names(&self) -> impl Iterator<Item = String> {
        (1_usize..).map(|n| format!("G{n}")).filter(|name| !self.kept.contains(name))
    }

    /// The plan with the groups in the places of those who go.
    pub fn filled(
        &self,
        plan: &Plan,
        groups: &[Group],
        options: &PartitionOptions,
    ) -> Result<Plan, PlanError> {
        let mut file = plan.file.clone();
        let by = match options.by {
            Criterion::Alike => "alike",
            Criterion::Worth => "worth",
            Criterion::Random => "random",
        };
        file.title = format!("{} (members by `{by}`)", file.title);
        file.member.retain(|name, _| self.kept.contains(name));
        for group in groups {
            let row = MemberFile { sensors: group.sensors.clone(), learner: self.learner.clone() };
            file.member.insert(group.name.clone(), row);
        }
        let phases = file.phase.values_mut().map(|row| &mut row.roster);
        let policies = file.policy.values_mut().map(|row| &mut row.roster);
        phases.chain(policies).for_each(|roster| self.fill(roster, groups));
        Plan::check(file).map_err(|e| {
            let message =
                format!("{} (with the groups in the places of {})", e.message, self.replaced.join(", "));
            PlanError::at(e.field, message)
        })
    }

    /// All groups where the first of those who go stood.
    fn fill(&self, roster: &mut Vec<String>, groups: &[Group]) {
        let Some(place) = roster.iter().position(|name| self.replaced.contains(name)) else { return };
        roster.retain(|name| !self.replaced.contains(name));
        roster.splice(place..place, groups.iter().map(|group| group.name.clone()));
    }
}

/// The phase whose members are replaced.
fn phase<'a>(plan: &'a Plan, options: &'a PartitionOptions) -> Result<&'a str, PlanError> {
    if let Some(name) = &options.phase {
        let known = plan.order.iter().map(String::as_str);
        let found = plan.file.phase.contains_key(name).then_some(name.as_str());
        return found.ok_or_else(|| unknown("phase", "phase", name, known));
    }
    let attends = |name: &&String| matches!(plan.file.phase[*name].acting, Acting::Attention(_));
    let any = plan.order.iter().find(attends).or(plan.order.first());
    any.map(String::as_str).ok_or_else(|| PlanError::at("phase", "the plan has none"))
}

impl Proposal {
    /// The experiment as it is written to disk, with a word on where its members come from.
    ///
    /// # Errors
    /// If a number of the plan cannot be written as TOML.
    pub fn experiment(&self) -> Result<String, toml::ser::Error> {
        let mut text = "# Members proposed by `metal partition`.\n".to_owned();
        for group in &self.groups {
            let _ = writeln!(text, "# {}: tells {:.2} for {:.2}", group.name, group.tells, group.price);
        }
        text.push('\n');
        Ok(text + &toml::to_string(&self.plan.file)?)
    }
}
