//! One training, and what it came to.

use super::PricesOptions;
use crate::evaluate::{Candidate, Course, test};
use crate::plan::Plan;
use crate::plan::file::SubsetsFile;
use crate::plan::rival::Rival;
use crate::progress::Progress;
use crate::registry::Roads;
use crate::reproduce::seed_streams;
use crate::reproduce::subsets::train_subset;
use crate::trace::EpisodeRecord;
use crate::train::{RunError, train_up_to};
use metal_rl::random::Streams;

/// What is measured.
pub(super) struct Subject<'a> {
    pub plan: &'a Plan,
    pub rows: &'a SubsetsFile,
    pub options: &'a PricesOptions,
}

/// Who is trained.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Who {
    /// Attention where prices are multiplied by `factor`.
    Attention { factor: f64 },
    /// A fixed choice of sensors, at the plan's own prices.
    Fixed(Rival),
}

/// Means per motor step over the test episodes of one training.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Tested {
    /// Motor reward.
    pub motor: f64,
    /// What its looks cost at the prices it was trained with, ≥ 0.
    pub price: f64,
    /// Looks.
    pub looks: f64,
}

impl Tested {
    fn of(runs: &[EpisodeRecord]) -> Self {
        let mean = |f: &dyn Fn(&EpisodeRecord) -> f64| {
            runs.iter().map(|r| r.per_step(f(r))).sum::<f64>() / runs.len().max(1) as f64
        };
        Self {
            motor: mean(&|r| r.motor),
            price: -mean(&|r| r.perceptual),
            looks: mean(&|r| r.look_count() as f64),
        }
    }
}

/// Training `training` of `who`: the same as training `training` of `metal run` with the same seed, where prices are the
/// plan's own.
pub(super) fn run(
    subject: &Subject<'_>,
    who: Who,
    training: usize,
    progress: &dyn Progress,
) -> Result<Tested, RunError> {
    let streams = seed_streams(subject.options.seed, training);
    match who {
        Who::Attention { factor } => attention(subject, factor, &streams, progress),
        Who::Fixed(rival) => {
            let subset = train_subset(subject.plan, subject.rows, (rival, 1.0), &streams, progress)?;
            tested(subject, &subset.candidate(), &streams, progress)
        }
    }
}

fn attention(
    subject: &Subject<'_>,
    factor: f64,
    streams: &Streams,
    progress: &dyn Progress,
) -> Result<Tested, RunError> {
    let mut file = subject.plan.file.clone();
    file.environment = file.environment.at_prices(factor);
    let plan = Plan::check(file)?;
    let trained = train_up_to(&plan, &subject.rows.like, streams, progress)?;
    let phase = &plan.file.phase[&subject.rows.like];
    let roster = plan.roster(&phase.roster);
    let candidate = Candidate { plan: &plan, mind: &trained.mind, acting: &phase.acting, roster, blind: 0 };
    tested(subject, &candidate, streams, progress)
}

fn tested(
    subject: &Subject<'_>,
    candidate: &Candidate<'_>,
    streams: &Streams,
    progress: &dyn Progress,
) -> Result<Tested, RunError> {
    let scenario = subject.plan.file.environment.training_scenario();
    let course = Course { scenario, roads: Roads::Validation, runs: subject.options.runs };
    Ok(Tested::of(&test(candidate, &course, &streams.child("prices"), progress)?))
}
