//! The iterations: drive, judge, fit, test on a validation stream, and keep the best student.

use super::config::CounterfactualConfig;
use super::fit::{fit, scale};
use super::judge::{Drive, Judge, Judged, Labels, Workers};
use super::rule::{LookRule, UnknownMember};
use super::student::{Student, StudentShape};
use crate::decision::Encoding;
use crate::environment::{Environment, EnvironmentError};
use crate::explore::{Exploration, Schedule};
use crate::learner::LearnerError;
use crate::member::Member;
use crate::num;
use crate::observe::{Observer, Step};
use crate::phase::{Budget, Phase};
use crate::policies::Counterfactual;
use crate::random::Streams;
use crate::run::{Stage, run};
use crate::set::IndexSet;
use crate::view::Scaling;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

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

/// One iteration in numbers. Costs are means per motor step of the greedy student on the validation stream, at true
/// prices.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Iterate {
    /// Motor steps the student drove itself to be taught.
    pub own_steps: usize,
    /// Motor steps of roll-outs in copies of the world.
    pub rolled_steps: usize,
    /// Motor steps of the validation.
    pub validation_steps: usize,
    /// Share of the price of looking that was learned from.
    pub price_share: f64,
    /// Share of this iteration's judged moments at which no move made much of a difference.
    pub idle: f64,
    /// Mean loss at the end of the fit, in units of the labels' spread.
    pub loss: f64,
    /// Motor reward and prices together.
    pub total: f64,
    /// Motor reward.
    pub motor: f64,
    /// Looks.
    pub looks: f64,
    /// Motor steps of a run of the validation, mean.
    #[serde(default = "one")]
    pub run_steps: f64,
}

/// Runs of equal length may be compared step by step.
fn one() -> f64 {
    1.0
}

impl Iterate {
    /// What a run would earn if a look cost this share of its price. Per run, not per step: where a world can end, who
    /// lives twice as long as another at the same reward per step is twice as good.
    fn at_price(&self, share: f64) -> f64 {
        self.run_steps * (self.motor + share * (self.total - self.motor))
    }
}

/// The iterate that would be best if a look cost this share of its price; the earlier one wins a tie.
fn best(diary: &[Iterate], share: f64) -> usize {
    let costs: Vec<f64> = diary.iter().map(|i| i.at_price(share)).collect();
    num::argmax(&costs)
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
    let shape = student_shape(config, school.members, &school.roster, school.environment.spec())?;
    let mut course = Course {
        student: Student::new(config, &shape, &streams.child("student"))?,
        window: VecDeque::new(),
        diary: Vec::new(),
        past: Vec::new(),
        judge: config.judge.build(school.workers, &streams.child("judge")),
        streams: *streams,
    };
    for iteration in 0..config.iterations {
        if (school.interrupted)() {
            return Err(CounterfactualError::Interrupted);
        }
        course.iteration(school, phase, iteration, observer)?;
        if course.is_exhausted(config.patience) {
            break;
        }
    }
    let best = best(&course.diary, 1.0);
    let student = course.past.into_iter().nth(best).unwrap_or(course.student);
    let policy = Counterfactual::new(student, school.roster.clone());
    Ok(Graduate { policy, diary: course.diary, best })
}

/// A student on its way.
struct Course<'a> {
    judge: Box<dyn Judge + 'a>,
    student: Student,
    window: VecDeque<Vec<Judged>>,
    diary: Vec<Iterate>,
    past: Vec<Student>,
    streams: Streams,
}

impl Course<'_> {
    fn iteration(
        &mut self,
        school: &mut School<'_>,
        phase: &Phase,
        iteration: usize,
        observer: &mut dyn Observer,
    ) -> Result<(), CounterfactualError> {
        let config = self.student.config().clone();
        let streams = self.streams.nth(iteration as u64);
        let horizon = school.environment.spec().horizon;
        let own = own_drive(phase, (iteration, config.iterations), horizon);
        let Budget::Steps(own_steps) = own.budget else { unreachable!("own drives are counted in steps") };
        let limit = drive_limit((iteration, config.iterations), config.first_drives, horizon);
        self.student.set_wide_eyed(iteration < config.wide_eyed_iterations());
        let price_share = price_share(iteration, (config.wide_eyed_iterations(), config.price_ramp));
        let drive =
            Drive { student: &self.student, phase: own, limit, price_share, streams: streams.child("drive") };
        let Labels { judged, rolled_steps, replace } = self.judge.labels(school, &drive, observer)?;
        let idle = idle(&judged);
        self.remember(judged, if replace { 1 } else { config.window });
        let data: Vec<&Judged> = self.window.iter().flatten().collect();
        if data.is_empty() {
            return Ok(());
        }
        self.student.set_scale(scale(&data, config.fit.unit));
        let loss = fit(&mut self.student, &data, price_share, &streams.child("fit"));
        let tally = self.validate(school, phase, config.validation_runs)?;
        if iteration == config.iterations / 2 && price_share >= 1.0 && iteration + 1 < config.iterations {
            self.student.keep(kept(&tally.asked, self.student.kept(), config.dismissal));
        }
        let mean = |sum: f64| sum / tally.steps.max(1) as f64;
        self.note(Iterate {
            own_steps,
            rolled_steps,
            validation_steps: tally.steps,
            price_share,
            idle,
            loss,
            total: mean(tally.motor - tally.price),
            motor: mean(tally.motor),
            looks: mean(tally.looks as f64),
            run_steps: tally.steps as f64 / config.validation_runs as f64,
        });
        Ok(())
    }

    fn remember(&mut self, judged: Vec<Judged>, window: usize) {
        self.window.push_back(judged);
        while self.window.len() > window {
            self.window.pop_front();
        }
    }

    fn note(&mut self, iterate: Iterate) {
        self.diary.push(iterate);
        self.past.push(self.student.clone());
        // Who looks at everybody tells nothing about how good the same student's own looks are.
        let free = self.student.config().wide_eyed_iterations();
        if self.diary.len() <= free {
            return;
        }
        let share = iterate.price_share;
        let best = free + best(&self.diary[free..], share);
        let record = self.diary[best].at_price(share);
        if iterate.at_price(share) < record - self.student.config().tolerance * record.abs() {
            self.student = self.past[best].clone();
        }
    }

    /// Whether nothing has become better for `patience` iterations at full price.
    fn is_exhausted(&self, patience: usize) -> bool {
        let best = best(&self.diary, 1.0);
        let later = &self.diary[self.diary.len().min(best + 1)..];
        patience > 0 && later.iter().filter(|i| i.price_share >= 1.0).count() >= patience
    }

    /// The greedy student on the validation stream, the same for every iterate.
    fn validate(
        &self,
        school: &mut School<'_>,
        phase: &Phase,
        runs: usize,
    ) -> Result<Tally, EnvironmentError> {
        let mut driver = Counterfactual::new(self.student.clone(), school.roster.clone());
        let mut stage = Stage {
            environment: &mut *school.validation,
            members: &mut *school.members,
            policy: &mut driver,
            scaling: school.scaling,
        };
        let mut tally = Tally { roster: school.roster.clone(), ..Tally::default() };
        tally.asked.resize(school.roster.len(), 0);
        let test = Phase::evaluation("validation", phase.roster, runs);
        run(&mut stage, &test, &self.streams.child("validation"), &mut tally)?;
        Ok(tally)
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

/// The slots among `before` that were `asked` often enough, or most; all, if nobody was.
fn kept(asked: &[usize], before: IndexSet, least: f64) -> IndexSet {
    let most = before.iter().map(|slot| asked[slot]).max().unwrap_or(0);
    if most == 0 {
        return before;
    }
    let all = asked.iter().sum::<usize>() as f64;
    let enough = |&slot: &usize| asked[slot] == most || asked[slot] as f64 >= least * all;
    before.iter().filter(enough).collect()
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
fn own_drive(phase: &Phase, (iteration, iterations): (usize, usize), horizon: usize) -> Phase {
    let steps = match phase.budget {
        Budget::Steps(n) => n,
        Budget::Episodes(n) => n * horizon,
    };
    let own = steps * (iteration + 1) / iterations - steps * iteration / iterations;
    let exploration = match phase.exploration.at(iteration as f64 / iterations as f64) {
        Exploration::Greedy => Schedule::Greedy,
        Exploration::SoftMax(t) => Schedule::SoftMax { from: t, to: t, until: 1.0 },
        Exploration::Random(p) => Schedule::Random { from: p, to: p, until: 1.0 },
    };
    let quiet = Phase::evaluation(&phase.name, phase.roster, 0);
    Phase { exploration, budget: Budget::Steps(own), ..quiet }
}

/// Sums over a validation.
#[derive(Default)]
struct Tally {
    motor: f64,
    price: f64,
    looks: usize,
    steps: usize,
    roster: Vec<usize>,
    asked: Vec<usize>,
}

impl Observer for Tally {
    fn on_step(&mut self, step: &Step<'_>) {
        for (asked, &member) in self.asked.iter_mut().zip(&self.roster) {
            *asked += usize::from(step.state.opinion(member).is_some());
        }
        self.motor += step.motor_reward;
        self.price += step.look_price;
        self.looks += step.percept.read().len();
        self.steps += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_price_rises_from_nothing_to_all_of_it() {
        let shares: Vec<f64> = (0..8).map(|i| price_share(i, (2, 4))).collect();
        assert_eq!(shares, [0.0, 0.0, 0.0, 0.25, 0.5, 0.75, 1.0, 1.0]);
        assert_eq!(price_share(0, (0, 0)), 1.0);
        assert_eq!(price_share(0, (1, 0)), 0.0);
    }

    #[test]
    fn who_is_hardly_asked_is_dismissed() {
        let all = IndexSet::first(3);
        assert_eq!(kept(&[90, 9, 1], all, 0.05), IndexSet::first(2));
        assert_eq!(kept(&[90, 9, 1], all.without(1), 0.0), all.without(1));
        assert_eq!(kept(&[0, 0, 0], all, 0.05), all);
        assert_eq!(kept(&[30, 30, 40], all, 0.5), IndexSet::EMPTY.with(2), "somebody has to stay");
    }

    #[test]
    fn who_lives_longer_at_the_same_reward_per_step_is_better() {
        let iterate = |run_steps, total| Iterate {
            own_steps: 0,
            rolled_steps: 0,
            validation_steps: 0,
            price_share: 1.0,
            idle: 0.0,
            loss: 0.0,
            total,
            motor: 1.0,
            looks: 0.0,
            run_steps,
        };
        // A pole that falls at once without a look, and one that stands for 200 steps of two looks each.
        let diary = [iterate(9.0, 1.0), iterate(200.0, 0.9)];
        assert_eq!(best(&diary, 1.0), 1);
    }

    #[test]
    fn drives_become_as_long_as_the_worlds() {
        let limits: Vec<usize> = (0..6).map(|i| drive_limit((i, 6), 10, 40)).collect();
        assert_eq!(limits, [10, 20, 30, 40, 40, 40]);
        assert_eq!(drive_limit((0, 6), 0, 40), 40);
        assert_eq!(drive_limit((0, 1), 60, 40), 40);
    }

    #[test]
    fn iterations_share_all_steps_of_the_phase() {
        let phase = Phase {
            budget: Budget::Episodes(7),
            exploration: Schedule::Random { from: 0.4, to: 0.1, until: 0.5 },
            ..Phase::evaluation("drive", IndexSet::first(1), 0)
        };
        let drives: Vec<Phase> = (0..4).map(|i| own_drive(&phase, (i, 4), 50)).collect();
        let steps = drives.iter().map(|d| match d.budget {
            Budget::Steps(n) => n,
            Budget::Episodes(_) => 0,
        });
        assert_eq!(steps.sum::<usize>(), 350);
        assert_eq!(drives[2].exploration, Schedule::Random { from: 0.1, to: 0.1, until: 1.0 });
        assert!(drives.iter().all(|d| !d.learns()));
    }
}
