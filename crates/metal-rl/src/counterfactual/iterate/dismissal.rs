//! Members that are hardly asked are dismissed: the fewer there are to choose from, the better the choice is learned.

use crate::counterfactual::student::Student;
use crate::set::IndexSet;
use serde::{Deserialize, Serialize};

/// Who was asked how often, in the tests of all iterates at full price since somebody could be dismissed last.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(in crate::counterfactual) struct Dismissal {
    asked: Vec<usize>,
}

impl Dismissal {
    /// Takes in how often each slot was asked in the test of an iteration; when it is time, dismisses from `student`
    /// whoever was hardly asked. Whether anybody had to go.
    pub fn after(&mut self, iteration: usize, asked: &[usize], student: &mut Student) -> bool {
        self.asked.resize(asked.len(), 0);
        self.asked.iter_mut().zip(asked).for_each(|(all, now)| *all += now);
        if !student.config().dismisses_after(iteration) {
            return false;
        }
        let before = student.kept();
        student.keep(kept(&self.asked, before, student.config().dismissal));
        self.asked.fill(0);
        student.kept() != before
    }

    /// Whether it can be that of a course with so many slots.
    pub fn fits(&self, slots: usize) -> bool {
        self.asked.is_empty() || self.asked.len() == slots
    }
}

/// The slots among `before` that were `asked` often enough, or most; all, if nobody was.
fn kept(asked: &[usize], before: IndexSet, least: f64) -> IndexSet {
    let most = before.iter().map(|slot| asked[slot]).max().unwrap_or(0);
    if most == 0 {
        return before;
    }
    let all = before.iter().map(|slot| asked[slot]).sum::<usize>() as f64;
    let enough = |&slot: &usize| asked[slot] == most || asked[slot] as f64 >= least * all;
    before.iter().filter(enough).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::counterfactual::config::CounterfactualConfig;
    use crate::counterfactual::student::StudentShape;
    use crate::counterfactual::student::rule::Rule;
    use crate::random::Streams;

    #[test]
    fn who_is_hardly_asked_is_dismissed() {
        let all = IndexSet::first(3);
        assert_eq!(kept(&[90, 9, 1], all, 0.05), IndexSet::first(2));
        assert_eq!(kept(&[90, 9, 1], all.without(1), 0.0), all.without(1));
        assert_eq!(
            kept(&[900, 60, 40], all.without(0), 0.3),
            all.without(0),
            "looks at what is no choice do not count"
        );
        assert_eq!(kept(&[0, 0, 0], all, 0.05), all);
        assert_eq!(kept(&[30, 30, 40], all, 0.5), IndexSet::EMPTY.with(2), "somebody has to stay");
    }

    #[test]
    fn again_and_again_by_what_was_asked_since() {
        let config = CounterfactualConfig {
            iterations: 12,
            wide_eyed: 1,
            price_ramp: 3,
            dismissal: 0.2,
            dismissed_every: 0.25,
            ..CounterfactualConfig::default()
        };
        let times: Vec<usize> = (0..12).filter(|&i| config.dismisses_after(i)).collect();
        assert_eq!(times, [6, 9], "not after the third: looks do not cost their full price yet");
        let rule = Rule::Adaptive { min_looks: 0, max_looks: 3 };
        let shape = StudentShape { blocks: vec![1; 3], prices: vec![1.0; 3], actions: 2, rule };
        let mut student = Student::new(&config, &shape, &Streams::new(1)).unwrap();
        let mut dismissal = Dismissal::default();
        assert!(!dismissal.after(5, &[10, 40, 0], &mut student));
        assert!(dismissal.after(6, &[90, 0, 5], &mut student), "100, 40 and 5 looks");
        assert_eq!(student.kept(), IndexSet::first(2));
        assert!(!dismissal.after(7, &[10, 10, 0], &mut student));
        assert!(dismissal.after(9, &[0, 40, 0], &mut student), "10 and 50 since");
        assert_eq!(student.kept(), IndexSet::EMPTY.with(1));
        assert!(dismissal.fits(3) && !dismissal.fits(2));
    }
}
