//! `metal prices`: attention at other prices of looking, against every fixed choice of sensors by the same recipe.
//!
//! What looks are worth shows only where their price changes: attention is learned anew at each, and should look less and
//! drive worse the more they cost, from all sensors where they are free to nobody where they cost more than they bring. A
//! fixed choice pays the same whatever it does, so it drives alike at all prices and is trained once. Not in the paper, whose
//! prices are those of Fig. 7b alone.
//!
//! In the order of the data: `options` → `trial` (one training, tested) → `report` → `print`, `draw`.

mod draw;
mod options;
mod print;
mod report;
mod trial;

pub use draw::draw;
pub use options::PricesOptions;
pub use print::text;
pub use report::{At, PricesReport, Row};

use crate::plan::rival::Rival;
use crate::plan::{Acting, Plan, PlanError};
use crate::progress::Progress;
use crate::train::RunError;
use metal_rl::set::IndexSet;
use rayon::prelude::*;
use trial::{Subject, Who};

/// Trains and tests everybody. The same plan and options give the same report, whatever the number of threads.
///
/// # Errors
/// If options do not fit the plan, its world fails, or the user interrupts.
pub fn run(plan: &Plan, options: &PricesOptions, progress: &dyn Progress) -> Result<PricesReport, RunError> {
    let (subject, everybody) = cast(plan, options)?;
    let jobs: Vec<(Who, usize)> =
        everybody.iter().flat_map(|&who| (0..options.seeds).map(move |training| (who, training))).collect();
    let tested: Vec<trial::Tested> = jobs
        .par_iter()
        .map(|&(who, training)| trial::run(&subject, who, training, progress))
        .collect::<Result<_, RunError>>()?;
    let by_training: Vec<&[trial::Tested]> = tested.chunks(options.seeds).collect();
    Ok(report::write(&subject, &everybody, &by_training))
}

/// About how many motor steps [`run`] will simulate, for a progress bar; copies of worlds are not counted.
///
/// # Errors
/// If options do not fit the plan.
pub fn planned_steps(plan: &Plan, options: &PricesOptions) -> Result<usize, RunError> {
    let (subject, everybody) = cast(plan, options)?;
    let budget: usize = subject.rows.budget_of.iter().map(|name| plan.budget_steps(name)).sum();
    Ok(everybody.len() * options.seeds * (budget + options.runs * plan.spec.horizon))
}

/// What is measured, and who takes part: attention at each factor, then the fixed choices, all sensors last.
fn cast<'a>(plan: &'a Plan, options: &'a PricesOptions) -> Result<(Subject<'a>, Vec<Who>), PlanError> {
    options.check()?;
    let rows = plan.file.subsets.as_ref().ok_or_else(|| {
        PlanError::at("subsets", "the file has none: it says by which phase's recipe fixed choices learn")
    })?;
    if !matches!(plan.file.phase[&rows.like].acting, Acting::Attention(_)) {
        let message = format!("phase `{}` learns no attention, so there is nothing to compare", rows.like);
        return Err(PlanError::at("subsets.like", message));
    }
    let mut everybody: Vec<Who> = options.factors.iter().map(|&factor| Who::Attention { factor }).collect();
    let all = Rival::always(IndexSet::first(plan.spec.sensors.len()));
    let mut rivals = rivals(plan, &options.rivals, &rows.among)?;
    rivals.retain(|rival| *rival != all);
    everybody.extend(rivals.into_iter().chain([all]).map(Who::Fixed));
    Ok((Subject { plan, rows, options }, everybody))
}

/// Those that were named on the command line, or in the file, or else all single sensors.
fn rivals(plan: &Plan, named: &[String], among: &[String]) -> Result<Vec<Rival>, PlanError> {
    let parse = |field| move |words: &String| Rival::parse(plan, field, words);
    let mut rivals: Vec<Rival> = match (named, among) {
        ([], []) => (0..plan.spec.sensors.len()).map(|s| Rival::always(IndexSet::EMPTY.with(s))).collect(),
        ([], among) => among.iter().map(parse("subsets.among")).collect::<Result<_, _>>()?,
        (named, _) => named.iter().map(parse("rivals")).collect::<Result<_, _>>()?,
    };
    rivals.sort_unstable();
    rivals.dedup();
    Ok(rivals)
}
