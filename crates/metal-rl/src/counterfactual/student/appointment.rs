//! Appointments: the next look is chosen in advance, by whom and in how many motor steps. In control theory this is
//! *self-triggered* sensing. Reading R135.
//!
//! Between two looks a student learns nothing new, so nothing is lost by deciding on the next one right after the last. Who asks
//! itself anew before every move whether to look now compares a look now with a look one step later, a small difference in the noise of
//! what comes after. An appointment is judged as a whole, against others on the very same state. What that brings is measured in
//! `docs/results/attention.md`.

use crate::counterfactual::student::gaze::Gaze;
use crate::counterfactual::student::{Next, Scratch, Student};
use crate::set::IndexSet;
use serde::{Deserialize, Serialize};

/// A look that is due.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Appointment {
    /// Who will be looked at.
    pub slot: usize,
    /// Motor steps until then; 0: now.
    pub wait: usize,
}

/// What keeping an appointment turned out to be worth, against the student's own choice on the same state.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Kept {
    /// The appointment.
    pub appointment: Appointment,
    /// What it earned more than the student's own choice.
    pub worth: f64,
}

/// All appointments of a moment: with whom and when.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Diary {
    /// Number of slots.
    pub slots: usize,
    /// Motor steps that may be looked ahead.
    pub ahead: usize,
}

impl Diary {
    /// How many there are.
    #[must_use]
    pub fn len(self) -> usize {
        self.slots * (self.ahead + 1)
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.len() == 0
    }

    /// The place of an appointment among all.
    #[must_use]
    pub fn index(self, appointment: Appointment) -> usize {
        appointment.wait * self.slots + appointment.slot
    }

    /// The appointment at a place.
    #[must_use]
    pub fn at(self, index: usize) -> Appointment {
        Appointment { slot: index % self.slots, wait: index / self.slots }
    }
}

impl Student {
    /// Whether `appointment` can be made by somebody who has looked at `attended` in this motor step.
    fn is_open(&self, appointment: Appointment, attended: IndexSet) -> bool {
        let now = appointment.wait == 0;
        let full = attended.len() >= self.rule().most_looks();
        self.kept().contains(appointment.slot) && !(now && (full || attended.contains(appointment.slot)))
    }

    /// All appointments that can be made now.
    pub(in crate::counterfactual) fn open_appointments(
        &self,
        attended: IndexSet,
    ) -> impl Iterator<Item = Appointment> + '_ {
        let diary = self.diary();
        (0..diary.len()).map(move |i| diary.at(i)).filter(move |&a| self.is_open(a, attended))
    }

    /// The appointment that the values in `scratch` call best.
    pub(in crate::counterfactual) fn preferred_appointment(
        &self,
        attended: IndexSet,
        scratch: &Scratch,
    ) -> Option<Appointment> {
        self.preferred_but(IndexSet::EMPTY, attended, scratch)
    }

    /// The same without a look at somebody who rests; whoever rests now may be appointed for later.
    fn preferred_but(&self, resting: IndexSet, attended: IndexSet, scratch: &Scratch) -> Option<Appointment> {
        let worth = |a: &Appointment| scratch.values[self.actions() + self.diary().index(*a)];
        let better =
            |best: Appointment, next: Appointment| if worth(&next) > worth(&best) { next } else { best };
        let awake = |a: &Appointment| a.wait > 0 || !resting.contains(a.slot);
        self.open_appointments(attended).filter(awake).reduce(better)
    }

    /// What to do where an appointment is kept, or made: the look that is due, or the move.
    pub(in crate::counterfactual) fn next_by_appointment(
        &self,
        resting: IndexSet,
        gaze: &mut Gaze,
        scratch: &mut Scratch,
    ) -> Next {
        let attended = gaze.attended();
        match gaze.appointment() {
            Some(Appointment { wait: 0, slot }) if !attended.contains(slot) && !resting.contains(slot) => {
                return Next::Look(slot);
            }
            Some(Appointment { wait, .. }) if wait > 0 => {
                self.evaluate(gaze.input(), scratch);
                return Next::Move(self.best_move(scratch));
            }
            _ => self.evaluate(gaze.input(), scratch),
        }
        let made = self.preferred_but(resting, attended, scratch);
        gaze.appoint(made);
        match made {
            Some(Appointment { wait: 0, slot }) => Next::Look(slot),
            _ => Next::Move(self.best_move(scratch)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::counterfactual::config::CounterfactualConfig;
    use crate::counterfactual::student::StudentShape;
    use crate::counterfactual::student::gaze::MemoryConfig;
    use crate::counterfactual::student::rule::Rule;
    use crate::random::Streams;

    fn student(max_looks: usize) -> Student {
        let rule = Rule::Appointed { max_looks, ahead: 3 };
        let shape = StudentShape { blocks: vec![1; 3], prices: vec![1.0; 3], actions: 2, rule };
        let memory = MemoryConfig { looks: 1, steps: 4, ..MemoryConfig::default() };
        let config = CounterfactualConfig { memory, ..CounterfactualConfig::default() };
        Student::new(&config, &shape, &Streams::new(1)).unwrap()
    }

    #[test]
    fn every_appointment_has_its_place() {
        let diary = Diary { slots: 3, ahead: 2 };
        assert_eq!(diary.len(), 9);
        assert!((0..9).all(|i| diary.index(diary.at(i)) == i));
        assert_eq!(diary.at(7), Appointment { slot: 1, wait: 2 });
    }

    #[test]
    fn an_appointment_is_kept_and_nobody_is_looked_at_before() {
        let student = student(1);
        let (mut gaze, mut scratch) = (Gaze::new(student.layout()), student.scratch());
        gaze.appoint(Some(Appointment { slot: 1, wait: 2 }));
        for _ in 0..2 {
            assert!(matches!(student.next(&mut gaze, &mut scratch), Next::Move(_)));
            student.advance(&mut gaze, 0);
            assert!(!gaze.has_appointed());
        }
        assert_eq!(student.next(&mut gaze, &mut scratch), Next::Look(1));
        gaze.look(student.layout(), 1, &[0.5]);
        assert!(
            matches!(student.next(&mut gaze, &mut scratch), Next::Move(_)),
            "one look is all it may take"
        );
        assert!(gaze.has_appointed() && gaze.appointment().is_some_and(|next| next.wait > 0));
    }

    #[test]
    fn whoever_rests_is_not_waited_for() {
        let student = student(1);
        let (mut gaze, mut scratch) = (Gaze::new(student.layout()), student.scratch());
        gaze.appoint(Some(Appointment { slot: 1, wait: 0 }));
        let next = student.next_but(IndexSet::EMPTY.with(1), &mut gaze, &mut scratch);
        assert_ne!(next, Next::Look(1));
        assert!(gaze.appointment().is_some());
    }

    #[test]
    fn only_what_can_be_looked_at_can_be_appointed() {
        let student = student(2);
        let seen = IndexSet::EMPTY.with(0);
        let open = |attended| student.open_appointments(attended).collect::<Vec<_>>();
        assert_eq!(open(IndexSet::EMPTY).len(), 3 * 4);
        assert!(open(seen).iter().all(|a| (a.slot, a.wait) != (0, 0)), "nobody is looked at twice");
        assert!(open(seen.with(1)).iter().all(|a| a.wait > 0), "two looks are enough");
        let mut scratch = student.scratch();
        let dear = Appointment { slot: 2, wait: 3 };
        scratch.values[student.actions() + student.diary().index(dear)] = 1.0;
        assert_eq!(student.preferred_appointment(seen, &scratch), Some(dear));
        // Who rests is not looked at now, and takes nobody else's place.
        let now = |slot| Appointment { slot, wait: 0 };
        scratch.values[student.actions() + student.diary().index(now(1))] = 3.0;
        scratch.values[student.actions() + student.diary().index(now(2))] = 2.0;
        assert_eq!(student.preferred_but(IndexSet::EMPTY.with(1), seen, &scratch), Some(now(2)));
    }
}
