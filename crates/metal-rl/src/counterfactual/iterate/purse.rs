//! How a phase's motor steps are shared among iterations, and in each of them between drives and tests.

use crate::counterfactual::config::CounterfactualConfig;
use crate::phase::{Budget, Phase};
use serde::{Deserialize, Serialize};

/// What is kept for the last tests, as a share of all steps.
const FINALS: f64 = 0.15;

/// What the next iteration must know of the steps before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(in crate::counterfactual) struct Spent {
    steps: usize,
    test: usize,
}

/// The motor steps of a phase.
#[derive(Clone, Copy, Debug)]
pub(in crate::counterfactual) struct Purse {
    total: usize,
    spent: usize,
    iterations: usize,
    thrifty: bool,
    runs: usize,
    test: usize,
}

impl Purse {
    /// All steps of `phase`.
    pub fn new(phase: &Phase, config: &CounterfactualConfig, horizon: usize) -> Self {
        let total = match phase.budget {
            Budget::Steps(n) => n,
            Budget::Episodes(n) => n * horizon,
        };
        let CounterfactualConfig { iterations, thrifty, validation_runs: runs, .. } = *config;
        Self { total, spent: 0, iterations, thrifty, runs, test: 0 }
    }

    /// Steps for an iteration, drive and test, where both are paid for.
    fn allowance(&self, iteration: usize) -> usize {
        let finals = (self.total as f64 * FINALS) as usize;
        (self.total - finals).saturating_sub(self.spent) / (self.iterations - iteration).max(1)
    }

    /// Steps that the student drives itself in an iteration.
    pub fn own(&mut self, iteration: usize) -> usize {
        let share = |i: usize| self.total * i / self.iterations;
        if !self.thrifty {
            return share(iteration + 1) - share(iteration);
        }
        let allowance = self.allowance(iteration);
        let own = allowance.div_ceil(2);
        self.spent = self.spent.saturating_add(own);
        self.test = allowance - own;
        own
    }

    /// How long the test of an iteration lasts.
    pub fn test(&self) -> Budget {
        if self.thrifty { Budget::Steps(self.test.max(1)) } else { Budget::Episodes(self.runs) }
    }

    /// Pays for a test.
    pub fn pay(&mut self, steps: usize) {
        self.spent = self.spent.saturating_add(steps);
    }

    /// What was spent.
    pub fn spent(&self) -> Spent {
        Spent { steps: self.spent, test: self.test }
    }

    /// Goes on from where so much was spent.
    pub fn set_spent(&mut self, spent: Spent) {
        (self.spent, self.test) = (spent.steps, spent.test);
    }

    /// What is left for the last tests.
    pub fn left(&self) -> usize {
        self.total.saturating_sub(self.spent)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::set::IndexSet;

    fn purse(thrifty: bool) -> Purse {
        let phase =
            Phase { budget: Budget::Episodes(7), ..Phase::evaluation("drive", IndexSet::first(1), 0) };
        let config = CounterfactualConfig { iterations: 4, thrifty, ..CounterfactualConfig::default() };
        Purse::new(&phase, &config, 50)
    }

    #[test]
    fn iterations_share_all_steps_of_the_phase() {
        let mut purse = purse(false);
        assert_eq!((0..4).map(|i| purse.own(i)).sum::<usize>(), 350);
        assert_eq!(purse.test(), Budget::Episodes(100));
    }

    #[test]
    fn where_steps_are_dear_tests_are_paid_for_and_some_steps_are_kept() {
        let mut purse = purse(true);
        for iteration in 0..4 {
            let own = purse.own(iteration);
            let Budget::Steps(test) = purse.test() else { panic!("tests are counted in steps") };
            assert!((35..=38).contains(&own) && own - test <= 1, "{own} + {test}");
            purse.pay(test);
        }
        assert_eq!(purse.left(), 350 - (350 - 52));
        purse.pay(1000);
        assert_eq!((purse.left(), purse.own(3)), (0, 0));
    }
}
