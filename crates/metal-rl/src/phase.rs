//! A phase of learning is data: who takes part, who senses, who learns, from what, for how long. Sec. 3.2.

use crate::explore::Schedule;
use crate::learner::Rate;
use crate::returns::Credit;
use crate::set::IndexSet;
use serde::{Deserialize, Serialize};

/// Who reads sensors before a move.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Sensing {
    /// The whole roster, whatever the policy wants (Phase I: all watch the advisor).
    Everyone,
    /// Whoever the policy consults.
    #[default]
    OnDemand,
}

/// Who learns from a motor step, among the roster.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Teaching {
    /// Those who were attended: they alone know what they saw.
    #[default]
    Attended,
    /// Nobody: evaluation, frozen experts.
    Nobody,
}

/// When a phase ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Budget {
    /// After this many episodes.
    Episodes(usize),
    /// After this many motor steps (the last episode is cut like by a time limit).
    Steps(usize),
}

/// How members learn in a phase.
#[derive(Clone, Debug, PartialEq)]
pub struct Lessons {
    /// Who learns.
    pub teaching: Teaching,
    /// How fast.
    pub rate: Rate,
    /// How credit flows back.
    pub credit: Credit,
    /// Member whose state value everybody bootstraps from (the FOA in Phase II, reading R9); none: each from its own.
    pub bootstrap: Option<usize>,
    /// Whether the moves are an expert's, who counts as flawless.
    pub demonstrated: bool,
}

/// One phase of one run.
#[derive(Clone, Debug, PartialEq)]
pub struct Phase {
    /// Name for records.
    pub name: String,
    /// Members that take part.
    pub roster: IndexSet,
    /// Who senses.
    pub sensing: Sensing,
    /// How members learn.
    pub lessons: Lessons,
    /// Whether the policy itself learns (attention control).
    pub policy_learns: bool,
    /// How the policy explores.
    pub exploration: Schedule,
    /// When it ends.
    pub budget: Budget,
}

impl Phase {
    /// Greedy evaluation over `episodes` by `roster`: nobody learns, nobody explores.
    #[must_use]
    pub fn evaluation(name: &str, roster: IndexSet, episodes: usize) -> Self {
        Self {
            name: name.to_owned(),
            roster,
            sensing: Sensing::OnDemand,
            lessons: Lessons {
                teaching: Teaching::Nobody,
                rate: Rate::Full,
                credit: Credit::default(),
                bootstrap: None,
                demonstrated: false,
            },
            policy_learns: false,
            exploration: Schedule::Greedy,
            budget: Budget::Episodes(episodes),
        }
    }

    /// Whether anybody learns.
    #[must_use]
    pub fn learns(&self) -> bool {
        self.policy_learns || self.lessons.teaching != Teaching::Nobody
    }
}
