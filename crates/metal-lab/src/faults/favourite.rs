//! Which sensor a trained policy looks at most.

use super::desk::Desk;
use crate::evaluate::{Candidate, drive};
use crate::train::RunError;
use metal_rl::observe::{Observer, Step};

/// The sensor that `candidate`, of this training, looks at most in the world it learned in.
pub(super) fn favourite(desk: &Desk<'_>, candidate: &Candidate<'_>, seed: usize) -> Result<usize, RunError> {
    let mut environment = desk.plan.file.environment.build()?;
    let mut tally = Tally(vec![0.0; desk.plan.spec.sensors.len()]);
    let streams = desk.seed(seed).child("favourite");
    drive(candidate, environment.as_mut(), (desk.options.runs, &streams), &mut tally)?;
    Ok(metal_rl::num::argmax(&tally.0))
}

/// Counts looks by sensor.
struct Tally(Vec<f64>);

impl Observer for Tally {
    fn on_step(&mut self, step: &Step<'_>) {
        for sensor in step.percept.read().iter() {
            self.0[sensor] += 1.0;
        }
    }
}
