//! From scores to a report: means with bootstrap intervals over the episodes that were judged.

use super::CeilingOptions;
use super::replay::{Fixed, Score, choices};
use super::rows::{Looking, Row};
use super::situation::Situations;
use super::subject::Subject;
use super::trial::{Trial, Turn};
use super::wheel::Drive;
use crate::results::Results;
use metal_rl::measure::statistics::{Bootstrap, Estimate, student};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Everything that was found. Rewards per motor step: negative is worse.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CeilingReport {
    /// Title of the experiment.
    pub title: String,
    /// Registry name of the world.
    pub world: String,
    /// How much was measured.
    pub options: CeilingOptions,
    /// Who could be looked at.
    pub members: Vec<String>,
    /// Price of one look at each of them.
    pub prices: Vec<f64>,
    /// The logs, driver by driver.
    pub logs: Vec<Log>,
    /// Best ways of looking, kind by kind.
    pub lines: Vec<Line>,
    /// Every subset at every rhythm.
    pub points: Vec<Point>,
    /// Cost of adaptive looks against that of fixed ones.
    pub ratios: Vec<Ratio>,
    /// Learned policies of a run, to compare with.
    pub learned: Vec<Learned>,
}

/// A driver and its log.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Log {
    /// Motor reward of the driver at the wheel.
    pub motor: f64,
    /// Share of its episodes with an accident.
    pub accidents: f64,
    /// Moments that were judged.
    pub moments: usize,
    /// Episodes.
    pub episodes: usize,
}

/// A way of looking: the ceiling, and the same student at the wheel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Line {
    /// Its kind.
    pub name: String,
    /// Whether looks are remembered.
    pub remembers: bool,
    /// The choice that was made most often where it was chosen, and how often; none: looks by need.
    pub choice: Option<(String, f64)>,
    /// Looks.
    pub looks: Estimate,
    /// Price of looks, ≥ 0.
    pub price: Estimate,
    /// Motor reward that is lost against the driver's own moves, ≥ 0 but for noise.
    pub lost: Estimate,
    /// The ceiling of the motor reward.
    pub motor: Estimate,
    /// The ceiling: motor reward minus price.
    pub total: Estimate,
    /// Where it is lost.
    pub places: Vec<Place>,
    /// At the wheel.
    pub driven: Option<Driven>,
}

/// What is lost in one kind of situation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Place {
    /// The situation.
    pub situation: String,
    /// Share of all motor steps.
    pub moments: f64,
    /// Lost per motor step there.
    pub lost: f64,
    /// Share of all that is lost.
    pub share: f64,
}

/// At the wheel: fixed choices by a universal student that was taught where they lead to, looks by need by the student of
/// the ceiling. Intervals are Student's over trainings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Driven {
    /// The choices that were best in other episodes, training by training; none: looks by need.
    pub choices: Vec<String>,
    /// Looks.
    pub looks: Estimate,
    /// Motor reward.
    pub motor: Estimate,
    /// Motor reward minus price.
    pub total: Estimate,
    /// Share of episodes with an accident.
    pub accidents: Estimate,
    /// What the motor cost is for, where the world says so.
    pub causes: BTreeMap<String, f64>,
}

/// A fixed choice of looks and its ceiling. Nothing was chosen here.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Who is looked at.
    pub members: Vec<String>,
    /// At every so many motor steps.
    pub every: usize,
    /// Whether looks are remembered.
    pub remembers: bool,
    /// Looks.
    pub looks: f64,
    /// Price of looks, ≥ 0.
    pub price: f64,
    /// The ceiling of the motor reward.
    pub motor: f64,
    /// The ceiling: motor reward minus price.
    pub total: f64,
    /// Price of looks at the wheel, ≥ 0.
    pub driven_price: f64,
    /// Motor reward at the wheel.
    pub driven_motor: f64,
}

/// One way of looking against another: ratio of total costs, below 1 if the first is cheaper.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ratio {
    /// The first.
    pub of: String,
    /// The other.
    pub to: String,
    /// Whether looks are remembered in both.
    pub remembers: bool,
    /// The ratio, with an interval over episodes, paired.
    pub ratio: Estimate,
}

/// A policy of a finished run, in the training scenario.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Learned {
    /// Its name.
    pub name: String,
    /// Looks.
    pub looks: f64,
    /// Price of looks, ≥ 0.
    pub price: f64,
    /// Motor reward.
    pub motor: Estimate,
    /// Motor reward minus price.
    pub total: Estimate,
}

/// The policies of `results` in `scenario`.
#[must_use]
pub fn learned(results: &Results, scenario: &str) -> Vec<Learned> {
    let find = |name: &String| {
        let of = |measure| results.estimate(name, scenario, measure);
        let (motor, total) = (of("motor")?, of("total")?);
        let (looks, price) = (of("looks")?.mean, -of("perceptual")?.mean);
        Some(Learned { name: name.clone(), looks, price, motor, total })
    };
    results.policies.keys().filter_map(find).collect()
}

/// An episode with what its driver itself pays per motor step.
struct Judged<'a> {
    score: &'a Score,
    driver: f64,
}

impl Judged<'_> {
    fn motor(&self) -> f64 {
        self.driver * self.score.steps - self.score.loss()
    }

    fn total(&self) -> f64 {
        self.motor() - self.score.price
    }
}

/// Episodes of all turns, driver by driver.
type Strata<'a> = Vec<Vec<Judged<'a>>>;

fn strata<'a>(trials: &'a [Trial], scores: impl Fn(&'a Turn) -> &'a [Score]) -> Strata<'a> {
    let of = |trial: &'a Trial| {
        let driver = trial.driver.motor;
        trial.turns.iter().flat_map(&scores).map(move |score| Judged { score, driver }).collect()
    };
    trials.iter().map(of).collect()
}

/// The mean of `number` per motor step, with its interval.
fn per_step(strata: &Strata<'_>, number: impl Fn(&Judged<'_>) -> f64) -> Estimate {
    let episodes = strata.iter().map(Vec::len).sum::<usize>() as f64;
    let steps: f64 = strata.iter().flatten().map(|j| j.score.steps).sum();
    let values: Vec<Vec<f64>> =
        strata.iter().map(|s| s.iter().map(|j| number(j) * episodes / steps.max(1.0)).collect()).collect();
    let values: Vec<&[f64]> = values.iter().map(Vec::as_slice).collect();
    let mean = |all: &[f64]| all.iter().sum::<f64>() / all.len().max(1) as f64;
    Bootstrap::default().estimate(&values, mean).unwrap_or(Estimate::point(0.0, 0))
}

/// Everything in numbers.
pub(super) fn write(subject: &Subject<'_>, options: &CeilingOptions, trials: &[Trial]) -> CeilingReport {
    let slots = subject.slots.len();
    let rows = Row::all(slots);
    CeilingReport {
        title: subject.plan.file.title.clone(),
        world: subject.plan.spec.id.clone(),
        options: options.clone(),
        members: subject.names.clone(),
        prices: subject.everybody().iter().map(|s| subject.price(std::iter::once(s).collect())).collect(),
        logs: trials.iter().map(log).collect(),
        lines: rows.iter().map(|&row| line(subject, trials, row)).collect(),
        points: choices(slots).into_iter().map(|choice| point(subject, trials, choice)).collect(),
        ratios: ratios(trials),
        learned: Vec::new(),
    }
}

fn log(trial: &Trial) -> Log {
    let Drive { motor, accidents, .. } = trial.driver;
    Log { motor, accidents, moments: trial.size.0, episodes: trial.size.1 }
}

fn line(subject: &Subject<'_>, trials: &[Trial], row: Row) -> Line {
    let strata = strata(trials, |turn| turn.scores(row));
    Line {
        name: row.name(),
        remembers: row.remembers,
        choice: usual(subject, trials, row),
        looks: per_step(&strata, |j| j.score.looks),
        price: per_step(&strata, |j| j.score.price),
        lost: per_step(&strata, |j| j.score.loss()),
        motor: per_step(&strata, |j| j.motor()),
        total: per_step(&strata, |j| j.total()),
        places: places(subject, &strata),
        driven: driven(subject, trials, row),
    }
}

/// The choice that most turns made.
fn usual(subject: &Subject<'_>, trials: &[Trial], row: Row) -> Option<(String, f64)> {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    let turns: Vec<&Turn> = trials.iter().flat_map(|t| &t.turns).collect();
    for choice in turns.iter().filter_map(|turn| turn.choice(row)) {
        *counts.entry(words(subject, choice)).or_default() += 1;
    }
    let (name, count) = counts.into_iter().max_by_key(|&(_, count)| count)?;
    Some((name, count as f64 / turns.len() as f64))
}

/// A fixed choice in words: `RN/2` is RN at every second motor step.
fn words(subject: &Subject<'_>, choice: Fixed) -> String {
    let rhythm = if choice.every > 1 { format!("/{}", choice.every) } else { String::new() };
    subject.words(choice.slots) + &rhythm
}

fn places(subject: &Subject<'_>, strata: &Strata<'_>) -> Vec<Place> {
    let all = strata.iter().flatten().fold(Score::default(), |all, j| all.and(j.score));
    let names = Situations::new(&subject.plan.spec).names();
    let place = |(i, name): (usize, &&str)| Place {
        situation: (*name).to_owned(),
        moments: all.moments[i] / all.steps.max(1.0),
        lost: all.losses[i] / all.moments[i].max(1.0),
        share: if all.loss() > 0.0 { all.losses[i] / all.loss() } else { 0.0 },
    };
    names.iter().enumerate().map(place).collect()
}

fn driven(subject: &Subject<'_>, trials: &[Trial], row: Row) -> Option<Driven> {
    let find = |t: &'_ Trial| {
        t.driven.iter().position(|(r, ..)| *r == row).map(|i| (t.driven[i].1, t.driven[i].2.clone()))
    };
    let drives: Vec<(Option<Fixed>, Drive)> = trials.iter().filter_map(find).collect();
    let over =
        |number: &dyn Fn(&Drive) -> f64| student(&drives.iter().map(|(_, d)| number(d)).collect::<Vec<_>>());
    let cause = |name: &String| {
        let sum: f64 = drives.iter().filter_map(|(_, d)| d.causes.get(name)).sum();
        (name.clone(), sum / drives.len() as f64)
    };
    Some(Driven {
        choices: drives.iter().filter_map(|(choice, _)| choice.map(|c| words(subject, c))).collect(),
        looks: over(&|d| d.looks)?,
        motor: over(&|d| d.motor)?,
        total: over(&Drive::total)?,
        accidents: over(&|d| d.accidents)?,
        causes: drives.first()?.1.causes.keys().map(cause).collect(),
    })
}

fn point(subject: &Subject<'_>, trials: &[Trial], choice: Fixed) -> Point {
    let strata = strata(trials, |turn| turn.fixed(choice));
    let steps: f64 = strata.iter().flatten().map(|j| j.score.steps).sum();
    let mean = |number: &dyn Fn(&Judged<'_>) -> f64| {
        strata.iter().flatten().map(number).sum::<f64>() / steps.max(1.0)
    };
    let drives: Vec<&Drive> =
        trials.iter().filter_map(|t| t.wheel.iter().find(|(c, _)| *c == choice).map(|(_, d)| d)).collect();
    let wheel =
        |number: &dyn Fn(&Drive) -> f64| drives.iter().map(|d| number(d)).sum::<f64>() / drives.len() as f64;
    Point {
        members: choice.slots.iter().map(|s| subject.names[s].clone()).collect(),
        every: choice.every,
        remembers: choice.remembers,
        looks: mean(&|j| j.score.looks),
        price: mean(&|j| j.score.price),
        motor: mean(&|j| j.motor()),
        total: mean(&|j| j.total()),
        driven_price: wheel(&|d| d.price),
        driven_motor: wheel(&|d| d.motor),
    }
}

/// Looks by need against the best that is fixed.
fn ratios(trials: &[Trial]) -> Vec<Ratio> {
    let pairs = [
        (Looking::Adaptive, Looking::AnyAlways, false),
        (Looking::Adaptive, Looking::AnyAlways, true),
        (Looking::Adaptive, Looking::AnyFixed, true),
    ];
    pairs
        .into_iter()
        .map(|(of, to, remembers)| ratio(trials, [of, to].map(|looking| Row { looking, remembers })))
        .collect()
}

fn ratio(trials: &[Trial], [of, to]: [Row; 2]) -> Ratio {
    let totals = |row: Row| {
        let strata = strata(trials, |turn| turn.scores(row));
        strata.into_iter().flatten().map(|j| j.total()).collect::<Vec<f64>>()
    };
    let (ours, theirs) = (totals(of), totals(to));
    // Episodes are drawn by their number, so that pairs stay together.
    let mut next = 0..ours.len();
    let episodes = |t: &Trial| t.turns.iter().map(|turn| turn.scores(of).len()).sum::<usize>();
    let strata: Vec<Vec<f64>> =
        trials.iter().map(|t| next.by_ref().take(episodes(t)).map(|i| i as f64).collect()).collect();
    let strata: Vec<&[f64]> = strata.iter().map(Vec::as_slice).collect();
    let quotient = |drawn: &[f64]| {
        let sum = |totals: &[f64]| drawn.iter().map(|&i| totals[i as usize]).sum::<f64>();
        sum(&ours) / sum(&theirs)
    };
    let ratio = Bootstrap::default().estimate(&strata, quotient).unwrap_or(Estimate::point(f64::NAN, 0));
    Ratio { of: of.name(), to: to.name(), remembers: of.remembers, ratio }
}
