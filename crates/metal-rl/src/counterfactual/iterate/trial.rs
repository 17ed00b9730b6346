//! Trials: the greedy student on the validation stream, and how sure one may be of what it earns.

use crate::counterfactual::iterate::{CounterfactualError, School};
use crate::counterfactual::judge::{Drive, Judge};
use crate::counterfactual::student::Student;
use crate::observe::{Observer, Step};
use crate::phase::{Budget, Phase};
use crate::random::Streams;
use serde::{Deserialize, Serialize};

/// What a run earned, paid and looked at.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::counterfactual) struct Run {
    pub motor: f64,
    pub price: f64,
    pub looks: usize,
    pub steps: usize,
}

/// The runs of a trial.
#[derive(Clone, Debug, Default)]
pub(in crate::counterfactual) struct Tally {
    /// Every run.
    pub runs: Vec<Run>,
    /// Motor steps before which each slot was looked at.
    pub asked: Vec<usize>,
    roster: Vec<usize>,
    open: Run,
}

impl Tally {
    fn new(roster: &[usize]) -> Self {
        Self { roster: roster.to_vec(), asked: vec![0; roster.len()], ..Self::default() }
    }

    /// All runs together.
    pub fn sum(&self) -> Run {
        let add = |a: Run, b: &Run| Run {
            motor: a.motor + b.motor,
            price: a.price + b.price,
            looks: a.looks + b.looks,
            steps: a.steps + b.steps,
        };
        self.runs.iter().fold(Run::default(), add)
    }
}

impl Observer for Tally {
    fn on_step(&mut self, step: &Step<'_>) {
        for (asked, &member) in self.asked.iter_mut().zip(&self.roster) {
            *asked += usize::from(step.state.opinion(member).is_some());
        }
        self.open.motor += step.motor_reward;
        self.open.price += step.look_price;
        self.open.looks += step.percept.read().len();
        self.open.steps += 1;
    }

    fn on_episode(&mut self, _episode: usize, _progress: f64) {
        self.runs.push(std::mem::take(&mut self.open));
    }
}

/// How much an earlier trial counts, against the one after it: students change, and so does how far their runs differ.
const FADING: f64 = 0.7;

/// How far runs of the same student differ, over the last trials.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(in crate::counterfactual) struct Spread {
    squares: f64,
    freedom: f64,
}

impl Spread {
    pub fn add(&mut self, runs: &[Run]) {
        let earned = |run: &Run| run.motor - run.price;
        let mean = runs.iter().map(earned).sum::<f64>() / runs.len().max(1) as f64;
        let squares: f64 = runs.iter().map(|run| (earned(run) - mean) * (earned(run) - mean)).sum();
        self.squares = FADING * self.squares + squares;
        self.freedom = FADING * self.freedom + runs.len().saturating_sub(1) as f64;
    }

    /// Standard error of the mean of so many runs.
    pub fn error(&self, runs: usize) -> f64 {
        if self.freedom > 0.0 { (self.squares / self.freedom / runs.max(1) as f64).sqrt() } else { 0.0 }
    }
}

/// Tests `student` over `budget`, on the validation stream; returns how many motor steps that took, too.
pub(in crate::counterfactual) fn trial(
    school: &mut School<'_>,
    judge: &mut dyn Judge,
    (student, phase, budget): (&Student, &Phase, Budget),
    streams: &Streams,
) -> Result<(Tally, usize), CounterfactualError> {
    let mut tally = Tally::new(&school.roster);
    let test = Phase { budget, ..Phase::evaluation("validation", phase.roster, 0) };
    let limit = school.environment.spec().horizon;
    let drive = Drive { student, driver: student, phase: test, limit, price_share: 1.0, streams: *streams };
    judge.watch(school, &drive, &mut tally)?;
    let spent = tally.sum().steps;
    // A run that the end of a trial cut short tells little, if there are others.
    if budget == Budget::Steps(spent) && tally.runs.len() > 1 {
        tally.runs.pop();
    }
    Ok((tally, spent))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_of_all_students_tell_how_far_one_run_may_be_off() {
        let mut spread = Spread::default();
        assert_eq!(spread.error(1), 0.0);
        let runs = |earned: [f64; 2]| earned.map(|e| Run { motor: e + 1.0, price: 1.0, ..Run::default() });
        spread.add(&runs([1.0, 3.0]));
        spread.add(&runs([101.0, 103.0]));
        assert!((spread.error(1) - 2.0f64.sqrt()).abs() < 1e-12);
        assert!((spread.error(2) - 1.0).abs() < 1e-12);
        spread.add(&runs([0.0, 0.0]));
        assert!(spread.error(1) < 1.2, "the last trial counts most");
    }
}
