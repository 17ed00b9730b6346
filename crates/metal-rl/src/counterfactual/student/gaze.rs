//! What a student holds while it drives: this motor step's readings, what it remembers of earlier ones, and a clock.
//! Written straight into the network's input.

use crate::counterfactual::student::appointment::Appointment;
use crate::counterfactual::student::recollection::Recollection;
use crate::set::IndexSet;
use serde::{Deserialize, Serialize};

/// What is remembered from earlier motor steps; all zero: nothing, as in the paper.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MemoryConfig {
    /// Earlier readings kept of each member, the last ones; beside today's reading they make motion visible.
    pub looks: usize,
    /// Motor steps after which a reading is forgotten.
    pub steps: usize,
    /// Last motor actions that are remembered: who knows what it did since it last looked knows where that led to.
    pub actions: usize,
    /// Units of the [`recollection`](crate::counterfactual::student::recollection::Recollection) that is carried along, a multiple of 16 up to 128; 0: none.
    pub recurrent: usize,
}

impl MemoryConfig {
    /// Whether looks are remembered at all.
    #[must_use]
    pub fn remembers(self) -> bool {
        self.looks > 0 || self.recurrent > 0
    }
}

/// Motor steps without a look that are as good as any longer time.
const LONG: f32 = 20.0;

/// Where everything lies in the input: readings by slot (null: zeros), one bit per slot that says "was looked at",
/// remembered readings with their age, the last motor actions (newest first; one bit per action), and for how long nobody was
/// looked at.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Layout {
    offsets: Vec<usize>,
    memory: MemoryConfig,
    actions: usize,
}

/// A part of an input that is known as a whole or not at all.
pub(in crate::counterfactual) struct Part {
    /// Where it lies.
    pub place: std::ops::Range<usize>,
    /// The number of the input that is above 0 if it is known; none: it always is.
    pub flag: Option<usize>,
    /// The slot it comes from.
    pub owner: Option<usize>,
    /// Whether it is of this motor step.
    pub now: bool,
}

impl Layout {
    /// The layout for members whose readings have these lengths.
    #[must_use]
    pub fn new(blocks: &[usize], memory: MemoryConfig, actions: usize) -> Self {
        let mut offsets = vec![0];
        for length in blocks {
            offsets.push(offsets[offsets.len() - 1] + length);
        }
        Self { offsets, memory, actions }
    }

    /// Number of slots.
    #[must_use]
    pub fn slots(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Length of the input.
    #[must_use]
    pub fn width(&self) -> usize {
        self.recollection().end
    }

    /// Where what is recollected lies; empty: there is none.
    #[must_use]
    pub fn recollection(&self) -> std::ops::Range<usize> {
        let start = self.unseen_at() + usize::from(self.memory.looks > 0);
        start..start + self.memory.recurrent
    }

    /// Length of what is seen in a motor step, with which an input begins: readings, and which of them were looked at.
    #[must_use]
    pub fn seen(&self) -> usize {
        self.readings() + self.slots()
    }

    /// Number of motor actions.
    #[must_use]
    pub fn actions(&self) -> usize {
        self.actions
    }

    /// Where a student with a memory is told for how long it has looked at nobody. When everything is forgotten, all
    /// moments would look alike, and whoever thinks that one blind step does no harm would take one after the other.
    fn unseen_at(&self) -> usize {
        self.actions_at() + self.memory.actions * self.actions
    }

    /// Where the reading of `slot` lies.
    #[must_use]
    pub fn block(&self, slot: usize) -> std::ops::Range<usize> {
        self.offsets[slot]..self.offsets[slot + 1]
    }

    fn readings(&self) -> usize {
        self.offsets[self.slots()]
    }

    fn bit(&self, slot: usize) -> usize {
        self.readings() + slot
    }

    /// Where the `depth`-th last remembered reading of `slot` lies; its age is written behind it.
    fn remembered(&self, slot: usize, depth: usize) -> std::ops::Range<usize> {
        let frame = self.readings() + self.slots();
        let start = frame * (1 + depth) + self.offsets[slot] + slot;
        start..start + self.block(slot).len()
    }

    /// Whether the reading of `slot` was looked at, in an input.
    #[must_use]
    pub fn is_seen(&self, slot: usize, input: &[f32]) -> bool {
        input[self.bit(slot)] > 0.0
    }

    /// Whether the `depth`-th last reading of `slot` is remembered in an input, and where.
    pub(in crate::counterfactual) fn memory(
        &self,
        slot: usize,
        depth: usize,
        input: &[f32],
    ) -> Option<std::ops::Range<usize>> {
        let place = self.remembered(slot, depth);
        (input[place.end] > 0.0).then_some(place)
    }

    /// How many earlier readings of each slot are remembered.
    pub(in crate::counterfactual) fn depth(&self) -> usize {
        self.memory.looks
    }

    /// The parts of an input that are known together or not at all: readings of this motor step, memories with their
    /// ages, and what is always known.
    pub(in crate::counterfactual) fn parts(&self) -> Vec<Part> {
        let reading =
            |slot| Part { place: self.block(slot), flag: Some(self.bit(slot)), owner: Some(slot), now: true };
        let memory = |slot, depth| {
            let place = self.remembered(slot, depth);
            Part { place: place.start..place.end + 1, flag: Some(place.end), owner: Some(slot), now: false }
        };
        let memories =
            (0..self.depth()).flat_map(|depth| (0..self.slots()).map(move |slot| memory(slot, depth)));
        let always = Part { place: self.actions_at()..self.width(), flag: None, owner: None, now: true };
        (0..self.slots()).map(reading).chain(memories).chain([always]).collect()
    }

    fn actions_at(&self) -> usize {
        (self.readings() + self.slots()) * (1 + self.memory.looks)
    }

    /// The part of an input that holds this motor step's readings, slot by slot.
    #[must_use]
    pub fn readings_of<'i>(&self, input: &'i [f32]) -> &'i [f32] {
        &input[..self.readings()]
    }

    /// As [`Self::readings_of`], to be written.
    pub fn readings_of_mut<'i>(&self, input: &'i mut [f32]) -> &'i mut [f32] {
        &mut input[..self.readings()]
    }

    /// Writes into an input which slots were looked at, and changes no reading.
    pub fn mark(&self, attended: IndexSet, input: &mut [f32]) {
        for slot in 0..self.slots() {
            input[self.bit(slot)] = f32::from(u8::from(attended.contains(slot)));
        }
    }

    /// Copies `full`, in which everybody was looked at, as somebody sees it who looked at `attended` only.
    pub fn mask(&self, full: &[f32], attended: IndexSet, out: &mut [f32]) {
        out.copy_from_slice(full);
        for slot in (0..self.slots()).filter(|&slot| !attended.contains(slot)) {
            out[self.block(slot)].fill(0.0);
            out[self.bit(slot)] = 0.0;
        }
    }
}

/// The state of a student within an episode.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Gaze {
    input: Vec<f32>,
    attended: IndexSet,
    ages: Vec<usize>,
    unseen: usize,
    clock: usize,
    appointment: Option<Appointment>,
    /// Whether the appointment was made in this motor step.
    appointed: bool,
}

impl Gaze {
    /// The beginning of an episode: nothing seen, nothing remembered.
    #[must_use]
    pub fn new(layout: &Layout) -> Self {
        Self {
            input: vec![0.0; layout.width()],
            attended: IndexSet::EMPTY,
            ages: vec![0; layout.slots() * layout.memory.looks],
            unseen: 0,
            clock: 0,
            appointment: None,
            appointed: false,
        }
    }

    /// Whether it is a gaze of this layout.
    pub(in crate::counterfactual) fn fits(&self, layout: &Layout) -> bool {
        self.input.len() == layout.width()
            && self.ages.len() == layout.slots() * layout.memory.looks
            && self.appointment.is_none_or(|next| next.slot < layout.slots())
    }

    /// Back to the beginning of an episode.
    pub fn reset(&mut self) {
        self.input.fill(0.0);
        self.ages.fill(0);
        (self.attended, self.unseen, self.clock) = (IndexSet::EMPTY, 0, 0);
        (self.appointment, self.appointed) = (None, false);
    }

    /// The network's input.
    #[must_use]
    pub fn input(&self) -> &[f32] {
        &self.input
    }

    /// Slots looked at in this motor step.
    #[must_use]
    pub fn attended(&self) -> IndexSet {
        self.attended
    }

    /// Motor steps since the beginning of the episode.
    #[must_use]
    pub fn clock(&self) -> usize {
        self.clock
    }

    /// The next look, if it is appointed.
    #[must_use]
    pub fn appointment(&self) -> Option<Appointment> {
        self.appointment
    }

    /// Whether it was appointed in this motor step.
    #[must_use]
    pub fn has_appointed(&self) -> bool {
        self.appointed
    }

    /// Makes an appointment.
    pub(in crate::counterfactual) fn appoint(&mut self, appointment: Option<Appointment>) {
        (self.appointment, self.appointed) = (appointment, true);
    }

    /// Sees `full`, in which everybody was looked at, as if `attended` were all that was looked at.
    pub fn see_through(&mut self, layout: &Layout, full: &[f32], attended: IndexSet) {
        layout.mask(full, attended, &mut self.input);
        self.attended = attended;
    }

    /// Takes in what the member in `slot` shows.
    pub fn look(&mut self, layout: &Layout, slot: usize, reading: &[f64]) {
        crate::learners::nn::narrow(reading, &mut self.input[layout.block(slot)]);
        self.input[layout.bit(slot)] = 1.0;
        self.attended = self.attended.with(slot);
    }

    /// Takes in the reading of `slot` out of everybody's, as [`Layout::readings_of`] gives them.
    pub fn look_again(&mut self, layout: &Layout, slot: usize, readings: &[f32]) {
        let place = layout.block(slot);
        self.input[place.clone()].copy_from_slice(&readings[place]);
        self.input[layout.bit(slot)] = 1.0;
        self.attended = self.attended.with(slot);
    }

    /// What is recollected changes with what was seen and done in this motor step.
    pub(in crate::counterfactual) fn recollect(
        &mut self,
        layout: &Layout,
        recollection: &Recollection,
        action: usize,
    ) {
        recollection.turn(layout, action, &mut self.input);
    }

    /// A motor step is over: its readings become memories, and nothing of the next one is seen yet. What is recollected is
    /// left to [`Student::advance`](crate::counterfactual::student::Student::advance).
    pub fn advance(&mut self, layout: &Layout, action: usize) {
        for slot in 0..layout.slots() {
            self.age(layout, slot);
        }
        let now = ..layout.readings() + layout.slots();
        self.input[now].fill(0.0);
        self.unseen = if self.attended.is_empty() { self.unseen + 1 } else { 0 };
        self.attended = IndexSet::EMPTY;
        self.remember_action(layout, action);
        if layout.memory.looks > 0 {
            self.input[layout.unseen_at()] = (self.unseen as f32 / LONG).min(1.0);
        }
        self.clock += 1;
        self.appointed = false;
        if let Some(appointment) = &mut self.appointment {
            appointment.wait = appointment.wait.saturating_sub(1);
        }
    }

    /// Older actions move back by one place, the oldest is forgotten.
    fn remember_action(&mut self, layout: &Layout, action: usize) {
        if layout.memory.actions == 0 {
            return;
        }
        let (from, to) = (layout.actions_at(), layout.unseen_at());
        self.input.copy_within(from..to - layout.actions, from + layout.actions);
        self.input[from..from + layout.actions].fill(0.0);
        self.input[from + action] = 1.0;
    }

    /// Memories of `slot` grow older by one step, and make room for this step's reading if there is one.
    fn age(&mut self, layout: &Layout, slot: usize) {
        let depth = layout.memory.looks;
        let ages = &mut self.ages[slot * depth..(slot + 1) * depth];
        if depth > 0 && self.attended.contains(slot) {
            ages.rotate_right(1);
            ages[0] = 0;
            for d in (1..depth).rev() {
                self.input.copy_within(layout.remembered(slot, d - 1), layout.remembered(slot, d).start);
            }
            self.input.copy_within(layout.block(slot), layout.remembered(slot, 0).start);
        } else if ages.first().is_none_or(|&newest| newest == 0) {
            return;
        }
        for (d, age) in ages.iter_mut().enumerate() {
            // Age 0 marks an empty place, but for the reading that came in just now.
            let empty = *age == 0 && !(d == 0 && self.attended.contains(slot));
            *age = if empty || *age >= layout.memory.steps { 0 } else { *age + 1 };
            let place = layout.remembered(slot, d);
            let freshness = place.end;
            if *age == 0 {
                self.input[place].fill(0.0);
                self.input[freshness] = 0.0;
            } else {
                self.input[freshness] = 1.0 - (*age - 1) as f32 / layout.memory.steps as f32;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layout(looks: usize, steps: usize) -> Layout {
        Layout::new(&[2, 1], MemoryConfig { looks, steps, actions: 1, recurrent: 0 }, 3)
    }

    #[test]
    fn a_look_fills_its_place_and_nothing_else() {
        let layout = layout(0, 0);
        let mut gaze = Gaze::new(&layout);
        gaze.look(&layout, 1, &[0.5]);
        assert_eq!(gaze.input(), [0.0, 0.0, 0.5, 0.0, 1.0, 0.0, 0.0, 0.0]);
        gaze.advance(&layout, 2);
        assert_eq!(gaze.input(), [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
        assert_eq!((gaze.attended(), gaze.clock()), (IndexSet::EMPTY, 1));
    }

    #[test]
    fn everybodys_readings_can_be_shown_without_the_student_knowing() {
        let layout = layout(1, 3);
        let mut all = Gaze::new(&layout);
        all.look(&layout, 0, &[0.1, 0.2]);
        all.look(&layout, 1, &[0.9]);
        let readings = layout.readings_of(all.input()).to_vec();
        assert_eq!(readings, [0.1, 0.2, 0.9]);
        let (mut one, mut again) = (Gaze::new(&layout), Gaze::new(&layout));
        one.look(&layout, 1, &[0.9]);
        again.look_again(&layout, 1, &readings);
        assert_eq!(one, again);
        let mut shown = again.input().to_vec();
        layout.readings_of_mut(&mut shown).copy_from_slice(&readings);
        layout.mark(again.attended(), &mut shown);
        assert_eq!(shown[..5], [0.1, 0.2, 0.9, 0.0, 1.0]);
    }

    #[test]
    fn readings_are_remembered_with_their_age_and_then_forgotten() {
        let layout = layout(2, 3);
        let mut gaze = Gaze::new(&layout);
        gaze.look(&layout, 1, &[0.5]);
        gaze.advance(&layout, 0);
        gaze.look(&layout, 1, &[0.7]);
        gaze.advance(&layout, 0);
        let memory = |gaze: &Gaze| {
            [0, 1].map(|d| {
                let place = layout.remembered(1, d);
                (gaze.input[place.start], gaze.input[place.end])
            })
        };
        let third = 1.0 / 3.0;
        assert_eq!(memory(&gaze), [(0.7, 1.0), (0.5, 1.0 - third)]);
        gaze.advance(&layout, 0);
        gaze.advance(&layout, 0);
        assert_eq!(memory(&gaze), [(0.7, 1.0 - 2.0f32 / 3.0), (0.0, 0.0)], "the older one is forgotten");
        gaze.advance(&layout, 0);
        assert_eq!(memory(&gaze), [(0.0, 0.0); 2]);
        assert!(gaze.input[..layout.remembered(0, 0).start].iter().all(|&x| x == 0.0));
    }

    #[test]
    fn the_last_actions_are_remembered_newest_first() {
        let layout = Layout::new(&[1], MemoryConfig { actions: 2, ..MemoryConfig::default() }, 3);
        let mut gaze = Gaze::new(&layout);
        let after = |gaze: &mut Gaze, action| {
            gaze.advance(&layout, action);
            gaze.input()[2..].to_vec()
        };
        assert_eq!(after(&mut gaze, 2), [0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
        assert_eq!(after(&mut gaze, 0), [1.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
        assert_eq!(after(&mut gaze, 1), [0.0, 1.0, 0.0, 1.0, 0.0, 0.0]);
        gaze.reset();
        assert_eq!(gaze.input(), Gaze::new(&layout).input());
    }

    #[test]
    fn a_mask_hides_what_was_not_attended_and_keeps_memories() {
        let layout = layout(1, 3);
        let mut gaze = Gaze::new(&layout);
        gaze.look(&layout, 0, &[0.1, 0.2]);
        gaze.advance(&layout, 1);
        gaze.look(&layout, 0, &[0.3, 0.4]);
        let some = gaze.clone();
        gaze.look(&layout, 1, &[0.9]);
        let mut out = vec![f32::NAN; layout.width()];
        layout.mask(gaze.input(), IndexSet::EMPTY.with(0), &mut out);
        assert_eq!(out, some.input());
    }
}
