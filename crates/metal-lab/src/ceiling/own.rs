//! Universal students: one network for every subset at every rhythm, taught where each of these ways of looking leads to.
//!
//! The plan's own recipe, counterfactual policy iteration, but every drive draws a fixed choice of looks of its own. Its
//! moves are judged by roll-outs that go on with the same looks, so that nothing is repaired by somebody who sees more. What
//! such a student costs at the wheel is no ceiling but a floor: the sensors allow at least that.

use super::driver::{Counting, in_school};
use super::lesson::SLOWEST;
use super::{CeilingOptions, subject::Subject};
use crate::progress::Progress;
use crate::train::RunError;
use metal_rl::counterfactual::fit::learn;
use metal_rl::counterfactual::judge::sight::gather;
use metal_rl::counterfactual::judge::{Drive, Judged, Pupil};
use metal_rl::counterfactual::student::rule::Rule;
use metal_rl::counterfactual::{Alone, CounterfactualError, RollOuts, Student};
use metal_rl::explore::Schedule;
use metal_rl::phase::{Budget, Phase};
use metal_rl::random::{Rng, Streams};
use metal_rl::set::IndexSet;
use rayon::prelude::*;
use std::collections::VecDeque;

/// Motor steps that are driven under one choice of looks before another one is drawn.
const STINT: usize = 100;
/// Share of moves left to chance at the beginning and at the end.
const CHANCE: [f64; 2] = [0.4, 0.1];
/// Probabilities of subsets of none, one, two, three members; the rest is any size. Small ones are those that pay.
const SIZES: [f64; 5] = [0.05, 0.4, 0.25, 0.15, 0.15];

/// A student for every fixed choice of looks.
pub(super) fn universal(
    subject: &Subject<'_>,
    remembers: bool,
    options: &CeilingOptions,
    streams: &Streams,
    progress: &dyn Progress,
) -> Result<Student, RunError> {
    let streams = streams.child("universal").nth(u64::from(remembers));
    let mut student = subject.watcher(remembers, options, &streams)?;
    let mut window: VecDeque<Vec<Judged>> = VecDeque::new();
    for iteration in 0..options.driver_iterations {
        if progress.interrupted() {
            return Err(RunError::Interrupted);
        }
        let streams = streams.nth(iteration as u64);
        let stage =
            Stage { subject, student: &student, share: (iteration, options.driver_iterations), progress };
        let stints = (options.driver_steps / options.driver_iterations).div_ceil(STINT).max(1);
        let labels = (0..stints).into_par_iter().map(|stint| stage.stint(&streams.nth(stint as u64)));
        window.push_back(labels.collect::<Result<Vec<_>, RunError>>()?.into_iter().flatten().collect());
        if window.len() > student.config().window {
            window.pop_front();
        }
        let data: Vec<&Judged> = window.iter().flatten().collect();
        if !data.is_empty() {
            learn(&mut student, &data, 1.0, &streams.child("fit"));
        }
    }
    Ok(student)
}

/// One iteration's drives.
struct Stage<'a> {
    subject: &'a Subject<'a>,
    student: &'a Student,
    share: (usize, usize),
    progress: &'a dyn Progress,
}

impl Stage<'_> {
    /// A drive under one choice of looks, judged under the same.
    fn stint(&self, streams: &Streams) -> Result<Vec<Judged>, RunError> {
        let student = self.student.under(any_rule(self.subject.slots.len(), &mut streams.stream("rule")));
        let (iteration, iterations) = self.share;
        let horizon = self.subject.plan.spec.horizon;
        // Short drives first: a bad student is soon where no move makes a difference.
        let first = student.config().first_drives.clamp(1, horizon);
        let limit = (first + (horizon - first) * 2 * iteration / iterations).min(horizon);
        let chance = CHANCE[0] + (CHANCE[1] - CHANCE[0]) * iteration as f64 / iterations as f64;
        let phase = Phase {
            exploration: Schedule::Random { from: chance, to: chance, until: 1.0 },
            budget: Budget::Steps(STINT),
            ..Phase::evaluation("stint", self.subject.roster(), 0)
        };
        let drive = Drive {
            student: &student,
            driver: &student,
            phase,
            limit,
            price_share: 0.0,
            streams: streams.child("drive"),
        };
        let mut counting = Counting { progress: self.progress, steps: 0 };
        in_school(self.subject, streams, self.progress, |school| {
            let Some((sights, _)) = gather(school, &drive, &mut counting)? else {
                let id = school.environment.spec().id.clone();
                return Err(RunError::Counterfactual(CounterfactualError::NoCopies(id)));
            };
            let (judged, steps) = RollOuts { workers: &Alone }.judge(sights, &Pupil::of(school, &drive))?;
            self.progress.steps(steps);
            Ok(judged.into_iter().map(|j| as_seen(&student, j)).collect())
        })
    }
}

/// The label as its student saw the moment, and nothing more.
fn as_seen(student: &Student, judged: Judged) -> Judged {
    let mut full = vec![0.0; judged.full.len()];
    student.layout().mask(&judged.full, judged.looks, &mut full);
    Judged { full, ..judged }
}

fn any_rule(slots: usize, rng: &mut Rng) -> Rule {
    let size = match rng.pick(&SIZES) {
        any if any + 1 == SIZES.len() => rng.below(slots + 1),
        size => size.min(slots),
    };
    let mut order: Vec<usize> = (0..slots).collect();
    rng.shuffle(&mut order);
    let slots: IndexSet = order.into_iter().take(size).collect();
    Rule::Scheduled { slots, every: 1 + rng.below(SLOWEST) }
}
