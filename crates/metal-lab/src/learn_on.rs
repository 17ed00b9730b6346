//! Learning on: a trained mind goes on as its phase ended, in another world, on a body, or after something broke.

use crate::mind::Mind;
use crate::plan::Plan;
use crate::progress::Silent;
use crate::train::{RunError, Watch, learn_phase};
use metal_rl::environment::Environment;
use metal_rl::explore::Schedule;
use metal_rl::observe::Observer;
use metal_rl::phase::Budget;
use metal_rl::policy::Heard;
use metal_rl::random::Streams;

/// The plan in which `phase` goes on as it ended: the exploration of its end, prices in full, so many episodes.
///
/// # Errors
/// If that plan is impossible.
pub fn learning_on(plan: &Plan, phase: &str, episodes: usize) -> Result<Plan, RunError> {
    let mut file = plan.file.clone();
    if let Some(row) = file.phase.get_mut(phase) {
        row.budget = Budget::Episodes(episodes);
        row.exploration = match row.exploration {
            Schedule::Greedy => Schedule::Greedy,
            Schedule::SoftMax { to, .. } => Schedule::SoftMax { from: to, to, until: 1.0 },
            Schedule::Random { to, .. } => Schedule::Random { from: to, to, until: 1.0 },
        };
    }
    for row in file.attention.values_mut() {
        row.settings.price_ramp = 0.0;
    }
    Ok(Plan::check(file)?)
}

/// Lets `mind`, which `phase` of `plan` left behind, learn on for so many episodes in `environment`. The mind comes back
/// even if the world fails: what was learned until then stays.
///
/// # Errors
/// If the plan is impossible; beside the mind: if the world fails, or the phase cannot be learned in it.
pub fn learn_on(
    (plan, phase): (&Plan, &str),
    mind: &Mind,
    environment: &mut dyn Environment,
    (episodes, streams): (usize, &Streams),
    observer: &mut dyn Observer,
) -> Result<(Mind, Result<(), RunError>), RunError> {
    let on = learning_on(plan, phase, episodes)?;
    let mut mind = Mind::thaw(&on, &mind.freeze_for(plan))?;
    let watch = Watch { environment, observer, ear: &mut |_: &Heard<'_>| {}, progress: &Silent };
    let learned = learn_phase(&on, phase, &mut mind, streams, watch).map(|_| ());
    Ok((mind, learned))
}
