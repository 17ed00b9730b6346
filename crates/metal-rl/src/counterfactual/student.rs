//! The student: what every move, and every look, is worth for any set of readings. Eqs. (8, 9).

pub mod appointment;
pub(in crate::counterfactual) mod approximator;
pub(in crate::counterfactual) mod believer;
pub mod gaze;
pub mod mixture;
pub mod recollection;
pub mod rule;
pub(in crate::counterfactual) mod units;

use self::appointment::Diary;
use self::approximator::{Approximator, Networks, Recall, Shape};
use self::believer::{Believer, Thoughts};
use self::gaze::{Gaze, Layout};
use self::mixture::Mixture;
use self::recollection::{Lesson, Recollection};
use self::rule::Rule;
use self::units::Units;
use super::config::{CounterfactualConfig, NAME};
use crate::learner::LearnerError;
use crate::learners::frozen;
use crate::num;
use crate::random::Streams;
use crate::set::IndexSet;
use serde::{Deserialize, Serialize};

/// What a student is born for.
#[derive(Clone, Debug, PartialEq)]
pub struct StudentShape {
    /// Length of what each slot shows.
    pub blocks: Vec<usize>,
    /// Price of looking at each slot. Fig. 7b.
    pub prices: Vec<f64>,
    /// Number of motor actions.
    pub actions: usize,
    /// Who decides on looks.
    pub rule: Rule,
}

/// Units the networks compute in, taken from the labels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Scale {
    /// Unit of advantages and of looks.
    pub advantage: f64,
    /// Unit of a state's value.
    pub value: f64,
    /// Value that the networks call 0.
    pub centre: f64,
}

/// The next thing to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next {
    /// Look at this slot.
    Look(usize),
    /// Carry out this motor action.
    Move(usize),
}

/// Networks over masked readings, or a mixture of Gaussians. In the order of the outputs: advantage of every motor action (its value minus that
/// of the state's best one, so that what is only true of the state cancels), then worth of looking at every slot, in
/// the same terms. A network of its own, asked only where a roll-out ends, knows the value of the state's best action:
/// values are some ten times larger than advantages and would drown them.
///
/// The last output is the worth of moving *now*: what the move that would be chosen turned out to be worth. The largest
/// of the moves' own values is no measure of that, because the maximum over noisy estimates flatters; looks, whose
/// values are means of outcomes, would lose against it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Student {
    config: CounterfactualConfig,
    layout: Layout,
    rule: Rule,
    prices: Vec<f64>,
    actions: usize,
    approximator: Approximator,
    scale: Scale,
    wide_eyed: bool,
    kept: IndexSet,
    units: Option<Units>,
    recollection: Option<Recollection>,
    #[serde(default)]
    believer: Option<Box<Believer>>,
}

/// Working memory for one student at a time.
#[derive(Clone, Debug)]
pub struct Scratch {
    seen: Vec<f32>,
    pub(super) thoughts: Thoughts,
    recall: Recall,
    /// Values in units of reward, in the order of [`Student`]'s outputs.
    pub values: Vec<f64>,
}

impl Student {
    /// A newborn student; its weights come from `streams`.
    ///
    /// # Errors
    /// If a setting is outside its range.
    pub fn new(
        config: &CounterfactualConfig,
        shape: &StudentShape,
        streams: &Streams,
    ) -> Result<Self, LearnerError> {
        config.validate()?;
        let layout = Layout::new(&shape.blocks, config.memory, shape.actions);
        let recollects = !layout.recollection().is_empty();
        let recollection = recollects
            .then(|| Recollection::new(&layout, &config.recollection, &mut streams.stream("recollection")));
        let own = own_shape(shape.actions, &layout, shape.rule);
        let approximator = Approximator::new(config, own, streams);
        Ok(Self {
            approximator,
            config: config.clone(),
            layout,
            rule: shape.rule,
            prices: shape.prices.clone(),
            actions: shape.actions,
            scale: Scale { advantage: 1.0, value: 1.0, centre: 0.0 },
            wide_eyed: false,
            kept: IndexSet::first(shape.blocks.len()).minus(gifts(shape.rule, &shape.prices)),
            units: None,
            recollection,
            believer: None,
        })
    }

    /// The student as bytes.
    #[must_use]
    pub fn freeze(&self) -> Vec<u8> {
        frozen::seal(NAME, self)
    }

    /// The student frozen in `bytes`, if it was trained under these settings and for this shape.
    ///
    /// # Errors
    /// If the bytes are damaged or belong to other settings or another shape.
    pub fn thaw(
        config: &CounterfactualConfig,
        shape: &StudentShape,
        bytes: &[u8],
    ) -> Result<Self, LearnerError> {
        let student: Self = frozen::open(NAME, bytes)?;
        let layout = Layout::new(&shape.blocks, config.memory, shape.actions);
        let own = own_shape(shape.actions, &layout, shape.rule);
        let sound = student.config == *config
            && student.layout == layout
            && student.rule == shape.rule
            && student.prices == shape.prices
            && student.actions == shape.actions
            && student.approximator.fits(config, own)
            && student.recollection.as_ref().is_none_or(|recollection| recollection.fits(&layout))
            && student.recollection.is_some() != layout.recollection().is_empty()
            && student.kept.minus(IndexSet::first(layout.slots())).is_empty()
            && student.units.iter().all(|units| units.fits(&layout))
            && student.believer.as_ref().is_none_or(|b| b.fits(&layout, shape.actions));
        if sound { Ok(student) } else { Err(frozen::foreign(NAME)) }
    }

    /// Its settings.
    #[must_use]
    pub fn config(&self) -> &CounterfactualConfig {
        &self.config
    }

    /// How its input is laid out.
    #[must_use]
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Who decides on its looks.
    #[must_use]
    pub fn rule(&self) -> Rule {
        self.rule
    }

    /// The same knowledge under another rule of looking.
    #[must_use]
    pub fn under(&self, rule: Rule) -> Self {
        Self { rule, wide_eyed: false, ..self.clone() }
    }

    /// Price of looking at each slot.
    #[must_use]
    pub fn prices(&self) -> &[f64] {
        &self.prices
    }

    /// Number of motor actions.
    #[must_use]
    pub fn actions(&self) -> usize {
        self.actions
    }

    /// Number of weights of all networks, or of the mixture.
    #[must_use]
    pub fn weights(&self) -> usize {
        let values = match &self.believer {
            Some(believer) => believer.weights(),
            None => self.approximator.weights(),
        };
        values + self.recollection.as_ref().map_or(0, Recollection::weights)
    }

    /// What it carries along from motor step to motor step, if anything.
    #[must_use]
    pub fn recollection(&self) -> Option<&Recollection> {
        self.recollection.as_ref()
    }

    /// A motor step is over: what was seen is remembered, and what is recollected changes.
    pub fn advance(&self, gaze: &mut Gaze, action: usize) {
        if let Some(recollection) = &self.recollection {
            gaze.recollect(&self.layout, recollection, action);
        }
        gaze.advance(&self.layout, action);
    }

    /// The recollection learns from drives, and their labels are brought to what is recollected now.
    pub(super) fn learn_recollection<'l>(
        &mut self,
        lessons: impl Iterator<Item = &'l mut Lesson>,
        streams: &Streams,
    ) {
        let slots = (self.kept, self.gifts());
        let Some(recollection) = &mut self.recollection else { return };
        let lessons: Vec<&mut Lesson> = lessons.collect();
        let seen = lessons.iter().map(|lesson| &**lesson);
        recollection.learn((&self.layout, &self.config.recollection), seen, slots, streams);
        lessons.into_iter().for_each(|lesson| recollection.relive(&self.layout, lesson));
    }

    /// From now on it is told what a model believes, and values looks by that alone.
    pub fn believe(&mut self, believer: Believer) {
        self.believer = Some(Box::new(believer));
    }

    pub(super) fn believer(&self) -> Option<&Believer> {
        self.believer.as_deref()
    }

    pub(super) fn believer_mut(&mut self) -> Option<&mut Believer> {
        self.believer.as_deref_mut()
    }

    /// Its networks.
    ///
    /// # Panics
    /// If it is a mixture, which is taught otherwise.
    pub(super) fn networks_mut(&mut self) -> &mut Networks {
        match &mut self.approximator {
            Approximator::Networks(networks) => networks,
            Approximator::Mixture(_) => panic!("a mixture has no networks"),
        }
    }

    /// Its mixture, if it is one.
    pub(super) fn mixture(&self) -> Option<&Mixture> {
        match &self.approximator {
            Approximator::Networks(_) => None,
            Approximator::Mixture(mixture) => Some(mixture),
        }
    }

    /// Its mixture, to be taught.
    pub(super) fn mixture_mut(&mut self) -> Option<&mut Mixture> {
        match &mut self.approximator {
            Approximator::Networks(_) => None,
            Approximator::Mixture(mixture) => Some(mixture),
        }
    }

    pub(super) fn scale(&self) -> Scale {
        self.scale
    }

    /// Changes the units; what was learned stays the same.
    pub(super) fn set_scale(&mut self, new: Scale) {
        self.approximator.rescale(self.scale, new);
        self.scale = new;
    }

    /// The units of its readings, if they are not those of the members' views.
    pub(super) fn units(&self) -> Option<&Units> {
        self.units.as_ref()
    }

    /// From now on readings are taken in these units.
    pub(super) fn set_units(&mut self, units: Units) {
        self.units = Some(units);
    }

    /// Slots that may be looked at by free choice at all.
    #[must_use]
    pub fn kept(&self) -> IndexSet {
        self.kept
    }

    /// Slots that cost nothing, where looks are its choice: it looks at them before every move, because what is known for
    /// nothing harms nobody. They are no choice, so neither count among its looks nor are dismissed.
    #[must_use]
    pub fn gifts(&self) -> IndexSet {
        gifts(self.rule, &self.prices)
    }

    /// From now on only `kept` may be looked at by free choice.
    pub(super) fn keep(&mut self, kept: IndexSet) {
        self.kept = kept;
    }

    /// From now on the student looks at everybody before every move, or no longer does; only where looks are its choice.
    pub(super) fn set_wide_eyed(&mut self, wide_eyed: bool) {
        self.wide_eyed = wide_eyed && self.rule.is_free();
    }

    /// Whether it looks at everybody before every move, although looks are its choice.
    pub(super) fn is_wide_eyed(&self) -> bool {
        self.wide_eyed
    }

    /// The slots that must be looked at in motor step `clock`, whatever the student chooses afterwards.
    fn due(&self, clock: usize) -> Option<IndexSet> {
        if self.wide_eyed {
            return Some(IndexSet::first(self.layout.slots()));
        }
        self.rule.due(clock).or_else(|| Some(self.gifts()))
    }

    /// Whether looks are free to choose and remembered, so that a look not taken is missed later on.
    #[must_use]
    pub fn remembers_free_looks(&self) -> bool {
        self.config.memory.remembers() && self.rule.is_free()
    }

    /// Working memory of the right size.
    #[must_use]
    pub fn scratch(&self) -> Scratch {
        let outputs = own_shape(self.actions, &self.layout, self.rule).outputs();
        Scratch {
            seen: vec![0.0; self.layout.width()],
            thoughts: Thoughts::default(),
            recall: Recall::new(outputs),
            values: vec![0.0; outputs],
        }
    }

    /// All values for a network input, into `scratch.values`.
    pub fn evaluate(&self, input: &[f32], scratch: &mut Scratch) {
        if let Some(believer) = &self.believer {
            return believer.evaluate(self, input, scratch);
        }
        scratch.seen.copy_from_slice(input);
        if let Some(units) = &self.units {
            units.apply(&self.layout, &mut scratch.seen);
        }
        let caution = (self.actions, self.config.network.caution);
        self.approximator.evaluate(&scratch.seen, caution, &mut scratch.values, &mut scratch.recall);
        scratch.values.iter_mut().for_each(|value| *value *= self.scale.advantage);
    }

    /// Which output is the worth of moving now.
    #[must_use]
    pub fn stop(&self) -> usize {
        self.actions + self.diary().len()
    }

    /// The looks it can appoint.
    #[must_use]
    pub fn diary(&self) -> Diary {
        diary(&self.layout, self.rule)
    }

    /// The motor action that the values in `scratch` call best.
    #[must_use]
    pub fn best_move(&self, scratch: &Scratch) -> usize {
        num::argmax(&scratch.values[..self.actions])
    }

    /// Slots that may still be looked at by free choice when `attended` have been.
    pub fn open_looks(&self, attended: IndexSet) -> IndexSet {
        let taken = attended.minus(self.gifts()).len();
        let free = matches!(self.rule, Rule::Adaptive { max_looks, .. } if taken < max_looks);
        if free { self.kept.minus(attended) } else { IndexSet::EMPTY }
    }

    /// The look with its worth that the student takes after `attended` by the values in `scratch`; none: it moves.
    #[must_use]
    pub fn preferred_look(&self, attended: IndexSet, scratch: &Scratch) -> Option<(usize, f64)> {
        self.preferred_among(self.open_looks(attended), attended, scratch)
    }

    fn preferred_among(&self, open: IndexSet, attended: IndexSet, scratch: &Scratch) -> Option<(usize, f64)> {
        let looks = &scratch.values[self.actions..self.stop()];
        let open = open.iter().map(|slot| (slot, looks[slot]));
        let best = open.reduce(|best, next| if next.1 > best.1 { next } else { best })?;
        let must = matches!(self.rule, Rule::Adaptive { min_looks, .. } if attended.len() < min_looks);
        (must || best.1 > self.threshold(scratch)).then_some(best)
    }

    /// Whether it weighs looks at members against moving now, as far as it may choose at all.
    #[must_use]
    pub fn weighs_looks(&self) -> bool {
        self.rule.is_free() && !self.rule.appoints()
    }

    /// The values in `scratch` on one scale, added to `out`: the best move is worth moving now, the others less as they are
    /// worse, and a look what is expected after it.
    pub fn weigh(&self, scratch: &Scratch, out: &mut Vec<f64>) {
        if !self.weighs_looks() || self.wide_eyed {
            return;
        }
        let (stop, best) = (scratch.values[self.stop()], scratch.values[self.best_move(scratch)]);
        out.extend(scratch.values[..self.actions].iter().map(|value| stop + value - best));
        let base = stop - self.threshold(scratch);
        out.extend(scratch.values[self.actions..self.stop()].iter().map(|look| base + look));
    }

    /// What a look must be worth more than: nothing, if looks are valued against moving now.
    fn threshold(&self, scratch: &Scratch) -> f64 {
        if self.config.fit.relative { 0.0 } else { scratch.values[self.stop()] }
    }

    /// What is expected of the best that can be done by the values in `scratch`, if that is `look` or to move now.
    pub(super) fn expected(&self, look: Option<(usize, f64)>, scratch: &Scratch) -> f64 {
        let stop = scratch.values[self.stop()];
        match look {
            None => stop,
            Some((_, worth)) if self.config.fit.relative => stop + worth,
            Some((_, worth)) => worth,
        }
    }

    /// The next look, or the move, where `gaze` stands. If it is a move, `scratch` holds the values behind it.
    /// A look that is appointed then is noted in `gaze`.
    pub fn next(&self, gaze: &mut Gaze, scratch: &mut Scratch) -> Next {
        self.next_but(IndexSet::EMPTY, gaze, scratch)
    }

    /// As [`Self::next`], without looks at slots that rest.
    pub fn next_but(&self, resting: IndexSet, gaze: &mut Gaze, scratch: &mut Scratch) -> Next {
        let attended = gaze.attended();
        if let Some(due) = self.due(gaze.clock())
            && let Some(slot) = due.minus(attended).minus(resting).iter().next()
        {
            return Next::Look(slot);
        }
        if self.rule.appoints() && !self.wide_eyed {
            return self.next_by_appointment(resting, gaze, scratch);
        }
        self.evaluate(gaze.input(), scratch);
        match self.preferred_among(self.open_looks(attended).minus(resting), attended, scratch) {
            Some((slot, _)) => Next::Look(slot),
            None => Next::Move(self.best_move(scratch)),
        }
    }

    /// What the future is worth to who decides on `action`, where the values in `scratch` were evaluated last.
    #[must_use]
    pub fn worth(&self, action: usize, scratch: &Scratch) -> f64 {
        let value = self.approximator.value(&scratch.seen, &scratch.recall);
        self.scale.centre + self.scale.value * value + scratch.values[action]
    }
}

/// Slots of no price, where looks are free to choose one after the other.
fn gifts(rule: Rule, prices: &[f64]) -> IndexSet {
    let slots = if matches!(rule, Rule::Adaptive { .. }) { prices } else { &[] };
    slots.iter().enumerate().filter(|&(_, &price)| price == 0.0).map(|(slot, _)| slot).collect()
}

fn own_shape(actions: usize, layout: &Layout, rule: Rule) -> Shape<'_> {
    Shape { actions, layout, looks: diary(layout, rule).len() }
}

/// Looks that are valued: one per slot, or per appointment.
fn diary(layout: &Layout, rule: Rule) -> Diary {
    let ahead = if let Rule::Appointed { ahead, .. } = rule { ahead } else { 0 };
    Diary { slots: layout.slots(), ahead }
}

#[cfg(test)]
mod tests;
