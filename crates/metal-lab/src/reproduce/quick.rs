//! `--quick`: the same experiment with budgets so small that its numbers only show that everything works.

use crate::plan::file::PlanFile;
use metal_rl::phase::Budget;

/// Divides every budget: phases to a fortieth, tests to a few runs, screening to singles' worth of steps.
#[must_use]
pub fn shrink(mut file: PlanFile) -> PlanFile {
    for phase in file.phase.values_mut() {
        phase.budget = match phase.budget {
            Budget::Episodes(n) => Budget::Episodes((n / 40).max(4)),
            Budget::Steps(n) => Budget::Steps(n.min(2000)),
        };
    }
    shorten_iterations(&mut file);
    file.evaluation.runs = file.evaluation.runs.min(20);
    if let Some(subsets) = &mut file.subsets {
        subsets.screening_seeds = 1;
        subsets.screening_runs = subsets.screening_runs.min(5);
        subsets.confirmed = subsets.confirmed.min(1);
    }
    file
}

/// Counterfactual policy iteration with a few short fits.
fn shorten_iterations(file: &mut PlanFile) {
    for config in file.attention.values_mut().filter_map(|row| row.counterfactual.as_mut()) {
        config.iterations = config.iterations.min(2);
        *config = config.clone().with_fits(1.0, 40);
        config.validation_runs = config.validation_runs.min(2);
    }
}

/// Cuts every phase to at most so many episodes (or motor steps, where its budget is in steps).
pub fn cut(file: &mut PlanFile, episodes: usize, steps: usize) {
    shorten_iterations(file);
    for phase in file.phase.values_mut() {
        phase.budget = match phase.budget {
            Budget::Episodes(n) => Budget::Episodes(n.min(episodes)),
            Budget::Steps(n) => Budget::Steps(n.min(steps)),
        };
    }
}
