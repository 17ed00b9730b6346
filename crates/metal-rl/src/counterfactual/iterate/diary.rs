//! The diary of a training: how good each iterate was, and which one is the best.

use crate::counterfactual::iterate::trial::{Spread, Tally};
use crate::num;
use serde::{Deserialize, Serialize};

/// One iteration in numbers. Costs are means per motor step of the greedy student on the validation stream, at true
/// prices.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Iterate {
    /// Motor steps the student drove itself to be taught.
    pub own_steps: usize,
    /// Motor steps of roll-outs in copies of the world.
    pub rolled_steps: usize,
    /// Motor steps of the validation.
    pub validation_steps: usize,
    /// Share of the price of looking that was learned from.
    pub price_share: f64,
    /// Share of this iteration's judged moments at which no move made much of a difference.
    pub idle: f64,
    /// Mean loss at the end of the fit, in units of the labels' spread.
    pub loss: f64,
    /// Motor reward and prices together.
    pub total: f64,
    /// Motor reward.
    pub motor: f64,
    /// Looks.
    pub looks: f64,
    /// Motor steps of a run of the validation, mean.
    #[serde(default = "one")]
    pub run_steps: f64,
    /// Runs of the validation.
    #[serde(default)]
    pub runs: usize,
    /// Standard error of what a run earns, where iterates are compared with care; else 0.
    #[serde(default)]
    pub error: f64,
}

/// Runs of equal length may be compared step by step.
fn one() -> f64 {
    1.0
}

impl Iterate {
    /// After another test of the same iterate, with the standard error of both together.
    pub(in crate::counterfactual) fn add(&mut self, test: &Tally, spread: Spread) {
        let (sum, before, runs) = (test.sum(), self.validation_steps as f64, test.runs.len());
        let steps = before + sum.steps as f64;
        let mean = |old: f64, new: f64| (old * before + new) / f64::max(steps, 1.0);
        self.total = mean(self.total, sum.motor - sum.price);
        self.motor = mean(self.motor, sum.motor);
        self.looks = mean(self.looks, sum.looks as f64);
        self.validation_steps += sum.steps;
        self.runs += runs;
        self.run_steps = self.validation_steps as f64 / self.runs.max(1) as f64;
        self.error = spread.error(self.runs);
    }

    /// What a run would earn if a look cost this share of its price. Per run, not per step: where a world can end, who
    /// lives twice as long as another at the same reward per step is twice as good.
    #[must_use]
    pub fn at_price(&self, share: f64) -> f64 {
        self.run_steps * (self.motor + share * (self.total - self.motor))
    }

    /// The same as far as it is sure: one standard error less.
    #[must_use]
    pub fn surely(&self, share: f64) -> f64 {
        self.at_price(share) - self.error
    }

    /// Whether it is worse than `record` by more than this share of the record and by more than chance, if a look cost
    /// this share of its price.
    #[must_use]
    pub fn is_worse_than(&self, record: &Self, share: f64, tolerance: f64) -> bool {
        let best = record.at_price(share);
        let chance = (self.error * self.error + record.error * record.error).sqrt();
        self.at_price(share) < best - f64::max(tolerance * best.abs(), chance)
    }
}

/// The iterate that is best if a look cost this share of its price; the earlier one wins a tie.
///
/// # Panics
/// If there is none.
#[must_use]
pub fn best(diary: &[Iterate], share: f64) -> usize {
    let worth: Vec<f64> = diary.iter().map(|i| i.surely(share)).collect();
    num::argmax(&worth)
}

/// The `most` iterates that are best at true prices, the best one first.
#[must_use]
pub fn finalists(diary: &[Iterate], most: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..diary.len()).collect();
    order.sort_by(|&a, &b| diary[b].surely(1.0).total_cmp(&diary[a].surely(1.0)));
    order.truncate(most);
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    fn iterate(run_steps: f64, total: f64, error: f64) -> Iterate {
        Iterate {
            own_steps: 0,
            rolled_steps: 0,
            validation_steps: 0,
            price_share: 1.0,
            idle: 0.0,
            loss: 0.0,
            total,
            motor: 1.0,
            looks: 0.0,
            run_steps,
            runs: 1,
            error,
        }
    }

    #[test]
    fn who_lives_longer_at_the_same_reward_per_step_is_better() {
        // A pole that falls at once without a look, and one that stands for 200 steps of two looks each.
        let diary = [iterate(9.0, 1.0, 0.0), iterate(200.0, 0.9, 0.0)];
        assert_eq!(best(&diary, 1.0), 1);
        assert_eq!(finalists(&diary, 5), [1, 0]);
    }

    #[test]
    fn one_lucky_run_is_no_record() {
        let diary = [iterate(100.0, 1.0, 2.0), iterate(120.0, 1.0, 50.0)];
        assert_eq!(best(&diary, 1.0), 0);
        assert!(!diary[0].is_worse_than(&diary[1], 1.0, 0.1), "by chance, perhaps");
        assert!(iterate(60.0, 1.0, 2.0).is_worse_than(&diary[0], 1.0, 0.1));
        assert!(!iterate(95.0, 1.0, 0.0).is_worse_than(&diary[0], 1.0, 0.1), "that is tolerated");
    }
}
