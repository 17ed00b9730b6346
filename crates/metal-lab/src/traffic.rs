//! The red cars of `Highway-v0`: full observers that learned to drive in phases I and II (Sec. 4.1), frozen with the
//! world they belong to.

use crate::experiments;
use crate::mind::Mind;
use crate::plan::{self, Plan};
use crate::progress::Progress;
use crate::train::{RunError, train_phase};
use metal_rl::learner::Learner;
use metal_rl::num;
use metal_rl::random::Streams;
use metal_rl::view::Scaling;
use metal_worlds::highway::{Driver, Steering, VISION};
use std::sync::{Arc, OnceLock};

/// The frozen mind that ships with `Highway-v0`: these bytes are part of that world. They were trained when the Gaussians' sums
/// were added one after the other; `metal train-traffic` makes the same mind again but for its last digits (reading R138).
const FROZEN: &[u8] = include_bytes!("../assets/highway-v0-traffic.mind");

/// The one seed of the traffic's training, chosen with the budget by the criteria of the world (docs/paper/fidelity.md).
const SEED: u64 = 3;

/// A full observer at the wheel of a red car: greedy, learning nothing.
struct Observer {
    learner: Box<dyn Learner>,
    scaling: Scaling,
}

impl Driver for Observer {
    fn drive(&self, vision: &[f64; VISION]) -> usize {
        let state = vision.map(|share| self.scaling.apply(share, 0.0, 1.0));
        let mut values = [0.0; 5];
        self.learner.values(&state, &mut values);
        num::argmax(&values)
    }
}

/// Who drives the red cars of `Highway-v0`.
///
/// # Panics
/// If the shipped mind does not fit its plan: the program was built from a damaged tree.
#[must_use]
pub fn steering() -> Steering {
    static DRIVER: OnceLock<Steering> = OnceLock::new();
    DRIVER.get_or_init(|| steering_by(FROZEN).expect("the traffic's mind is part of the program")).clone()
}

/// Red cars that drive by another mind, as [`train`] returns it.
///
/// # Errors
/// If the bytes are damaged or no mind of the traffic's plan.
pub fn steering_by(frozen: &[u8]) -> Result<Steering, RunError> {
    let plan = plan()?;
    let learner = plan.members[0].learner.thaw(frozen)?;
    Ok(Steering::Mind(Arc::new(Observer { learner, scaling: plan.file.scaling })))
}

fn plan() -> Result<Plan, plan::PlanError> {
    plan::parse(experiments::TRAFFIC, &[])
}

/// Motor steps of the traffic's training.
///
/// # Errors
/// If the traffic's plan is refused.
pub fn planned_steps() -> Result<usize, RunError> {
    let plan = plan()?;
    Ok(plan.order.iter().map(|name| plan.budget_steps(name)).sum())
}

/// Trains the traffic's mind, among scripted cars, and returns it frozen.
///
/// # Errors
/// If the user interrupts.
pub fn train(progress: &dyn Progress) -> Result<Vec<u8>, RunError> {
    let plan = plan()?;
    let streams = Streams::new(SEED);
    let mut mind = Mind::newborn(&plan, &streams)?;
    for phase in &plan.order {
        mind = train_phase(&plan, phase, mind, &streams, progress)?.mind;
    }
    Ok(mind.members[0].learner.freeze())
}
