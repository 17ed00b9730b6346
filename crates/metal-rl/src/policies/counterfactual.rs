//! A student of counterfactual policy iteration at the wheel; see [`mod@crate::counterfactual`].

use crate::counterfactual::gaze::Gaze;
use crate::counterfactual::student::{Next, Scratch, Student};
use crate::decision::{DecisionState, Encoding};
use crate::policy::{Choice, Policy, Situation};
use crate::random::Rng;
use crate::set::IndexSet;

/// Drives by a [`Student`]: looks as the student (or its rule) decides, moves as it finds best. Exploration concerns
/// moves only: what a look would have been worth is learned without taking it.
#[derive(Clone)]
pub struct Counterfactual {
    student: Student,
    encoding: Encoding,
    members: Vec<usize>,
    gaze: Gaze,
    scratch: Scratch,
    block: Vec<f64>,
    moved: Option<usize>,
}

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
        Self { student, encoding, members, gaze, scratch, block: Vec::new(), moved: None }
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
                // It was asked and had nothing to say: null, and looked at (reading R130).
                None => self.block.fill(0.0),
            }
            self.gaze.look(self.student.layout(), slot, &self.block);
        }
    }
}

impl Policy for Counterfactual {
    fn begin(&mut self, _learning: bool) {
        self.gaze.reset();
        self.moved = None;
    }

    fn choose(&mut self, situation: &Situation<'_>, rng: &mut Rng) -> Choice {
        // Only now is the last motor step over: until here, its readings stand for inspection.
        if let Some(action) = self.moved.take() {
            self.gaze.advance(self.student.layout(), action);
        }
        self.listen(situation.state);
        match self.student.next(&self.gaze, &mut self.scratch) {
            Next::Look(slot) => Choice::Consult(self.members[slot]),
            Next::Move(_) => {
                let actions = self.student.actions();
                let moves = &mut self.scratch.values[..actions];
                let action = situation.exploration.choose(moves, IndexSet::first(actions), rng);
                self.moved = Some(action);
                Choice::Move(action)
            }
        }
    }
}
