//! What may be chosen about a proposal.

use crate::plan::PlanError;
use crate::plan::limits::count;
use metal_rl::partition::alike::LEVELS;
use serde::{Deserialize, Serialize};

/// What makes sensors belong together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Criterion {
    /// They say the same: agglomerative clustering by normalised information distance, average linkage.
    Alike,
    /// Together they tell the expert's action better than their price: greedy optimisation.
    #[default]
    Worth,
    /// Nothing: what a proposal has to beat.
    Random,
}

/// How members are proposed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PartitionOptions {
    /// What makes sensors belong together.
    pub by: Criterion,
    /// Groups wanted; none: as many as the criterion says, at most `most`.
    pub groups: Option<usize>,
    /// Most groups where the criterion chooses their number; how many random ones there are.
    pub most: usize,
    /// Motor steps of the demonstration.
    pub steps: usize,
    /// Share of its moves that are left to chance, so that the expert is also watched where it would never go.
    pub chance: f64,
    /// Parts into which each number is cut to compare sensors.
    pub levels: usize,
    /// How much a price counts against what a group tells; 1: as much as for who looks at everything.
    pub thrift: f64,
    /// The phase whose members are replaced; none: the first that learns attention, or the first of all.
    pub phase: Option<String>,
    /// The one number all randomness comes from.
    pub seed: u64,
}

impl Default for PartitionOptions {
    fn default() -> Self {
        Self {
            by: Criterion::default(),
            groups: None,
            most: 12,
            steps: 4000,
            chance: 0.0,
            levels: LEVELS,
            thrift: 1.0,
            phase: None,
            seed: 1,
        }
    }
}

/// Most parts: beyond, no two moments would be alike.
const MOST_LEVELS: usize = 64;

impl PartitionOptions {
    /// Refuses what cannot be carried out.
    ///
    /// # Errors
    /// The first impossible field, with what is allowed.
    pub fn check(&self) -> Result<(), PlanError> {
        self.groups.map_or(Ok(()), |groups| count("groups", groups, "groups"))?;
        count("most", self.most, "groups")?;
        count("steps", self.steps, "motor steps")?;
        if !(0.0..=1.0).contains(&self.chance) {
            return Err(PlanError::at("chance", format!("{}: a share in [0, 1]", self.chance)));
        }
        if !(2..=MOST_LEVELS).contains(&self.levels) {
            return Err(PlanError::at("levels", format!("{}: 2 to {MOST_LEVELS} parts", self.levels)));
        }
        if !(self.thrift >= 0.0 && self.thrift.is_finite()) {
            return Err(PlanError::at("thrift", format!("{}: at least 0, and finite", self.thrift)));
        }
        Ok(())
    }
}
