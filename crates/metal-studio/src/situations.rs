//! The situations of Table 1 at one glance: what a driver looks at, beside what the paper printed.

use crate::lane::Lane;
use metal_lab::paper;
use metal_rl::environment::EnvironmentError;
use metal_worlds::highway::Situation;
use serde::Serialize;

/// What is looked at in one situation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Looked {
    /// Its name in Table 1.
    pub name: &'static str,
    /// Members asked by our driver, in order.
    pub ours: Vec<usize>,
    /// Our driver's move.
    pub action: usize,
    /// Looks printed in the paper.
    pub paper: &'static [&'static str],
}

/// All six, for the driver of `lane`; its world stays as it is.
///
/// # Errors
/// If a sensor fails.
pub fn table1(lane: &mut Lane) -> Result<Vec<Looked>, EnvironmentError> {
    let stands = lane.world.clone();
    let rows: Result<Vec<Looked>, EnvironmentError> =
        Situation::ALL.iter().map(|&situation| look(lane, situation)).collect();
    lane.world = stands;
    rows
}

fn look(lane: &mut Lane, situation: Situation) -> Result<Looked, EnvironmentError> {
    lane.world.world.reset_to(0, situation);
    let frame = lane.think()?;
    let name = situation.name();
    let paper = paper::TABLE1.iter().find(|(n, _, _)| *n == name).map_or(&[][..], |(_, looks, _)| looks);
    Ok(Looked { name, ours: frame.asked, action: frame.action, paper })
}
