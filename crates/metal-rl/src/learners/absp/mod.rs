//! Bayesian continuous Q-learning with action-based soft partitioning by Gaussians: our reconstruction of the learner
//! the paper takes from its reference \[11\] (Sec. 3.2.1), whose text could not be read (reading R20).
//!
//! Each action owns Gaussians over the state; each Gaussian has a value q, a mass n of states in which the action was
//! tried and a mass g of states in which it succeeded. An immovable uniform background is the prior: far from all
//! data, values are the background's and all actions are equally supported.
//!
//! # Formula
//! w_c = min(n_c, n_max),  ρ_c = w_c N_c(s) / (n₀ + Σ w N(s)),  Q(s, a) = ρ₀ Q₀ + Σ_c ρ_c q_c                                    (S1)
//! P(a|s) = (n₀ + Σ_{c of a} g_c N_c(s)) / Σ_b (n₀ + Σ_{c of b} g_c N_c(s))                              (S2)
//!
//! S2 is the rule of Bayes: P(s|a) is the density of states in which a succeeded. Eq. (11), reading R21.

mod bank;
mod frame;
mod gaussians;
mod merge;
mod mixture;
mod scan;

use super::frozen;
use super::settings::{POSITIVE, Settings};
use crate::learner::{Bump, Dims, Learner, LearnerError, Rate, Sample};
use crate::num;
pub(super) use bank::{Bank, normalise_logs};
pub use frame::Shape;
pub(super) use frame::{Frame, chi_squared_quantile};
pub(super) use gaussians::{Gaussians, LANES, Lane, MAX_FULL};
pub(super) use mixture::{NEGLIGIBLE, TOUCHED, with_rows};
use serde::{Deserialize, Serialize};

/// Name in configurations and frozen bytes.
pub(super) const NAME: &str = "absp";

/// Form of the covariances.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Covariance {
    /// Full up to 8 dimensions, diagonal above.
    #[default]
    Auto,
    /// Axes-parallel: d numbers.
    Diagonal,
    /// Any orientation: d(d + 1)/2 numbers, at most 64 dimensions.
    Full,
}

/// How degrees of support come from the mixtures. Eq. (11).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum DosRule {
    /// Bayes' rule on the densities of successful states (S2).
    #[default]
    SuccessBayes,
    /// softmax(Q/temperature).
    Softmax {
        /// In units of value, > 0.
        temperature: f64,
    },
    /// Bayes' rule on the densities of tried states: habits, not merit.
    Density,
    /// Bayes' rule with the prior exp(q/temperature) in place of masses: merit, not habits.
    Gibbs {
        /// In units of value, > 0.
        temperature: f64,
    },
    /// (Q − min Q + 10⁻⁹)/Σ, which Eq. (21) suggests.
    NormalisedQ,
}

/// Settings of the mixtures, shared by [`Absp`] and [`super::bayes_mix::BayesMix`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MixtureConfig {
    /// Form of the covariances.
    pub covariance: Covariance,
    /// Standard deviation of a new component (states are in \[0, 1\]); 0 takes 0.07 up to 2 dimensions, 0.10 up to 4,
    /// 0.25 up to 8, 0.15 above.
    pub first_width: f64,
    /// Smallest standard deviation; for full covariances given the earlier dimensions.
    pub smallest_width: f64,
    /// Every density is raised to min(1, effective_dims/d), so that in many dimensions neighbours still overlap.
    /// At least d: off. Needed for the 24 dimensions of the full observer.
    pub effective_dims: f64,
    /// A state is new beyond this quantile of the distance of a component's own samples, in (0, 1).
    pub gate_quantile: f64,
    /// Most components per action; beyond, the most similar ones merge.
    pub cap: usize,
    /// Most that the mass of a component counts in responsibilities, at least 1. Without this limit a component
    /// visited a thousand times owns the centres of its rarely visited neighbours, and they never learn.
    pub most_mass: f64,
    /// n₀: mass of the background per action, > 0.
    pub background_mass: f64,
    /// Q₀: value of the background. 0 with negative rewards is optimistic and drives exploration.
    pub background_value: f64,
    /// κ₀: weight of the value before creation in a new component's value; 1 if rewards are noisy.
    pub prior_count: f64,
    /// How components move and stretch.
    pub shape: Shape,
    /// A component is dropped if after this many updates …
    pub prune_age: f64,
    /// … its mass is still below this.
    pub prune_mass: f64,
}

impl Default for MixtureConfig {
    fn default() -> Self {
        Self {
            covariance: Covariance::Auto,
            first_width: 0.0,
            smallest_width: 0.02,
            effective_dims: 4.0,
            gate_quantile: 0.90,
            cap: 100,
            most_mass: 10.0,
            background_mass: 0.01,
            background_value: 0.0,
            prior_count: 0.0,
            shape: Shape::Signed { step: 0.02 },
            prune_age: 200.0,
            prune_mass: 2.0,
        }
    }
}

impl MixtureConfig {
    /// Refuses settings outside their range, in the name of a learner.
    pub(super) fn validate(&self, learner: &'static str) -> Result<(), LearnerError> {
        let s = Settings(learner);
        s.within("first_width", self.first_width, 0.0..=1e3, "must be at least 0 (0: automatic)")?;
        s.within("smallest_width", self.smallest_width, 1e-6..=1e3, "must be at least 1e-6")?;
        s.within("effective_dims", self.effective_dims, 0.1..=1e9, "must be at least 0.1")?;
        s.within("gate_quantile", self.gate_quantile, 0.01..=0.999_999, "must be in (0, 1)")?;
        s.within("cap", self.cap as f64, 1.0..=1e5, "must be 1 to 100000")?;
        s.within("most_mass", self.most_mass, 1.0..=1e300, "must be at least 1")?;
        s.within("background_mass", self.background_mass, 1e-12..=1e300, "must be above 0")?;
        s.within("background_value", self.background_value, -1e12..=1e12, "must be finite")?;
        s.within("prior_count", self.prior_count, 0.0..=1e6, "must be at least 0")?;
        s.within("prune_age", self.prune_age, 0.0..=1e300, "must be at least 0")?;
        s.within("prune_mass", self.prune_mass, 0.0..=1e300, "must be at least 0")?;
        match self.shape {
            Shape::Signed { step } => s.within("shape.signed.step", step, 0.0..=0.5, "must be 0 to 0.5"),
            Shape::Resp { least } => s.within("shape.resp.least", least, 0.0..=0.5, "must be 0 to 0.5"),
        }
    }

    /// The settings worked out for `dims`.
    pub(super) fn frame(&self, learner: &'static str, dims: usize) -> Result<Frame, LearnerError> {
        self.validate(learner)?;
        let full = match self.covariance {
            Covariance::Auto => dims <= 8,
            Covariance::Diagonal => false,
            Covariance::Full => true,
        };
        let most = if full { MAX_FULL } else { usize::MAX };
        Settings(learner).within(
            "covariance",
            dims as f64,
            1.0..=most as f64,
            "full covariances allow 1 to 64 dimensions",
        )?;
        let effective = self.effective_dims.min(dims as f64);
        Ok(Frame {
            dims,
            full,
            first_width: self.width(dims).max(self.smallest_width),
            smallest_width: self.smallest_width,
            most_mass: self.most_mass,
            background_mass: self.background_mass,
            background_value: self.background_value,
            prior_count: self.prior_count,
            shape: self.shape,
            sharpness: effective / dims as f64,
            gate: chi_squared_quantile(effective, self.gate_quantile),
            cap: self.cap,
            prune_age: self.prune_age,
            prune_mass: self.prune_mass,
        })
    }

    /// Standard deviation of a new component.
    fn width(&self, dims: usize) -> f64 {
        match dims {
            _ if self.first_width > 0.0 => self.first_width,
            0..=2 => 0.07,
            3..=4 => 0.10,
            5..=8 => 0.25,
            _ => 0.15,
        }
    }
}

/// Settings of [`Absp`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct AbspConfig {
    /// The mixtures.
    pub mixture: MixtureConfig,
    /// How degrees of support come from them.
    pub dos: DosRule,
}

impl AbspConfig {
    /// Refuses settings outside their range.
    ///
    /// # Errors
    /// Names the first field that is out of range.
    pub fn validate(&self) -> Result<(), LearnerError> {
        self.validate_as(NAME)
    }

    /// As [`Self::validate`], in the name of a learner built on this one.
    pub(super) fn validate_as(&self, learner: &'static str) -> Result<(), LearnerError> {
        self.mixture.validate(learner)?;
        match self.dos {
            DosRule::Softmax { temperature } | DosRule::Gibbs { temperature } => {
                Settings(learner).check("dos.temperature", temperature, POSITIVE)
            }
            DosRule::SuccessBayes | DosRule::Density | DosRule::NormalisedQ => Ok(()),
        }
    }
}

/// Action-based soft partitioning; see the [module](self).
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Absp {
    config: AbspConfig,
    bank: Bank,
    choices: usize,
}

impl Absp {
    /// A learner that knows nothing.
    ///
    /// # Errors
    /// If a setting is outside its range.
    pub fn new(config: &AbspConfig, dims: Dims) -> Result<Self, LearnerError> {
        config.validate()?;
        let frame = config.mixture.frame(NAME, dims.inputs)?;
        Ok(Self { config: config.clone(), bank: Bank::new(frame, dims.choices), choices: dims.choices })
    }

    /// The learner frozen in `bytes`.
    ///
    /// # Errors
    /// If the bytes are damaged or were frozen under other settings.
    pub fn thaw(config: &AbspConfig, bytes: &[u8]) -> Result<Self, LearnerError> {
        let absp: Self = frozen::open(NAME, bytes)?;
        if absp.is_sound(config) { Ok(absp) } else { Err(frozen::foreign(NAME)) }
    }

    /// Whether a thawed learner is whole and of these settings.
    pub(super) fn is_sound(&self, config: &AbspConfig) -> bool {
        let frame = config.mixture.frame(NAME, self.bank.frame.dims);
        self.config == *config && frame == Ok(self.bank.frame.clone()) && self.bank.is_sound(self.choices)
    }

    /// The mixtures of all actions.
    pub(super) fn bank(&self) -> &Bank {
        &self.bank
    }

    /// Number of components of each action.
    #[must_use]
    pub fn components(&self) -> Vec<usize> {
        self.bank.mixtures().iter().map(mixture::Mixture::len).collect()
    }

    /// Turns what the scans left in `out` (see [`Self::log_supports`]) and the values into degrees of support.
    fn finish_support(&self, state: &[f64], values: &[f64], out: &mut [f64]) {
        match self.config.dos {
            DosRule::SuccessBayes | DosRule::Density => normalise_logs(out),
            DosRule::Softmax { temperature } => {
                out.copy_from_slice(values);
                num::soft_max(out, temperature);
            }
            DosRule::Gibbs { temperature } => {
                for (a, out) in out.iter_mut().enumerate() {
                    *out = self.bank.log_gibbs(a, state, temperature);
                }
                normalise_logs(out);
            }
            DosRule::NormalisedQ => {
                let least = values.iter().copied().fold(f64::INFINITY, f64::min);
                let sum: f64 = values.iter().map(|v| v - least + 1e-9).sum();
                out.iter_mut().zip(values).for_each(|(o, v)| *o = (v - least + 1e-9) / sum);
            }
        }
    }

    /// ln of the supports of some actions before normalisation, for the rules that read it off scans.
    fn log_supports(&self, scans: &[scan::Scan], out: &mut [f64]) {
        let out = &mut out[..scans.len()];
        let density = self.config.dos == DosRule::Density;
        for (out, scan) in out.iter_mut().zip(scans) {
            let [mass, success] = scan.masses();
            *out = if density { mass } else { success };
        }
        num::ln_of_each(out);
        out.iter_mut().zip(scans).for_each(|(out, scan)| *out += scan.reference);
    }
}

impl Learner for Absp {
    fn dims(&self) -> Dims {
        Dims { inputs: self.bank.frame.dims, choices: self.choices }
    }

    fn values(&self, state: &[f64], out: &mut [f64]) {
        assert_eq!(state.len(), self.bank.frame.dims, "length of the state");
        self.bank.scan_each(state, |first, scans| {
            out[first..].iter_mut().zip(scans).for_each(|(out, scan)| *out = scan.value());
        });
    }

    fn support(&self, state: &[f64], out: &mut [f64]) {
        const STACK: usize = 64;
        if out.len() <= STACK {
            self.values_and_support(state, &mut [0.0; STACK][..out.len()], out);
        } else {
            self.values_and_support(state, &mut vec![0.0; out.len()], out);
        }
    }

    fn values_and_support(&self, state: &[f64], values: &mut [f64], support: &mut [f64]) {
        assert_eq!(state.len(), self.bank.frame.dims, "length of the state");
        self.bank.scan_each(state, |first, scans| {
            values[first..].iter_mut().zip(scans).for_each(|(value, scan)| *value = scan.value());
            self.log_supports(scans, &mut support[first..]);
        });
        self.finish_support(state, values, support);
    }

    fn learn(&mut self, sample: Sample<'_>, rate: Rate) -> f64 {
        self.bank.learn(&sample, rate)
    }

    fn size(&self) -> (usize, &'static str) {
        (self.bank.components(), "components")
    }

    fn bumps(&self) -> Vec<Bump> {
        let of_choice = |(choice, mixture): (usize, &mixture::Mixture)| {
            let gaussians = &mixture.gaussians;
            let dims = self.bank.frame.dims;
            let bump = |c: usize| Bump {
                choice,
                mean: (0..dims).map(|i| gaussians.mean(c, i)).collect(),
                deviation: (0..dims).map(|i| gaussians.covariance(c, i, i).sqrt()).collect(),
            };
            (0..mixture.len()).map(bump).collect::<Vec<_>>()
        };
        self.bank.mixtures().iter().enumerate().flat_map(of_choice).collect()
    }

    fn freeze(&self) -> Vec<u8> {
        frozen::seal(NAME, self)
    }

    fn boxed_clone(&self) -> Box<dyn Learner> {
        Box::new(self.clone())
    }
}
