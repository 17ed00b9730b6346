//! Table 1: what attention control looks at in six situations, and how it then moves.

use super::{Garage, picture, sensors_read};
use crate::evaluate::{Candidate, decide};
use crate::paper;
use crate::registry::Roads;
use crate::results::SceneRow;
use crate::train::RunError;
use metal_rl::measure::looks::sequences;
use metal_rl::num;
use metal_rl::run::Decided;
use metal_worlds::highway::{Highway, Scenario, Situation};

/// The situations are drawn up by hand; this seed only makes the infra-red sensors' noise.
const NOISE: u64 = 0;

/// The six rows, in the paper's order.
pub fn rows(garage: &Garage<'_>, drivers: &[Candidate<'_>]) -> Result<Vec<SceneRow>, RunError> {
    let mut world = garage.world(&Roads::Training, Scenario::FreeRoad);
    let mut rows = Vec::new();
    for (name, looks, _) in paper::TABLE1 {
        let Some(&situation) = Situation::ALL.iter().find(|s| s.name() == name) else { continue };
        world.reset_to(NOISE, situation);
        let decisions = decisions(garage, drivers, &mut world)?;
        let (members, agreement) = most_frequent(&decisions);
        rows.push(SceneRow {
            situation: name.to_owned(),
            image: picture::image(&world),
            learned: sensors_read(drivers[0].plan, &members),
            agreement,
            action: Some(drivers[0].plan.spec.actions[action_after(&decisions, &members)].clone()),
            paper: looks.iter().map(|&sensor| sensor.to_owned()).collect(),
        });
    }
    Ok(rows)
}

/// What each driver does where the world stands.
fn decisions(
    garage: &Garage<'_>,
    drivers: &[Candidate<'_>],
    world: &mut Highway,
) -> Result<Vec<Decided>, RunError> {
    drivers.iter().map(|driver| decide(driver, world, &garage.streams)).collect()
}

/// The sequence of looks that most drivers take, and their share.
fn most_frequent(decisions: &[Decided]) -> (Vec<usize>, f64) {
    let counted = sequences(decisions.iter().map(|d| d.order.as_slice()));
    let first = counted.into_iter().next();
    first.map_or((Vec::new(), 0.0), |c| (c.sequence, c.count as f64 / decisions.len() as f64))
}

/// The move that most of those who looked like this make.
fn action_after(decisions: &[Decided], order: &[usize]) -> usize {
    let alike = || decisions.iter().filter(|d| d.order == order);
    let most = alike().map(|d| d.action).max().unwrap_or(0);
    let votes: Vec<f64> = (0..=most).map(|a| alike().filter(|d| d.action == a).count() as f64).collect();
    num::argmax(&votes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_situation_of_the_paper_is_a_situation_of_the_world() {
        let ours = Situation::ALL.map(Situation::name);
        assert_eq!(ours, paper::TABLE1.map(|(name, _, _)| name));
    }

    #[test]
    fn the_majority_is_asked_for_its_move() {
        let decided = |order: &[usize], action| Decided { order: order.to_vec(), action, look_price: 0.0 };
        let all = [decided(&[1], 4), decided(&[0, 2], 1), decided(&[0, 2], 3), decided(&[0, 2], 3)];
        let (order, agreement) = most_frequent(&all);
        assert_eq!((order.as_slice(), agreement), (&[0, 2][..], 0.75));
        assert_eq!(action_after(&all, &order), 3);
    }
}
