//! Incremental Gaussian mixture network over states and values together: every component is a small linear model of
//! the value (Heinen and Engel; Pinto and Engel 2015; Agostini and Celaya 2010).
//!
//! The published covariance step can lose positive definiteness (reading R32); ours is the exact weighted recursion on
//! a Cholesky factor. With the value as the last dimension, that factor also holds the regression: its last row.
//!
//! # Formula
//! m_c(s) = μ_q + Σ_qs Σ_ss⁻¹ (s − μ_s) = μ_q + L\[q\]\[·\] y,  y = L_ss⁻¹ (s − μ_s);  v_c = L\[q\]\[q\]²
//! Q(s, a) = ρ₀ Q₀ + Σ_c ρ_c m_c(s);  Var(s, a) = Σ_c ρ_c (v_c + (m_c − Q)²) + ρ₀ (σ₀² + (Q₀ − Q)²)

use super::absp::{Gaussians, LANES, Lane, MAX_FULL, NEGLIGIBLE, TOUCHED, chi_squared_quantile, with_rows};
use super::frozen;
use super::settings::{POSITIVE, Settings};
use crate::learner::{Dims, Learner, LearnerError, Rate, Sample};
use crate::num;
use serde::{Deserialize, Serialize};

/// Name in configurations and frozen bytes.
pub(super) const NAME: &str = "igmn";

/// Settings of [`Igmn`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct IgmnConfig {
    /// Standard deviation of a new component along the state (in \[0, 1\]).
    pub first_width: f64,
    /// Smallest standard deviation along the state.
    pub smallest_width: f64,
    /// Standard deviation of a new component along the value, in units of value.
    pub first_value_width: f64,
    /// Smallest standard deviation along the value, given the state.
    pub smallest_value_width: f64,
    /// Every density is raised to min(1, effective_dims/d); at least d: off.
    pub effective_dims: f64,
    /// A state is new beyond this quantile of the distance of a component's own states, in (0, 1).
    pub gate_quantile: f64,
    /// Most components per action; beyond, the lightest one is dropped.
    pub cap: usize,
    /// Smallest share of a sample per unit of responsibility: how fast old samples are forgotten.
    pub least_share: f64,
    /// Most that the mass of a component counts in responsibilities, at least 1; see
    /// [`MixtureConfig::most_mass`](super::absp::MixtureConfig::most_mass).
    pub most_mass: f64,
    /// Mass of the background per action, > 0; its value is 0.
    pub background_mass: f64,
    /// Temperature of the degrees of support, in units of value: softmax(Q/temperature).
    pub temperature: f64,
}

impl Default for IgmnConfig {
    fn default() -> Self {
        Self {
            first_width: 0.10,
            smallest_width: 0.02,
            first_value_width: 1.0,
            smallest_value_width: 0.1,
            effective_dims: 4.0,
            gate_quantile: 0.90,
            cap: 100,
            least_share: 0.02,
            most_mass: 1000.0,
            background_mass: 0.01,
            temperature: 1.0,
        }
    }
}

impl IgmnConfig {
    /// Refuses settings outside their range.
    ///
    /// # Errors
    /// Names the first field that is out of range.
    pub fn validate(&self) -> Result<(), LearnerError> {
        let s = Settings(NAME);
        s.within("first_width", self.first_width, 1e-6..=1e3, "must be at least 1e-6")?;
        s.within("smallest_width", self.smallest_width, 1e-6..=1e3, "must be at least 1e-6")?;
        s.within("first_value_width", self.first_value_width, 1e-6..=1e9, "must be at least 1e-6")?;
        s.within("smallest_value_width", self.smallest_value_width, 1e-6..=1e9, "must be at least 1e-6")?;
        s.within("effective_dims", self.effective_dims, 0.1..=1e9, "must be at least 0.1")?;
        s.within("gate_quantile", self.gate_quantile, 0.01..=0.999_999, "must be in (0, 1)")?;
        s.within("cap", self.cap as f64, 1.0..=1e5, "must be 1 to 100000")?;
        s.within("least_share", self.least_share, 0.0..=0.5, "must be 0 to 0.5")?;
        s.within("most_mass", self.most_mass, 1.0..=1e300, "must be at least 1")?;
        s.within("background_mass", self.background_mass, 1e-12..=1e300, "must be above 0")?;
        s.check("temperature", self.temperature, POSITIVE)
    }
}

/// The components of one action.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Joint {
    gaussians: Gaussians,
    /// n per component, one lane each.
    mass: Vec<Lane>,
    /// κ: targets behind each value, forgetting included.
    count: Vec<Lane>,
}

/// Sums over the components of one action for one state, all times exp(−reference).
struct Recall {
    reference: f64,
    mass: f64,
    value: f64,
    nearest: f64,
}

/// What a component says about a state.
struct Opinion {
    component: usize,
    log_density: f64,
    expected: f64,
}

impl Joint {
    fn new(config: &IgmnConfig, inputs: usize) -> Self {
        let mut floors = vec![config.smallest_width; inputs];
        floors.push(config.smallest_value_width);
        Self { gaussians: Gaussians::with_value_axis(floors), mass: Vec::new(), count: Vec::new() }
    }

    /// Calls `each` with every component's opinion; returns the squared distance to the nearest.
    fn ask(&self, sharpness: f64, s: &[f64], mut each: impl FnMut(Opinion)) -> f64 {
        let scale = s.len() as f64 * num::ln(2.0 * std::f64::consts::PI);
        let mut nearest = f64::INFINITY;
        with_rows(s.len() + 1, |rows| {
            for group in 0..self.gaussians.groups() {
                let d2 = self.gaussians.distances(group, s, rows);
                let expected = self.gaussians.expected_last(group, rows);
                let log_dets = self.gaussians.log_dets()[group];
                for lane in 0..(self.gaussians.len() - group * LANES).min(LANES) {
                    nearest = nearest.min(d2[lane]);
                    each(Opinion {
                        component: group * LANES + lane,
                        log_density: -0.5 * sharpness * (scale + log_dets[lane] + d2[lane]),
                        expected: expected[lane],
                    });
                }
            }
        });
        nearest
    }

    /// The value of a state and what is needed for responsibilities. The background has value 0.
    fn recall(&self, config: &IgmnConfig, sharpness: f64, s: &[f64]) -> Recall {
        let (mut reference, mut mass, mut value) = (0.0, config.background_mass, 0.0);
        let nearest = self.ask(sharpness, s, |o| {
            if o.log_density > reference {
                let factor = num::exp(reference - o.log_density);
                mass *= factor;
                value *= factor;
                reference = o.log_density;
            }
            if o.log_density - reference > NEGLIGIBLE {
                let m = self.weight(config, o.component) * num::exp(o.log_density - reference);
                mass += m;
                value += m * o.expected;
            }
        });
        Recall { reference, mass, value: value / mass, nearest }
    }

    /// What a component's mass counts in responsibilities.
    fn weight(&self, config: &IgmnConfig, c: usize) -> f64 {
        self.mass[c / LANES][c % LANES].min(config.most_mass)
    }

    /// Responsibility of the component of an opinion.
    fn responsibility(&self, config: &IgmnConfig, recall: &Recall, o: &Opinion) -> f64 {
        if o.log_density - recall.reference > NEGLIGIBLE {
            self.weight(config, o.component) * num::exp(o.log_density - recall.reference) / recall.mass
        } else {
            0.0
        }
    }

    /// A new component at (state, target); beyond the cap the lightest other one goes.
    fn create(&mut self, config: &IgmnConfig, point: &[f64]) {
        let value_axis = point.len() - 1;
        if self.gaussians.len() == config.cap {
            self.drop_lightest();
        }
        let width = |i| if i == value_axis { config.first_value_width } else { config.first_width };
        let c = self.gaussians.push(point, width);
        self.mass.resize(self.gaussians.groups(), [0.0; LANES]);
        self.count.resize(self.gaussians.groups(), [0.0; LANES]);
        self.mass[c / LANES][c % LANES] = 1.0;
        self.count[c / LANES][c % LANES] = 1.0;
    }

    fn drop_lightest(&mut self) {
        let mass = |c: usize| self.mass[c / LANES][c % LANES];
        let last = self.gaussians.len() - 1;
        let lightest = (0..last).fold(last, |a, b| if mass(b) < mass(a) { b } else { a });
        for store in [&mut self.mass, &mut self.count] {
            store[lightest / LANES][lightest % LANES] = store[last / LANES][last % LANES];
        }
        self.gaussians.swap_remove(lightest);
    }

    /// Value step, then the exact recursion towards `point` = (state, target), for one component.
    fn adapt(&mut self, config: &IgmnConfig, who: (usize, f64), lesson: (&[f64], f64, Rate), e: &mut [f64]) {
        let (c, rho) = who;
        let (point, error, rate) = lesson;
        let (mass, count) = (&mut self.mass[c / LANES][c % LANES], &mut self.count[c / LANES][c % LANES]);
        *mass += rho;
        *count += rho;
        let share = match rate {
            Rate::Full => rho,
            Rate::Constant(alpha) => alpha * rho,
            Rate::Average(alpha) => {
                let share = (rho / *count).max(alpha * rho);
                *count = count.min(1.0 / alpha);
                share
            }
        };
        let w = (rho / *mass).max(config.least_share * rho).min(0.5);
        let axis = point.len() - 1;
        self.gaussians.set_mean(c, axis, self.gaussians.mean(c, axis) + share * error);
        self.gaussians.attract(c, point, w, e);
    }
}

/// Incremental Gaussian mixture network over (state, value) per action; see the [module](self).
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Igmn {
    config: IgmnConfig,
    dims: Dims,
    sharpness: f64,
    gate: f64,
    actions: Vec<Joint>,
    #[serde(skip)]
    work: Work,
}

/// Buffers of learning; they carry nothing from sample to sample.
#[derive(Clone, Debug, Default)]
struct Work {
    point: Vec<f64>,
    scratch: Vec<f64>,
    touched: Vec<(usize, f64)>,
}

impl Igmn {
    /// A learner that knows nothing.
    ///
    /// # Errors
    /// If a setting is outside its range.
    pub fn new(config: &IgmnConfig, dims: Dims) -> Result<Self, LearnerError> {
        config.validate()?;
        let most = (MAX_FULL - 1) as f64;
        Settings(NAME).within(
            "dims.inputs",
            dims.inputs as f64,
            1.0..=most,
            "there must be 1 to 63 inputs",
        )?;
        let effective = config.effective_dims.min(dims.inputs as f64);
        Ok(Self {
            config: config.clone(),
            dims,
            sharpness: effective / dims.inputs as f64,
            gate: chi_squared_quantile(effective, config.gate_quantile),
            actions: (0..dims.choices).map(|_| Joint::new(config, dims.inputs)).collect(),
            work: Work::default(),
        })
    }

    /// The learner frozen in `bytes`.
    ///
    /// # Errors
    /// If the bytes are damaged or were frozen under other settings.
    pub fn thaw(config: &IgmnConfig, bytes: &[u8]) -> Result<Self, LearnerError> {
        let igmn: Self = frozen::open(NAME, bytes)?;
        let sound = igmn.actions.len() == igmn.dims.choices
            && igmn.dims.inputs < MAX_FULL
            && igmn.actions.iter().all(|a| {
                let groups = a.gaussians.groups();
                a.gaussians.is_sound()
                    && a.gaussians.dims() == igmn.dims.inputs + 1
                    && [a.mass.len(), a.count.len()] == [groups, groups]
            });
        if sound && igmn.config == *config { Ok(igmn) } else { Err(frozen::foreign(NAME)) }
    }
}

impl Learner for Igmn {
    fn dims(&self) -> Dims {
        self.dims
    }

    fn values(&self, state: &[f64], out: &mut [f64]) {
        assert_eq!(state.len(), self.dims.inputs, "length of the state");
        for (action, out) in self.actions.iter().zip(out) {
            *out = action.recall(&self.config, self.sharpness, state).value;
        }
    }

    fn support(&self, state: &[f64], out: &mut [f64]) {
        self.values(state, out);
        num::soft_max(out, self.config.temperature);
    }

    fn values_and_support(&self, state: &[f64], values: &mut [f64], support: &mut [f64]) {
        self.values(state, values);
        support.copy_from_slice(values);
        num::soft_max(support, self.config.temperature);
    }

    fn uncertainty(&self, state: &[f64], out: &mut [f64]) -> bool {
        let prior = self.config.first_value_width * self.config.first_value_width;
        for (action, out) in self.actions.iter().zip(out) {
            let recall = action.recall(&self.config, self.sharpness, state);
            let background = self.config.background_mass * num::exp(-recall.reference) / recall.mass;
            let mut variance = background * (prior + recall.value * recall.value);
            action.ask(self.sharpness, state, |o| {
                let (v, gap) = (action.gaussians.last_width(o.component), o.expected - recall.value);
                let rho = action.responsibility(&self.config, &recall, &o);
                if rho > 0.0 {
                    variance += rho * (v * v + gap * gap);
                }
            });
            *out = variance.sqrt();
        }
        true
    }

    fn learn(&mut self, sample: Sample<'_>, rate: Rate) -> f64 {
        assert_eq!(sample.state.len(), self.dims.inputs, "length of the state");
        let action = &mut self.actions[sample.choice];
        let recall = action.recall(&self.config, self.sharpness, sample.state);
        let error = sample.target - recall.value;
        let Work { point, scratch, touched } = &mut self.work;
        point.clear();
        point.extend_from_slice(sample.state);
        point.push(sample.target);
        let distance = recall.nearest * self.sharpness;
        if distance > self.gate || distance.is_nan() {
            action.create(&self.config, point);
            return error;
        }
        scratch.resize(point.len(), 0.0);
        touched.clear();
        action.ask(self.sharpness, sample.state, |o| {
            touched.push((o.component, action.responsibility(&self.config, &recall, &o)));
        });
        for &who in touched.iter().filter(|&&(_, rho)| rho >= TOUCHED) {
            action.adapt(&self.config, who, (point, error, rate), scratch);
        }
        error
    }

    fn size(&self) -> (usize, &'static str) {
        (self.actions.iter().map(|a| a.gaussians.len()).sum(), "components")
    }

    fn freeze(&self) -> Vec<u8> {
        frozen::seal(NAME, self)
    }

    fn boxed_clone(&self) -> Box<dyn Learner> {
        Box::new(self.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Rng;

    #[test]
    fn few_components_follow_a_slope_that_constants_cannot() {
        let dims = Dims { inputs: 2, choices: 1 };
        let config = IgmnConfig { first_width: 0.4, smallest_value_width: 0.01, ..IgmnConfig::default() };
        let mut igmn = Igmn::new(&config, dims).unwrap();
        let mut rng = Rng::new(5);
        let plane = |s: &[f64]| 3.0 * s[0] - 2.0 * s[1] + 1.0;
        let mut worst: f64 = 0.0;
        for step in 0..4000 {
            let s = [rng.uniform(), rng.uniform()];
            let sample = Sample { state: &s, choice: 0, target: plane(&s), demonstrated: false };
            let error = igmn.learn(sample, Rate::Average(0.0));
            if step >= 3000 {
                worst = worst.max(error.abs());
            }
        }
        assert!(igmn.size().0 <= 6, "{} components", igmn.size().0);
        assert!(worst < 0.3, "worst error {worst} on a plane of range 5");
    }

    #[test]
    fn uncertainty_falls_where_data_are() {
        let dims = Dims { inputs: 1, choices: 1 };
        let mut igmn = Igmn::new(&IgmnConfig::default(), dims).unwrap();
        for _ in 0..50 {
            let sample = Sample { state: &[0.2], choice: 0, target: -4.0, demonstrated: false };
            igmn.learn(sample, Rate::Constant(0.2));
        }
        let (mut near, mut far) = ([0.0], [0.0]);
        igmn.uncertainty(&[0.2], &mut near);
        igmn.uncertainty(&[0.9], &mut far);
        assert!(near[0] < 0.5 && far[0] > 0.9, "{near:?} {far:?}");
    }
}
