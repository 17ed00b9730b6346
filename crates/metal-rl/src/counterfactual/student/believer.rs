//! A student that is told what a model believes ([`Belief`]) instead of what was seen. The model decides on moves and
//! knows what moving now is worth; only looks are learned.
//!
//! One small network values every look from what the model says of it, so whatever is learned of one sensor holds for
//! all of them. Its targets are expectations of the model, not outcomes: they have no noise but that of the readings.

use crate::belief::{Belief, Opinion};
use crate::counterfactual::config::CounterfactualConfig;
use crate::counterfactual::iterate::School;
use crate::counterfactual::judge::Judged;
use crate::counterfactual::student::gaze::{Layout, MemoryConfig};
use crate::counterfactual::student::rule::Rule;
use crate::counterfactual::student::{Scratch, Student, StudentShape};
use crate::decision::Content;
use crate::learners::nn::{Activation, Adam, Batch, Network};
use crate::num;
use crate::random::{Rng, Streams};
use crate::set::IndexSet;
use serde::{Deserialize, Serialize};

/// What is said of a look, and of the moment.
const OF_A_LOOK: usize = 5;
const OF_THE_MOMENT: usize = 11;
/// Widths of the hidden layers.
const HIDDEN: [usize; 2] = [32, 32];
/// Best looks by which a moment is described.
const BEST: usize = 3;
/// Training steps of other students for one of a believer's, which has one small network for all sensors and labels without
/// noise; and fewest.
const STEPS_FOR_ONE: usize = 20;
const FEWEST: usize = 20;
/// Share of labels for the look that the student would take itself; the others are for any look.
const PREFERRED: f64 = 0.5;

/// A model, and what looks are worth by what it says.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Believer {
    belief: Belief,
    scorer: Network,
}

/// Working memory.
#[derive(Clone, Debug, Default)]
pub(in crate::counterfactual) struct Thoughts {
    opinion: Opinion,
    input: Vec<f32>,
    gains: Vec<f64>,
}

impl Believer {
    /// A newborn believer in `belief`.
    #[must_use]
    pub fn new(belief: Belief, (activation, adam): (Activation, Adam), streams: &Streams) -> Self {
        let widths = [OF_A_LOOK + OF_THE_MOMENT, HIDDEN[0], HIDDEN[1], 1];
        let scorer = Network::new(&widths, activation, adam, &mut streams.stream("weights"));
        Self { belief, scorer }
    }

    /// Whether its model is of these sensors and so many motor actions.
    #[must_use]
    pub fn fits(&self, layout: &Layout, actions: usize) -> bool {
        let sensors = self.belief.sensors();
        let same = |(slot, &n): (usize, &usize)| layout.block(slot).len() == n;
        sensors.len() == layout.slots()
            && sensors.iter().enumerate().all(same)
            && self.belief.actions() == actions
            && self.scorer.fits(&[OF_A_LOOK + OF_THE_MOMENT, HIDDEN[0], HIDDEN[1], 1])
    }

    /// Number of weights.
    #[must_use]
    pub fn weights(&self) -> usize {
        self.scorer.weights()
    }

    /// All values of `student` for a network input, in the order of its outputs.
    pub(in crate::counterfactual) fn evaluate(
        &self,
        student: &Student,
        input: &[f32],
        scratch: &mut Scratch,
    ) {
        let layout = student.layout();
        let attended: IndexSet = (0..layout.slots()).filter(|&slot| layout.is_seen(slot, input)).collect();
        let open = student.open_looks(attended);
        let (actions, stop) = (student.actions(), student.stop());
        let Scratch { values, thoughts, .. } = scratch;
        self.belief.update(layout.readings_of(input), |slot| attended.contains(slot), &mut thoughts.opinion);
        values.fill(0.0);
        values[..actions].copy_from_slice(&thoughts.opinion.moves);
        let now = num::max(&thoughts.opinion.moves);
        values[stop] = now;
        if open.is_empty() {
            return;
        }
        self.belief.look_ahead(&mut thoughts.opinion);
        self.describe_moment(student, (attended, open), thoughts);
        let ground = if student.config().fit.relative { 0.0 } else { now };
        for slot in open.iter() {
            let price = student.prices()[slot];
            let worth = if self.may_pay(price, thoughts.opinion.tells[slot].all) {
                self.describe_look(price, slot, thoughts);
                let mut worth = [0.0];
                self.scorer.forward(&thoughts.input, &mut worth);
                self.belief.stake() * f64::from(worth[0])
            } else {
                -price
            };
            values[actions + slot] = ground + worth;
        }
    }

    /// Whether a look that tells so much (in nats) can be worth its price, whatever is looked at afterwards. Where numbers are
    /// correlated it may tell more beside another than by itself; then the other is worth looking at first.
    ///
    /// # Formula
    /// stake · √(information / 2) > price,  by Pinsker's inequality
    fn may_pay(&self, price: f64, information: f64) -> bool {
        self.belief.stake() * (information / 2.0).sqrt() > price
    }

    /// How sure the model is, and what is left to be looked at.
    fn describe_moment(
        &self,
        student: &Student,
        (attended, open): (IndexSet, IndexSet),
        thoughts: &mut Thoughts,
    ) {
        let Thoughts { opinion, input, gains } = thoughts;
        let stake = self.belief.stake();
        gains.clear();
        gains.extend(open.iter().map(|slot| opinion.tells[slot].class));
        gains.sort_by(|a, b| b.total_cmp(a));
        let best = gains.iter().take(BEST).sum::<f64>() / BEST as f64;
        let other = |slot: usize| opinion.tells[slot].all - opinion.tells[slot].class;
        let context = open.iter().map(other).fold(0.0, f64::max);
        let prices: f64 = open.iter().map(|slot| student.prices()[slot]).sum();
        let class_entropy = entropy(&opinion.classes);
        let most = student.rule().most_looks().min(student.kept().len()).max(1);
        gains.clear();
        gains.extend(&opinion.classes);
        gains.sort_by(|a, b| b.total_cmp(a));
        gains.resize(gains.len().max(BEST), 0.0);
        let moment = [
            num::max(&opinion.moves) / stake,
            gains[0],
            gains[1],
            gains[2],
            class_entropy,
            entropy(&opinion.hypotheses) - class_entropy,
            open.iter().map(|slot| opinion.tells[slot].class).fold(0.0, f64::max),
            best,
            context,
            (most - attended.len().min(most)) as f64 / most as f64,
            prices / open.len() as f64 / stake,
        ];
        input.clear();
        input.resize(OF_A_LOOK, 0.0);
        input.extend(moment.map(|x| x as f32));
    }

    fn describe_look(&self, price: f64, slot: usize, thoughts: &mut Thoughts) {
        let tells = thoughts.opinion.tells[slot];
        let look = [
            tells.class,
            tells.all - tells.class,
            tells.duel / (1.0 + tells.duel),
            num::exp(-tells.duel / 8.0),
            price / self.belief.stake(),
        ];
        thoughts.input.iter_mut().zip(look).for_each(|(x, y)| *x = y as f32);
    }
}

impl School<'_> {
    /// What a student of this shape is told, if it is told anything and the world is drawn from a model.
    pub(in crate::counterfactual) fn believer(
        &self,
        config: &CounterfactualConfig,
        shape: &StudentShape,
        streams: &Streams,
    ) -> Option<Believer> {
        // Slots must be sensors, seen as they are: a model knows nothing of members' opinions, or of earlier readings.
        let is_sensor = |(slot, &member): (usize, &usize)| self.members[member].view.sensors() == [slot];
        let plain = config.content == Content::Readings && config.memory == MemoryConfig::default();
        if !(config.network.belief && plain && self.roster.iter().enumerate().all(is_sensor)) {
            return None;
        }
        let belief = self.environment.belief()?.scaled(self.scaling);
        let net = &config.network;
        let believer = Believer::new(belief, (net.activation, net.adam), &streams.child("belief"));
        let layout = Layout::new(&shape.blocks, config.memory, shape.actions);
        believer.fits(&layout, shape.actions).then_some(believer)
    }
}

fn entropy(probabilities: &[f64]) -> f64 {
    -probabilities.iter().filter(|p| **p > 1e-12).map(|&p| p * num::ln(p)).sum::<f64>()
}

/// Trains the looks of `student`, who believes, on the readings of `data`; returns the mean loss over the last half.
/// Looks cost their full price from the beginning: what moves are worth is known by then.
///
/// # Formula
/// look i at mask m: −priceᵢ + what the model expects of the best move once a copy of the student, from m + i on,
/// looks no more, less the prices of these looks; against what it expects of moving now
pub(in crate::counterfactual) fn fit(student: &mut Student, data: &[&Judged], streams: &Streams) -> f64 {
    if !matches!(student.rule(), Rule::Adaptive { .. }) {
        // Where looks are no choice, there is nothing to learn.
        return 0.0;
    }
    let mut settings = student.config().fit.clone();
    settings.batches = (settings.batches / STEPS_FOR_ONE).max(FEWEST);
    settings.refresh = (settings.refresh / STEPS_FOR_ONE).max(1);
    let rate = student.config().network.adam.learning_rate;
    let Some(mut scorer) = student.believer().map(|b| b.scorer.clone()) else { return 0.0 };
    let mut lesson = Lesson::new(student, streams.stream("fit"));
    let (mut average, mut averaged, mut loss, mut losses) = (scorer.clone(), 0.0, 0.0, 0.0);
    for start in (0..settings.batches).step_by(settings.refresh) {
        for batch in start..(start + settings.refresh).min(settings.batches) {
            let progress = batch as f64 / settings.batches as f64;
            let rate = rate * num::pow(settings.final_rate, progress) as f32;
            lesson.draw(student, data);
            scorer.set_learning_rate(rate);
            if lesson.targets.is_empty() {
                continue;
            }
            let error = scorer.train_batch(&lesson.batch());
            if 2 * batch >= settings.batches {
                loss += error;
                losses += 1.0;
            }
            if progress >= 1.0 - settings.averaged {
                averaged += 1.0;
                average.blend(&scorer, 1.0 / averaged);
            }
        }
        student.set_scorer(&scorer);
    }
    student.set_scorer(if averaged > 0.0 { &average } else { &scorer });
    loss / f64::max(losses, 1.0)
}

impl Student {
    fn set_scorer(&mut self, scorer: &Network) {
        if let Some(believer) = self.believer_mut() {
            believer.scorer = scorer.clone();
        }
    }
}

/// Batches of looks.
struct Lesson {
    rng: Rng,
    stake: f64,
    masked: Vec<f32>,
    scratch: Scratch,
    slots: Vec<usize>,
    inputs: Vec<f32>,
    targets: Vec<f32>,
    weights: Vec<f32>,
}

impl Lesson {
    fn new(student: &Student, rng: Rng) -> Self {
        Self {
            rng,
            stake: student.believer().map_or(1.0, |b| b.belief.stake()),
            masked: vec![0.0; student.layout().width()],
            scratch: student.scratch(),
            slots: Vec::new(),
            inputs: Vec::new(),
            targets: Vec::new(),
            weights: Vec::new(),
        }
    }

    fn batch(&self) -> Batch<'_> {
        Batch { inputs: &self.inputs, targets: &self.targets, weights: &self.weights }
    }

    /// Fills the batch with looks of the teacher's, and others, on states drawn at random.
    fn draw(&mut self, teacher: &Student, data: &[&Judged]) {
        self.inputs.clear();
        self.targets.clear();
        let fit = &teacher.config().fit;
        for _ in 0..fit.batch {
            let judged = data[self.rng.below(data.len())];
            let mask = self.mask(teacher, judged);
            let open = teacher.open_looks(mask);
            if open.is_empty() {
                continue;
            }
            self.draw_looks(teacher, judged, (mask, open));
        }
        self.weights.clear();
        self.weights.resize(self.targets.len(), 1.0);
    }

    /// Some looks that are open at the mask, with what they are worth on this very state.
    fn draw_looks(&mut self, teacher: &Student, judged: &Judged, (mask, open): (IndexSet, IndexSet)) {
        let Some(believer) = teacher.believer() else { return };
        self.see(teacher, judged, mask);
        let now = self.scratch.values[teacher.stop()];
        let looks = &self.scratch.values[teacher.actions()..];
        let best = open.iter().reduce(|a, b| if looks[b] > looks[a] { b } else { a });
        self.slots.clear();
        for _ in 0..teacher.config().fit.looks_per_sample {
            let any = open.iter().nth(self.rng.below(open.len()));
            let Some(slot) = (if self.rng.chance(PREFERRED) { best } else { any }) else { return };
            believer.describe_look(teacher.prices()[slot], slot, &mut self.scratch.thoughts);
            self.inputs.extend(&self.scratch.thoughts.input);
            self.slots.push(slot);
        }
        for i in 0..self.slots.len() {
            let slot = self.slots[i];
            let worth = self.worth(teacher, judged, mask.with(slot)) - teacher.prices()[slot];
            self.targets.push(((worth - now) / self.stake) as f32);
        }
    }

    /// What is expected of the move where the teacher, from `mask` on, looks no more, less the prices of its looks.
    fn worth(&mut self, teacher: &Student, judged: &Judged, mut mask: IndexSet) -> f64 {
        let mut spent = 0.0;
        loop {
            self.see(teacher, judged, mask);
            let Some((slot, _)) = teacher.preferred_look(mask, &self.scratch) else {
                return self.scratch.values[teacher.stop()] - spent;
            };
            mask = mask.with(slot);
            spent += teacher.prices()[slot];
        }
    }

    fn see(&mut self, teacher: &Student, judged: &Judged, mask: IndexSet) {
        teacher.layout().mask(&judged.full, mask, &mut self.masked);
        teacher.evaluate(&self.masked, &mut self.scratch);
    }

    /// Stops on the way of the teacher's own looks, or any looks.
    fn mask(&mut self, teacher: &Student, judged: &Judged) -> IndexSet {
        let most = teacher.rule().most_looks().min(teacher.kept().len());
        if !self.rng.chance(teacher.config().fit.own_looks) {
            return self.any_looks(teacher.kept(), most).union(teacher.gifts());
        }
        let (mut mask, mut chosen, mut stops) = (teacher.gifts(), teacher.gifts(), 1.0);
        loop {
            self.see(teacher, judged, mask);
            let Some((slot, _)) = teacher.preferred_look(mask, &self.scratch) else { return chosen };
            mask = mask.with(slot);
            stops += 1.0;
            if self.rng.chance(1.0 / stops) {
                chosen = mask;
            }
        }
    }

    fn any_looks(&mut self, among: IndexSet, most: usize) -> IndexSet {
        let mut mask = IndexSet::EMPTY;
        for _ in 0..self.rng.below(most.max(1)) {
            let open = among.minus(mask);
            mask = open.iter().nth(self.rng.below(open.len())).map_or(mask, |slot| mask.with(slot));
        }
        mask
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::belief::{Hypothesis, Number};
    use crate::counterfactual::config::FitConfig;
    use crate::counterfactual::fit::fit as fit_any;

    const PRICE: f64 = 0.05;
    const SPREAD: f64 = 0.1;
    const CONTEXTS: usize = 6;
    const SENSORS: usize = 1 + CONTEXTS;

    /// The first number is the context; it says which of the others tells the class (0 or 1). The rest is 1/2.
    fn belief() -> Belief {
        let number = Number::Value { ruler: vec![[0.0, 0.0], [1.0, 1.0]], nullable: false };
        let hypothesis = |i: usize| Hypothesis {
            log_prior: 0.0,
            class: i % 2,
            means: means(i / 2, i % 2).to_vec(),
            variances: spreads().map(|s| s * s).to_vec(),
        };
        let rewards = vec![vec![0.0, -1.0], vec![-1.0, 0.0]];
        let hypotheses = (0..2 * CONTEXTS).map(hypothesis).collect();
        Belief::new(vec![1; SENSORS], vec![number; SENSORS], hypotheses, rewards)
    }

    fn means(context: usize, class: usize) -> [f64; SENSORS] {
        let mut means = [0.5; SENSORS];
        means[0] = context as f64 / (CONTEXTS - 1) as f64;
        means[1 + context] = class as f64;
        means
    }

    fn spreads() -> [f64; SENSORS] {
        let mut spreads = [SPREAD; SENSORS];
        spreads[0] = 0.02;
        spreads
    }

    fn shape() -> StudentShape {
        let rule = Rule::Adaptive { min_looks: 0, max_looks: 4 };
        StudentShape { blocks: vec![1; SENSORS], prices: vec![PRICE; SENSORS], actions: 2, rule }
    }

    fn student(batches: usize) -> Student {
        let fit = FitConfig { batches, ..FitConfig::default() };
        let config = CounterfactualConfig { fit, ..CounterfactualConfig::default() };
        let mut student = Student::new(&config, &shape(), &Streams::new(1)).unwrap();
        let net = &config.network;
        student.believe(Believer::new(belief(), (net.activation, net.adam), &Streams::new(2)));
        student
    }

    fn full(cells: [f64; SENSORS]) -> Vec<f32> {
        cells.into_iter().chain([1.0; SENSORS]).map(|x| x as f32).collect()
    }

    fn row(rng: &mut Rng) -> Judged {
        let mut cells = means(rng.below(CONTEXTS), rng.below(2));
        cells.iter_mut().zip(spreads()).for_each(|(cell, spread)| *cell += spread * rng.normal());
        let advantages = vec![0.0, 0.0];
        let looks = IndexSet::EMPTY;
        Judged {
            full: full(cells),
            clock: 0,
            looks,
            advantages,
            value: 0.0,
            stops: Vec::new(),
            appointments: None,
        }
    }

    fn values(student: &Student, cells: [f64; SENSORS], mask: IndexSet) -> Scratch {
        let (mut masked, mut scratch) = (vec![0.0; 2 * SENSORS], student.scratch());
        student.layout().mask(&full(cells), mask, &mut masked);
        student.evaluate(&masked, &mut scratch);
        scratch
    }

    #[test]
    fn moves_and_moving_now_are_worth_what_the_model_expects() {
        let (student, seen) = (student(1), IndexSet::EMPTY.with(0).with(2));
        let mut cells = [0.5; SENSORS];
        (cells[0], cells[2]) = (0.2, 0.6);
        let scratch = values(&student, cells, seen);
        // Context 1: column 2 is 0 or 1, and 0.6 is nearer to 1 by (0.6² − 0.4²) / (2 · 0.01) = 10 in logarithms.
        let wrong = 1.0 / (1.0 + num::exp(10.0));
        assert!((scratch.values[1] + wrong).abs() < 1e-5, "{:?}", scratch.values);
        assert_eq!(scratch.values[student.stop()], scratch.values[1]);
        assert_eq!(student.best_move(&scratch), 1);
    }

    #[test]
    fn looks_at_the_context_first_although_it_tells_nothing_of_the_class() {
        let mut student = student(6000);
        let mut rng = Streams::new(3).stream("rows");
        let rows: Vec<Judged> = (0..1000).map(|_| row(&mut rng)).collect();
        fit_any(&mut student, &rows.iter().collect::<Vec<_>>(), 1.0, &Streams::new(4));
        let look = |cells: [f64; SENSORS], mask| {
            let scratch = values(&student, cells, mask);
            student.preferred_look(mask, &scratch)
        };
        let (slot, worth) = look([0.0; SENSORS], IndexSet::EMPTY).unwrap();
        assert_eq!(slot, 0);
        // The context and one column, 0.05 each; without the context one reads 3 1/3 columns.
        assert!((worth + 2.0 * PRICE).abs() < 0.03, "{worth}");
        for context in 0..CONTEXTS {
            let (cells, read) = (means(context, 1), IndexSet::EMPTY.with(0));
            assert_eq!(look(cells, read).map(|l| l.0), Some(1 + context));
            assert_eq!(look(cells, read.with(1 + context)), None, "it knows the class");
        }
    }

    #[test]
    fn a_look_that_tells_too_little_for_its_price_is_not_even_considered() {
        let student = student(1);
        let believer = student.believer().unwrap();
        // √(0.005 / 2) is 0.05.
        assert!(!believer.may_pay(PRICE, 0.0049) && believer.may_pay(PRICE, 0.0051));
        let mut cells = [0.5; SENSORS];
        cells[0] = 0.0;
        let mask = IndexSet::EMPTY.with(0);
        let looks = values(&student, cells, mask).values[2 + 2..2 + SENSORS].to_vec();
        let now = -0.5;
        assert!(looks.iter().all(|&worth| worth == now - PRICE), "of the other contexts: {looks:?}");
    }

    #[test]
    fn a_believer_fits_its_sensors_and_nothing_else_and_survives_freezing() {
        let student = student(1);
        let believer = student.believer().unwrap();
        assert!(believer.fits(student.layout(), 2) && !believer.fits(student.layout(), 3));
        let mut blocks = [1; SENSORS];
        blocks[3] = 2;
        assert!(!believer.fits(&Layout::new(&blocks, MemoryConfig::default(), 2), 2));
        let thawed = Student::thaw(student.config(), &shape(), &student.freeze()).unwrap();
        let of = |student| values(student, [0.3; SENSORS], IndexSet::EMPTY.with(4)).values;
        assert_eq!(of(&student), of(&thawed));
    }
}
