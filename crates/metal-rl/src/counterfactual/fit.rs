//! Fitting the student to labels: moves by regression on what they would have been worth, looks by replay.

use super::config::{FitConfig, Unit};
use super::judge::Judged;
use super::student::mixture;
use super::student::rule::Rule;
use super::student::{Scale, Scratch, Student};
use crate::learners::nn::{Batch, Network};
use crate::num;
use crate::random::{Rng, Streams};
use crate::set::IndexSet;

/// Smallest unit, against labels that are all alike.
pub(super) const SMALLEST: f64 = 1e-3;

/// Trains every network of `student`, or its mixture, on `data`; returns the mean loss of moves and looks over the last half.
///
/// # Formula
/// move a, seen through mask m: Q(s, a) − max Q(s, ·);  value: max Q(s, ·);
/// moving now: what the move that a copy of the student prefers turned out to be worth
/// look i at mask m: −share · priceᵢ + max( moving now, open looks | m + i ),  on the same state, by that copy
///
/// # Panics
/// If there is no data.
pub fn fit(student: &mut Student, data: &[&Judged], price_share: f64, streams: &Streams) -> f64 {
    assert!(!data.is_empty(), "there must be something to learn from");
    if student.believer().is_some() {
        return super::student::believer::fit(student, data, streams);
    }
    if let Some(config) = student.config().mixture.clone() {
        return mixture::fit(student, &config, (data, price_share), streams);
    }
    let settings = student.config().fit.clone();
    let rate = student.config().network.adam.learning_rate;
    let lesson = |name: &str, n: usize, outputs: usize| {
        Lesson::new(student, (outputs, settings.batch), streams.child(name).nth(n as u64).stream("fit"))
    };
    let choices = student.stop() + 1;
    let mut pupils: Vec<Lesson> =
        (0..student.config().network.ensemble).map(|n| lesson("choices", n, choices)).collect();
    let mut value = lesson("value", 0, 1);
    let mut loss = Mean::default();
    for start in (0..settings.batches).step_by(settings.refresh) {
        let teacher = student.clone();
        for batch in start..(start + settings.refresh).min(settings.batches) {
            let pace = Pace::new(&settings, rate, batch);
            for (n, pupil) in pupils.iter_mut().enumerate() {
                pupil.draw_choices(&teacher, data, price_share);
                let error = pupil.train(&mut student.networks_mut().choices[n], pace);
                if 2 * batch >= settings.batches {
                    loss.add(error);
                }
            }
            value.draw_values(&teacher, data);
            value.train(&mut student.networks_mut().value, pace);
        }
    }
    for (pupil, network) in pupils.into_iter().zip(&mut student.networks_mut().choices) {
        pupil.hand_over(network);
    }
    value.hand_over(&mut student.networks_mut().value);
    loss.mean()
}

/// As [`fit`], after the units of the student were taken from the labels: for whoever has labels of its own.
///
/// # Panics
/// If there is no data.
pub fn learn(student: &mut Student, data: &[&Judged], price_share: f64, streams: &Streams) -> f64 {
    let unit = student.config().fit.unit;
    student.set_scale(scale(data, unit));
    fit(student, data, price_share, streams)
}

/// A running mean.
#[derive(Default)]
pub(super) struct Mean {
    sum: f64,
    count: f64,
}

impl Mean {
    pub(super) fn add(&mut self, x: f64) {
        self.sum += x;
        self.count += 1.0;
    }

    pub(super) fn mean(&self) -> f64 {
        self.sum / self.count.max(1.0)
    }
}

/// The units in which labels are about 1.
pub(super) fn scale(data: &[&Judged], unit: Unit) -> Scale {
    let n = data.len().max(1) as f64;
    let centre = data.iter().map(|j| j.value).sum::<f64>() / n;
    let variance = data.iter().map(|j| (j.value - centre) * (j.value - centre)).sum::<f64>() / n;
    let size = |j: &&Judged| {
        j.advantages.iter().map(|&a| unit.size(a)).sum::<f64>() / j.advantages.len().max(1) as f64
    };
    let advantage = unit.of(data.iter().map(size).sum::<f64>() / n);
    Scale { advantage: advantage.max(SMALLEST), value: variance.sqrt().max(SMALLEST), centre }
}

/// How far and how a training step goes.
#[derive(Clone, Copy)]
struct Pace {
    rate: f32,
    decay: f32,
    averaged: bool,
}

impl Pace {
    fn new(settings: &FitConfig, rate: f32, batch: usize) -> Self {
        let progress = batch as f64 / settings.batches as f64;
        let rate = rate * num::pow(settings.final_rate, progress) as f32;
        let averaged = progress >= 1.0 - settings.averaged;
        Self { rate, decay: rate * settings.weight_decay as f32, averaged }
    }
}

/// One network's batches.
pub(super) struct Lesson {
    rng: Rng,
    rows: usize,
    width: usize,
    outputs: usize,
    inputs: Vec<f32>,
    targets: Vec<f32>,
    weights: Vec<f32>,
    masked: Vec<f32>,
    scratch: Scratch,
    average: Option<(Network, usize)>,
}

impl Lesson {
    /// Batches of `rows` samples; one output more than there are choices holds the values of states.
    pub fn new(student: &Student, (outputs, rows): (usize, usize), rng: Rng) -> Self {
        let width = student.layout().width();
        Self {
            rng,
            rows,
            width,
            outputs,
            inputs: vec![0.0; rows * width],
            targets: vec![0.0; rows * outputs],
            weights: vec![0.0; rows * outputs],
            masked: vec![0.0; width],
            scratch: student.scratch(),
            average: None,
        }
    }

    /// One training step on the batch.
    fn train(&mut self, network: &mut Network, pace: Pace) -> f64 {
        network.set_learning_rate(pace.rate);
        network.decay(pace.decay);
        let batch = Batch { inputs: &self.inputs, targets: &self.targets, weights: &self.weights };
        let loss = network.train_batch(&batch);
        if pace.averaged {
            let (average, count) = self.average.get_or_insert_with(|| (network.clone(), 0));
            *count += 1;
            average.blend(network, 1.0 / *count as f32);
        }
        loss
    }

    /// The end of the fit: the average of the last weights, if there is one, takes the place of the last.
    fn hand_over(self, network: &mut Network) {
        if let Some((average, _)) = self.average {
            *network = average;
        }
    }

    /// A state drawn at random, written into the batch as seen through a mask.
    fn draw<'d>(&mut self, row: usize, teacher: &Student, data: &[&'d Judged]) -> (&'d Judged, IndexSet) {
        let judged = data[self.rng.below(data.len())];
        let mask = self.mask(teacher, judged);
        let place = row * self.width..(row + 1) * self.width;
        teacher.layout().mask(&judged.full, mask, &mut self.inputs[place]);
        (judged, mask)
    }

    /// Inputs, targets and weights of the batch.
    pub fn rows(&self) -> (&[f32], &[f32], &[f32]) {
        (&self.inputs, &self.targets, &self.weights)
    }

    /// Fills the batch with what moves and looks are worth.
    pub fn draw_choices(&mut self, teacher: &Student, data: &[&Judged], price_share: f64) {
        self.weights.fill(0.0);
        let unit = teacher.scale().advantage;
        for row in 0..self.rows {
            let (judged, mask) = self.draw(row, teacher, data);
            for (action, advantage) in judged.advantages.iter().enumerate() {
                self.label((row, action), advantage / unit, 1.0);
            }
            if let Some(made) = judged.appointments.as_ref().filter(|made| made.looks == mask) {
                for kept in &made.kept {
                    let output = teacher.actions() + teacher.diary().index(kept.appointment);
                    self.label((row, output), kept.worth / unit, 1.0);
                }
            }
            if self.outputs > teacher.stop() + 1 {
                let scale = teacher.scale();
                self.label((row, teacher.stop() + 1), (judged.value - scale.centre) / scale.value, 1.0);
            }
            if !teacher.open_looks(mask).is_empty() {
                let now = self.label_stop(row, (judged, mask), teacher);
                for _ in 0..teacher.config().fit.looks_per_sample {
                    self.label_look(row, (judged, mask), teacher, (price_share, now));
                }
            }
            self.convert(row, teacher);
        }
    }

    /// Fills the batch with values of states.
    fn draw_values(&mut self, teacher: &Student, data: &[&Judged]) {
        let scale = teacher.scale();
        for row in 0..self.rows {
            let (judged, _) = self.draw(row, teacher, data);
            self.label((row, 0), (judged.value - scale.centre) / scale.value, 1.0);
            self.convert(row, teacher);
        }
    }

    /// Brings a row to the student's units, in which its networks see it.
    fn convert(&mut self, row: usize, student: &Student) {
        if let Some(units) = student.units() {
            units.apply(student.layout(), &mut self.inputs[row * self.width..(row + 1) * self.width]);
        }
    }

    fn label(&mut self, (row, output): (usize, usize), target: f64, weight: f32) {
        let at = row * self.outputs + output;
        self.targets[at] = target as f32;
        self.weights[at] = weight;
    }

    /// What the move that the teacher prefers turned out to be worth; returns what looks are valued against there, and how
    /// much such a label counts.
    fn label_stop(
        &mut self,
        row: usize,
        (judged, mask): (&Judged, IndexSet),
        teacher: &Student,
    ) -> (f64, f32) {
        teacher.evaluate(&self.inputs[row * self.width..(row + 1) * self.width], &mut self.scratch);
        let (worth, exact) = judged.stop(mask, teacher.best_move(&self.scratch));
        let weight = if exact { 1.0 } else { teacher.config().fit.inexact as f32 };
        self.label((row, teacher.stop()), worth / teacher.scale().advantage, weight);
        if teacher.config().fit.relative { (worth, weight) } else { (0.0, 1.0) }
    }

    /// One look that is open at the mask, drawn at random; `now` is what [`Self::label_stop`] returned.
    fn label_look(
        &mut self,
        row: usize,
        (judged, mask): (&Judged, IndexSet),
        teacher: &Student,
        (price_share, (now, weight)): (f64, (f64, f32)),
    ) {
        let open = teacher.open_looks(mask);
        let Some(slot) = open.iter().nth(self.rng.below(open.len())) else { return };
        let work = (&mut self.masked[..], &mut self.scratch);
        let worth = look_worth(teacher, judged, (mask, slot), price_share, work);
        self.label((row, teacher.actions() + slot), (worth - now) / teacher.scale().advantage, weight);
    }

    /// The looks through which a state is seen: those of the rule; else some that the teacher would take itself, or
    /// any.
    fn mask(&mut self, teacher: &Student, judged: &Judged) -> IndexSet {
        let looks = match teacher.rule() {
            Rule::Scheduled { .. } => teacher.rule().due(judged.clock).unwrap_or_default(),
            Rule::Appointed { max_looks, .. } => {
                if self.rng.chance(teacher.config().fit.own_looks) {
                    judged.appointments.as_ref().map_or(judged.looks, |made| made.looks)
                } else {
                    self.any_looks(teacher.kept(), max_looks)
                }
            }
            Rule::Adaptive { max_looks, .. } => {
                let open = teacher.config().fit.open_eyes;
                if open > 0.0 && teacher.is_wide_eyed() && self.rng.chance(open) {
                    return IndexSet::first(teacher.layout().slots());
                }
                if self.rng.chance(teacher.config().fit.own_looks) {
                    if !judged.stops.is_empty() && self.rng.chance(0.5) {
                        return judged.stops[self.rng.below(judged.stops.len())].looks;
                    }
                    self.own_looks(teacher, judged)
                } else {
                    let more = teacher.config().fit.more_than_allowed;
                    self.any_looks(teacher.kept(), if more { teacher.kept().len() } else { max_looks })
                }
            }
        };
        looks.union(teacher.gifts())
    }

    fn any_looks(&mut self, among: IndexSet, most: usize) -> IndexSet {
        let size = self.rng.below(most.min(among.len()) + 1);
        let mut mask = IndexSet::EMPTY;
        while mask.len() < size {
            let open = among.minus(mask);
            mask = open.iter().nth(self.rng.below(open.len())).map_or(among, |slot| mask.with(slot));
        }
        mask
    }

    /// A stop on the way of the teacher's own looks, every stop with the same probability.
    fn own_looks(&mut self, teacher: &Student, judged: &Judged) -> IndexSet {
        let (mut mask, mut chosen, mut stops) = (teacher.gifts(), teacher.gifts(), 1.0);
        loop {
            teacher.layout().mask(&judged.full, mask, &mut self.masked);
            teacher.evaluate(&self.masked, &mut self.scratch);
            match teacher.preferred_look(mask, &self.scratch) {
                Some((slot, _)) => mask = mask.with(slot),
                None => return chosen,
            }
            stops += 1.0;
            if self.rng.chance(1.0 / stops) {
                chosen = mask;
            }
        }
    }
}

/// What looking at `slot` is worth where `mask` has been seen: its price, and the best that is known with it.
///
/// With λ, the teacher's expectation gives way to what its further looks and its move earn on this very state.
fn look_worth(
    teacher: &Student,
    judged: &Judged,
    (mask, slot): (IndexSet, usize),
    price_share: f64,
    (masked, scratch): (&mut [f32], &mut Scratch),
) -> f64 {
    let lambda = teacher.config().fit.lambda;
    let (mut after, mut spent) = (mask.with(slot), price_share * teacher.prices()[slot]);
    let mut expected = None;
    loop {
        teacher.layout().mask(&judged.full, after, masked);
        teacher.evaluate(masked, scratch);
        let look = teacher.preferred_look(after, scratch);
        let best = teacher.expected(look, scratch) - spent;
        let expected = *expected.get_or_insert(best);
        if lambda <= 0.0 {
            return expected;
        }
        let Some((next, _)) = look else {
            let (worth, exact) = judged.stop(after, teacher.best_move(scratch));
            let lambda = if exact { lambda } else { 0.0 };
            return (1.0 - lambda) * expected + lambda * (worth - spent);
        };
        after = after.with(next);
        spent += price_share * teacher.prices()[next];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::counterfactual::config::{CounterfactualConfig, FitConfig};
    use crate::counterfactual::student::StudentShape;

    fn student(rule: Rule, fit: FitConfig) -> Student {
        let shape = StudentShape { blocks: vec![1, 1], prices: vec![2.0, 0.5], actions: 2, rule };
        let config = CounterfactualConfig { fit, ..CounterfactualConfig::default() };
        Student::new(&config, &shape, &Streams::new(3)).unwrap()
    }

    /// A state whose right move is told by the first reading; the second one tells nothing.
    fn state(bit: bool, noise: f32) -> Judged {
        let right = usize::from(bit);
        let advantages = (0..2).map(|a| if a == right { 0.0 } else { -10.0 }).collect();
        Judged {
            full: vec![right as f32, noise, 1.0, 1.0],
            clock: 0,
            looks: IndexSet::EMPTY,
            advantages,
            value: -3.0,
            stops: Vec::new(),
            appointments: None,
        }
    }

    const FREE: Rule = Rule::Adaptive { min_looks: 0, max_looks: 2 };

    #[test]
    fn a_look_is_worth_what_is_known_after_it_less_its_price() {
        let student = student(FREE, FitConfig { lambda: 0.0, ..FitConfig::default() });
        let (judged, mut masked) = (state(true, 0.4), vec![0.0; 4]);
        let (mut scratch, mut again) = (student.scratch(), student.scratch());
        let worth = look_worth(&student, &judged, (IndexSet::EMPTY, 1), 0.5, (&mut masked, &mut scratch));
        student.evaluate(&[0.0, 0.4, 0.0, 1.0], &mut again);
        // Moving now, or a look at slot 0; slot 1 has been looked at.
        let best = again.values[2].max(again.values[4]);
        assert_eq!(worth, best - 0.5 * 0.5);
    }

    #[test]
    fn with_lambda_it_is_worth_what_the_teacher_then_earns_on_this_very_state() {
        let rule = Rule::Adaptive { min_looks: 0, max_looks: 1 };
        let student = student(rule, FitConfig { lambda: 1.0, ..FitConfig::default() });
        let (judged, mut masked, mut scratch) = (state(true, 0.4), vec![0.0; 4], student.scratch());
        let worth = look_worth(&student, &judged, (IndexSet::EMPTY, 0), 1.0, (&mut masked, &mut scratch));
        student.evaluate(&[1.0, 0.0, 1.0, 0.0], &mut scratch);
        assert_eq!(worth, judged.advantages[student.best_move(&scratch)] - 2.0);
    }

    /// A student taught on states whose right move only slot 0 tells, and its values where nothing was seen.
    fn taught(relative: bool) -> (Student, Scratch) {
        let settings = FitConfig { batches: 800, batch: 32, refresh: 50, relative, ..FitConfig::default() };
        let mut student = student(FREE, settings);
        let states: Vec<Judged> = (0..40).map(|i| state(i % 2 == 0, (i * 7 % 10) as f32 / 10.0)).collect();
        let data: Vec<&Judged> = states.iter().collect();
        student.set_scale(scale(&data, Unit::default()));
        fit(&mut student, &data, 1.0, &Streams::new(1));
        let mut scratch = student.scratch();
        student.evaluate(&[0.0; 4], &mut scratch);
        (student, scratch)
    }

    fn near(value: f64, expected: f64) -> bool {
        (value - expected).abs() < 0.7
    }

    #[test]
    fn the_look_that_tells_is_learned_and_the_other_is_not_bought() {
        let (student, scratch) = taught(false);
        assert!(near(scratch.values[0], -5.0) && near(scratch.values[1], -5.0), "{:?}", scratch.values);
        assert!(
            near(scratch.values[2], -2.0),
            "what it tells is worth 5, its price is 2: {:?}",
            scratch.values
        );
        assert!(
            near(scratch.values[3], -2.5),
            "tells nothing, but the other may follow: {:?}",
            scratch.values
        );
        assert_eq!(student.preferred_look(IndexSet::EMPTY, &scratch).map(|(slot, _)| slot), Some(0));
    }

    #[test]
    fn looks_may_be_valued_by_what_they_add_to_moving_at_once() {
        let (student, mut scratch) = taught(true);
        assert!(near(scratch.values[4], -5.0), "moving at once is worth the same: {:?}", scratch.values);
        assert!(near(scratch.values[2], 3.0) && near(scratch.values[3], 2.5), "{:?}", scratch.values);
        let look = student.preferred_look(IndexSet::EMPTY, &scratch);
        assert_eq!(look.map(|(slot, _)| slot), Some(0));
        assert!(near(student.expected(look, &scratch), -2.0));
        student.evaluate(&[1.0, 0.0, 1.0, 0.0], &mut scratch);
        let seen = IndexSet::EMPTY.with(0);
        assert_eq!(
            student.preferred_look(seen, &scratch),
            None,
            "the other adds nothing: {:?}",
            scratch.values
        );
    }

    #[test]
    fn a_change_of_units_keeps_what_was_learned() {
        let mut student = student(FREE, FitConfig::default());
        let (mut before, mut after) = (student.scratch(), student.scratch());
        student.evaluate(&[0.3; 4], &mut before);
        student.set_scale(Scale { advantage: 7.0, value: 20.0, centre: -50.0 });
        student.evaluate(&[0.3; 4], &mut after);
        for (b, a) in before.values.iter().zip(&after.values) {
            assert!((b - a).abs() < 1e-5);
        }
    }
}
