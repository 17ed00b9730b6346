//! `results.json`, schema 1: every number of the report, documented field by field in `docs/results-json.md`.
//!
//! Costs are mean per motor step and never positive: negative is worse. Maps are ordered, so the same results give the
//! same bytes.

mod figure_data;
pub mod lookup;

pub use figure_data::{
    AliasingRow, CAMERA_COLUMNS, CAMERA_ROWS, CameraRegion, CurvePoint, Figures, FrontPoint, LooksBlock,
    LooksMap, MapPoint, PixelImage, Pose, RoadOutline, RoadView, SceneRow, SeedPoint, Stage, TestDrive,
};
pub use metal_rl::measure::statistics::Estimate;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::paper::PaperNumbers;

/// MEASURE → estimate.
pub type Measures = BTreeMap<String, Estimate>;
/// SCENARIO → MEASURE → estimate.
pub type Scenarios = BTreeMap<String, Measures>;
/// POLICY → SCENARIO → MEASURE → estimate.
pub type Policies = BTreeMap<String, Scenarios>;

/// The version of the layout that this crate writes and reads.
pub const SCHEMA: u32 = 1;

/// Everything a run of the experiment found out.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Results {
    /// Version of this layout, [`SCHEMA`].
    pub schema: u32,
    /// Whether budgets were cut so far that the numbers only show that everything works.
    pub quick: bool,
    /// Number of independent trainings.
    pub seeds: u32,
    /// Roads of `policies`: `training`, `validation`, `test` or `seeds:1,2,…`.
    pub roads: String,
    /// The main table: POLICY → SCENARIO → MEASURE → estimate.
    pub policies: Policies,
    /// Largest probability of aliasing (Table 3).
    pub table3: Vec<Table3Row>,
    /// The data behind each figure.
    pub figures: Figures,
    /// The same table on further roads, by the name of the roads.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub other_roads: BTreeMap<String, Policies>,
    /// Runs of 50 steps, parted by accident (Table 2): style (`ten_runs`, `full`) → POLICY → SCENARIO → cell.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub table2: BTreeMap<String, Table2>,
    /// Ratios of total costs with their intervals, e.g. `acl/foa`: mean over the three scenarios, paired by seed.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub ratios: BTreeMap<String, Estimate>,
    /// The fixed subset that stands behind the policy `best_fixed`, e.g. `fixed:MN+MF`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub best_fixed: Option<String>,
    /// The paper's printed numbers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub paper: Option<PaperNumbers>,
    /// Processor time in seconds, by part of the work, summed over threads.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub cpu_seconds: BTreeMap<String, f64>,
    /// Program, crates, world, compiler and `git` revision.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub versions: BTreeMap<String, String>,
    /// The full configuration of the run, as it was read.
    #[serde(default, skip_serializing_if = "serde_json::Value::is_null")]
    pub config: serde_json::Value,
}

/// One row of Table 3.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Table3Row {
    /// Number of aliased states that fall on one message.
    pub k: u32,
    /// Quantisation level of the decision space.
    pub q: u32,
    /// Number of motor actions.
    pub actions: u32,
    /// Probability of equal sums for one action, Eq. (22).
    pub p0: f64,
    /// Upper bound of the probability of aliasing, Eq. (26).
    pub p: f64,
}

/// POLICY → SCENARIO → cell of Table 2.
pub type Table2 = BTreeMap<String, BTreeMap<String, Table2Cell>>;

/// One cell of Table 2: all runs, and those with and without an accident.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Table2Cell {
    /// Number of runs of 50 steps.
    pub runs: u64,
    /// Runs with at least one accident.
    pub accidents: u64,
    /// Mean over all runs.
    pub all: Costs,
    /// Mean over the runs with an accident; absent if there was none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accident: Option<Costs>,
    /// Mean over the runs without; absent if there was none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub no_accident: Option<Costs>,
}

/// Motor + perceptual = total, mean per motor step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Costs {
    /// Motor cost (Fig. 7a).
    pub motor: Estimate,
    /// Price of the looks (Fig. 7b), negative.
    pub perceptual: Estimate,
    /// Their sum.
    pub total: Estimate,
}
