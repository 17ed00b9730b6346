//! Optimal values of a maze whose position is known, by value iteration.

use super::{ACTIONS, Cell, MazeConfig};

/// Value of every cell (see [`MazeConfig::index`]) under the best policy for someone who sees both coordinates and
/// pays no looks; the goal and walls are worth 0. `discount` is in (0, 1].
#[must_use]
pub fn optimal_values(config: &MazeConfig, discount: f64) -> Vec<f64> {
    let starts = config.starts();
    let mut values = vec![0.0; config.side * config.side];
    // Starting at 0, an upper bound, a cell k steps from the goal is right after k sweeps at the latest.
    for _ in 0..starts.len() {
        for &cell in &starts {
            values[config.index(cell)] = (0..ACTIONS.len())
                .map(|a| worth(config, &values, (cell, a), discount))
                .fold(f64::MIN, f64::max);
        }
    }
    values
}

/// The best action where nothing is discounted; the lowest index wins a tie.
pub fn best_action(config: &MazeConfig, values: &[f64], cell: Cell) -> usize {
    let worths: [f64; ACTIONS.len()] = std::array::from_fn(|a| worth(config, values, (cell, a), 1.0));
    metal_rl::num::argmax(&worths)
}

fn worth(config: &MazeConfig, values: &[f64], (cell, action): (Cell, usize), discount: f64) -> f64 {
    let next = config.next(cell, action);
    config.reward(next.is_none()) + discount * values[config.index(next.unwrap_or(cell))]
}

/// From which cells (see [`MazeConfig::index`]) the goal can be reached. Steps can be retraced, so it is enough to
/// spread from the goal.
pub fn reaches_goal(config: &MazeConfig) -> Vec<bool> {
    let mut reached = vec![false; config.side * config.side];
    let mut border = vec![config.goal];
    while let Some(cell) = border.pop() {
        if !std::mem::replace(&mut reached[config.index(cell)], true) {
            border.extend((0..ACTIONS.len()).filter_map(|a| config.next(cell, a)));
        }
    }
    reached
}
