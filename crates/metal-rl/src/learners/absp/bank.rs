//! The mixtures of all actions: the part that [`super::Absp`] and [`super::super::bayes_mix::BayesMix`] share.

use super::frame::Frame;
use super::mixture::{Facts, Lesson, Mixture};
use super::scan::{Scan, scan_each};
use crate::learner::{Rate, Sample};
use crate::learners::usual_error::UsualError;
use crate::num;
use serde::{Deserialize, Serialize};

/// One mixture per action, and how large their errors usually are.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Bank {
    pub frame: Frame,
    mixtures: Vec<Mixture>,
    errors: UsualError,
    #[serde(skip)]
    scratch: Vec<f64>,
}

impl Bank {
    /// Slowest rate at which the usual error follows.
    const ERROR_RATE: f64 = 1e-3;

    /// Empty mixtures.
    pub fn new(frame: Frame, choices: usize) -> Self {
        let mixtures = (0..choices).map(|_| Mixture::new(&frame)).collect();
        Self { frame, mixtures, errors: UsualError::default(), scratch: Vec::new() }
    }

    /// One mixture per action.
    pub fn mixtures(&self) -> &[Mixture] {
        &self.mixtures
    }

    /// Components of all actions.
    pub fn components(&self) -> usize {
        self.mixtures.iter().map(Mixture::len).sum()
    }

    /// Sums of one action for one state.
    pub fn scan(&self, choice: usize, state: &[f64]) -> Scan {
        self.mixtures[choice].scan(&self.frame, state)
    }

    /// Sums of every action for one state; `tell` is told the number of the first of some actions, and theirs.
    pub fn scan_each(&self, state: &[f64], tell: impl FnMut(usize, &[Scan])) {
        scan_each(&self.mixtures, &self.frame, state, tell);
    }

    /// Mean squared error so far (1 before the first error).
    pub fn error_variance(&self) -> f64 {
        if self.errors.square > 0.0 { self.errors.square } else { 1.0 }
    }

    /// Learns one sample and returns the error before it.
    pub fn learn(&mut self, sample: &Sample<'_>, rate: Rate) -> f64 {
        assert_eq!(sample.state.len(), self.frame.dims, "length of the state");
        let scan = self.mixtures[sample.choice].study(&self.frame, sample.state);
        let error = sample.target - scan.value();
        self.errors.take_in(error, Self::ERROR_RATE);
        let surprise = (error / self.error_variance().sqrt()).clamp(-1.0, 1.0);
        let success = sample.demonstrated || self.is_best(sample, scan.value());
        let lesson = Lesson { state: sample.state, target: sample.target, error, success, rate, surprise };
        self.scratch.resize(self.frame.dims, 0.0);
        let error_variance = self.error_variance();
        let mixture = &mut self.mixtures[sample.choice];
        let grown = mixture.learn(&self.frame, &lesson, &scan, &mut self.scratch);
        if grown {
            mixture.tidy(&self.frame, error_variance);
        }
        error
    }

    /// Whether no action is worth more than what the sample says of its own, whose value is known. Asks no further than
    /// the first that is.
    fn is_best(&self, sample: &Sample<'_>, known: f64) -> bool {
        let exceeds = |a| a != sample.choice && self.scan(a, sample.state).value() > sample.target;
        known <= sample.target && !(0..self.mixtures.len()).any(exceeds)
    }

    /// ln Σ exp(q/T) N(s) of one action.
    pub fn log_gibbs(&self, choice: usize, state: &[f64], temperature: f64) -> f64 {
        self.mixtures[choice].log_gibbs(&self.frame, state, temperature)
    }

    /// Expectation of `of(facts, lane)` over the components of one action; the background counts `background`.
    pub fn expect(
        &self,
        choice: usize,
        state: &[f64],
        background: f64,
        of: impl Fn(&Facts, usize) -> f64,
    ) -> f64 {
        self.mixtures[choice].expect(&self.frame, state, background, of)
    }

    /// Whether thawed parts fit together.
    pub fn is_sound(&self, choices: usize) -> bool {
        self.mixtures.len() == choices && self.mixtures.iter().all(|m| m.is_sound(&self.frame))
    }
}

/// Softmax of logarithms, all of which must be finite.
pub(crate) fn normalise_logs(logs: &mut [f64]) {
    num::soft_max(logs, 1.0);
}
