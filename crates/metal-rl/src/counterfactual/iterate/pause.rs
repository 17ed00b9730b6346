//! A training between two of its iterations, as bytes: whoever goes on from there ends with the same student, bit by bit.

use super::{Course, Lesson};
use crate::counterfactual::iterate::diary::Iterate;
use crate::counterfactual::iterate::dismissal::Dismissal;
use crate::counterfactual::iterate::purse::Spent;
use crate::counterfactual::iterate::trial::Spread;
use crate::counterfactual::judge::Judged;
use crate::counterfactual::student::{Student, StudentShape};
use crate::learner::LearnerError;
use crate::learners::frozen;
use crate::set::IndexSet;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::collections::VecDeque;

/// What a course is sealed as.
const NAME: &str = "course, second form";

/// A part of a training: from where, and until when.
pub struct Term<'a> {
    /// Where the training stands, as bytes; none: at its beginning. After a term: where it paused; none: it is over.
    pub course: Option<Vec<u8>>,
    /// Asked between two iterations whether to pause.
    pub pause: &'a mut dyn FnMut() -> bool,
}

/// What is written down of a course. Settings and streams are not: whoever goes on has the same.
#[derive(Serialize, Deserialize)]
struct Notes<'a> {
    next: usize,
    student: Vec<u8>,
    past: Vec<Vec<u8>>,
    window: Cow<'a, VecDeque<Lesson>>,
    diary: Cow<'a, [Iterate]>,
    judge: Vec<u8>,
    spent: Spent,
    spread: Spread,
    held: usize,
    stray: Option<Vec<u8>>,
    dismissal: Cow<'a, Dismissal>,
    since: usize,
}

impl Course<'_> {
    /// The course as bytes.
    pub(super) fn freeze(&self) -> Vec<u8> {
        let notes = Notes {
            next: self.next,
            student: self.student.freeze(),
            past: self.past.iter().map(Student::freeze).collect(),
            window: Cow::Borrowed(&self.window),
            diary: Cow::Borrowed(&self.diary),
            judge: self.judge.freeze(),
            spent: self.purse.spent(),
            spread: self.spread,
            held: self.held,
            stray: self.stray.as_ref().map(Student::freeze),
            dismissal: Cow::Borrowed(&self.dismissal),
            since: self.since,
        };
        frozen::seal(NAME, &notes)
    }

    /// Takes up this newborn course where it stood when it became `bytes`.
    ///
    /// # Errors
    /// If they are damaged, or of a course with other settings or for a student of another shape.
    pub(super) fn thaw(&mut self, shape: &StudentShape, bytes: &[u8]) -> Result<(), LearnerError> {
        let notes: Notes<'_> = frozen::open(NAME, bytes)?;
        let config = self.student.config().clone();
        let thaw = |bytes: &Vec<u8>| Student::thaw(&config, shape, bytes);
        self.student = thaw(&notes.student)?;
        self.past = notes.past.iter().map(thaw).collect::<Result<_, _>>()?;
        self.stray = notes.stray.as_ref().map(thaw).transpose()?;
        self.judge.thaw(&self.student, &notes.judge)?;
        let mut labels = notes.window.iter().flat_map(|lesson| &lesson.judged);
        let sound = notes.held <= notes.next
            && notes.next <= config.iterations
            && notes.diary.len() == self.past.len()
            && notes.since <= notes.diary.len()
            && notes.dismissal.fits(self.student.layout().slots())
            && notes.window.len() <= config.window
            && notes.window.iter().all(|lesson| lesson.fits(self.student.layout()))
            && labels.all(|judged| fits(judged, &self.student));
        if !sound {
            return Err(frozen::foreign(NAME));
        }
        (self.next, self.held, self.spread) = (notes.next, notes.held, notes.spread);
        (self.window, self.diary) = (notes.window.into_owned(), notes.diary.into_owned());
        (self.dismissal, self.since) = (notes.dismissal.into_owned(), notes.since);
        self.purse.set_spent(notes.spent);
        Ok(())
    }
}

/// Whether labels are for such a student.
fn fits(judged: &Judged, student: &Student) -> bool {
    let all = IndexSet::first(student.layout().slots());
    judged.full.len() == student.layout().width()
        && judged.advantages.len() == student.actions()
        && judged.looks.minus(all).is_empty()
        && judged.stops.iter().all(|stop| stop.looks.minus(all).is_empty())
        && judged.appointments.iter().all(|made| made.fits(student.diary(), all))
}
