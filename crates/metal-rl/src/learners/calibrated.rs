//! Supports that mean the same whoever gives them: of another learner's values, the probability that an action turns out best.
//!
//! Eq. (7) lets the most confident agent decide, and the decision space (Eq. 10) shows supports of many agents side by side. Both
//! take for granted that 0.7 from one agent is as good as 0.7 from another, which nothing in Eq. (11) brings about: what a
//! support says depends on the learner's family and on its temperature. Here it follows from how wrong the agent usually
//! is. Who sees little of what matters is often far off, and supports nothing much; reading R141.
//!
//! # Formula
//! P\[a\] = exp(Q(s, a)/T) / Σ exp(Q(s, b)/T),  T = σ √6/π,  σ²: mean squared error before learning. That is the probability that
//! a's outcome is the largest, if outcomes are values plus independent errors of a Gumbel distribution with standard deviation σ.

use super::settings::Settings;
use super::usual_error::UsualError;
use super::{LearnerConfig, frozen};
use crate::learner::{Bump, Dims, Learner, LearnerError, Rate, Sample};
use crate::num;
use serde::{Deserialize, Serialize};

/// Name in configurations and frozen bytes.
pub(super) const NAME: &str = "calibrated";

/// √6/π: scale of a Gumbel distribution by its standard deviation.
const SCALE: f64 = 0.779_696_801_233_675_8;
/// Errors are never taken for smaller than this.
const SMALLEST: f64 = 1e-6;

/// Settings of [`Calibrated`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CalibratedConfig {
    /// The learner whose values, in units of reward, are supported.
    pub of: Box<LearnerConfig>,
    /// Samples after which an error counts 1/e: many enough to know, few enough to follow a learner that learns on.
    #[serde(default = "default_memory")]
    pub memory: f64,
}

fn default_memory() -> f64 {
    2000.0
}

impl CalibratedConfig {
    /// Refuses settings outside their range, also of the learner inside.
    ///
    /// # Errors
    /// Names the first field that is out of range.
    pub fn validate(&self) -> Result<(), LearnerError> {
        Settings(NAME).within("memory", self.memory, 10.0..=1e9, "must be 10 to a billion samples")?;
        self.of.validate()
    }
}

/// A learner with calibrated supports; see the [module](self). Its values are those of the learner inside.
#[derive(Clone)]
pub struct Calibrated {
    inner: Box<dyn Learner>,
    memory: f64,
    errors: UsualError,
}

/// What is frozen.
#[derive(Serialize, Deserialize)]
struct Frozen {
    memory: f64,
    errors: UsualError,
    inner: Vec<u8>,
}

impl Calibrated {
    /// A learner that knows nothing; whatever is random inside comes from `seed`.
    ///
    /// # Errors
    /// If a setting is outside its range.
    pub fn new(config: &CalibratedConfig, dims: Dims, seed: u64) -> Result<Self, LearnerError> {
        config.validate()?;
        Ok(Self { inner: config.of.build(dims, seed)?, memory: config.memory, errors: UsualError::default() })
    }

    /// The learner frozen in `bytes`.
    ///
    /// # Errors
    /// If the bytes are damaged or were frozen under other settings.
    pub fn thaw(config: &CalibratedConfig, bytes: &[u8]) -> Result<Self, LearnerError> {
        let Frozen { memory, errors, inner } = frozen::open(NAME, bytes)?;
        let sound = errors.square.is_finite() && errors.square >= 0.0 && errors.count >= 0.0;
        if !sound || memory.to_bits() != config.memory.to_bits() {
            return Err(frozen::foreign(NAME));
        }
        Ok(Self { inner: config.of.thaw(&inner)?, memory, errors })
    }

    /// Temperature of the supports; none before the first error.
    fn temperature(&self) -> Option<f64> {
        (self.errors.count > 0.0).then(|| (SCALE * self.usual_error()).max(SMALLEST))
    }

    /// σ, the standard deviation of its errors, in units of reward; 0 before the first.
    #[must_use]
    pub fn usual_error(&self) -> f64 {
        self.errors.square.sqrt()
    }
}

impl Learner for Calibrated {
    fn dims(&self) -> Dims {
        self.inner.dims()
    }

    fn values(&self, state: &[f64], out: &mut [f64]) {
        self.inner.values(state, out);
    }

    fn support(&self, state: &[f64], out: &mut [f64]) {
        let Some(temperature) = self.temperature() else {
            return self.inner.support(state, out);
        };
        self.inner.values(state, out);
        num::soft_max(out, temperature);
    }

    fn values_and_support(&self, state: &[f64], values: &mut [f64], support: &mut [f64]) {
        let Some(temperature) = self.temperature() else {
            return self.inner.values_and_support(state, values, support);
        };
        self.inner.values(state, values);
        support.copy_from_slice(values);
        num::soft_max(support, temperature);
    }

    fn uncertainty(&self, state: &[f64], out: &mut [f64]) -> bool {
        self.inner.uncertainty(state, out)
    }

    fn learn(&mut self, sample: Sample<'_>, rate: Rate) -> f64 {
        let error = self.inner.learn(sample, rate);
        self.errors.take_in(error, 1.0 / self.memory);
        error
    }

    fn size(&self) -> (usize, &'static str) {
        self.inner.size()
    }

    fn bumps(&self) -> Vec<Bump> {
        self.inner.bumps()
    }

    fn freeze(&self) -> Vec<u8> {
        let (memory, errors) = (self.memory, self.errors);
        frozen::seal(NAME, &Frozen { memory, errors, inner: self.inner.freeze() })
    }

    fn boxed_clone(&self) -> Box<dyn Learner> {
        Box::new(self.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::super::TileConfig;
    use super::*;
    use crate::random::Rng;

    /// What three actions are worth, and what a state tells of it.
    fn moment(rng: &mut Rng) -> (f64, [f64; 3]) {
        let seen = rng.uniform();
        (seen, [2.0 * seen, 1.0, 0.5].map(|worth| worth + 0.8 * rng.normal()))
    }

    /// Tile coding with supports of its own `temperature`, taught by chance.
    fn taught(temperature: f64) -> Calibrated {
        let tile = TileConfig { temperature, ..TileConfig::default() };
        let config = CalibratedConfig { of: Box::new(LearnerConfig::Tile(tile)), memory: 2000.0 };
        let mut learner = Calibrated::new(&config, Dims { inputs: 1, choices: 3 }, 0).unwrap();
        let mut rng = Rng::new(5);
        for _ in 0..30_000 {
            let (seen, worth) = moment(&mut rng);
            let choice = rng.below(3);
            let sample = Sample { state: &[seen], choice, target: worth[choice], demonstrated: false };
            learner.learn(sample, Rate::Average(0.01));
        }
        learner
    }

    /// Mean distance between the support of an action and how often it is the best, over ten bins of support by their weight.
    fn miscalibration(support_of: impl Fn(&[f64], &mut [f64])) -> f64 {
        let (mut rng, mut bins) = (Rng::new(6), [(0.0, 0.0); 10]);
        for _ in 0..50_000 {
            let (seen, worth) = moment(&mut rng);
            let mut support = [0.0; 3];
            support_of(&[seen], &mut support);
            for (a, &said) in support.iter().enumerate() {
                let bin = &mut bins[((said * 10.0) as usize).min(9)];
                bin.0 += said;
                bin.1 += f64::from(u8::from(a == num::argmax(&worth)));
            }
        }
        bins.iter().map(|(said, was)| (said - was).abs()).sum::<f64>() / 150_000.0
    }

    #[test]
    fn supports_of_the_too_sure_become_the_frequencies_of_being_best() {
        let learner = taught(0.1);
        let raw = miscalibration(|s, out| learner.inner.support(s, out));
        let calibrated = miscalibration(|s, out| learner.support(s, out));
        assert!(raw > 0.1 && calibrated < 0.02, "{raw} became {calibrated}");
        assert!((learner.usual_error() - 0.8).abs() < 0.05, "{}", learner.usual_error());
    }

    #[test]
    fn all_temperatures_become_the_same() {
        let (sure, humble) = (taught(0.1), taught(50.0));
        let (mut one, mut other) = ([0.0; 3], [0.0; 3]);
        sure.support(&[0.3], &mut one);
        humble.support(&[0.3], &mut other);
        assert_eq!(one, other);
    }

    #[test]
    fn who_sees_less_is_less_sure() {
        let config = CalibratedConfig { of: Box::default(), memory: 2000.0 };
        let mut seeing = Calibrated::new(&config, Dims { inputs: 1, choices: 2 }, 0).unwrap();
        let (mut blind, mut rng) = (seeing.clone(), Rng::new(7));
        for _ in 0..5000 {
            let (seen, choice) = (rng.uniform(), rng.below(2));
            let target = if (seen < 0.5) == (choice == 0) { 0.0 } else { -10.0 };
            for (learner, state) in [(&mut seeing, seen), (&mut blind, 0.5)] {
                learner.learn(
                    Sample { state: &[state], choice, target, demonstrated: false },
                    Rate::Average(0.02),
                );
            }
        }
        let surest = |learner: &Calibrated, state: f64| {
            let mut support = [0.0; 2];
            learner.support(&[state], &mut support);
            num::max(&support)
        };
        assert!(surest(&seeing, 0.2) > 0.95 && surest(&blind, 0.5) < 0.7);
    }
}
