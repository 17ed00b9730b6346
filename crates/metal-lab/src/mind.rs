//! A mind: the members of a plan and its attention controllers, newborn, trained, frozen or thawed.

use crate::plan::{Acting, Plan};
use metal_rl::counterfactual::iterate::student_shape;
use metal_rl::counterfactual::{CounterfactualConfig, Student, StudentShape};
use metal_rl::fuse::Fuser;
use metal_rl::learner::{Dims, LearnerError};
use metal_rl::member::{Member, decision_dims};
use metal_rl::policies::attention::{Consultable, learner_dims};
use metal_rl::policies::{Advisor, Attention, Blind, Counterfactual, Fusion, RandomLooks, Solo};
use metal_rl::policy::Policy;
use metal_rl::random::Streams;
use metal_rl::set::IndexSet;
use metal_rl::view::View;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Members and attention controllers.
#[derive(Clone)]
pub struct Mind {
    /// Members, in the order of the plan.
    pub members: Vec<Member>,
    /// Attention controllers, each born when its phase begins.
    pub attention: BTreeMap<String, Attention>,
    /// Students of counterfactual policy iteration, by the name of their attention controller.
    pub students: BTreeMap<String, Counterfactual>,
}

/// A mind as bytes: learners by the name of their owner.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrozenMind {
    /// Format version.
    pub version: u32,
    /// Members' learners.
    pub members: BTreeMap<String, Vec<u8>>,
    /// Attention controllers' learners, with the roster each was born for.
    pub attention: BTreeMap<String, (Vec<String>, Vec<u8>)>,
}

/// Version of [`FrozenMind`].
pub const FROZEN_VERSION: u32 = 1;

impl Mind {
    /// The newborn mind of `plan`; every learner's own randomness comes from `streams`.
    ///
    /// # Errors
    /// If a learner refuses its settings.
    pub fn newborn(plan: &Plan, streams: &Streams) -> Result<Self, LearnerError> {
        let mut members = Vec::new();
        for m in &plan.members {
            let view = View::new(&plan.spec, &m.sensors);
            let dims = Dims { inputs: view.dims(), choices: plan.spec.actions.len() };
            let learner = m.learner.build(dims, streams.child("member").child(&m.name).seed())?;
            members.push(Member { name: m.name.clone(), view, learner });
        }
        Ok(Self { members, attention: BTreeMap::new(), students: BTreeMap::new() })
    }

    /// Takes the attention controller `name` out of the mind; a newborn one over `roster` if there is none yet.
    ///
    /// # Errors
    /// If its learner refuses its settings.
    pub fn take_attention(
        &mut self,
        plan: &Plan,
        name: &str,
        roster: IndexSet,
        streams: &Streams,
    ) -> Result<Attention, LearnerError> {
        if let Some(attention) = self.attention.remove(name) {
            return Ok(attention);
        }
        let (dims, config) = self.attention_shape(plan, name, roster);
        let learner = config.build(dims, streams.child("attention").child(name).seed())?;
        Ok(self.attention_with(plan, name, roster, learner))
    }

    fn attention_shape(
        &self,
        plan: &Plan,
        name: &str,
        roster: IndexSet,
    ) -> (Dims, metal_rl::learners::LearnerConfig) {
        let row = &plan.file.attention[name];
        let members: Vec<usize> = roster.iter().collect();
        let dims = learner_dims(&row.settings, &decision_dims(&self.members, &plan.spec), &members);
        let learner = row.learner.as_deref().expect("checked plan");
        (dims, plan.file.learner[learner].clone())
    }

    fn attention_with(
        &self,
        plan: &Plan,
        name: &str,
        roster: IndexSet,
        learner: Box<dyn metal_rl::learner::Learner>,
    ) -> Attention {
        let members: Vec<usize> = roster.iter().collect();
        let prices = members.iter().map(|&m| self.members[m].price(&plan.spec)).collect();
        let dims = decision_dims(&self.members, &plan.spec);
        let settings = plan.file.attention[name].settings.clone();
        Attention::new(settings, learner, &dims, Consultable { members, prices })
    }

    fn thaw_student(
        &self,
        plan: &Plan,
        config: &CounterfactualConfig,
        roster: IndexSet,
        bytes: &[u8],
    ) -> Result<Counterfactual, LearnerError> {
        let slots: Vec<usize> = roster.iter().collect();
        let shape: StudentShape = student_shape(config, &self.members, &slots, &plan.spec)
            .map_err(|e| LearnerError::Frozen { learner: "counterfactual", reason: e.to_string() })?;
        Ok(Counterfactual::new(Student::thaw(config, &shape, bytes)?, slots))
    }

    /// Whether the attention controller `name` was born.
    #[must_use]
    pub fn has_attention(&self, name: &str) -> bool {
        self.attention.contains_key(name) || self.students.contains_key(name)
    }

    /// Puts somebody at the wheel. An attention controller must have been born.
    ///
    /// # Panics
    /// If the plan names an attention controller that was never born (a checked plan does not).
    #[must_use]
    pub fn policy(&self, plan: &Plan, acting: &Acting, roster: IndexSet, blind: usize) -> Box<dyn Policy> {
        let actions = plan.spec.actions.len();
        match acting {
            Acting::Advisor | Acting::Demonstrations(_) => Box::new(Advisor),
            Acting::Solo(name) => Box::new(Solo::new(plan.member(name).expect("checked plan"), actions)),
            Acting::Fusion(fuser) => Box::new(Fusion::new(fuser.clone(), roster, actions)),
            Acting::Attention(name) => match self.students.get(name) {
                Some(student) => Box::new(student.clone()),
                None => Box::new(self.attention[name].clone()),
            },
            Acting::RandomLooks(mean) => {
                Box::new(RandomLooks::new(Fuser::MaxConfidence, roster, *mean, actions))
            }
            Acting::Blind => Box::new(Blind { action: blind }),
        }
    }

    /// All learners as bytes.
    #[must_use]
    pub fn freeze(&self, attention_rosters: &BTreeMap<String, Vec<String>>) -> FrozenMind {
        let members = self.members.iter().map(|m| (m.name.clone(), m.learner.freeze())).collect();
        let learners = self.attention.iter().map(|(name, a)| (name, a.learner().freeze()));
        let students = self.students.iter().map(|(name, s)| (name, s.student().freeze()));
        let attention = learners
            .chain(students)
            .map(|(name, bytes)| {
                let roster = attention_rosters.get(name).cloned().unwrap_or_default();
                (name.clone(), (roster, bytes))
            })
            .collect();
        FrozenMind { version: FROZEN_VERSION, members, attention }
    }

    /// As [`Self::freeze`], every attention controller with the roster that `plan` gives it.
    #[must_use]
    pub fn freeze_for(&self, plan: &Plan) -> FrozenMind {
        let rows = plan.file.phase.values();
        let rosters = rows.filter_map(|row| match &row.acting {
            Acting::Attention(name) => Some((name.clone(), row.roster.clone())),
            _ => None,
        });
        self.freeze(&rosters.collect())
    }

    /// The mind of `plan` with the learners of `frozen`.
    ///
    /// # Errors
    /// If bytes are damaged or a member is missing.
    pub fn thaw(plan: &Plan, frozen: &FrozenMind) -> Result<Self, LearnerError> {
        let damaged = |reason: String| LearnerError::Frozen { learner: "mind", reason };
        if frozen.version != FROZEN_VERSION {
            return Err(damaged(format!("version {}, this program reads {FROZEN_VERSION}", frozen.version)));
        }
        let mut mind = Self::newborn(plan, &Streams::new(0))?;
        for (member, row) in mind.members.iter_mut().zip(&plan.members) {
            let Some(bytes) = frozen.members.get(&member.name) else {
                return Err(damaged(format!("member `{}` is missing", member.name)));
            };
            let learner = row.learner.thaw(bytes)?;
            if learner.dims() != member.learner.dims() {
                return Err(damaged(format!("member `{}` has another shape than the plan", member.name)));
            }
            member.learner = learner;
        }
        for (name, (roster, bytes)) in &frozen.attention {
            if !plan.file.attention.contains_key(name) {
                return Err(damaged(format!("attention `{name}` is not in the plan")));
            }
            let roster = plan.roster(roster);
            if let Some(config) = &plan.file.attention[name].counterfactual {
                let student = mind.thaw_student(plan, config, roster, bytes)?;
                mind.students.insert(name.clone(), student);
                continue;
            }
            let (dims, config) = mind.attention_shape(plan, name, roster);
            let learner = config.thaw(bytes)?;
            if learner.dims() != dims {
                return Err(damaged(format!("attention `{name}` has another shape than the plan")));
            }
            let attention = mind.attention_with(plan, name, roster, learner);
            mind.attention.insert(name.clone(), attention);
        }
        Ok(mind)
    }
}
