//! The paper's printed numbers, each with its place, to be set beside ours.
//!
//! Nothing here is measured by this program. Costs are as printed: negative is worse. Where the paper prints parts and
//! their sum, the test below checks that they agree.

use std::collections::BTreeMap;

use metal_rl::measure::aliasing::{TABLE_3, Table3Row};
use serde::{Deserialize, Serialize};

/// What the paper prints, in the shape of `results.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PaperNumbers {
    /// Where the numbers come from.
    pub source: String,
    /// Mean looks per decision at the end of learning (Sec. 4.4).
    pub looks: f64,
    /// Ratio of total costs ACL / FOA, mean of the three scenarios (derived from Table 2).
    pub ratio_to_foa: f64,
    /// Ratio of total costs ACL / fusion, mean of the three scenarios (derived from Table 2).
    pub ratio_to_fusion: f64,
    /// Table 2: POLICY → SCENARIO → cell.
    pub table2: BTreeMap<String, BTreeMap<String, PaperCell>>,
    /// Table 3, in the printed order.
    pub table3: Vec<PaperTable3Row>,
    /// Table 1: situation and sequence of looks, in the printed order.
    pub table1: Vec<PaperScene>,
}

/// One cell of the paper's Table 2 (10 runs of 50 steps).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PaperCell {
    /// Mean motor cost; the paper prints none for ACL.
    pub motor: Option<f64>,
    /// Mean perceptual cost; the paper prints none for ACL.
    pub perceptual: Option<f64>,
    /// Mean total over the ten runs.
    pub total: f64,
    /// Runs with an accident, of ten (none is printed for the free road).
    pub accidents: Option<u32>,
    /// The runs with an accident.
    pub accident: Option<PaperCosts>,
    /// The runs without.
    pub no_accident: Option<PaperCosts>,
}

/// Motor + perceptual = total as printed; ACL has only the total.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PaperCosts {
    /// Mean motor cost.
    pub motor: Option<f64>,
    /// Mean perceptual cost.
    pub perceptual: Option<f64>,
    /// Mean total.
    pub total: f64,
}

/// One row of the paper's Table 3, as printed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PaperTable3Row {
    /// Number of aliased states.
    pub k: u32,
    /// Quantisation level.
    pub q: u32,
    /// Number of motor actions.
    pub actions: u32,
    /// Printed p₀.
    pub p0: f64,
    /// Printed probability of aliasing.
    pub p: f64,
}

/// One row of the paper's Table 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PaperScene {
    /// The situation.
    pub situation: String,
    /// The sequence of perceptual actions.
    pub looks: Vec<String>,
    /// The paper's intuitive justification, in short.
    pub reason: String,
}

/// Sec. 4.4: "The final average of perceptions is as low as 2.1 out of 7."
pub const LOOKS: f64 = 2.1;
/// Number of tiny agents (Sec. 4.2): six regions of the camera and the infra-red ring.
pub const SENSORS: u32 = 7;
/// Runs behind each cell of Table 2 (Sec. 4.4).
pub const RUNS: u64 = 10;
/// ACL / FOA: mean of 12.3/15.6, 15.4/26.1 and 17.1/22.0 (Table 2).
pub const RATIO_TO_FOA: f64 = 0.72;
/// ACL / fusion: mean of 12.3/23.3, 15.4/27.0 and 17.1/24.9 (Table 2).
pub const RATIO_TO_FUSION: f64 = 0.60;

/// Table 1: situation, sequence of looks, the paper's justification in short.
pub const TABLE1: [(&str, &[&str], &str); 6] = [
    ("Perpendicular view to free road", &["MN", "RN", "RF", "MF", "LF"], "hard: nearly all are attended"),
    ("Looking at a free curve from the roadside", &["MN", "RF", "MF", "LF"], "moderately hard"),
    ("An obstacle at the left", &["MN", "IR", "LF"], "red in MN: check proximity and place of the obstacle"),
    ("The road is blocked with an obstacle", &["MN", "MF", "IR"], "red in MN: as above"),
    ("Free road (middle)", &["MN", "MF"], "white in MN: check the curvature"),
    ("Free road (left)", &["MN"], "all of MN is black: nothing is close ahead"),
];

/// All numbers of the paper.
#[must_use]
pub fn numbers() -> PaperNumbers {
    let source =
        "METAL: A framework for mixture-of-experts task and attention learning, Tables 1-3 and Sec. 4.4";
    PaperNumbers {
        source: source.to_owned(),
        looks: LOOKS,
        ratio_to_foa: RATIO_TO_FOA,
        ratio_to_fusion: RATIO_TO_FUSION,
        table2: table2(),
        table3: TABLE_3.iter().map(table3_row).collect(),
        table1: TABLE1.iter().map(|&row| scene(row)).collect(),
    }
}

/// The cell of the paper's Table 2, for `foa`, `fusion` and `acl`.
#[must_use]
pub fn cell(policy: &str, scenario: &str) -> Option<PaperCell> {
    table2().remove(policy)?.remove(scenario)
}

/// Table 2: "Analysis of the after learning behavior: total punishment for 50 steps".
fn table2() -> BTreeMap<String, BTreeMap<String, PaperCell>> {
    let foa = [
        free_road(Some((-4.6, -11.0)), -15.6),
        risky((4, -26.1), split(-23.0, -11.0, -34.0), split(-9.9, -11.0, -20.9)),
        risky((3, -22.0), split(-19.7, -11.0, -30.7), split(-7.3, -11.0, -18.3)),
    ];
    let fusion = [
        free_road(Some((-11.3, -12.0)), -23.3),
        risky((7, -27.0), split(-16.5, -12.0, -28.5), split(-11.5, -12.0, -23.5)),
        risky((5, -24.9), split(-15.5, -12.0, -27.5), split(-10.3, -12.0, -22.3)),
    ];
    let acl = [
        free_road(None, -12.3),
        risky((3, -15.4), total_only(-21.2), total_only(-13.0)),
        risky((3, -17.1), total_only(-21.1), total_only(-15.4)),
    ];
    [("foa", foa), ("fusion", fusion), ("acl", acl)]
        .into_iter()
        .map(|(policy, cells)| (policy.to_owned(), by_scenario(cells)))
        .collect()
}

fn by_scenario(cells: [PaperCell; 3]) -> BTreeMap<String, PaperCell> {
    crate::results::lookup::SCENARIOS.iter().map(|s| (*s).to_owned()).zip(cells).collect()
}

fn free_road(parts: Option<(f64, f64)>, total: f64) -> PaperCell {
    let (motor, perceptual) = parts.unzip();
    PaperCell { motor, perceptual, total, accidents: None, accident: None, no_accident: None }
}

fn risky((accidents, total): (u32, f64), accident: PaperCosts, no_accident: PaperCosts) -> PaperCell {
    PaperCell {
        motor: None,
        perceptual: accident.perceptual,
        total,
        accidents: Some(accidents),
        accident: Some(accident),
        no_accident: Some(no_accident),
    }
}

fn split(motor: f64, perceptual: f64, total: f64) -> PaperCosts {
    PaperCosts { motor: Some(motor), perceptual: Some(perceptual), total }
}

fn total_only(total: f64) -> PaperCosts {
    PaperCosts { motor: None, perceptual: None, total }
}

fn table3_row(row: &Table3Row) -> PaperTable3Row {
    let [k, q, actions] = [row.merged_states, row.levels, row.actions].map(|n| n as u32);
    PaperTable3Row { k, q, actions, p0: row.collision.value, p: row.aliasing.value }
}

/// The printed row of Table 3 with these numbers, if there is one.
#[must_use]
pub fn table3(k: u32, q: u32, actions: u32) -> Option<PaperTable3Row> {
    TABLE_3.iter().map(table3_row).find(|row| (row.k, row.q, row.actions) == (k, q, actions))
}

fn scene((situation, looks, reason): (&str, &[&str], &str)) -> PaperScene {
    PaperScene {
        situation: situation.to_owned(),
        looks: looks.iter().map(|&s| s.to_owned()).collect(),
        reason: reason.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_printed_parts_add_up_to_the_printed_totals() {
        for cell in table2().values().flat_map(BTreeMap::values) {
            for costs in [cell.accident, cell.no_accident].into_iter().flatten() {
                if let (Some(motor), Some(perceptual)) = (costs.motor, costs.perceptual) {
                    assert!((motor + perceptual - costs.total).abs() < 0.051, "{costs:?}");
                }
            }
            if let (Some(accidents), Some(bad), Some(good)) =
                (cell.accidents, cell.accident, cell.no_accident)
            {
                let mean = (f64::from(accidents) * bad.total + f64::from(10 - accidents) * good.total) / 10.0;
                assert!((mean - cell.total).abs() < 0.07, "{mean} against the printed {}", cell.total);
            }
        }
    }

    #[test]
    fn the_printed_ratios_follow_from_table_2() {
        let mean_ratio = |other: &str| {
            let ratio = |s: &str| cell("acl", s).unwrap().total / cell(other, s).unwrap().total;
            crate::results::lookup::SCENARIOS.map(ratio).iter().sum::<f64>() / 3.0
        };
        assert!((mean_ratio("foa") - RATIO_TO_FOA).abs() < 0.005, "{}", mean_ratio("foa"));
        assert!((mean_ratio("fusion") - RATIO_TO_FUSION).abs() < 0.005, "{}", mean_ratio("fusion"));
    }
}
