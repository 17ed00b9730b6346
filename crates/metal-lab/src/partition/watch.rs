//! The demonstration: the world's expert drives, everything is read, as in Phase I. Sec. 3.2.1.

use super::PartitionOptions;
use crate::plan::{Plan, PlanError};
use crate::progress::Progress;
use crate::train::RunError;
use metal_rl::environment::{End, Environment};
use metal_rl::partition::Shown;
use metal_rl::random::Streams;

/// Watches the expert; `sensors` are read before every move.
pub(super) fn watch(
    plan: &Plan,
    sensors: &[usize],
    options: &PartitionOptions,
    (streams, progress): (&Streams, &dyn Progress),
) -> Result<Shown, RunError> {
    let mut world = plan.file.environment.build()?;
    let features = |s: &usize| plan.spec.sensors[*s].features.len();
    let mut shown = Shown::of(sensors.iter().map(features).collect());
    let (mut seeds, mut moves) = (streams.stream("episodes"), streams.stream("moves"));
    let mut episode = 0;
    while shown.len() < options.steps {
        if progress.interrupted() {
            return Err(RunError::Interrupted);
        }
        world.reset(seeds.bits())?;
        let before = shown.len();
        for _ in 0..plan.spec.horizon.min(options.steps - before) {
            let readings = read(plan, world.as_mut(), sensors)?;
            let advice = world.advise().ok_or_else(|| nobody(plan))?;
            shown.add(&readings, advice, episode);
            let left_to_chance = options.chance > 0.0 && moves.chance(options.chance);
            let action = if left_to_chance { moves.below(plan.spec.actions.len()) } else { advice };
            if world.step(action)?.end != End::Running {
                break;
            }
        }
        progress.steps(shown.len() - before);
        episode += 1;
    }
    Ok(shown)
}

fn nobody(plan: &Plan) -> PlanError {
    let message = format!("{} has no expert advisor, so nobody demonstrates", plan.spec.id);
    PlanError::at("environment", message)
}

/// Readings of `sensors`, scaled as for a member; those of a silent sensor are 0 (reading R109).
fn read(plan: &Plan, world: &mut dyn Environment, sensors: &[usize]) -> Result<Vec<f64>, RunError> {
    let mut readings = Vec::new();
    for &sensor in sensors {
        let features = &plan.spec.sensors[sensor].features;
        let mut raw = vec![0.0; features.len()];
        world.sense(sensor, &mut raw)?;
        let answered = raw.iter().all(|x| x.is_finite());
        let scaled = raw.iter().zip(features).map(|(&x, f)| plan.file.scaling.apply(x, f.low, f.high));
        readings.extend(scaled.map(|x| if answered { x } else { 0.0 }));
    }
    Ok(readings)
}
