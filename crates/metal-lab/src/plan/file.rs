//! The experiment file as it is typed: TOML tables, every key known, nothing checked against anything else yet.

use crate::registry::EnvironmentConfig;
use metal_rl::counterfactual::CounterfactualConfig;
use metal_rl::explore::Schedule;
use metal_rl::fuse::Fuser;
use metal_rl::learner::Rate;
use metal_rl::learners::LearnerConfig;
use metal_rl::phase::{Budget, Sensing, Teaching};
use metal_rl::policies::AttentionConfig;
use metal_rl::returns::Credit;
use metal_rl::view::Scaling;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// An experiment file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanFile {
    /// One line that says what the experiment is for.
    pub title: String,
    /// The world.
    pub environment: EnvironmentConfig,
    /// How readings are scaled for every member.
    #[serde(default)]
    pub scaling: Scaling,
    /// Learners by name, for members and attention to refer to.
    pub learner: BTreeMap<String, LearnerConfig>,
    /// Members by name: tiny agents, full observer.
    pub member: BTreeMap<String, MemberFile>,
    /// Attention controllers by name.
    #[serde(default)]
    pub attention: BTreeMap<String, AttentionFile>,
    /// Phases by name; `after` makes a tree of them.
    pub phase: BTreeMap<String, PhaseFile>,
    /// Who is evaluated, by name.
    pub policy: BTreeMap<String, PolicyFile>,
    /// How the trained minds are evaluated.
    #[serde(default)]
    pub evaluation: EvaluationFile,
    /// The fixed subsets of sensors to compare with; none if absent.
    #[serde(default)]
    pub subsets: Option<SubsetsFile>,
}

/// A member: what it sees and how it learns.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MemberFile {
    /// Sensors seen. Eqs. (1, 2).
    pub sensors: Vec<String>,
    /// Name of its learner.
    pub learner: String,
}

/// An attention controller: its learner and settings, or counterfactual policy iteration instead.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AttentionFile {
    /// Name of its learner.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub learner: Option<String>,
    /// Settings.
    #[serde(default)]
    pub settings: AttentionConfig,
    /// Learn by counterfactual policy iteration; then there is no learner.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub counterfactual: Option<CounterfactualConfig>,
}

/// Who is at the wheel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Acting {
    /// The environment's expert advisor.
    Advisor,
    /// A person, shown again from a file of demonstrations (see [`crate::demonstrations`]); only in a phase.
    Demonstrations(PathBuf),
    /// One member by itself: the full observer, a fixed subset.
    Solo(String),
    /// The whole roster through a fuser. Eq. (7).
    Fusion(Fuser),
    /// An attention controller. Eqs. (8)-(11).
    Attention(String),
    /// Random looks, this many on average, fused by the paper's rule.
    RandomLooks(f64),
    /// The best constant motor action (chosen on validation roads).
    Blind,
}

impl Acting {
    /// Whether a flawless expert acts and all others watch: Phase I.
    #[must_use]
    pub fn is_watched(&self) -> bool {
        matches!(self, Self::Advisor | Self::Demonstrations(_))
    }
}

impl PlanFile {
    /// Shows the demonstrations of `path` wherever the advisor would act in a phase.
    pub fn watch_demonstrations(&mut self, path: &Path) {
        for phase in self.phase.values_mut().filter(|phase| phase.acting.is_watched()) {
            phase.acting = Acting::Demonstrations(path.to_path_buf());
        }
    }
}

/// A phase as a row of data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PhaseFile {
    /// The phase whose minds this one starts from; none: newborn minds.
    #[serde(default)]
    pub after: Option<String>,
    /// Members that take part.
    pub roster: Vec<String>,
    /// Who is at the wheel.
    pub acting: Acting,
    /// Who senses.
    #[serde(default)]
    pub sensing: Sensing,
    /// Which members learn.
    #[serde(default)]
    pub teaching: Teaching,
    /// How fast they learn.
    pub rate: Rate,
    /// How credit flows back.
    #[serde(default)]
    pub credit: Credit,
    /// Member whose state value all bootstrap from; none: each from its own.
    #[serde(default)]
    pub bootstrap: Option<String>,
    /// How the policy explores.
    #[serde(default)]
    pub exploration: Schedule,
    /// When the phase ends.
    pub budget: Budget,
}

/// A row of the comparison.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PolicyFile {
    /// The phase whose trained minds are used; none: newborn minds (for the advisor and the blind).
    #[serde(default)]
    pub after: Option<String>,
    /// Members that may be consulted; empty: nobody.
    #[serde(default)]
    pub roster: Vec<String>,
    /// Who is at the wheel.
    pub acting: Acting,
}

/// How trained minds are tested: greedy, nobody learns.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct EvaluationFile {
    /// Runs per scenario, shared among the seeds.
    pub runs: usize,
    /// Scenarios; empty: the environment's own start.
    pub scenarios: Vec<String>,
}

impl Default for EvaluationFile {
    fn default() -> Self {
        Self { runs: 500, scenarios: Vec::new() }
    }
}

/// The fixed subsets of sensors: the paper's "first possible answer" (Sec. 1), each by one learner of its own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SubsetsFile {
    /// Learner of every subset; none if they learn by counterfactual policy iteration.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub learner: Option<String>,
    /// Phase whose rate, credit and exploration every subset's training takes over. If it learns by counterfactual
    /// policy iteration, so do they, with looks that are fixed and everything else the same.
    pub like: String,
    /// Motor steps from look to look: 1 looks always, 2 every second time. More than 1 only with counterfactual policy
    /// iteration.
    #[serde(default = "always", skip_serializing_if = "is_always")]
    pub every: Vec<usize>,
    /// Those to screen, as in `MN+MF/2`; none: all single sensors and pairs, and larger ones grown from the best pair.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub among: Vec<String>,
    /// Phases whose motor steps add up to the budget of a subset, so that all rows spend the same.
    pub budget_of: Vec<String>,
    /// Share of that budget spent while screening, in (0, 1].
    pub screening_share: f64,
    /// Seeds of the screening, apart from those of the report.
    pub screening_seeds: usize,
    /// Evaluation runs per screened subset (on validation roads).
    pub screening_runs: usize,
    /// How many of the best are trained again, on fresh seeds with the full budget.
    pub confirmed: usize,
}

fn always() -> Vec<usize> {
    vec![1]
}

fn is_always(every: &[usize]) -> bool {
    every == [1]
}
