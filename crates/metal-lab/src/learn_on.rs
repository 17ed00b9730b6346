//! Learning on: a trained mind goes on as its phase ended, in another world, on a body, or after something broke.

use crate::mind::Mind;
use crate::plan::{Plan, PlanError};
use crate::progress::Silent;
use crate::train::{RunError, Watch, learn_phase};
use metal_rl::environment::Environment;
use metal_rl::explore::Schedule;
use metal_rl::observe::Observer;
use metal_rl::phase::Budget;
use metal_rl::policy::Heard;
use metal_rl::random::Streams;

/// Whether a mind that `phase` left behind can learn on, step by step and wherever it is: counterfactual policy iteration begins
/// anew, in a world that can be copied.
#[must_use]
pub fn can_learn_on(plan: &Plan, phase: &str) -> bool {
    plan.counterfactual(phase).is_none()
}

/// The plan in which `phase` goes on as it ended: the exploration of its end, prices in full, so many episodes.
///
/// # Errors
/// If that plan is impossible, or the phase cannot go on (see [`can_learn_on`]).
pub fn learning_on(plan: &Plan, phase: &str, episodes: usize) -> Result<Plan, RunError> {
    if !can_learn_on(plan, phase) {
        let message = "counterfactual policy iteration begins anew, in a world that can be copied: nobody learns on from it";
        return Err(PlanError::at(format!("phase.{phase}.acting"), message).into());
    }
    let mut file = plan.file.clone();
    if let Some(row) = file.phase.get_mut(phase) {
        row.budget = Budget::Episodes(episodes);
        row.exploration = match row.exploration {
            Schedule::Greedy => Schedule::Greedy,
            Schedule::SoftMax { to, .. } => Schedule::SoftMax { from: to, to, until: 1.0 },
            Schedule::Random { to, .. } => Schedule::Random { from: to, to, until: 1.0 },
        };
    }
    for row in file.attention.values_mut().filter(|row| row.counterfactual.is_none()) {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{experiments, plan};

    #[test]
    fn only_what_is_learned_step_by_step_goes_on() {
        let plan = plan::parse(experiments::PAPER, &[]).unwrap();
        let refused = learning_on(&plan, "attention", 3).unwrap_err().to_string();
        assert!(refused.contains("phase.attention.acting") && refused.contains("copied"), "{refused}");
        let on = learning_on(&plan, "attention_phase3", 3).unwrap();
        assert_eq!(on.file.phase["attention_phase3"].budget, Budget::Episodes(3));
    }
}
