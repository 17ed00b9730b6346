//! A mind that was learned from a recipe: members, and whoever controls attention.

use super::method::{AttentionMethod, ValuesMethod};
use super::recipe::Recipe;
use crate::plan::PlanError;
use crate::train::RunError;
use metal_rl::counterfactual::iterate::student_shape;
use metal_rl::counterfactual::{CounterfactualConfig, Student};
use metal_rl::environment::EnvironmentSpec;
use metal_rl::learner::{Dims, LearnerError};
use metal_rl::learners::{GivenConfig, LearnerConfig};
use metal_rl::member::{Member, decision_dims};
use metal_rl::policies::attention::{Consultable, learner_dims};
use metal_rl::policies::{Attention, Counterfactual};
use metal_rl::policy::Policy;
use metal_rl::random::Streams;
use metal_rl::set::IndexSet;
use metal_rl::view::View;

/// Name of the full observer.
pub(super) const OBSERVER: &str = "FOA";

/// Who controls attention, after which method.
#[derive(Clone)]
pub enum Controller {
    /// Values of looks and moves.
    Values(Box<Attention>),
    /// A student of counterfactual policy iteration.
    Counterfactual(Box<Counterfactual>),
}

impl Controller {
    /// It at the wheel.
    #[must_use]
    pub fn policy(&self) -> Box<dyn Policy> {
        match self {
            Self::Values(attention) => attention.clone(),
            Self::Counterfactual(student) => student.clone(),
        }
    }

    /// Its learner as bytes.
    #[must_use]
    pub fn freeze(&self) -> Vec<u8> {
        match self {
            Self::Values(attention) => attention.learner().freeze(),
            Self::Counterfactual(driver) => driver.student().freeze(),
        }
    }
}

/// A mind, what it was learned for and how.
#[derive(Clone)]
pub struct Learned {
    /// The contract of the task's world.
    pub spec: EnvironmentSpec,
    /// Sensors that are experts' opinions.
    pub opinions: Vec<usize>,
    /// How it was learned.
    pub recipe: Recipe,
    /// A tiny agent per sensor, in the order of the sensors; the full observer last.
    pub members: Vec<Member>,
    /// Attention control; none before Phase III.
    pub controller: Option<Controller>,
}

impl Learned {
    /// The newborn mind for a world.
    ///
    /// # Errors
    /// If the world has too many sensors, or a learner refuses its shape.
    pub fn newborn(
        spec: &EnvironmentSpec,
        opinions: &[usize],
        recipe: &Recipe,
        streams: &Streams,
    ) -> Result<Self, RunError> {
        recipe.check()?;
        check_sensors(spec)?;
        let all: Vec<usize> = (0..spec.sensors.len()).collect();
        let mut members = Vec::new();
        for &s in &all {
            let given = LearnerConfig::Given(GivenConfig {});
            let config = if opinions.contains(&s) { &given } else { &recipe.tiny };
            members.push(born(spec, (&spec.sensors[s].name, &[s]), config, streams)?);
        }
        members.push(born(spec, (OBSERVER, &all), &recipe.observer, streams)?);
        let recipe = recipe.clone().for_horizon(spec.horizon);
        Ok(Self { spec: spec.clone(), opinions: opinions.to_vec(), recipe, members, controller: None })
    }

    /// The tiny agents.
    #[must_use]
    pub fn tiny_agents(&self) -> IndexSet {
        IndexSet::first(self.members.len() - 1)
    }

    /// Tiny agents and full observer.
    #[must_use]
    pub fn everybody(&self) -> IndexSet {
        IndexSet::first(self.members.len())
    }

    /// Index of the full observer.
    #[must_use]
    pub fn observer(&self) -> usize {
        self.members.len() - 1
    }

    /// A newborn attention controller of the paper's method.
    pub(super) fn newborn_attention(&self, streams: &Streams) -> Result<Attention, LearnerError> {
        let values = self.recipe.method.values();
        let seed = streams.child("attention").seed();
        let learner = values.learner.build(self.attention_dims(&values), seed)?;
        Ok(self.attention_with(&values, learner))
    }

    /// The attention controller frozen in `bytes`.
    ///
    /// # Errors
    /// If the bytes are damaged or belong to another task.
    pub(super) fn thaw_controller(&self, bytes: &[u8]) -> Result<Controller, LearnerError> {
        if let AttentionMethod::Counterfactual(config) = &self.recipe.method {
            return self.thaw_student(config, bytes);
        }
        let values = self.recipe.method.values();
        let learner = values.learner.thaw(bytes)?;
        if learner.dims() != self.attention_dims(&values) {
            let reason = "it has another shape than the task".to_owned();
            return Err(LearnerError::Frozen { learner: "attention", reason });
        }
        Ok(Controller::Values(Box::new(self.attention_with(&values, learner))))
    }

    fn thaw_student(&self, config: &CounterfactualConfig, bytes: &[u8]) -> Result<Controller, LearnerError> {
        let roster = self.roster();
        let shape = student_shape(config, &self.members, &roster, &self.spec)
            .map_err(|e| LearnerError::Frozen { learner: "counterfactual", reason: e.to_string() })?;
        let student = Student::thaw(config, &shape, bytes)?;
        Ok(Controller::Counterfactual(Box::new(Counterfactual::new(student, roster))))
    }

    /// Who may be consulted.
    pub(super) fn roster(&self) -> Vec<usize> {
        self.tiny_agents().iter().collect()
    }

    fn attention_dims(&self, values: &ValuesMethod) -> Dims {
        learner_dims(&values.settings, &decision_dims(&self.members, &self.spec), &self.roster())
    }

    fn attention_with(
        &self,
        values: &ValuesMethod,
        learner: Box<dyn metal_rl::learner::Learner>,
    ) -> Attention {
        let members = self.roster();
        let prices = members.iter().map(|&m| self.members[m].price(&self.spec)).collect();
        let dims = decision_dims(&self.members, &self.spec);
        let settings = values.credited(self.recipe.credit);
        Attention::new(settings, learner, &dims, Consultable { members, prices })
    }
}

/// A newborn member of this name that sees these sensors.
pub(crate) fn born(
    spec: &EnvironmentSpec,
    (name, sensors): (&str, &[usize]),
    config: &LearnerConfig,
    streams: &Streams,
) -> Result<Member, LearnerError> {
    let view = View::new(spec, sensors);
    let dims = Dims { inputs: view.dims(), choices: spec.actions.len() };
    let learner = config.build(dims, streams.child("member").child(name).seed())?;
    Ok(Member { name: name.to_owned(), view, learner })
}

fn check_sensors(spec: &EnvironmentSpec) -> Result<(), PlanError> {
    let most = IndexSet::CAPACITY - 1;
    let n = spec.sensors.len();
    if n == 0 || n > most {
        return Err(PlanError::at("sensors", format!("{n}: between 1 and {most}")));
    }
    if spec.actions.is_empty() || spec.actions.len() > IndexSet::CAPACITY - n {
        let most = IndexSet::CAPACITY - n;
        let message = format!("{}: between 1 and {most} beside {n} sensors", spec.actions.len());
        return Err(PlanError::at("actions", message));
    }
    for (i, sensor) in spec.sensors.iter().enumerate() {
        check_sensor(spec, i, sensor)?;
    }
    Ok(())
}

fn check_sensor(
    spec: &EnvironmentSpec,
    index: usize,
    sensor: &metal_rl::environment::SensorSpec,
) -> Result<(), PlanError> {
    let field = |what: &str| format!("sensors.{}.{what}", sensor.name);
    if sensor.name == OBSERVER || spec.sensors[..index].iter().any(|s| s.name == sensor.name) {
        return Err(PlanError::at(field("name"), format!("taken; `{OBSERVER}` is the full observer")));
    }
    if !(sensor.price.is_finite() && sensor.price >= 0.0) {
        return Err(PlanError::at(field("cost"), format!("{}: finite and at least 0", sensor.price)));
    }
    if sensor.features.is_empty() {
        return Err(PlanError::at(field("features"), "none: a sensor delivers at least one number"));
    }
    match sensor.features.iter().find(|f| !(f.low < f.high && f.low.is_finite() && f.high.is_finite())) {
        Some(f) => {
            let message = format!("{} … {}: low < high, both finite", f.low, f.high);
            Err(PlanError::at(field(&f.name), message))
        }
        None => Ok(()),
    }
}
