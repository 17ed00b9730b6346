//! One driver, its log, and every way of looking along it; the shares of the log take turns.

use super::log::{Episode, kept};
use super::replay::{Fixed, Score, adaptive, choices, fixed, sum};
use super::rows::{Looking, Row};
use super::wheel::{Drive, Wheel};
use super::{CeilingOptions, driver, lesson, own, subject::Subject};
use crate::plan::PlanError;
use crate::progress::Progress;
use crate::train::RunError;
use metal_rl::counterfactual::Student;
use metal_rl::random::Streams;
use rayon::prelude::*;

/// What came out of one driver.
pub(super) struct Trial {
    /// The driver at the wheel.
    pub driver: Drive,
    /// Moments of the log, and episodes.
    pub size: (usize, usize),
    /// Every turn.
    pub turns: Vec<Turn>,
    /// Every fixed choice at the wheel, in the episodes that choose.
    pub wheel: Vec<Chosen>,
    /// Every row at the wheel, in episodes of its own, with what was chosen.
    pub driven: Vec<Driven>,
}

/// A turn: somebody learned from one share of the log, another share chose, a third one judges.
pub(super) struct Turn {
    choices: Vec<Fixed>,
    /// Cost per motor step of every choice where it is chosen.
    chosen: Vec<f64>,
    /// Every choice where it is judged, episode by episode.
    judged: Vec<Vec<Score>>,
    adaptive: [Vec<Score>; 2],
    /// Who looks by need, without memory and with it.
    lookers: [Student; 2],
}

impl Turn {
    /// The cheapest fixed choice among those of `row` where it is chosen; none if looks are not fixed.
    pub fn choice(&self, row: Row) -> Option<Fixed> {
        let candidates = self.choices.iter().zip(&self.chosen).filter(|(choice, _)| row.allows(choice));
        candidates.min_by(|a, b| a.1.total_cmp(b.1)).map(|(choice, _)| *choice)
    }

    /// `row` where it is judged, episode by episode.
    pub fn scores(&self, row: Row) -> &[Score] {
        match row.looking {
            Looking::Adaptive => &self.adaptive[usize::from(row.remembers)],
            _ => self.choice(row).map_or(&[], |choice| self.fixed(choice)),
        }
    }

    /// A fixed choice where it is judged, episode by episode.
    pub fn fixed(&self, choice: Fixed) -> &[Score] {
        self.choices.iter().position(|c| *c == choice).map_or(&[], |i| &self.judged[i])
    }
}

/// Drives, judges, learns and replays.
pub(super) fn run(
    subject: &Subject<'_>,
    options: &CeilingOptions,
    streams: &Streams,
    progress: &dyn Progress,
) -> Result<Trial, RunError> {
    progress.stage("a driver that sees everything learns");
    let driver = driver::taught(subject, options, streams, progress)?;
    progress.stage("it drives, and all its moves are judged");
    let log = kept(subject, &driver, options, streams, progress)?;
    if log.len() < options.folds {
        let message = format!("{} episodes: at least one for each of {} shares", log.len(), options.folds);
        return Err(PlanError::at("log_steps", message).into());
    }
    progress.stage("students learn from the log, and every way of looking is replayed");
    let turns = turns(subject, &log, options, streams, progress)?;
    progress.stage("universal students learn");
    let universal =
        [false, true].map(|remembers| own::universal(subject, remembers, options, streams, progress));
    let [plain, mindful] = universal;
    let students = [plain?, mindful?];
    progress.stage("students at the wheel");
    let wheel = Wheel { subject, runs: options.runs, streams: streams.child("wheel"), progress };
    let (choosing, driven) = at_the_wheel(&wheel, &students, &turns[0])?;
    Ok(Trial {
        driver: wheel.drive(&driver, None)?,
        size: (log.iter().map(Vec::len).sum(), log.len()),
        wheel: choosing,
        driven,
        turns,
    })
}

/// A fixed choice at the wheel.
type Chosen = (Fixed, Drive);
/// A row at the wheel, with the choice it made.
type Driven = (Row, Option<Fixed>, Drive);

/// Every fixed choice by the universal students, in some episodes; then the best of every row in others. Looks by need are
/// those of the first turn's students.
fn at_the_wheel(
    wheel: &Wheel<'_>,
    universal: &[Student; 2],
    turn: &Turn,
) -> Result<(Vec<Chosen>, Vec<Driven>), RunError> {
    let student = |choice: &Fixed| &universal[usize::from(choice.remembers)];
    let choosing = Wheel { runs: wheel.runs.div_ceil(4), streams: wheel.streams.child("choosing"), ..*wheel };
    let choices = turn.choices.par_iter().map(|c| Ok((*c, choosing.drive(student(c), Some(*c))?)));
    let choices: Vec<Chosen> = choices.collect::<Result<_, RunError>>()?;
    let drive = |row: &Row| {
        let own = choices.iter().filter(|(choice, _)| row.allows(choice));
        let best = own.max_by(|a, b| a.1.total().total_cmp(&b.1.total())).map(|(choice, _)| *choice);
        let by_need = &turn.lookers[usize::from(row.remembers)];
        let drive = wheel.drive(best.as_ref().map_or(by_need, student), best)?;
        Ok((*row, best, drive))
    };
    let rows = Row::all(wheel.subject.slots.len());
    let driven = rows.par_iter().map(drive).collect::<Result<_, RunError>>()?;
    Ok((choices, driven))
}

fn turns(
    subject: &Subject<'_>,
    log: &[Episode],
    options: &CeilingOptions,
    streams: &Streams,
    progress: &dyn Progress,
) -> Result<Vec<Turn>, RunError> {
    let turn = |n: usize| {
        if progress.interrupted() {
            return Err(RunError::Interrupted);
        }
        turn(subject, &Shares::new(log, n, options.folds), options, &streams.child("turn").nth(n as u64))
    };
    (0..options.folds).into_par_iter().map(turn).collect()
}

/// The log, shared out for one turn. Episodes stay whole.
pub(super) struct Shares<'a> {
    pub teach: Vec<&'a Episode>,
    pub choose: Vec<&'a Episode>,
    pub judge: Vec<&'a Episode>,
}

impl<'a> Shares<'a> {
    pub fn new(log: &'a [Episode], turn: usize, folds: usize) -> Self {
        let mut shares = Self { teach: Vec::new(), choose: Vec::new(), judge: Vec::new() };
        for (i, episode) in log.iter().enumerate() {
            match (i + turn) % folds {
                0 => shares.judge.push(episode),
                1 => shares.choose.push(episode),
                _ => shares.teach.push(episode),
            }
        }
        shares
    }
}

/// Learns from one share, replays in the two others.
pub(super) fn turn(
    subject: &Subject<'_>,
    shares: &Shares<'_>,
    options: &CeilingOptions,
    streams: &Streams,
) -> Result<Turn, RunError> {
    let forgetful = lesson::forgetful(subject, &shares.teach, options, streams)?;
    let mut rounds = lesson::mindful(subject, &shares.teach, options, streams)?;
    let best = best_looker(subject, &rounds, &shares.choose);
    let own = rounds[best].clone();
    let last = rounds.pop().unwrap_or_else(|| own.clone());
    let choices = choices(subject.slots.len());
    let student = |choice: &Fixed| if choice.remembers { &last } else { &forgetful };
    let replay = |choice: &Fixed| {
        let cost = sum(&fixed(subject, student(choice), *choice, &shares.choose));
        (cost.cost() / cost.steps.max(1.0), fixed(subject, student(choice), *choice, &shares.judge))
    };
    let (chosen, judged) = choices.par_iter().map(replay).unzip();
    Ok(Turn {
        chosen,
        judged,
        choices,
        adaptive: [adaptive(subject, &forgetful, &shares.judge), adaptive(subject, &own, &shares.judge)],
        lookers: [forgetful, own],
    })
}

/// Which of the students looks best of its own accord, where it is chosen.
fn best_looker(subject: &Subject<'_>, students: &[Student], choose: &[&Episode]) -> usize {
    let costs: Vec<f64> = students.iter().map(|s| -sum(&adaptive(subject, s, choose)).cost()).collect();
    metal_rl::num::argmax(&costs)
}
