//! A member of the mind: a tiny agent, or the full observer, which is a tiny agent that sees a lot.

use crate::decision::{DecisionDims, DecisionState};
use crate::environment::{Environment, EnvironmentError, EnvironmentSpec};
use crate::learner::Learner;
use crate::view::{Percept, View};

/// An expert with a name, a partial view and a learner.
#[derive(Clone)]
pub struct Member {
    /// Name, unique in the mind (`MN`, `FOA`, …).
    pub name: String,
    /// What it sees: s_TA of Eq. (1) or s_FOA of Eq. (2).
    pub view: View,
    /// What it knows.
    pub learner: Box<dyn Learner>,
}

impl Member {
    /// Price of consulting this member when none of its sensors was read yet. Fig. 7b.
    #[must_use]
    pub fn price(&self, spec: &EnvironmentSpec) -> f64 {
        self.view.sensors().iter().map(|&s| spec.sensors[s].price).sum()
    }

    /// Reads what the member sees, lets it speak into `state`, and returns the price of the sensors read just now. If
    /// none of its sensors answered, it has nothing to say: null (reading R130).
    ///
    /// # Errors
    /// If a sensor does not answer.
    pub fn consult(
        &self,
        index: usize,
        environment: &mut dyn Environment,
        percept: &mut Percept,
        state: &mut DecisionState,
    ) -> Result<f64, EnvironmentError> {
        let (reading, values, support) = state.attend(index);
        let price = self.read(environment, percept, reading)?;
        if self.view.set().minus(percept.silent()).is_empty() {
            state.silence(index);
        } else {
            self.learner.values_and_support(reading, values, support);
        }
        Ok(price)
    }

    /// Reads what the member sees into `out` without asking what it makes of it; returns the price of the sensors read
    /// just now.
    ///
    /// # Errors
    /// If a sensor does not answer.
    pub fn read(
        &self,
        environment: &mut dyn Environment,
        percept: &mut Percept,
        out: &mut [f64],
    ) -> Result<f64, EnvironmentError> {
        let mut price = 0.0;
        for &sensor in self.view.sensors() {
            if percept.look(environment, sensor)? {
                price += environment.spec().sensors[sensor].price;
            }
        }
        self.view.state(percept, out);
        Ok(price)
    }
}

/// Sizes of the decision state of `members`.
#[must_use]
pub fn decision_dims(members: &[Member], spec: &EnvironmentSpec) -> DecisionDims {
    DecisionDims {
        member_inputs: members.iter().map(|m| m.view.dims()).collect(),
        actions: spec.actions.len(),
    }
}
