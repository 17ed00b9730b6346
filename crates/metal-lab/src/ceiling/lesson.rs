//! Lessons: what to do, and where to look, for any set of readings; without memory, and with it.
//!
//! Without memory a look concerns one moment only, and the recipe's own fit finds the best order of looks by replay.
//! With memory a look is remembered, so its worth is followed over some steps of the log, along the looks that the student
//! itself would take there. The log does not change by that, and no roll-out is needed.

use super::log::Episode;
use super::{CeilingOptions, subject::Subject};
use crate::train::RunError;
use metal_rl::counterfactual::Student;
use metal_rl::counterfactual::fit::learn;
use metal_rl::counterfactual::judge::{Judged, Stop};
use metal_rl::counterfactual::student::gaze::Gaze;
use metal_rl::counterfactual::student::{Next, Scratch};
use metal_rl::random::{Rng, Streams};
use metal_rl::set::IndexSet;
use rayon::prelude::*;

/// Longest rhythm that is learned and judged: looks at every so many motor steps.
pub(super) const SLOWEST: usize = 4;
/// Probability that chance takes the looks of a motor step, and most steps of it in a row without any.
const WANDER: f64 = 0.2;
const LONGEST_ERRAND: usize = 6;

/// The student without a memory.
pub(super) fn forgetful(
    subject: &Subject<'_>,
    episodes: &[&Episode],
    options: &CeilingOptions,
    streams: &Streams,
) -> Result<Student, RunError> {
    let mut student = subject.looker(false, options, &streams.child("forgetful"))?;
    let mut gaze = Gaze::new(student.layout());
    let mut judged = Vec::new();
    for moment in episodes.iter().flat_map(|e| e.iter()) {
        gaze.reset();
        subject.everybody().iter().for_each(|slot| gaze.look_again(student.layout(), slot, &moment.readings));
        judged.push(label(&gaze, IndexSet::EMPTY, &moment.advantages, Vec::new()));
    }
    let data: Vec<&Judged> = judged.iter().collect();
    learn(&mut student, &data, 1.0, &streams.child("forgetful"));
    Ok(student)
}

/// The students with a memory, round by round. The first has learned from looks at random, each other one from those of
/// the round before, too.
pub(super) fn mindful(
    subject: &Subject<'_>,
    episodes: &[&Episode],
    options: &CeilingOptions,
    streams: &Streams,
) -> Result<Vec<Student>, RunError> {
    let streams = streams.child("mindful");
    let mut student = subject.looker(true, options, &streams)?;
    let mut rounds = Vec::new();
    for round in 0..=options.rounds {
        let streams = streams.nth(round as u64);
        let views: Vec<(usize, usize)> =
            (0..options.copies).flat_map(|copy| (0..episodes.len()).map(move |e| (copy, e))).collect();
        let seen = views.into_par_iter().map(|(copy, e)| {
            let habit = if round > 0 && copy % 2 == 0 { Habit::Own } else { Habit::Random };
            let rng = streams.nth(copy as u64).nth(e as u64).stream("looks");
            Viewer::new(&student, habit, rng).view(episodes[e], (round > 0).then_some(options.lookahead))
        });
        let judged: Vec<Vec<Judged>> = seen.collect();
        let data: Vec<&Judged> = judged.iter().flatten().collect();
        learn(&mut student, &data, 1.0, &streams.child("fit"));
        rounds.push(student.clone());
    }
    Ok(rounds)
}

fn label(gaze: &Gaze, looks: IndexSet, advantages: &[f64], stops: Vec<Stop>) -> Judged {
    let full = gaze.input().to_vec();
    Judged {
        full,
        clock: gaze.clock(),
        looks,
        advantages: advantages.to_vec(),
        value: 0.0,
        stops,
        appointments: None,
    }
}

/// How an episode is looked at.
#[derive(Clone, Copy, PartialEq)]
enum Habit {
    /// As the student would, but for some errands.
    Own,
    /// Some subset at some rhythm.
    Random,
}

/// Looks through an episode.
struct Viewer<'a> {
    student: &'a Student,
    habit: Habit,
    rng: Rng,
    scratch: Scratch,
    slots: IndexSet,
    every: usize,
    errand: usize,
}

impl<'a> Viewer<'a> {
    fn new(student: &'a Student, habit: Habit, mut rng: Rng) -> Self {
        let slots = any_looks(student.layout().slots(), &mut rng);
        let every = 1 + rng.below(SLOWEST);
        Self { student, habit, rng, scratch: student.scratch(), slots, every, errand: 0 }
    }

    /// Labels for all moments, with the worth of stopping after some looks if it is followed.
    fn view(mut self, episode: &Episode, followed: Option<usize>) -> Vec<Judged> {
        let layout = self.student.layout();
        let mut gaze = Gaze::new(layout);
        let mut judged = Vec::with_capacity(episode.len());
        // A rhythm may begin anywhere, so that memories are of every age everywhere.
        let shift = self.rng.below(self.every);
        for (t, moment) in episode.iter().enumerate() {
            let before = gaze.clone();
            let mut full = gaze.clone();
            (0..layout.slots()).for_each(|slot| full.look_again(layout, slot, &moment.readings));
            self.look(&mut gaze, (t + shift).is_multiple_of(self.every), &moment.readings);
            let looks = gaze.attended();
            let stops = followed.map_or_else(Vec::new, |steps| {
                self.stops(&before, full.input(), looks, &Future { episode, t, steps })
            });
            judged.push(label(&full, looks, &moment.advantages, stops));
            gaze.advance(layout, moment.action);
        }
        judged
    }

    fn look(&mut self, gaze: &mut Gaze, due: bool, readings: &[f32]) {
        let layout = self.student.layout();
        if self.habit == Habit::Random {
            let slots = if due { self.slots } else { IndexSet::EMPTY };
            return slots.iter().for_each(|slot| gaze.look_again(layout, slot, readings));
        }
        if self.errand > 0 {
            self.errand -= 1;
        } else if !self.rng.chance(WANDER) {
            decide(self.student, gaze, readings, &mut self.scratch);
        } else if self.rng.chance(0.5) {
            self.errand = self.rng.below(LONGEST_ERRAND);
        } else {
            gaze.look_again(layout, self.rng.below(layout.slots()), readings);
        }
    }

    /// What stopping after the looks of this moment is worth, and after some others, compared with the former.
    fn stops(&mut self, before: &Gaze, full: &[f32], own: IndexSet, future: &Future<'_>) -> Vec<Stop> {
        let all = IndexSet::first(self.student.layout().slots());
        let rng = &mut self.rng;
        let mut any = |from: IndexSet| from.iter().nth(rng.below(from.len().max(1)));
        let others = [
            Some(IndexSet::EMPTY),
            any(own).map(|slot| own.without(slot)),
            any(all.minus(own)).map(|slot| own.with(slot)),
            any(all).map(|slot| IndexSet::EMPTY.with(slot)),
        ];
        let mut stops: Vec<Stop> = Vec::with_capacity(1 + others.len());
        let mut rest = 0.0;
        for looks in std::iter::once(own).chain(others.into_iter().flatten()) {
            if stops.iter().any(|s| s.looks == looks) {
                continue;
            }
            let mut gaze = before.clone();
            gaze.see_through(self.student.layout(), full, looks);
            let (now, later) = future.worth(self.student, gaze, &mut self.scratch);
            if stops.is_empty() {
                // What is only true of the moment cancels.
                rest = later;
            }
            stops.push(Stop { looks, worth: now + later - rest });
        }
        stops
    }
}

/// A subset of any size, every size with the same probability.
fn any_looks(slots: usize, rng: &mut Rng) -> IndexSet {
    let mut order: Vec<usize> = (0..slots).collect();
    rng.shuffle(&mut order);
    order.into_iter().take(rng.below(slots + 1)).collect()
}

/// The student's own looks, then its move; and the price of these looks.
pub(super) fn decide(
    student: &Student,
    gaze: &mut Gaze,
    readings: &[f32],
    scratch: &mut Scratch,
) -> (usize, f64) {
    let mut price = 0.0;
    loop {
        match student.next(gaze, scratch) {
            Next::Move(action) => return (action, price),
            Next::Look(slot) => {
                gaze.look_again(student.layout(), slot, readings);
                price += student.prices()[slot];
            }
        }
    }
}

/// The rest of an episode from its moment `t` on.
struct Future<'a> {
    episode: &'a Episode,
    t: usize,
    steps: usize,
}

impl Future<'_> {
    /// What the student's move is worth where `gaze` stands, and what its looks and moves of the next steps are.
    fn worth(&self, student: &Student, mut gaze: Gaze, scratch: &mut Scratch) -> (f64, f64) {
        student.evaluate(gaze.input(), scratch);
        let now = self.episode[self.t].advantages[student.best_move(scratch)];
        let mut later = 0.0;
        for pair in self.episode[self.t..].windows(2).take(self.steps) {
            gaze.advance(student.layout(), pair[0].action);
            let (action, price) = decide(student, &mut gaze, &pair[1].readings, scratch);
            later += pair[1].advantages[action] - price;
        }
        (now, later)
    }
}
