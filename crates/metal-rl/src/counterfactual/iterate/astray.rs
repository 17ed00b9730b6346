//! Iterates that go astray: an iterate much worse than the best is given up for it, and then drives a part of the next
//! drive, judged with the future of the student that it was given up for. Where only the best one drives, nobody learns
//! what is right where the next fit goes wrong, too, and the same mistake comes back for ever.

use super::diary::{Iterate, best};
use super::{CounterfactualError, Course, School, drive_limit, own_drive};
use crate::counterfactual::judge::{Drive, Labels};
use crate::counterfactual::student::Student;
use crate::observe::Observer;
use crate::phase::Phase;

impl Course<'_> {
    /// Writes an iterate down; if it is much worse than the best, that one goes on in its place.
    pub(super) fn note(&mut self, iterate: Iterate) {
        self.diary.push(iterate);
        self.past.push(self.student.clone());
        self.stray = None;
        // Who looks at everybody tells nothing about how good the same student's own looks are.
        let since = self.since.max(self.student.config().wide_eyed_iterations());
        if self.diary.len() <= since {
            return;
        }
        let share = iterate.price_share;
        let best = since + best(&self.diary[since..], share);
        if iterate.is_worse_than(&self.diary[best], share, self.student.config().tolerance) {
            self.stray = Some(std::mem::replace(&mut self.student, self.past[best].clone()));
            if self.student.config().thrifty {
                // What comes after the best was judged for students that were given up.
                self.window.retain(|lesson| lesson.iteration <= best + 1);
            }
        } else {
            self.held += 1;
        }
    }

    /// Labels of an iteration: of the student's own drive and, if the last iterate was given up, of that one's.
    pub(super) fn drive(
        &mut self,
        school: &mut School<'_>,
        phase: &Phase,
        (own_steps, price_share): (usize, f64),
        observer: &mut dyn Observer,
    ) -> Result<Labels, CounterfactualError> {
        let config = self.student.config();
        let at = (self.next, config.iterations);
        let limit = drive_limit(at, config.first_drives, school.environment.spec().horizon);
        let streams = self.streams.nth(self.next as u64);
        let mut all = Labels::default();
        for (driver, steps, name) in drivers(&self.student, self.stray.as_ref(), own_steps) {
            if steps > 0 {
                let (phase, streams) = (own_drive(phase, at, steps), streams.child(name));
                let drive = Drive { student: &self.student, driver, phase, limit, price_share, streams };
                all.add(self.judge.labels(school, &drive, observer)?);
            }
        }
        Ok(all)
    }
}

/// Who drives how many of `steps`, from which stream.
fn drivers<'a>(
    student: &'a Student,
    stray: Option<&'a Student>,
    steps: usize,
) -> [(&'a Student, usize, &'static str); 2] {
    let config = student.config();
    // What the other one recollects or has appointed means nothing to the student.
    let strange = config.memory.recurrent > 0 || student.rule().appoints();
    let share = if strange || stray.is_none() { 0.0 } else { config.astray };
    let astray = (steps as f64 * share) as usize;
    [(student, steps - astray, "drive"), (stray.unwrap_or(student), astray, "astray")]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::counterfactual::config::CounterfactualConfig;
    use crate::counterfactual::iterate::purse::Purse;
    use crate::counterfactual::judge::Alone;
    use crate::counterfactual::student::StudentShape;
    use crate::counterfactual::student::gaze::MemoryConfig;
    use crate::counterfactual::student::rule::Rule;
    use crate::random::Streams;
    use crate::set::IndexSet;

    fn student(config: &CounterfactualConfig, seed: u64) -> Student {
        let rule = Rule::Adaptive { min_looks: 0, max_looks: 2 };
        let shape = StudentShape { blocks: vec![1; 2], prices: vec![1.0; 2], actions: 2, rule };
        Student::new(config, &shape, &Streams::new(seed)).unwrap()
    }

    fn iterate(total: f64) -> Iterate {
        Iterate {
            own_steps: 10,
            rolled_steps: 0,
            validation_steps: 10,
            price_share: 1.0,
            idle: 0.0,
            loss: 0.0,
            total,
            motor: total,
            looks: 0.0,
            run_steps: 10.0,
            runs: 1,
            error: 0.0,
        }
    }

    #[test]
    fn who_was_given_up_drives_and_the_best_goes_on() {
        let config = CounterfactualConfig { wide_eyed: 0, astray: 0.25, ..CounterfactualConfig::default() };
        let (good, bad) = (student(&config, 1), student(&config, 2));
        let phase = Phase::evaluation("attention", IndexSet::first(2), 1);
        let mut course = Course {
            next: 0,
            judge: config.judge.build(&Alone, &Streams::new(3)),
            student: good.clone(),
            window: Default::default(),
            diary: Vec::new(),
            past: Vec::new(),
            purse: Purse::new(&phase, &config, 10),
            spread: Default::default(),
            held: 0,
            stray: None,
            dismissal: Default::default(),
            since: 0,
            streams: Streams::new(4),
        };
        course.note(iterate(-1.0));
        assert!(course.stray.is_none(), "the first is the best");
        course.student = bad.clone();
        course.note(iterate(-2.0));
        assert_eq!(course.student.freeze(), good.freeze());
        assert_eq!(course.stray.as_ref().map(Student::freeze), Some(bad.freeze()));
        let [own, astray] = drivers(&course.student, course.stray.as_ref(), 100);
        assert_eq!((own.0.freeze(), own.1), (good.freeze(), 75));
        assert_eq!((astray.0.freeze(), astray.1), (bad.freeze(), 25));
        // Once members are gone, what was possible with them is no record any more.
        (course.student, course.since) = (bad, 2);
        course.note(iterate(-3.0));
        assert!(course.stray.is_none());
    }

    #[test]
    fn nobody_drives_for_a_student_who_cannot_use_it() {
        let plain = CounterfactualConfig::default();
        let good = student(&plain, 1);
        assert_eq!(drivers(&good, None, 9).map(|d| d.1), [9, 0]);
        let memory = MemoryConfig { looks: 1, steps: 2, actions: 0, recurrent: 16 };
        let dreamer = student(&CounterfactualConfig { memory, ..plain }, 1);
        assert_eq!(drivers(&dreamer, Some(&good), 9).map(|d| d.1), [9, 0]);
    }
}
