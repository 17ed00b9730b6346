//! A student of counterfactual policy iteration at the wheel; see [`mod@crate::counterfactual`].

use crate::counterfactual::student::gaze::Gaze;
use crate::counterfactual::student::{Next, Scratch, Student};
use crate::decision::{DecisionState, Encoding};
use crate::explore::Exploration;
use crate::policies::rests::{RestConfig, Rests, slots_of};
use crate::policy::{Choice, Policy, Situation};
use crate::random::Rng;
use crate::set::IndexSet;

/// Drives by a [`Student`]: looks as the student (or its rule) decides, moves as it finds best. Where moves are explored
/// and looks are remembered, looks wander, too (see
/// [`wander`](crate::counterfactual::CounterfactualConfig::wander)).
#[derive(Clone)]
pub struct Counterfactual {
    student: Student,
    encoding: Encoding,
    members: Vec<usize>,
    gaze: Gaze,
    scratch: Scratch,
    block: Vec<f64>,
    /// See [`Policy::weighed`].
    weighed: Vec<f64>,
    moved: Option<usize>,
    errand: Option<Errand>,
    rests: Rests,
}

/// Looks left to chance: at this slot, or at nobody, in this motor step and some more.
#[derive(Clone, Copy)]
struct Errand {
    slot: Option<usize>,
    more: usize,
}

/// Most motor steps in a row in which chance lets nobody be looked at.
const LONGEST_ERRAND: usize = 6;

impl Counterfactual {
    /// A driver; slot i of the student is member `members[i]`.
    ///
    /// # Panics
    /// If the student was born for another number of members.
    #[must_use]
    pub fn new(student: Student, members: Vec<usize>) -> Self {
        assert_eq!(student.layout().slots(), members.len(), "one slot per member");
        let encoding = Encoding { content: student.config().content, ..Encoding::default() };
        let (gaze, scratch) = (Gaze::new(student.layout()), student.scratch());
        let rests = Rests::new(RestConfig::default(), members.len());
        let (block, weighed) = (Vec::new(), Vec::new());
        Self { student, encoding, members, gaze, scratch, block, weighed, moved: None, errand: None, rests }
    }

    /// What it learned.
    #[must_use]
    pub fn student(&self) -> &Student {
        &self.student
    }

    /// What it knows: what it saw in this motor step, and what it remembers.
    #[must_use]
    pub fn gaze(&self) -> &Gaze {
        &self.gaze
    }

    /// Chance's say in the looks of a new motor step.
    fn errand(&self, exploration: Exploration, rng: &mut Rng) -> Option<Errand> {
        let explores = exploration != Exploration::Greedy && self.student.remembers_free_looks();
        if !explores || !rng.chance(self.student.config().wander) {
            return None;
        }
        let kept = self.student.kept();
        if rng.chance(0.5) {
            return Some(Errand { slot: None, more: rng.below(LONGEST_ERRAND) });
        }
        Some(Errand { slot: kept.iter().nth(rng.below(kept.len().max(1))), more: 0 })
    }

    /// The next look or move: by the student, or on an errand.
    fn next(&mut self) -> Next {
        self.weighed.clear();
        let gift = self.student.gifts().minus(self.gaze.attended()).iter().next();
        if let (Some(_), Some(slot)) = (self.errand, gift) {
            return Next::Look(slot);
        }
        match self.errand {
            None => {
                let next = self.student.next_but(self.rests.resting(), &mut self.gaze, &mut self.scratch);
                self.student.weigh(&self.scratch, &mut self.weighed);
                next
            }
            Some(Errand { slot: Some(slot), .. }) if !self.gaze.attended().contains(slot) => Next::Look(slot),
            Some(_) => {
                self.student.evaluate(self.gaze.input(), &mut self.scratch);
                Next::Move(self.student.best_move(&self.scratch))
            }
        }
    }

    /// Takes in what was said since the last question.
    fn listen(&mut self, state: &DecisionState) {
        for (slot, &member) in self.members.iter().enumerate() {
            if self.gaze.attended().contains(slot) {
                continue;
            }
            if !state.attended().contains(member) {
                continue;
            }
            self.block.resize(self.student.layout().block(slot).len(), 0.0);
            match state.opinion(member) {
                Some(opinion) => self.encoding.write(&opinion, &mut self.block),
                // It was asked and had nothing to say: null, and looked at (reading R109).
                None => self.block.fill(0.0),
            }
            self.gaze.look(self.student.layout(), slot, &self.block);
        }
    }
}

impl Policy for Counterfactual {
    fn weighed(&self) -> Option<&[f64]> {
        self.student.weighs_looks().then_some(&self.weighed)
    }

    fn begin(&mut self, _learning: bool) {
        self.gaze.reset();
        (self.moved, self.errand) = (None, None);
        self.rests.begin();
    }

    fn choose(&mut self, situation: &Situation<'_>, rng: &mut Rng) -> Choice {
        // Only now is the last motor step over: until here, its readings stand for inspection.
        if let Some(action) = self.moved.take() {
            self.student.advance(&mut self.gaze, action);
        }
        self.listen(situation.state);
        if self.gaze.attended().is_empty() && self.errand.is_none() {
            self.errand = self.errand(situation.exploration, rng);
        }
        match self.next() {
            Next::Look(slot) => Choice::Consult(self.members[slot]),
            Next::Move(_) => {
                let actions = self.student.actions();
                let moves = &mut self.scratch.values[..actions];
                let action = situation.exploration.choose(moves, IndexSet::first(actions), rng);
                self.moved = Some(action);
                let slots = |of: IndexSet| slots_of(&self.members, of);
                let (asked, heard) = (slots(situation.state.attended()), slots(situation.state.heard()));
                self.rests.end_step(asked, heard);
                self.errand = self.errand.filter(|e| e.more > 0).map(|e| Errand { more: e.more - 1, ..e });
                Choice::Move(action)
            }
        }
    }
}
