//! The data behind each figure. Every part may be missing: the report then says "not run".

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::Estimate;

/// Height of the camera's image in pixels (Sec. 4.1).
pub const CAMERA_ROWS: usize = 39;
/// Width of the camera's image in pixels (Sec. 4.1).
pub const CAMERA_COLUMNS: usize = 52;

/// The data behind all figures.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Figures {
    /// Learning curves (Fig. 8): POLICY → blocks of episodes in order.
    pub learning_curves: BTreeMap<String, Vec<CurvePoint>>,
    /// How many looks were taken per motor decision, over learning (Fig. 9).
    pub looks_histograms: Vec<LooksBlock>,
    /// The six situations of Table 1.
    pub table1: Vec<SceneRow>,
    /// The camera's regions of interest (Fig. 6c).
    pub camera_regions: Vec<CameraRegion>,
    /// The robot's view and the road from above (Fig. 6).
    pub fig6: Option<RoadView>,
    /// A drive on a test road (Fig. 11).
    pub fig11: Option<TestDrive>,
    /// What is looked at where.
    pub look_map: Option<LooksMap>,
    /// Fixed subsets of sensors: price against motor cost.
    pub subset_front: Vec<FrontPoint>,
    /// POLICY → what each training reached.
    pub sensitivity: BTreeMap<String, Vec<SeedPoint>>,
    /// Aliasing measured on the learned decision space (Sec. 6.1).
    pub aliasing_empirical: Vec<AliasingRow>,
}

/// One block of episodes of a learning curve; the interval is over trainings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CurvePoint {
    /// Index of the block, from 0.
    pub block: u32,
    /// Episodes finished at the end of the block.
    pub episodes: u32,
    /// Mean motor cost per motor step within the block.
    pub motor: Estimate,
    /// Mean perceptual cost per motor step within the block.
    pub perceptual: Estimate,
    /// Mean total cost per motor step within the block.
    pub total: Estimate,
    /// Total cost of all motor steps from the start of learning to the end of the block.
    pub accumulated: Estimate,
}

/// The looks taken within one block of episodes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LooksBlock {
    /// Index of the block, from 0.
    pub block: u32,
    /// Episodes finished at the end of the block.
    pub episodes: u32,
    /// Share of motor decisions taken after 0, 1, 2, … looks; sums to one.
    pub share: Vec<f64>,
}

/// Colour classes of an image, one string per row, one digit per pixel:
/// 0 black road, 1 white line, 2 red car, 3 green roadside, 4 anything else (above the horizon).
pub type PixelImage = Vec<String>;

/// One situation of Table 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SceneRow {
    /// Name of the situation, as the paper prints it.
    pub situation: String,
    /// What the camera sees.
    pub image: PixelImage,
    /// The sequence of looks that most trainings take, by sensor.
    pub learned: Vec<String>,
    /// Share of trainings that take exactly this sequence.
    pub agreement: f64,
    /// The motor action that follows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub action: Option<String>,
    /// The sequence printed in the paper.
    pub paper: Vec<String>,
}

/// One region of the camera's image, in pixels from the top left corner; ends are exclusive.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CameraRegion {
    /// Name of the sensor that sees it: `MN`, `LN`, `RN`, `MF`, `LF`, `RF`.
    pub name: String,
    /// First row.
    pub top: usize,
    /// Row after the last.
    pub bottom: usize,
    /// First column.
    pub left: usize,
    /// Column after the last.
    pub right: usize,
}

/// The middle line of a closed road, and its width.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RoadOutline {
    /// Points \[x, y\] of the middle line, in metres; the last joins the first.
    pub middle: Vec<[f64; 2]>,
    /// Width of both lanes together, in metres.
    pub width_m: f64,
}

/// Where a robot stands and where it heads.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// In metres.
    pub x: f64,
    /// In metres.
    pub y: f64,
    /// In radians, anticlockwise from the x axis.
    pub heading_rad: f64,
}

/// Fig. 6: the road from above and the robot's view at the same moment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RoadView {
    /// The road.
    pub road: RoadOutline,
    /// What the learner's camera sees.
    pub image: PixelImage,
    /// The learner.
    pub learner: Pose,
    /// The red cars.
    pub cars: Vec<Pose>,
}

/// Fig. 11: one drive on a test road, one entry per motor step.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TestDrive {
    /// Road that was driven, e.g. `test 3`.
    pub road: String,
    /// Reward of each motor step, looks included.
    pub reward: Vec<f64>,
    /// Mean of the last five rewards (fewer at the start).
    pub moving_average: Vec<f64>,
    /// Sum of the rewards so far.
    pub accumulated: Vec<f64>,
}

/// What is looked at where.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LooksMap {
    /// The road driven.
    pub road: RoadOutline,
    /// One entry per motor decision.
    pub points: Vec<MapPoint>,
}

/// One motor decision on the map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MapPoint {
    /// In metres.
    pub x: f64,
    /// In metres.
    pub y: f64,
    /// Looks taken before the decision.
    pub looks: u32,
    /// The sensor read first; absent if none was.
    pub first: Option<String>,
}

/// One fixed subset of sensors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrontPoint {
    /// The sensors.
    pub sensors: Vec<String>,
    /// They are read at every so-manieth motor step; 1 is always.
    #[serde(default = "always")]
    pub every: usize,
    /// Price of its looks per motor step; positive.
    pub price: f64,
    /// Mean motor cost per motor step.
    pub motor: Estimate,
    /// Motor cost minus the price.
    pub total: Estimate,
    /// How thoroughly it was measured.
    pub stage: Stage,
}

/// What results say that were written before rhythms were among the fixed choices.
const fn always() -> usize {
    1
}

impl FrontPoint {
    /// The sensors with `between` between them, and `/2` after them if they are read at every second step.
    #[must_use]
    pub fn words(&self, between: &str) -> String {
        let rhythm = if self.every == 1 { String::new() } else { format!("/{}", self.every) };
        format!("{}{rhythm}", self.sensors.join(between))
    }
}

/// How thoroughly a fixed subset was measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// On a few seeds, to choose candidates.
    Screened,
    /// Trained again on fresh seeds, so that choosing the winner is not selection.
    Confirmed,
}

/// What one training reached, mean over the mixture of scenarios.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SeedPoint {
    /// The seed.
    pub seed: u64,
    /// Mean motor cost per motor step.
    pub motor: f64,
    /// Mean perceptual cost per motor step.
    pub perceptual: f64,
    /// Mean total cost per motor step.
    pub total: f64,
    /// Mean looks per motor decision.
    pub looks: f64,
}

/// Aliasing measured on what was learned.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AliasingRow {
    /// The space or tiny agent measured, e.g. `decision space` or `MN`.
    pub space: String,
    /// Quantisation level at which two points count as equal.
    pub q: u32,
    /// Share of pairs of distinct physical states that fall on the same point.
    pub rate: Estimate,
}
