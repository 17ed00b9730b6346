//! Settings of counterfactual policy iteration.

use super::judge::JudgeConfig;
use super::student::gaze::MemoryConfig;
use super::student::mixture::MixtureConfig;
use super::student::recollection::{RecollectionConfig, is_size};
use super::student::rule::LookRule;
use crate::decision::Content;
use crate::learner::LearnerError;
use crate::learners::nn::{Activation, Adam};
use serde::{Deserialize, Serialize};

/// Name in configurations, errors and frozen bytes.
pub const NAME: &str = "counterfactual";

/// The network, or networks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct NetworkConfig {
    /// Widths of the hidden layers.
    pub hidden: Vec<usize>,
    /// What hidden units do.
    pub activation: Activation,
    /// Optimiser; its clip is in units of the labels' spread.
    pub adam: Adam,
    /// Networks with initial weights and batches of their own, whose values are averaged.
    pub ensemble: usize,
    /// Standard deviations among the networks that are taken off the value of a move; 0: the plain mean. It makes a
    /// student that is not sure of a move look once more.
    pub caution: f64,
    /// Whether a student that learns in an imagined world is told what the model behind it believes after each look (see
    /// [`Believer`](super::Believer)), where there is such a model.
    pub belief: bool,
}

impl Default for NetworkConfig {
    fn default() -> Self {
        Self {
            hidden: vec![64, 64],
            activation: Activation::LeakyRelu,
            adam: Adam { learning_rate: 3e-3, ..Adam::default() },
            ensemble: 1,
            caution: 0.0,
            belief: false,
        }
    }
}

/// What advantages are measured in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Unit {
    /// Their root mean square.
    #[default]
    RootMeanSquare,
    /// Their mean size: a few disasters do not make everything else look alike.
    MeanAbsolute,
}

impl Unit {
    /// What is averaged of `x`.
    pub(super) fn size(self, x: f64) -> f64 {
        match self {
            Self::RootMeanSquare => x * x,
            Self::MeanAbsolute => x.abs(),
        }
    }

    /// The unit by that average.
    pub(super) fn of(self, mean: f64) -> f64 {
        match self {
            Self::RootMeanSquare => mean.sqrt(),
            Self::MeanAbsolute => mean,
        }
    }
}

/// What the student's readings are measured in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Inputs {
    /// As the members' views scale them.
    #[default]
    Scaled,
    /// Standard deviations from the mean of what was seen until looks cost their full price: a network is slow to learn
    /// from numbers that use a small part of their range.
    Standardized,
}

/// How the networks are fitted to an iteration's labels.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FitConfig {
    /// Training steps per iteration and network.
    pub batches: usize,
    /// Samples per training step.
    pub batch: usize,
    /// Training steps between copies of the network that look targets are computed with.
    pub refresh: usize,
    /// Share of samples seen through the looks that the student itself would take there; the rest is seen through
    /// random looks.
    pub own_looks: f64,
    /// Share of samples seen with everybody looked at, while that is how the student drives (see
    /// [`wide_eyed`](CounterfactualConfig::wide_eyed)), in [0, 1].
    pub open_eyes: f64,
    /// Whether random looks may be more than the student may take: what is worth looking at is found out by those who
    /// see more than is worth looking at.
    pub more_than_allowed: bool,
    /// Looks that are given a target in each sample.
    pub looks_per_sample: usize,
    /// Whether a look is valued against moving at once on the same state: what they have in common, most of it noise, cancels.
    /// Else both are valued for themselves.
    pub relative: bool,
    /// Share of the labels of the state itself, against the teacher's expectation, in what is known after a look, in
    /// [0, 1]. An expectation that learned a state by heart overrates looks; the labels do not.
    pub lambda: f64,
    /// Weight of what moving now was worth if it was judged after other looks than those it is learned for (only with
    /// memory), in [0, 1].
    pub inexact: f64,
    /// Decay of the weights per training step, in units of the step size.
    pub weight_decay: f64,
    /// Share at the end of a fit over which weights are averaged, in [0, 1).
    pub averaged: f64,
    /// What advantages are measured in; the optimiser's clip is in this unit.
    pub unit: Unit,
    /// What readings are measured in.
    pub inputs: Inputs,
    /// The step size of the optimiser falls to this share of itself over a fit, in (0, 1].
    pub final_rate: f64,
}

impl Default for FitConfig {
    fn default() -> Self {
        Self {
            batches: 3000,
            batch: 64,
            refresh: 150,
            own_looks: 0.7,
            open_eyes: 0.0,
            more_than_allowed: false,
            looks_per_sample: 2,
            relative: false,
            lambda: 1.0,
            inexact: 0.1,
            weight_decay: 0.1,
            averaged: 0.3,
            unit: Unit::default(),
            inputs: Inputs::default(),
            final_rate: 0.02,
        }
    }
}

/// Counterfactual policy iteration, as data. Its budget of motor steps is that of the phase it runs in.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CounterfactualConfig {
    /// Who decides on looks.
    pub looks: LookRule,
    /// How moves are judged.
    pub judge: JudgeConfig,
    /// What of a consulted member enters the student's state.
    pub content: Content,
    /// What the student remembers from earlier motor steps.
    pub memory: MemoryConfig,
    /// How what it recollects is learned, if its memory has a place for that.
    pub recollection: RecollectionConfig,
    /// The network.
    pub network: NetworkConfig,
    /// A mixture of Gaussians in its place, if given.
    pub mixture: Option<MixtureConfig>,
    /// How it is fitted.
    pub fit: FitConfig,
    /// Rounds of driving, judging and fitting; the phase's own steps are shared among them.
    pub iterations: usize,
    /// Labels of this many last iterations are learned from.
    pub window: usize,
    /// Motor steps after which the student's own drives begin anew in the first iteration; the limit rises evenly to the
    /// world's own over the first half of the iterations. 0: episodes are as long as the world's from the beginning. A
    /// bad student is soon where no move makes a difference any more, and would learn from hardly anything else.
    pub first_drives: usize,
    /// Probability, in [0, 1], that in a motor step of the student's own drives looks are left to chance: one slot is
    /// looked at, or nobody, in this step and up to five more. Looks move nothing, but with memory they decide what is
    /// known later: a student who always looks has never been where somebody is who did not, and would judge those places
    /// by guesswork.
    pub wander: f64,
    /// Share of visited states that are judged, in (0, 1].
    pub judged: f64,
    /// Motor steps of a roll-out before the student's own value stands in for the rest.
    pub horizon: usize,
    /// Whether it stands in; else a roll-out that is cut short ends in nothing.
    pub bootstrap: bool,
    /// Discount per motor action, in [0, 1).
    pub gamma: f64,
    /// First iterations, in which looks cost their first price and everybody is looked at before every move: whoever can drive
    /// with open eyes finds out soon which looks it can do without, while a student that knows nothing learns neither
    /// from the other. The last iteration is never one of them, however few there are.
    pub wide_eyed: usize,
    /// Iterations after them over which the price of looking that is learned from rises from the first to the true one.
    pub price_ramp: usize,
    /// The share of its price that a look costs in the first iterations, from which it rises; below 0, looks are paid for: a
    /// student that sees no difference yet looks rather than not.
    pub first_price: f64,
    /// Whether nothing is taken for granted, where every motor step counts: the steps of validations are part of the budget,
    /// and the judge may learn from them; iterates are compared with the error of the comparison; the price rises only
    /// while the student keeps up, and what was judged for a student that was given up is forgotten; the best iterates are
    /// tested once more at the end.
    pub thrifty: bool,
    /// After every [`Self::dismissed_every`] members that got less than this share of all looks since the last time are
    /// dismissed, in [0, 1), but for the one that got most: the fewer there are to choose from, the better the choice is
    /// learned. 0: nobody is.
    pub dismissal: f64,
    /// After which share of the iterations that is, again and again, in (0, 1], but not before looks cost their full price.
    pub dismissed_every: f64,
    /// How much worse than the best so far an iterate may be, as a share of the best one's cost at the price learned
    /// from, before the student goes back to the best; infinite: never back. A student that stops looking gets into
    /// states in which looking is of no use any more, and would stay blind.
    pub tolerance: f64,
    /// Share of the next drive, in [0, 1], that an iterate drives after it was given up, judged as if the student went on
    /// that it was given up for. Else the same mistakes come back: nobody has seen what they lead to.
    pub astray: f64,
    /// Episodes in which each iterate is tested on the validation stream; the best is kept.
    pub validation_runs: usize,
    /// Iterations at full price without a better iterate after which training stops; 0: never.
    pub patience: usize,
}

impl Default for CounterfactualConfig {
    fn default() -> Self {
        Self {
            looks: LookRule::default(),
            judge: JudgeConfig::default(),
            content: Content::Readings,
            memory: MemoryConfig::default(),
            recollection: RecollectionConfig::default(),
            network: NetworkConfig::default(),
            mixture: None,
            fit: FitConfig::default(),
            iterations: 36,
            window: 10,
            first_drives: 10,
            wander: 0.3,
            judged: 0.8,
            horizon: 10,
            bootstrap: true,
            gamma: 0.93,
            wide_eyed: 2,
            price_ramp: 5,
            first_price: 0.0,
            thrifty: false,
            dismissal: 0.05,
            dismissed_every: 0.25,
            tolerance: 0.1,
            astray: 0.5,
            validation_runs: 100,
            patience: 0,
        }
    }
}

impl CounterfactualConfig {
    /// The same with `share` of the training steps of every fit, or with at most `most`.
    #[must_use]
    pub fn with_fits(mut self, share: f64, most: usize) -> Self {
        let less = |batches: usize| ((batches as f64 * share).round() as usize).clamp(1, most.max(1));
        self.fit.batches = less(self.fit.batches);
        if let JudgeConfig::Critic(critic) = &mut self.judge {
            critic.batches = less(critic.batches);
        }
        if let Some(mixture) = &mut self.mixture {
            let draws = (mixture.draws as f64 * share).round() as usize;
            mixture.draws = draws.clamp(1, most.max(1).saturating_mul(self.fit.batch));
        }
        self
    }

    /// Whether moves are judged after other looks, too: where looks are free to choose and remembered, a look not taken
    /// is missed later on.
    #[must_use]
    pub fn judges_twice(&self) -> bool {
        self.memory.remembers() && matches!(self.looks, LookRule::Adaptive { .. })
    }

    /// First iterations in which everybody is looked at: those that were asked for, but never all there are, since who
    /// looks at everybody learns nothing about its own looks.
    #[must_use]
    pub fn wide_eyed_iterations(&self) -> usize {
        self.wide_eyed.min(self.iterations.saturating_sub(1))
    }

    /// Whether members are dismissed after this iteration: never before looks cost their full price.
    #[must_use]
    pub fn dismisses_after(&self, iteration: usize) -> bool {
        let every = ((self.iterations as f64 * self.dismissed_every) as usize).max(1);
        let dear = self.wide_eyed_iterations() + self.price_ramp;
        let first = dear.div_ceil(every).max(1) * every;
        iteration >= first && iteration.is_multiple_of(every) && iteration + 1 < self.iterations
    }

    /// Refuses settings outside their range.
    ///
    /// # Errors
    /// Names the first field that is out of range.
    pub fn validate(&self) -> Result<(), LearnerError> {
        self.validate_network()?;
        self.validate_fit()?;
        self.validate_looks()?;
        self.validate_recollection()?;
        if let JudgeConfig::Critic(critic) = &self.judge {
            critic.validate()?;
        }
        if let Some(mixture) = &self.mixture {
            mixture.validate()?;
            let plain = self.memory.recurrent == 0 && !matches!(self.looks, LookRule::Appointed { .. });
            let allowed = "has no place for what is recollected (`memory.recurrent`) or appointed (`looks`)";
            within("mixture", mixture.components as f64, plain, allowed)?;
        }
        count("iterations", self.iterations, 1..=10_000)?;
        count("window", self.window, 1..=10_000)?;
        count("first_drives", self.first_drives, 0..=1_000_000)?;
        within("wander", self.wander, (0.0..=1.0).contains(&self.wander), "must be in [0, 1]")?;
        share("judged", self.judged)?;
        count("horizon", self.horizon, 1..=100_000)?;
        within("gamma", self.gamma, (0.0..1.0).contains(&self.gamma), "must be in [0, 1)")?;
        count("wide_eyed", self.wide_eyed, 0..=10_000)?;
        count("price_ramp", self.price_ramp, 0..=10_000)?;
        let first = self.first_price;
        within("first_price", first, (-10.0..=1.0).contains(&first), "must be -10 to 1")?;
        let dismissal = self.dismissal;
        within("dismissal", dismissal, (0.0..1.0).contains(&dismissal), "must be in [0, 1)")?;
        let at = self.dismissed_every;
        within("dismissed_every", at, at > 0.0 && at <= 1.0, "must be in (0, 1]")?;
        within("tolerance", self.tolerance, self.tolerance >= 0.0, "must be at least 0")?;
        within("astray", self.astray, (0.0..=1.0).contains(&self.astray), "must be in [0, 1]")?;
        count("validation_runs", self.validation_runs, 1..=1_000_000)?;
        count("patience", self.patience, 0..=10_000)
    }

    fn validate_network(&self) -> Result<(), LearnerError> {
        let net = &self.network;
        net.hidden.iter().try_for_each(|&width| count("network.hidden", width, 1..=4096))?;
        let rate = f64::from(net.adam.learning_rate);
        let positive = |x: f64| x.is_finite() && x > 0.0;
        within("network.adam.learning_rate", rate, positive(rate), "must be finite and above 0")?;
        let clip = f64::from(net.adam.error_clip);
        within("network.adam.error_clip", clip, positive(clip), "must be finite and above 0")?;
        for (field, beta) in [("network.adam.beta1", net.adam.beta1), ("network.adam.beta2", net.adam.beta2)]
        {
            within(field, f64::from(beta), (0.0..1.0).contains(&beta), "must be in [0, 1)")?;
        }
        count("network.ensemble", net.ensemble, 1..=64)?;
        let caution = net.caution;
        within("network.caution", caution, (0.0..=100.0).contains(&caution), "must be 0 to 100")
    }

    fn validate_fit(&self) -> Result<(), LearnerError> {
        let fit = &self.fit;
        count("fit.batches", fit.batches, 1..=10_000_000)?;
        count("fit.batch", fit.batch, 1..=65_536)?;
        count("fit.refresh", fit.refresh, 1..=10_000_000)?;
        let own = fit.own_looks;
        within("fit.own_looks", own, (0.0..=1.0).contains(&own), "must be in [0, 1]")?;
        count("fit.looks_per_sample", fit.looks_per_sample, 1..=64)?;
        let shares =
            [("fit.open_eyes", fit.open_eyes), ("fit.lambda", fit.lambda), ("fit.inexact", fit.inexact)];
        for (field, value) in shares {
            within(field, value, (0.0..=1.0).contains(&value), "must be in [0, 1]")?;
        }
        let averaged = fit.averaged;
        within("fit.averaged", averaged, (0.0..1.0).contains(&averaged), "must be in [0, 1)")?;
        let decay = fit.weight_decay;
        within("fit.weight_decay", decay, (0.0..=100.0).contains(&decay), "must be 0 to 100")?;
        share("fit.final_rate", fit.final_rate)
    }

    fn validate_recollection(&self) -> Result<(), LearnerError> {
        let (units, recollection) = (self.memory.recurrent, &self.recollection);
        within("memory.recurrent", units as f64, is_size(units), "must be a multiple of 16 up to 128")?;
        let copies = units == 0 || self.judge == JudgeConfig::RollOuts;
        within(
            "memory.recurrent",
            units as f64,
            copies,
            "needs roll-outs (`judge`); a critic's log is not relived",
        )?;
        count("recollection.batches", recollection.batches, 1..=10_000_000)?;
        count("recollection.batch", recollection.batch, 1..=65_536)?;
        let rate = f64::from(recollection.adam.learning_rate);
        let positive = |x: f64| x.is_finite() && x > 0.0;
        within("recollection.adam.learning_rate", rate, positive(rate), "must be finite and above 0")?;
        share("recollection.final_rate", recollection.final_rate)?;
        let other = recollection.other_looks;
        within("recollection.other_looks", other, (0.0..=1.0).contains(&other), "must be in [0, 1]")
    }

    fn validate_looks(&self) -> Result<(), LearnerError> {
        match &self.looks {
            LookRule::Adaptive { min_looks, max_looks } => {
                count("looks.adaptive.max_looks", *max_looks, 1..=64)?;
                count("looks.adaptive.min_looks", *min_looks, 0..=*max_looks)?;
            }
            LookRule::Appointed { max_looks, ahead } => {
                count("looks.appointed.max_looks", *max_looks, 1..=64)?;
                count("looks.appointed.ahead", *ahead, 1..=64)?;
                let copies = self.judge == JudgeConfig::RollOuts;
                within("looks.appointed.ahead", *ahead as f64, copies, "needs roll-outs (`judge`)")?;
            }
            LookRule::Every { steps, .. } => count("looks.every.steps", *steps, 1..=100_000)?,
            LookRule::Fixed(_) | LookRule::All => {}
        }
        count("memory.looks", self.memory.looks, 0..=64)?;
        count("memory.actions", self.memory.actions, 0..=64)?;
        // A remembered reading without an age it may reach would be forgotten at once.
        count("memory.steps", self.memory.steps, usize::from(self.memory.looks > 0)..=10_000)
    }
}

pub(super) fn count(
    field: &'static str,
    n: usize,
    allowed: std::ops::RangeInclusive<usize>,
) -> Result<(), LearnerError> {
    let words = match (*allowed.start(), *allowed.end()) {
        (0, _) => "is too large",
        (_, 64) => "must be 1 to 64",
        (_, 4096) => "must be 1 to 4096",
        _ => "must be at least 1, and no machine gets beyond some millions",
    };
    within(field, n as f64, allowed.contains(&n), words)
}

pub(super) fn share(field: &'static str, value: f64) -> Result<(), LearnerError> {
    within(field, value, value > 0.0 && value <= 1.0, "must be in (0, 1]")
}

pub(super) fn within(
    field: &'static str,
    value: f64,
    fits: bool,
    allowed: &'static str,
) -> Result<(), LearnerError> {
    if fits { Ok(()) } else { Err(LearnerError::Setting { learner: NAME, field, value, allowed }) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn impossible_settings_are_named() {
        let field = |change: &dyn Fn(&mut CounterfactualConfig)| {
            let mut config = CounterfactualConfig::default();
            change(&mut config);
            match config.validate() {
                Err(LearnerError::Setting { field, .. }) => field,
                other => panic!("{other:?}"),
            }
        };
        assert_eq!(CounterfactualConfig::default().validate(), Ok(()));
        assert_eq!(field(&|c| c.gamma = 1.0), "gamma");
        assert_eq!(field(&|c| c.judged = 0.0), "judged");
        assert_eq!(field(&|c| c.wide_eyed = 10_001), "wide_eyed");
        assert_eq!(field(&|c| c.fit.final_rate = f64::NAN), "fit.final_rate");
        assert_eq!(field(&|c| c.network.ensemble = 0), "network.ensemble");
        assert_eq!(
            field(&|c| c.looks = LookRule::Adaptive { min_looks: 0, max_looks: 0 }),
            "looks.adaptive.max_looks"
        );
        assert_eq!(
            field(&|c| c.looks = LookRule::Adaptive { min_looks: 3, max_looks: 2 }),
            "looks.adaptive.min_looks"
        );
        assert_eq!(
            field(&|c| c.memory = MemoryConfig { looks: 1, ..MemoryConfig::default() }),
            "memory.steps"
        );
    }
}
