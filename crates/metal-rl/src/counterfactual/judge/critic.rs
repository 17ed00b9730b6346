//! A critic learned from the log: it sees everything and knows what the student knows, and says what every motor action
//! is worth if the student then goes on as it does. It takes the place of roll-outs where a world cannot be copied.
//!
//! The student's looks after a logged step need no guessing: all that it could have seen is in the log, so its looks and its
//! next move are replayed on it, whatever it looked at then. A critic that sees more than the pupil is no teacher who
//! sees more: it says what the *pupil's* future is worth (the asymmetric critic of Pinto et al. 2018).

use crate::counterfactual::config::{count, within};
use crate::counterfactual::fit::{Mean, SMALLEST};
use crate::counterfactual::iterate::{CounterfactualError, School};
use crate::counterfactual::judge::log::{Moment, log};
use crate::counterfactual::judge::{Drive, Judge, Judged, Labels, Stop, other_looks};
use crate::counterfactual::student::gaze::Gaze;
use crate::counterfactual::student::{Next, Scratch, Student};
use crate::learner::LearnerError;
use crate::learners::nn::{Activation, Adam, Batch, Network};
use crate::num;
use crate::observe::Observer;
use crate::random::{Rng, Streams};
use crate::set::IndexSet;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

mod rest;

/// Settings of the critic.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CriticConfig {
    /// Widths of the hidden layers.
    pub hidden: Vec<usize>,
    /// What hidden units do.
    pub activation: Activation,
    /// Optimiser; its clip is in units of what is learned.
    pub adam: Adam,
    /// Motor steps that are kept, the last ones.
    pub capacity: usize,
    /// Training steps per iteration.
    pub batches: usize,
    /// Samples per training step.
    pub batch: usize,
    /// Training steps between copies of the networks that targets are computed with.
    pub refresh: usize,
    /// The step size of the optimiser falls to this share of itself over an iteration's training, in (0, 1].
    pub final_rate: f64,
    /// Share at the end of an iteration's training over which weights are averaged, in [0, 1).
    pub averaged: f64,
    /// Moments, drawn from all that are kept, that are labelled for the student in each iteration, at most.
    pub labels: usize,
}

impl Default for CriticConfig {
    fn default() -> Self {
        Self {
            hidden: vec![64, 64],
            activation: Activation::LeakyRelu,
            adam: Adam { learning_rate: 1e-3, ..Adam::default() },
            capacity: 100_000,
            batches: 4000,
            batch: 64,
            refresh: 100,
            final_rate: 0.1,
            averaged: 0.3,
            labels: 20_000,
        }
    }
}

impl CriticConfig {
    /// Refuses settings outside their range.
    ///
    /// # Errors
    /// Names the first field that is out of range.
    pub fn validate(&self) -> Result<(), LearnerError> {
        self.hidden.iter().try_for_each(|&width| count("judge.critic.hidden", width, 1..=4096))?;
        let rate = f64::from(self.adam.learning_rate);
        let positive = rate.is_finite() && rate > 0.0;
        within("judge.critic.adam.learning_rate", rate, positive, "must be finite and above 0")?;
        count("judge.critic.capacity", self.capacity, 1..=10_000_000)?;
        count("judge.critic.batches", self.batches, 1..=10_000_000)?;
        count("judge.critic.batch", self.batch, 1..=65_536)?;
        count("judge.critic.refresh", self.refresh, 1..=10_000_000)?;
        let (rate, averaged) = (self.final_rate, self.averaged);
        within("judge.critic.final_rate", rate, rate > 0.0 && rate <= 1.0, "must be in (0, 1]")?;
        within("judge.critic.averaged", averaged, (0.0..1.0).contains(&averaged), "must be in [0, 1)")?;
        count("judge.critic.labels", self.labels, 1..=10_000_000)
    }
}

/// What a state is worth to the student as it looked there, and what each action after any looks adds to it, each in units of its own: values are some ten times larger than
/// advantages and would drown them.
#[derive(Clone, Serialize, Deserialize)]
struct Networks {
    value: Network,
    advantage: Network,
    unit: f64,
    centre: f64,
    advantage_unit: f64,
}

impl Networks {
    fn new(config: &CriticConfig, (width, actions): (usize, usize), rng: &mut Rng) -> Self {
        let mut network = |outputs: usize| {
            let hidden = config.hidden.iter().copied();
            let widths: Vec<usize> = std::iter::once(width).chain(hidden).chain([outputs]).collect();
            Network::new(&widths, config.activation, config.adam, rng)
        };
        Self { value: network(1), advantage: network(actions), unit: 1.0, centre: 0.0, advantage_unit: 1.0 }
    }

    fn value(&self, input: &[f32]) -> f64 {
        let mut out = [0.0];
        self.value.forward(input, &mut out);
        self.centre + self.unit * f64::from(out[0])
    }

    fn advantages(&self, input: &[f32], raw: &mut [f32], out: &mut [f64]) {
        self.advantage.forward(input, raw);
        for (out, &raw) in out.iter_mut().zip(raw.iter()) {
            *out = self.advantage_unit * f64::from(raw);
        }
    }

    /// Changes the units; what was learned stays the same.
    fn set_units(&mut self, (centre, value): (f64, f64), advantage: f64) {
        let shift = (self.centre - centre) / value;
        self.value.rescale_outputs((self.unit / value) as f32, shift as f32);
        self.advantage.rescale_outputs((self.advantage_unit / advantage) as f32, 0.0);
        (self.centre, self.unit, self.advantage_unit) = (centre, value, advantage);
    }
}

/// The judge without copies.
pub struct Critic {
    config: CriticConfig,
    moments: VecDeque<Moment>,
    networks: Option<Networks>,
    streams: Streams,
    drives: u64,
}

impl Critic {
    /// A critic that has seen nothing yet.
    #[must_use]
    pub fn new(config: CriticConfig, streams: &Streams) -> Self {
        Self { config, moments: VecDeque::new(), networks: None, streams: *streams, drives: 0 }
    }

    /// Adds to the log, which forgets its oldest moments.
    fn learn_by_heart(&mut self, moments: Vec<Moment>) {
        self.moments.extend(moments);
        while self.moments.len() > self.config.capacity {
            self.moments.pop_front();
        }
    }

    /// What no future can be worth more or less than, by the rewards seen: networks that are asked where nothing was seen
    /// say anything, and would believe each other.
    fn bounds(&self, drive: &Drive<'_>) -> (f64, f64) {
        let prices: f64 = drive.student.prices().iter().sum();
        let rewards = self.moments.iter().map(|m| m.reward);
        let price = drive.price_share * prices;
        let low = rewards.clone().fold(0.0, f64::min) - price.max(0.0);
        let high = rewards.fold(0.0, f64::max) - price.min(0.0);
        let steps = 1.0 / (1.0 - drive.student.config().gamma);
        (low * steps, high * steps)
    }
}

impl Judge for Critic {
    fn labels(
        &mut self,
        school: &mut School<'_>,
        drive: &Drive<'_>,
        observer: &mut dyn Observer,
    ) -> Result<Labels, CounterfactualError> {
        self.learn_by_heart(log(school, drive, self.config.capacity, observer)?);
        self.drives += 1;
        let streams = self.streams.nth(self.drives);
        if self.moments.is_empty() {
            return Ok(Labels { judged: Vec::new(), trail: Vec::new(), rolled_steps: 0 });
        }
        let shape = (drive.student.layout().width(), drive.student.actions());
        let newborn = || Networks::new(&self.config, shape, &mut self.streams.stream("weights"));
        let networks = self.networks.take().unwrap_or_else(newborn);
        let mut desk = Desk::new(drive, networks, self.bounds(drive), streams.stream("fit"));
        desk.fit(&self.config, &self.moments);
        let judged = desk.judge_some(self.config.labels, &self.moments);
        self.networks = Some(desk.networks);
        Ok(Labels { judged, trail: Vec::new(), rolled_steps: 0 })
    }

    /// Nothing that is seen is wasted: greedy drives are those in which values are learned best.
    fn watch(
        &mut self,
        school: &mut School<'_>,
        drive: &Drive<'_>,
        observer: &mut dyn Observer,
    ) -> Result<(), CounterfactualError> {
        std::mem::swap(&mut school.environment, &mut school.validation);
        let seen = log(school, drive, self.config.capacity, observer);
        std::mem::swap(&mut school.environment, &mut school.validation);
        self.learn_by_heart(seen?);
        Ok(())
    }

    fn freeze(&self) -> Vec<u8> {
        rest::freeze(self)
    }

    fn thaw(&mut self, student: &Student, bytes: &[u8]) -> Result<(), LearnerError> {
        rest::thaw(self, student, bytes)
    }
}

/// One network's targets, and how much each counts.
struct Column {
    targets: Vec<f32>,
    weights: Vec<f32>,
}

/// A batch for both networks.
struct Page {
    inputs: Vec<f32>,
    values: Column,
    moves: Column,
}

impl Page {
    fn new(rows: usize, (width, actions): (usize, usize)) -> Self {
        let column = |n: usize| Column { targets: vec![0.0; n], weights: vec![0.0; n] };
        Self { inputs: vec![0.0; rows * width], values: column(rows), moves: column(rows * actions) }
    }

    fn batch<'p>(&'p self, column: &'p Column) -> Batch<'p> {
        Batch { inputs: &self.inputs, targets: &column.targets, weights: &column.weights }
    }
}

/// Working memory of a critic at work.
struct Desk<'a> {
    student: &'a Student,
    price_share: f64,
    bounds: (f64, f64),
    networks: Networks,
    rng: Rng,
    gaze: Gaze,
    scratch: Scratch,
    input: Vec<f32>,
    next: Vec<f32>,
    raw: Vec<f32>,
    advantages: Vec<f64>,
}

impl<'a> Desk<'a> {
    fn new(drive: &Drive<'a>, networks: Networks, bounds: (f64, f64), rng: Rng) -> Self {
        let student = drive.student;
        let width = student.layout().width();
        Self {
            student,
            price_share: drive.price_share,
            bounds,
            networks,
            rng,
            gaze: Gaze::new(student.layout()),
            scratch: student.scratch(),
            input: vec![0.0; width],
            next: vec![0.0; width],
            raw: vec![0.0; student.actions()],
            advantages: vec![0.0; student.actions()],
        }
    }

    /// Looks after which a moment's move is learned: the student's own, or others if they are remembered.
    fn looks(&mut self, moment: &Moment) -> IndexSet {
        let own = moment.gaze.attended();
        if !self.student.remembers_free_looks() || self.rng.chance(0.5) {
            return own;
        }
        let others = alternatives(self.student, own, &mut self.rng);
        others[self.rng.below(others.len())]
    }

    /// The critic's input for a moment after `looks`: everything, and which of it the student knows.
    fn at(&mut self, moment: &Moment, looks: IndexSet) {
        self.input.copy_from_slice(&moment.full);
        self.student.layout().mark(looks, &mut self.input);
        if let Some(units) = self.student.units() {
            units.apply_to_all(self.student.layout(), &mut self.input);
        }
    }

    /// The move that the student prefers at a moment after `looks`.
    fn preferred_move(&mut self, moment: &Moment, looks: IndexSet) -> usize {
        self.gaze.clone_from(&moment.gaze);
        self.gaze.see_through(self.student.layout(), &moment.full, looks);
        self.student.evaluate(self.gaze.input(), &mut self.scratch);
        self.student.best_move(&self.scratch)
    }

    /// What a moment's move led to after `looks`, by the student's own looks and move at the next one and by what
    /// `teacher` says of it.
    ///
    /// # Formula
    /// y = r + γ ( −share · prices of the next looks m' + V(s', m') )
    fn outcome(&mut self, moment: &Moment, looks: IndexSet, teacher: &Networks) -> f64 {
        let Some(after) = &moment.after else { return moment.reward };
        let layout = self.student.layout();
        self.gaze.clone_from(&moment.gaze);
        self.gaze.see_through(layout, &moment.full, looks);
        self.student.advance(&mut self.gaze, moment.action);
        let mut price = 0.0;
        while let Next::Look(slot) = self.student.next(&mut self.gaze, &mut self.scratch) {
            self.gaze.look_again(layout, slot, after);
            price += self.student.prices()[slot];
        }
        self.next.copy_from_slice(self.gaze.input());
        layout.readings_of_mut(&mut self.next).copy_from_slice(after);
        if let Some(units) = self.student.units() {
            units.apply_to_all(layout, &mut self.next);
        }
        let future =
            (teacher.value(&self.next) - self.price_share * price).clamp(self.bounds.0, self.bounds.1);
        moment.reward + self.student.config().gamma * future
    }

    /// Trains the networks on moments drawn at random.
    fn fit(&mut self, config: &CriticConfig, moments: &VecDeque<Moment>) {
        self.set_units(moments);
        let mut page = Page::new(config.batch, (self.input.len(), self.advantages.len()));
        let mut average: Option<(Networks, usize)> = None;
        for start in (0..config.batches).step_by(config.refresh) {
            let teacher = self.networks.clone();
            for batch in start..(start + config.refresh).min(config.batches) {
                let progress = batch as f64 / config.batches as f64;
                let rate = config.adam.learning_rate * num::pow(config.final_rate, progress) as f32;
                self.networks.value.set_learning_rate(rate);
                self.networks.advantage.set_learning_rate(rate);
                page.moves.weights.fill(0.0);
                for row in 0..config.batch {
                    let moment = &moments[self.rng.below(moments.len())];
                    self.write(&mut page, row, moment, &teacher);
                }
                self.networks.value.train_batch(&page.batch(&page.values));
                self.networks.advantage.train_batch(&page.batch(&page.moves));
                if progress >= 1.0 - config.averaged {
                    let (average, count) = average.get_or_insert_with(|| (self.networks.clone(), 0));
                    *count += 1;
                    average.value.blend(&self.networks.value, 1.0 / *count as f32);
                    average.advantage.blend(&self.networks.advantage, 1.0 / *count as f32);
                }
            }
        }
        if let Some((average, _)) = average {
            self.networks = average;
        }
    }

    /// Writes a moment into a batch.
    fn write(&mut self, page: &mut Page, row: usize, moment: &Moment, teacher: &Networks) {
        let looks = self.looks(moment);
        let (value, advantage) = self.targets(moment, looks, teacher);
        let width = self.input.len();
        page.inputs[row * width..(row + 1) * width].copy_from_slice(&self.input);
        page.values.targets[row] =
            ((value.unwrap_or(0.0) - self.networks.centre) / self.networks.unit) as f32;
        page.values.weights[row] = f32::from(u8::from(value.is_some()));
        let place = row * self.advantages.len() + moment.action;
        page.moves.targets[place] = (advantage / self.networks.advantage_unit) as f32;
        page.moves.weights[place] = 1.0;
    }

    /// Targets of V and A at a moment after `looks`, whose input is left in `self.input`; none of V where the student knew
    /// something else or would have moved otherwise.
    ///
    /// # Formula
    /// V(s) ← y(own looks)  if a = π;  A(s, m, a) ← y(m) − V(s)
    fn targets(&mut self, moment: &Moment, looks: IndexSet, teacher: &Networks) -> (Option<f64>, f64) {
        let own = moment.gaze.attended();
        let outcome = self.outcome(moment, looks, teacher);
        let typical = looks == own && self.preferred_move(moment, looks) == moment.action;
        self.at(moment, own);
        let base = teacher.value(&self.input);
        self.at(moment, looks);
        (typical.then_some(outcome), outcome - base)
    }

    /// Units in which targets are about 1, from a sample of moments.
    fn set_units(&mut self, moments: &VecDeque<Moment>) {
        const SAMPLE: usize = 1000;
        let teacher = self.networks.clone();
        let unit = self.student.config().fit.unit;
        let (mut values, mut squares, mut advantages) = (Mean::default(), Mean::default(), Mean::default());
        for _ in 0..SAMPLE {
            let moment = &moments[self.rng.below(moments.len())];
            let (value, advantage) = self.targets(moment, moment.gaze.attended(), &teacher);
            if let Some(value) = value {
                values.add(value);
                squares.add(value * value);
            }
            advantages.add(unit.size(advantage));
        }
        let centre = values.mean();
        let spread = (squares.mean() - centre * centre).max(0.0).sqrt();
        let advantage = unit.of(advantages.mean());
        self.networks.set_units((centre, spread.max(SMALLEST)), advantage.max(SMALLEST));
    }

    /// Labels for at most `most` moments, drawn at random.
    fn judge_some(&mut self, most: usize, moments: &VecDeque<Moment>) -> Vec<Judged> {
        if moments.len() <= most {
            return moments.iter().map(|m| self.judge(m)).collect();
        }
        (0..most)
            .map(|_| {
                let at = self.rng.below(moments.len());
                self.judge(&moments[at])
            })
            .collect()
    }

    fn judge(&mut self, moment: &Moment) -> Judged {
        let own = moment.gaze.attended();
        self.at(moment, own);
        let base = self.networks.value(&self.input);
        self.networks.advantages(&self.input, &mut self.raw, &mut self.advantages);
        let best = num::max(&self.advantages);
        let advantages = self.advantages.iter().map(|a| a - best).collect();
        let stops = self.stops(moment, best);
        let value = base + best;
        Judged {
            full: moment.full.clone(),
            clock: moment.gaze.clock(),
            looks: own,
            advantages,
            value,
            stops,
            appointments: None,
        }
    }

    /// What moving is worth after the student's own looks and after others, if that makes a difference.
    fn stops(&mut self, moment: &Moment, best: f64) -> Vec<Stop> {
        if !self.student.remembers_free_looks() {
            return Vec::new();
        }
        let own = moment.gaze.attended();
        let mut stops: Vec<Stop> = Vec::new();
        for looks in std::iter::once(own).chain(alternatives(self.student, own, &mut self.rng)) {
            if stops.iter().all(|s| s.looks != looks) {
                let action = self.preferred_move(moment, looks);
                self.at(moment, looks);
                self.networks.advantages(&self.input, &mut self.raw, &mut self.advantages);
                stops.push(Stop { looks, worth: self.advantages[action] - best });
            }
        }
        stops
    }
}

/// Looks that a student who looked at `own` could have taken instead: all that there are, if they are few.
fn alternatives(student: &Student, own: IndexSet, rng: &mut Rng) -> Vec<IndexSet> {
    const FEW: usize = 4;
    let kept = student.kept();
    if kept.len() > FEW {
        return other_looks(student, own, rng).to_vec();
    }
    let some = |bits: usize| {
        let chosen = kept.iter().enumerate().filter(|(i, _)| bits >> i & 1 == 1);
        chosen.map(|(_, slot)| slot).collect::<IndexSet>().union(student.gifts())
    };
    (0..1usize << kept.len()).map(some).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::counterfactual::config::CounterfactualConfig;
    use crate::counterfactual::student::StudentShape;
    use crate::counterfactual::student::gaze::MemoryConfig;
    use crate::counterfactual::student::rule::Rule;

    /// Two slots, the first tells the state (0 or 1); it is looked at every time, for 0.5.
    fn student(rule: Rule, memory: MemoryConfig) -> Student {
        let config = CounterfactualConfig { gamma: 0.5, memory, ..CounterfactualConfig::default() };
        let shape = StudentShape { blocks: vec![1, 1], prices: vec![0.5, 4.0], actions: 2, rule };
        Student::new(&config, &shape, &Streams::new(3)).unwrap()
    }

    fn drive(student: &Student) -> Drive<'_> {
        let phase = crate::phase::Phase::evaluation("drive", IndexSet::first(2), 0);
        Drive { student, driver: student, phase, limit: 10, price_share: 1.0, streams: Streams::new(5) }
    }

    /// In state 0, action 1 leads to state 1 for −1 and action 0 stays for −2; from state 1 everything ends with −4.
    fn moments(student: &Student) -> VecDeque<Moment> {
        let looked = |state: f64| {
            let mut gaze = Gaze::new(student.layout());
            gaze.look(student.layout(), 0, &[state]);
            let mut full = gaze.clone();
            full.look(student.layout(), 1, &[0.3]);
            (gaze, full.input().to_vec())
        };
        let step = |state: f64, action: usize, reward: f64, next: Option<f64>| {
            let (gaze, full) = looked(state);
            let after = next.map(|next| vec![next as f32, 0.3]);
            Moment { gaze, full, action, reward, after }
        };
        let three = [
            step(0.0, 0, -2.0, Some(0.0)),
            step(0.0, 1, -1.0, Some(1.0)),
            step(1.0, 0, -4.0, None),
            step(1.0, 1, -4.0, None),
        ];
        three.into_iter().collect()
    }

    fn critic(student: &Student) -> (Vec<Judged>, (f64, f64)) {
        let config = CriticConfig { batches: 3000, batch: 16, refresh: 50, ..CriticConfig::default() };
        let drive = drive(student);
        let critic = Critic { moments: moments(student), ..Critic::new(config.clone(), &Streams::new(1)) };
        let bounds = critic.bounds(&drive);
        let shape = (student.layout().width(), 2);
        let networks = Networks::new(&config, shape, &mut Streams::new(1).stream("weights"));
        let mut desk = Desk::new(&drive, networks, bounds, Streams::new(2).stream("fit"));
        desk.fit(&config, &critic.moments);
        (desk.judge_some(100, &critic.moments), bounds)
    }

    #[test]
    fn moves_are_worth_what_the_student_then_earns_and_pays() {
        let rule = Rule::Scheduled { slots: IndexSet::EMPTY.with(0), every: 1 };
        let student = student(rule, MemoryConfig::default());
        let (judged, bounds) = critic(&student);
        let mut scratch = student.scratch();
        student.evaluate(judged[0].full.as_slice(), &mut scratch);
        let mut gaze = Gaze::new(student.layout());
        gaze.look(student.layout(), 0, &[0.0]);
        student.evaluate(gaze.input(), &mut scratch);
        // γ = 1/2, and a look at slot 0 costs 1/2 after every move: −1 + ½(−½ − 4) = −3.25 for leaving,
        // −2 + ½(−½ + V) for staying, where V is what the student itself does.
        let leaving: f64 = -1.0 + 0.5 * (-0.5 - 4.0);
        let stays = student.best_move(&scratch) == 0;
        let own = if stays { -2.25 / 0.5 } else { leaving };
        let staying = -2.0 + 0.5 * (-0.5 + own);
        let near = |is: f64, should: f64| (is - should).abs() < 0.15;
        let best = leaving.max(staying);
        assert!(near(judged[0].value, best), "{} for {best}", judged[0].value);
        let advantages = [staying - best, leaving - best];
        assert!(judged[0].advantages.iter().zip(advantages).all(|(&a, b)| near(a, b)), "{:?}", judged[0]);
        assert!(near(judged[2].value, -4.0), "{:?}", judged[2]);
        assert_eq!((judged[0].stops.len(), judged[0].looks), (0, IndexSet::EMPTY.with(0)));
        assert_eq!(bounds, (2.0 * (-4.0 - 4.5), 0.0));
    }

    #[test]
    fn with_memory_all_looks_that_there_are_are_judged() {
        let rule = Rule::Adaptive { min_looks: 0, max_looks: 2 };
        let student = student(rule, MemoryConfig { looks: 1, steps: 3, ..MemoryConfig::default() });
        let (judged, _) = critic(&student);
        for own in judged {
            let looks: Vec<IndexSet> = own.stops.iter().map(|s| s.looks).collect();
            assert_eq!((looks.len(), looks[0]), (4, own.looks));
            assert!(own.stops[0].worth <= 0.0, "no move of its own is better than the best");
        }
    }

    #[test]
    fn impossible_settings_are_named() {
        let field = |config: CriticConfig| match config.validate() {
            Err(LearnerError::Setting { field, .. }) => field,
            other => panic!("{other:?}"),
        };
        assert_eq!(CriticConfig::default().validate(), Ok(()));
        assert_eq!(field(CriticConfig { capacity: 0, ..CriticConfig::default() }), "judge.critic.capacity");
        assert_eq!(field(CriticConfig { hidden: vec![0], ..CriticConfig::default() }), "judge.critic.hidden");
        let fading = CriticConfig { final_rate: 0.0, ..CriticConfig::default() };
        assert_eq!(field(fading), "judge.critic.final_rate");
        let forgetful = CriticConfig { averaged: 1.0, ..CriticConfig::default() };
        assert_eq!(field(forgetful), "judge.critic.averaged");
        let adam = Adam { learning_rate: f32::NAN, ..Adam::default() };
        let named = "judge.critic.adam.learning_rate";
        assert_eq!(field(CriticConfig { adam, ..CriticConfig::default() }), named);
    }
}
