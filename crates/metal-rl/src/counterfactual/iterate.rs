//! The iterations: drive, judge, fit, test on a validation stream, and keep the best student.

use self::diary::{Iterate, best, finalists};
use self::dismissal::Dismissal;
use self::purse::Purse;
use self::trial::{Spread, Tally, trial};
use super::config::{CounterfactualConfig, Inputs};
use super::fit::{fit, scale};
use super::judge::{Judge, Judged, Labels, Workers};
use super::student::recollection::Lesson;
use super::student::rule::{LookRule, UnknownMember};
use super::student::units::Units;
use super::student::{Student, StudentShape};
use crate::decision::Encoding;
use crate::environment::{Environment, EnvironmentError};
use crate::explore::{Exploration, Schedule};
use crate::learner::LearnerError;
use crate::member::Member;
use crate::observe::Observer;
use crate::phase::{Budget, Phase};
use crate::policies::Counterfactual;
use crate::policy::Ear;
use crate::random::Streams;
use crate::view::Scaling;
use std::collections::VecDeque;

mod astray;
pub mod diary;
mod dismissal;
mod pause;
pub(in crate::counterfactual) mod purse;
pub(in crate::counterfactual) mod trial;

pub use pause::Term;

/// Where a student is taught.
pub struct School<'a> {
    /// The world it drives in; it must be able to copy itself.
    pub environment: &'a mut dyn Environment,
    /// The world in which iterates are compared, with starts (or roads) of its own.
    pub validation: &'a mut dyn Environment,
    /// The mind's members; they do not learn meanwhile.
    pub members: &'a mut [Member],
    /// Who may be consulted; slot i of the student is member `roster[i]`.
    pub roster: Vec<usize>,
    /// How readings are scaled.
    pub scaling: Scaling,
    /// Who carries out independent work, such as roll-outs.
    pub workers: &'a dyn Workers,
    /// Asked between iterations: whether to stop.
    pub interrupted: &'a dyn Fn() -> bool,
    /// Told of every choice while the student drives for its lessons.
    pub ear: Ear<'a>,
}

/// Why nobody could be taught.
#[derive(Debug, thiserror::Error)]
pub enum CounterfactualError {
    /// The world, a body or its link failed.
    #[error(transparent)]
    Environment(#[from] EnvironmentError),
    /// A setting is outside its range.
    #[error(transparent)]
    Learner(#[from] LearnerError),
    /// A fixed rule names somebody who is not there.
    #[error(transparent)]
    Member(#[from] UnknownMember),
    /// The world cannot be copied.
    #[error(
        "{0} cannot be copied (`Environment::fork`), so nothing can be rolled out in it; a critic (`judge`) needs no copies"
    )]
    NoCopies(String),
    /// Somebody wanted to stop.
    #[error("interrupted")]
    Interrupted,
}

/// Who left school.
pub struct Graduate {
    /// The best student of all iterations, ready to drive.
    pub policy: Counterfactual,
    /// What happened, iteration by iteration.
    pub diary: Vec<Iterate>,
    /// Which iteration it comes from, from 0.
    pub best: usize,
}

/// The shape of a student for these members; slot i is member `roster[i]`.
///
/// # Errors
/// If `looks` names a member who is not on the roster.
pub fn student_shape(
    config: &CounterfactualConfig,
    members: &[Member],
    roster: &[usize],
    spec: &crate::environment::EnvironmentSpec,
) -> Result<StudentShape, UnknownMember> {
    let encoding = Encoding { content: config.content, ..Encoding::default() };
    let actions = spec.actions.len();
    let of = |&m: &usize| &members[m];
    let names: Vec<String> = roster.iter().map(of).map(|m| m.name.clone()).collect();
    Ok(StudentShape {
        blocks: roster.iter().map(of).map(|m| encoding.block(m.view.dims(), actions)).collect(),
        prices: roster.iter().map(of).map(|m| m.price(spec)).collect(),
        actions,
        rule: LookRule::resolve(&config.looks, &names)?,
    })
}

/// Teaches a newborn student. The exploration and the budget are those of `phase`; all randomness comes from `streams`.
///
/// # Errors
/// If the world fails or cannot be copied, a setting is impossible, or somebody interrupts.
pub fn iterate(
    school: &mut School<'_>,
    config: &CounterfactualConfig,
    phase: &Phase,
    streams: &Streams,
    observer: &mut dyn Observer,
) -> Result<Graduate, CounterfactualError> {
    let mut whole = Term { course: None, pause: &mut || false };
    iterate_term(school, (config, phase, streams), &mut whole, observer)
}

/// As [`iterate`], a term of it. Terms one after the other come to the same bits as one training, if the worlds forget
/// everything between episodes. If it pauses, the best student so far comes back.
///
/// # Errors
/// As [`iterate`]; and if the course in `term` is damaged or another one.
pub fn iterate_term(
    school: &mut School<'_>,
    (config, phase, streams): (&CounterfactualConfig, &Phase, &Streams),
    term: &mut Term<'_>,
    observer: &mut dyn Observer,
) -> Result<Graduate, CounterfactualError> {
    let shape = student_shape(config, school.members, &school.roster, school.environment.spec())?;
    let mut student = Student::new(config, &shape, &streams.child("student"))?;
    if let Some(believer) = school.believer(config, &shape, streams) {
        student.believe(believer);
    }
    let mut course = Course {
        next: 0,
        student,
        window: VecDeque::new(),
        diary: Vec::new(),
        past: Vec::new(),
        judge: config.judge.build(school.workers, &streams.child("judge")),
        purse: Purse::new(phase, config, school.environment.spec().horizon),
        spread: Spread::default(),
        held: 0,
        stray: None,
        dismissal: Dismissal::default(),
        since: 0,
        streams: *streams,
    };
    if let Some(bytes) = term.course.take() {
        course.thaw(&shape, &bytes)?;
    }
    while course.next < config.iterations {
        if (school.interrupted)() {
            return Err(CounterfactualError::Interrupted);
        }
        course.iteration(school, phase, course.next, observer)?;
        course.next += 1;
        if course.is_exhausted(config.patience) {
            break;
        }
        if course.next < config.iterations && (term.pause)() {
            term.course = Some(course.freeze());
            return Ok(course.graduate(&school.roster));
        }
    }
    if config.thrifty {
        course.finals(school, phase)?;
    }
    Ok(course.graduate(&school.roster))
}

/// A student on its way.
struct Course<'a> {
    /// The next iteration, from 0.
    next: usize,
    judge: Box<dyn Judge + 'a>,
    student: Student,
    window: VecDeque<Lesson>,
    diary: Vec<Iterate>,
    past: Vec<Student>,
    purse: Purse,
    spread: Spread,
    /// Iterations in which the student kept up.
    held: usize,
    /// The last iterate, if it was given up.
    stray: Option<Student>,
    dismissal: Dismissal,
    /// The first iteration that later ones are compared with: those before it could ask members that were dismissed.
    since: usize,
    streams: Streams,
}

impl Course<'_> {
    /// The best student until now.
    fn graduate(self, roster: &[usize]) -> Graduate {
        let best = best(&self.diary, 1.0);
        let student = self.past.into_iter().nth(best).unwrap_or(self.student);
        Graduate { policy: Counterfactual::new(student, roster.to_vec()), diary: self.diary, best }
    }

    fn iteration(
        &mut self,
        school: &mut School<'_>,
        phase: &Phase,
        iteration: usize,
        observer: &mut dyn Observer,
    ) -> Result<(), CounterfactualError> {
        let config = self.student.config().clone();
        let streams = self.streams.nth(iteration as u64);
        let own_steps = self.purse.own(iteration);
        self.student.set_wide_eyed(iteration < config.wide_eyed_iterations());
        let price_share = self.price_share(&config, iteration);
        let Labels { judged, trail, rolled_steps } =
            self.drive(school, phase, (own_steps, price_share), observer)?;
        let idle = idle(&judged);
        self.remember(Lesson { iteration, judged, trail }, config.window);
        self.student.learn_recollection(self.window.iter_mut(), &streams);
        let data: Vec<&Judged> = self.window.iter().flat_map(|lesson| &lesson.judged).collect();
        if data.is_empty() {
            return Ok(());
        }
        self.student.set_scale(scale(&data, config.fit.unit));
        if config.fit.inputs == Inputs::Standardized && (iteration == 0 || price_share < 1.0) {
            let full = data.iter().map(|judged| &judged.full[..]);
            self.student.set_units(Units::of(self.student.layout(), full));
        }
        let loss = fit(&mut self.student, &data, price_share, &streams.child("fit"));
        let tally = self.validate(school, phase)?;
        let (sum, runs) = (tally.sum(), tally.runs.len());
        let mean = |all: f64| all / sum.steps.max(1) as f64;
        self.spread.add(&tally.runs);
        self.note(Iterate {
            own_steps,
            rolled_steps,
            validation_steps: sum.steps,
            price_share,
            idle,
            loss,
            total: mean(sum.motor - sum.price),
            motor: mean(sum.motor),
            looks: mean(sum.looks as f64),
            run_steps: sum.steps as f64 / runs.max(1) as f64,
            runs,
            error: if config.thrifty { self.spread.error(runs) } else { 0.0 },
        });
        if price_share >= 1.0 && self.dismissal.after(iteration, &tally.asked, &mut self.student) {
            if let Some(stray) = &mut self.stray {
                stray.keep(self.student.kept());
            }
            self.since = self.diary.len();
        }
        Ok(())
    }

    /// The share of its price that a look costs: by the clock, or by how often the student kept up.
    fn price_share(&self, config: &CounterfactualConfig, iteration: usize) -> f64 {
        let free = config.wide_eyed_iterations();
        let at = if config.thrifty { iteration.min(free + self.held) } else { iteration };
        let risen = price_share(at, (free, config.price_ramp));
        config.first_price + (1.0 - config.first_price) * risen
    }

    fn remember(&mut self, lesson: Lesson, window: usize) {
        self.window.push_back(lesson);
        while self.window.len() > window {
            self.window.pop_front();
        }
    }

    /// Whether nothing has become better for `patience` iterations at full price.
    fn is_exhausted(&self, patience: usize) -> bool {
        let best = best(&self.diary, 1.0);
        let later = &self.diary[self.diary.len().min(best + 1)..];
        patience > 0 && later.iter().filter(|i| i.price_share >= 1.0).count() >= patience
    }

    /// The greedy student on the validation stream, the same for every iterate; where steps are dear, as far as they go.
    fn validate(&mut self, school: &mut School<'_>, phase: &Phase) -> Result<Tally, CounterfactualError> {
        let mut streams = self.streams.child("validation");
        if self.student.config().thrifty {
            // Tests of a run or two would prefer whoever is good at these.
            streams = streams.nth(self.diary.len() as u64);
        }
        let test = (&self.student, phase, self.purse.test());
        let (tally, spent) = trial(school, self.judge.as_mut(), test, &streams)?;
        self.purse.pay(spent);
        Ok(tally)
    }

    /// The best iterates once more, on other starts than before, for what is left of the budget.
    fn finals(&mut self, school: &mut School<'_>, phase: &Phase) -> Result<(), CounterfactualError> {
        const FINALISTS: usize = 4;
        let finalists = finalists(&self.diary, FINALISTS);
        for (rank, &at) in finalists.iter().enumerate() {
            let steps = self.purse.left() / (finalists.len() - rank);
            if steps == 0 {
                break;
            }
            let test = (&self.past[at], phase, Budget::Steps(steps));
            let (tally, spent) = trial(school, self.judge.as_mut(), test, &self.streams.child("finals"))?;
            self.purse.pay(spent);
            self.diary[at].add(&tally, self.spread);
        }
        Ok(())
    }
}

/// The share of its price that a look costs in `iteration` (from 0): nothing in the first `free` ones and in one more,
/// then ever more over `ramp` iterations.
#[must_use]
pub fn price_share(iteration: usize, (free, ramp): (usize, usize)) -> f64 {
    let paid = iteration.saturating_sub(free) as f64;
    if iteration < free {
        0.0
    } else if ramp == 0 {
        1.0
    } else {
        (paid / ramp as f64).min(1.0)
    }
}

/// Motor steps after which own drives begin anew: from `first` to `horizon` over the first half of all iterations.
fn drive_limit((iteration, iterations): (usize, usize), first: usize, horizon: usize) -> usize {
    let half = (iterations / 2).max(1);
    if first == 0 || iteration >= half || first >= horizon {
        horizon
    } else {
        first + (horizon - first) * iteration / half
    }
}

/// The share of moments at which the worst move costs less than a tenth of what it costs on average.
fn idle(judged: &[Judged]) -> f64 {
    let spread = |j: &Judged| -j.advantages.iter().copied().fold(0.0, f64::min);
    let spreads: Vec<f64> = judged.iter().map(spread).collect();
    let n = spreads.len().max(1) as f64;
    let mean = spreads.iter().sum::<f64>() / n;
    spreads.iter().filter(|&&s| s < 0.1 * mean).count() as f64 / n
}

/// The part of a phase that is driven in one of its iterations: nobody learns, exploration stands still.
fn own_drive(phase: &Phase, (iteration, iterations): (usize, usize), steps: usize) -> Phase {
    let exploration = match phase.exploration.at(iteration as f64 / iterations as f64) {
        Exploration::Greedy => Schedule::Greedy,
        Exploration::SoftMax(t) => Schedule::SoftMax { from: t, to: t, until: 1.0 },
        Exploration::Random(p) => Schedule::Random { from: p, to: p, until: 1.0 },
    };
    let quiet = Phase::evaluation(&phase.name, phase.roster, 0);
    Phase { exploration, budget: Budget::Steps(steps), ..quiet }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::set::IndexSet;

    #[test]
    fn the_price_rises_from_nothing_to_all_of_it() {
        let shares: Vec<f64> = (0..8).map(|i| price_share(i, (2, 4))).collect();
        assert_eq!(shares, [0.0, 0.0, 0.0, 0.25, 0.5, 0.75, 1.0, 1.0]);
        assert_eq!(price_share(0, (0, 0)), 1.0);
        assert_eq!(price_share(0, (1, 0)), 0.0);
    }

    #[test]
    fn drives_become_as_long_as_the_worlds() {
        let limits: Vec<usize> = (0..6).map(|i| drive_limit((i, 6), 10, 40)).collect();
        assert_eq!(limits, [10, 20, 30, 40, 40, 40]);
        assert_eq!(drive_limit((0, 6), 0, 40), 40);
        assert_eq!(drive_limit((0, 1), 60, 40), 40);
    }

    #[test]
    fn exploration_stands_still_within_an_iteration() {
        let phase = Phase {
            exploration: Schedule::Random { from: 0.4, to: 0.1, until: 0.5 },
            ..Phase::evaluation("drive", IndexSet::first(1), 0)
        };
        let drive = own_drive(&phase, (2, 4), 80);
        assert_eq!(drive.exploration, Schedule::Random { from: 0.1, to: 0.1, until: 1.0 });
        assert_eq!((drive.budget, drive.learns()), (Budget::Steps(80), false));
    }
}
