//! What attention control remembers of an episode, and the targets it makes of it.

use crate::policy::Experience;

/// One decision: a look or a move, in the encoded state where it was made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Decision {
    /// Index of the choice (motor actions first, then looks).
    pub choice: usize,
    /// Price of the look as it is learned from (0 for a move).
    pub price: f64,
    /// Best value among what was available in this state when the decision was made.
    pub best: f64,
}

/// One motor step: its looks, then its move.
#[derive(Clone, Copy, Debug, PartialEq)]
struct MotorStep {
    /// Index of the move among the decisions.
    moved: usize,
    /// What came of it; none if the time limit fell before it was carried out.
    experience: Option<Experience>,
}

/// An episode as a flat list of decisions, grouped into motor steps.
#[derive(Clone, Debug, Default)]
pub(super) struct Memory {
    inputs: Vec<f64>,
    decisions: Vec<Decision>,
    steps: Vec<MotorStep>,
}

impl Memory {
    pub fn clear(&mut self) {
        self.inputs.clear();
        self.decisions.clear();
        self.steps.clear();
    }

    /// Remembers a decision made in the encoded state `input`; `is_move` closes the motor step.
    pub fn record(&mut self, input: &[f64], decision: Decision, is_move: bool) {
        self.inputs.extend_from_slice(input);
        self.decisions.push(decision);
        if is_move {
            self.steps.push(MotorStep { moved: self.decisions.len() - 1, experience: None });
        }
    }

    /// Attaches what the last move led to.
    pub fn experienced(&mut self, experience: Experience) {
        if let Some(step) = self.steps.last_mut() {
            step.experience = Some(experience);
        }
    }

    pub fn last(&self) -> Option<&Decision> {
        self.decisions.last()
    }

    /// The encoded state of the `i`-th decision of width `width`.
    pub fn input(&self, i: usize, width: usize) -> &[f64] {
        &self.inputs[i * width..(i + 1) * width]
    }

    pub fn decisions(&self) -> &[Decision] {
        &self.decisions
    }

    /// Targets of all decisions whose consequences are known, into `out` (NaN where they are not).
    ///
    /// Backwards through the episode. A move is worth r + γ · W of the next motor step, where
    /// W = −(prices of its looks) + (1 − λ) · best value where its looks ended + λ · target of its move.
    /// A look is worth −price + (1 − λ) · best value after it + λ · target of what was chosen there.
    /// The all-null state in between is never used as a value: it is the same for every future.
    pub fn targets(&self, gamma: f64, lambda: f64, out: &mut Vec<f64>) {
        out.clear();
        out.resize(self.decisions.len(), f64::NAN);
        let mut next_step_worth = 0.0;
        for (k, step) in self.steps.iter().enumerate().rev() {
            let first = if k == 0 { 0 } else { self.steps[k - 1].moved + 1 };
            let arrived = self.decisions[step.moved].best;
            let move_worth = match step.experience {
                // Not carried out: its own estimate stands for the future that the time limit cut off.
                None => arrived,
                Some(e) if e.terminal => e.motor_reward,
                Some(e) => e.motor_reward + gamma * next_step_worth,
            };
            if step.experience.is_some() {
                out[step.moved] = move_worth;
            }
            let blended = (1.0 - lambda) * arrived + lambda * move_worth;
            let mut following = blended;
            for d in (first..step.moved).rev() {
                let price = self.decisions[d].price;
                out[d] = following - price;
                following = (1.0 - lambda) * self.decisions[d].best + lambda * out[d];
            }
            next_step_worth =
                blended - self.decisions[first..step.moved].iter().map(|d| d.price).sum::<f64>();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decision(choice: usize, price: f64, best: f64) -> Decision {
        Decision { choice, price, best }
    }

    fn lived(motor_reward: f64, terminal: bool) -> Experience {
        Experience { motor_reward, terminal }
    }

    #[test]
    fn a_move_sees_past_the_null_state_to_where_the_next_looks_ended() {
        let mut memory = Memory::default();
        memory.record(&[0.0], decision(5, 1.5, -100.0), false);
        memory.record(&[0.1], decision(0, 0.0, -20.0), true);
        memory.experienced(lived(-2.0, false));
        memory.record(&[0.0], decision(6, 2.0, -100.0), false);
        memory.record(&[0.2], decision(1, 0.0, -8.0), true);
        memory.experienced(lived(-3.0, true));
        let mut targets = Vec::new();
        memory.targets(0.9, 0.0, &mut targets);
        // λ = 0: the value where looks ended, never the −100 of the null state.
        assert!((targets[1] - (-2.0 + 0.9 * (-8.0 - 2.0))).abs() < 1e-12);
        assert!((targets[2] - (-8.0 - 2.0)).abs() < 1e-12);
        assert_eq!(targets[3], -3.0, "a terminal end has no future");
        memory.targets(0.9, 1.0, &mut targets);
        assert!((targets[0] - (-1.5 - 2.0 + 0.9 * (-2.0 - 3.0))).abs() < 1e-12);
    }

    #[test]
    fn a_time_limit_bootstraps_from_the_move_that_was_not_made() {
        let mut memory = Memory::default();
        memory.record(&[0.0], decision(0, 0.0, -20.0), true);
        memory.experienced(lived(-1.0, false));
        memory.record(&[0.0], decision(5, 1.5, -30.0), false);
        memory.record(&[0.3], decision(0, 0.0, -10.0), true);
        let mut targets = Vec::new();
        memory.targets(0.5, 1.0, &mut targets);
        assert!((targets[0] - (-1.0 + 0.5 * (-10.0 - 1.5))).abs() < 1e-12);
        assert!(targets[2].is_nan(), "nothing is learned about a move that was not made");
    }
}
