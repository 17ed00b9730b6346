//! Bayesian Q-learning over soft partitions: every component keeps a Normal-Gamma belief about its value
//! (Dearden, Friedman and Russell 1998), so that the learner knows how sure it is. The storage is [`Absp`]'s.
//!
//! # Formula
//! κ′ = κ + ρ;  m′ = m + (ρ/κ′)(y − m);  α = 2 + κ/2;  β = σ₀² + ½ Σ ρ (y − m)²
//! Var[mean of c] = β/(κ(α − 1));  Var(s, a) = Σ_c ρ_c (Var[mean of c] + (m_c − Q)²) + ρ₀ (σ₀² + (Q₀ − Q)²)

use super::absp::{Absp, AbspConfig, DosRule, MixtureConfig, Shape};
use super::frozen;
use super::settings::{POSITIVE, Settings};
use crate::learner::{Dims, Learner, LearnerError, Rate, Sample};
use crate::num;
use crate::random::Rng;
use serde::{Deserialize, Serialize};

/// Name in configurations and frozen bytes.
pub(super) const NAME: &str = "bayes_mix";

/// Settings of [`BayesMix`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BayesMixConfig {
    /// The mixtures.
    pub mixture: MixtureConfig,
    /// How degrees of support come from them.
    pub dos: DosRule,
    /// σ₀: standard deviation of a value before any evidence, in units of value, > 0.
    pub prior_sd: f64,
}

impl Default for BayesMixConfig {
    fn default() -> Self {
        let mixture = MixtureConfig { shape: Shape::Resp { least: 0.02 }, ..MixtureConfig::default() };
        Self { mixture, dos: DosRule::default(), prior_sd: 10.0 }
    }
}

impl BayesMixConfig {
    /// Refuses settings outside their range.
    ///
    /// # Errors
    /// Names the first field that is out of range.
    pub fn validate(&self) -> Result<(), LearnerError> {
        Settings(NAME).check("prior_sd", self.prior_sd, POSITIVE)?;
        self.as_absp().validate_as(NAME)
    }

    /// The settings of the storage.
    fn as_absp(&self) -> AbspConfig {
        AbspConfig { mixture: self.mixture.clone(), dos: self.dos }
    }
}

/// Soft partitioning with a belief about every value; see the [module](self).
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct BayesMix {
    config: BayesMixConfig,
    core: Absp,
}

impl BayesMix {
    /// A learner that knows nothing.
    ///
    /// # Errors
    /// If a setting is outside its range.
    pub fn new(config: &BayesMixConfig, dims: Dims) -> Result<Self, LearnerError> {
        config.validate()?;
        Ok(Self { config: config.clone(), core: Absp::new(&config.as_absp(), dims)? })
    }

    /// The learner frozen in `bytes`.
    ///
    /// # Errors
    /// If the bytes are damaged or were frozen under other settings.
    pub fn thaw(config: &BayesMixConfig, bytes: &[u8]) -> Result<Self, LearnerError> {
        let mix: Self = frozen::open(NAME, bytes)?;
        let fits = mix.config == *config && mix.core.is_sound(&config.as_absp());
        if fits { Ok(mix) } else { Err(frozen::foreign(NAME)) }
    }

    /// Variance of Q(s, a) as believed.
    fn variance(&self, choice: usize, state: &[f64]) -> f64 {
        let prior = self.config.prior_sd * self.config.prior_sd;
        let q = self.core.bank().scan(choice, state).value();
        let gap = self.core.bank().frame.background_value - q;
        self.core.bank().expect(choice, state, prior + gap * gap, |facts, lane| {
            let (count, gap) = (facts.count[lane], facts.value[lane] - q);
            let beta = prior + 0.5 * facts.scatter[lane];
            beta / (count * (1.0 + 0.5 * count)) + gap * gap
        })
    }
}

impl Learner for BayesMix {
    fn dims(&self) -> Dims {
        self.core.dims()
    }

    fn values(&self, state: &[f64], out: &mut [f64]) {
        self.core.values(state, out);
    }

    fn support(&self, state: &[f64], out: &mut [f64]) {
        self.core.support(state, out);
    }

    fn values_and_support(&self, state: &[f64], values: &mut [f64], support: &mut [f64]) {
        self.core.values_and_support(state, values, support);
    }

    fn uncertainty(&self, state: &[f64], out: &mut [f64]) -> bool {
        for (a, out) in out.iter_mut().enumerate() {
            *out = self.variance(a, state).sqrt();
        }
        true
    }

    /// Values are posterior means, so every rate is an average that forgets: α only limits the count to 1/α (R31).
    fn learn(&mut self, sample: Sample<'_>, rate: Rate) -> f64 {
        let floor = match rate {
            Rate::Full => 1.0,
            Rate::Constant(alpha) | Rate::Average(alpha) => alpha,
        };
        self.core.learn(sample, Rate::Average(floor))
    }

    fn size(&self) -> (usize, &'static str) {
        self.core.size()
    }

    fn freeze(&self) -> Vec<u8> {
        frozen::seal(NAME, self)
    }

    fn boxed_clone(&self) -> Box<dyn Learner> {
        Box::new(self.clone())
    }
}

/// One draw of each value from N(mean, sd²) into `out`: acting greedily on draws tries each action as often as it is
/// believed to be the best (Thompson sampling).
pub fn thompson(means: &[f64], sds: &[f64], rng: &mut Rng, out: &mut [f64]) {
    for ((out, mean), sd) in out.iter_mut().zip(means).zip(sds) {
        *out = mean + sd * rng.normal();
    }
}

/// Myopic value of perfect information about each action into `out`: how much better decisions would get on average if
/// its value were known. Act greedily on mean + this.
///
/// # Formula
/// best action: E[(m₂ − q)⁺];  any other: E[(q − m₁)⁺];  q ~ N(mean, sd²), m₁ ≥ m₂ the two best means
pub fn value_of_information(means: &[f64], sds: &[f64], out: &mut [f64]) {
    let best = num::argmax(means);
    let others = means.iter().enumerate().filter(|&(a, _)| a != best);
    let second = others.map(|(_, &m)| m).fold(f64::NEG_INFINITY, f64::max);
    for (a, out) in out.iter_mut().enumerate() {
        *out = match a == best {
            true if means.len() == 1 => 0.0,
            true => mean_excess(second - means[a], sds[a]),
            false => mean_excess(means[a] - means[best], sds[a]),
        };
    }
}

/// E[x⁺] for x ~ N(mean, sd²).
fn mean_excess(mean: f64, sd: f64) -> f64 {
    if sd <= 0.0 {
        return mean.max(0.0);
    }
    let z = mean / sd;
    let density = num::exp(-0.5 * z * z) / (2.0 * std::f64::consts::PI).sqrt();
    let below = 0.5 * (1.0 + num::erf(z * std::f64::consts::FRAC_1_SQRT_2));
    (sd * density + mean * below).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_excess_is_that_of_sampling() {
        let mut rng = Rng::new(2);
        for (mean, sd) in [(-1.0, 0.7), (0.3, 2.0), (0.0, 1.0)] {
            let n = 200_000;
            let sampled = (0..n).map(|_| (mean + sd * rng.normal()).max(0.0)).sum::<f64>() / f64::from(n);
            assert!((mean_excess(mean, sd) - sampled).abs() < 0.02);
        }
    }

    #[test]
    fn information_is_worth_most_where_it_could_change_the_choice() {
        let mut gains = [0.0; 3];
        value_of_information(&[1.0, 0.9, -5.0], &[0.1, 1.0, 1.0], &mut gains);
        assert!(gains[1] > gains[0] && gains[1] > gains[2] && gains[2] >= 0.0);
    }

    #[test]
    fn beliefs_sharpen_with_evidence_and_widen_away_from_it() {
        let dims = Dims { inputs: 2, choices: 2 };
        let mut mix = BayesMix::new(&BayesMixConfig::default(), dims).unwrap();
        let mut rng = Rng::new(1);
        let mut history = Vec::new();
        for _ in 0..400 {
            let sample = Sample { state: &[0.5, 0.5], choice: 0, target: rng.normal(), demonstrated: false };
            mix.learn(sample, Rate::Average(0.001));
            let mut sd = [0.0; 2];
            assert!(mix.uncertainty(&[0.5, 0.5], &mut sd));
            history.push(sd[0]);
        }
        assert!(history[399] < 0.25 * history[9], "{} then {}", history[9], history[399]);
        // 400 unit-variance targets: the mean is known to about 1/20, the background adds a little.
        assert!((0.03..0.4).contains(&history[399]), "{}", history[399]);
        let mut sd = [0.0; 2];
        mix.uncertainty(&[0.0, 0.0], &mut sd);
        assert!((sd[0] - 10.0).abs() < 0.5 && (sd[1] - 10.0).abs() < 1e-9, "{sd:?}");
    }

    #[test]
    fn draws_have_the_asked_spread() {
        let mut rng = Rng::new(3);
        let (mut sum, mut out) = (0.0, [0.0; 2]);
        for _ in 0..20_000 {
            thompson(&[1.0, -1.0], &[2.0, 0.0], &mut rng, &mut out);
            assert!((out[1] + 1.0).abs() < 1e-12);
            sum += (out[0] - 1.0) * (out[0] - 1.0) / 20_000.0;
        }
        assert!((sum - 4.0).abs() < 0.2);
    }
}
