//! Fitting a mixture to labels: first the density of what was seen, then what moves and looks are worth, in rounds.

use super::blocks::Blocks;
use super::config::MixtureConfig;
use super::density::Density;
use super::em::{Moments, Prior, sweep};
use super::heads::{Heads, Labels, Sums, largest};
use super::information::Information;
use super::start::{newborn, start};
use super::{HINTS, Knowledge, Mixture, Work, shape};
use crate::counterfactual::fit::Lesson;
use crate::counterfactual::judge::Judged;
use crate::counterfactual::student::Student;
use crate::counterfactual::student::rule::Rule;
use crate::random::{Rng, Streams};

/// Share that the draws of one round count in the next.
const KEPT: f64 = 0.3;

/// A component with a smaller share of an equal part of all moments begins anew somewhere else.
const DESERTED: f64 = 0.05;

/// Teaches the student's mixture; returns the mean loss of moves and looks on the draws of the last round, by what was
/// learned before it.
pub(in crate::counterfactual) fn fit(
    student: &mut Student,
    config: &MixtureConfig,
    (data, price_share): (&[&Judged], f64),
    streams: &Streams,
) -> f64 {
    let mut knowledge = learn_density(student, config, data, streams);
    let unit = student.scale().advantage;
    knowledge.prices = student.prices().iter().map(|price| price_share * price / unit).collect();
    let mut lesson = Lesson::new(student, (student.stop() + 2, 1), streams.stream("lessons"));
    let mut sums = Sums::new(knowledge.heads.shape(), knowledge.density.components());
    // Who knows nothing judges looks by what it would do without knowing anything: that is soon forgotten.
    let mut kept = if student.mixture().is_some_and(Mixture::knows_something) { KEPT } else { 0.0 };
    let mut loss = 0.0;
    for _ in 0..config.rounds {
        let pages = draw(&mut lesson, student, (data, price_share), config.draws);
        loss = pages.loss(student);
        let mut desk =
            Desk { actions: student.actions(), stop: student.stop(), config, work: Work::default() };
        desk.learn_moves(&pages, &mut knowledge, &mut sums);
        desk.learn_looks(&pages, &mut knowledge, &mut sums);
        sums.fade(kept);
        kept = KEPT;
        if let Some(mixture) = student.mixture_mut() {
            mixture.knowledge = Some(knowledge.clone());
        }
    }
    loss
}

/// The density of the moments, from the one before if there is one of this shape; local values are still 0.
fn learn_density(
    student: &Student,
    config: &MixtureConfig,
    data: &[&Judged],
    streams: &Streams,
) -> Knowledge {
    let visible = match student.rule() {
        Rule::Adaptive { .. } | Rule::Appointed { .. } => student.kept().union(student.gifts()),
        Rule::Scheduled { slots, .. } => slots,
    };
    let (actions, slots) = (student.actions(), student.layout().slots());
    let blocks = Blocks::new(student.layout(), visible, actions);
    let moments = moments(student, &blocks, data);
    let prior = Prior::of(&moments, &blocks.ranges(), config.least_noise * config.least_noise, config.prior);
    let mut rng = streams.stream("density");
    let old = student.mixture().and_then(|m| m.knowledge.as_ref()).filter(|old| old.blocks == blocks);
    let (mut density, sweeps) = match old {
        Some(old) => (old.density.clone(), config.sweeps),
        None => {
            let shape = (blocks.ranges(), config.factors, config.components);
            (start(shape, &moments, &prior, &mut rng), config.first_sweeps)
        }
    };
    for round in 0..sweeps {
        let (_, masses) = sweep(&mut density, &moments, &prior);
        if round < sweeps / 2 {
            resettle(&mut density, &masses, (&moments, &prior), &mut rng);
        }
    }
    let information =
        Information::of((&blocks, config.codewords, slots), &density, (&moments, &prior), &mut rng);
    let heads = Heads::new(shape(&blocks, config.factors, actions, slots), density.components());
    let relative = student.config().fit.relative;
    Knowledge { blocks, density, information, heads, prices: vec![0.0; slots], relative }
}

/// Everything that was judged, as features.
fn moments(student: &Student, blocks: &Blocks, data: &[&Judged]) -> Moments {
    let (width, parts) = (blocks.width(), blocks.ranges().len());
    let mut moments = Moments {
        features: vec![0.0; data.len() * width],
        seen: vec![false; data.len() * parts],
        count: data.len(),
    };
    let (mut input, unit) = (vec![0.0; student.layout().width()], student.scale().advantage);
    let rows = moments.features.chunks_exact_mut(width).zip(moments.seen.chunks_exact_mut(parts));
    for ((x, seen), judged) in rows.zip(data) {
        input.copy_from_slice(&judged.full);
        if let Some(units) = student.units() {
            units.apply(student.layout(), &mut input);
        }
        blocks.read(&input, x, seen);
        seen[parts - 1] = true;
        for (x, advantage) in x[blocks.targets()].iter_mut().zip(&judged.advantages) {
            *x = advantage / unit;
        }
    }
    moments
}

/// Components that hardly anything belongs to begin anew at moments drawn at random.
fn resettle(density: &mut Density, masses: &[f64], (moments, prior): (&Moments, &Prior), rng: &mut Rng) {
    let fair = moments.count as f64 / masses.len() as f64;
    let (blocks, factors) = (density.blocks().to_vec(), density.factors());
    for c in (0..masses.len()).filter(|&c| masses[c] < DESERTED * fair) {
        let place = moments.row(rng.below(moments.count));
        let weight = 1.0 / masses.len() as f64;
        density.set(c, &newborn((&blocks, factors, weight), place, prior, rng));
    }
}

/// Draws of one round: inputs with what moves, looks, moving now and the state turned out to be worth.
struct Pages {
    width: usize,
    outputs: usize,
    inputs: Vec<f32>,
    targets: Vec<f32>,
    weights: Vec<f32>,
}

fn draw(
    lesson: &mut Lesson,
    teacher: &Student,
    (data, price_share): (&[&Judged], f64),
    draws: usize,
) -> Pages {
    let (width, outputs) = (teacher.layout().width(), teacher.stop() + 2);
    let mut pages = Pages { width, outputs, inputs: vec![], targets: vec![], weights: vec![] };
    for _ in 0..draws {
        lesson.draw_choices(teacher, data, price_share);
        let (inputs, targets, weights) = lesson.rows();
        pages.inputs.extend_from_slice(inputs);
        pages.targets.extend_from_slice(targets);
        pages.weights.extend_from_slice(weights);
    }
    pages
}

/// A label and its weight, by output.
type Page<'a> = (&'a [f32], &'a [f32], &'a [f32]);

impl Pages {
    fn rows(&self) -> impl Iterator<Item = Page<'_>> {
        let labels = self.targets.chunks_exact(self.outputs).zip(self.weights.chunks_exact(self.outputs));
        self.inputs
            .chunks_exact(self.width)
            .zip(labels)
            .map(|(input, (target, weight))| (input, target, weight))
    }

    /// Half the mean squared error of moves and looks, by what the student knows.
    fn loss(&self, student: &Student) -> f64 {
        let Some(mixture) = student.mixture() else { return 0.0 };
        let (mut work, mut values) = (Work::default(), vec![0.0; self.outputs - 1]);
        let mut sum = 0.0;
        for (input, targets, weights) in self.rows() {
            mixture.evaluate(input, &mut values, &mut work);
            for ((value, &target), &weight) in values.iter().zip(targets).zip(weights) {
                let error = value - f64::from(target);
                sum += 0.5 * f64::from(weight) * error * error;
            }
        }
        sum / (self.targets.len() / self.outputs).max(1) as f64
    }
}

/// Where local values are fitted.
struct Desk<'a> {
    actions: usize,
    stop: usize,
    config: &'a MixtureConfig,
    work: Work,
}

impl Desk<'_> {
    /// The group of an output: moves and the value of the state, moving now, looks.
    fn group(&self, output: usize) -> usize {
        if output < self.actions || output > self.stop {
            0
        } else if output == self.stop {
            1
        } else {
            2 + output - self.actions
        }
    }

    fn learn_moves(&mut self, pages: &Pages, knowledge: &mut Knowledge, sums: &mut Sums) {
        for (input, targets, weights) in pages.rows() {
            knowledge.infer(input, &mut self.work);
            let known = (0..targets.len()).filter(|&o| self.group(o) == 0 && weights[o] > 0.0);
            let labels: Vec<(usize, f64)> = known.map(|o| (o, f64::from(targets[o]))).collect();
            for i in 0..self.work.belief.active.len() {
                let (c, share) = self.work.belief.active[i];
                knowledge.locate(c, &self.work.belief, &mut self.work.inputs);
                sums.add(c, &self.work.inputs, Labels { group: 0, labels: &labels, weight: share });
            }
        }
        sums.fit(&mut knowledge.heads, &|output| self.group(output), self.config.prior);
    }

    /// Looks and moving now, after the moves, whose worth is one of their inputs.
    fn learn_looks(&mut self, pages: &Pages, knowledge: &mut Knowledge, sums: &mut Sums) {
        let (actions, slots) = (self.actions, self.stop - self.actions);
        let hints = knowledge.heads.shape().inputs - HINTS;
        let mut values = vec![0.0; actions];
        for (input, targets, weights) in pages.rows() {
            knowledge.infer(input, &mut self.work);
            values.fill(0.0);
            knowledge.value_moves((self.config.moves, actions), &mut values, &mut self.work);
            knowledge.foresee((actions, slots), &mut self.work);
            self.work.inputs[hints] = largest(&values);
            for output in (actions..=self.stop).filter(|&o| weights[o] > 0.0) {
                let slot = output - actions;
                self.work.inputs[hints + 1] = if output < self.stop { self.work.gains[slot] } else { 0.0 };
                let labels = [(output, f64::from(targets[output]))];
                for i in 0..self.work.belief.active.len() {
                    let (c, share) = self.work.belief.active[i];
                    knowledge.locate(c, &self.work.belief, &mut self.work.inputs);
                    let weight = share * f64::from(weights[output]);
                    let seen = Labels { group: self.group(output), labels: &labels, weight };
                    sums.add(c, &self.work.inputs, seen);
                }
            }
        }
        sums.fit(&mut knowledge.heads, &|output| self.group(output), self.config.prior);
    }
}
