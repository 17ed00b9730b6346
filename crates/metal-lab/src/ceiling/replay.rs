//! Replay: any way of looking along the log, as if somebody had looked like that there.

use super::lesson::{SLOWEST, decide};
use super::log::{Episode, Moment};
use super::situation::MOST;
use super::subject::Subject;
use metal_rl::counterfactual::Student;
use metal_rl::counterfactual::student::gaze::Gaze;
use metal_rl::set::IndexSet;

/// What an episode comes to under one way of looking; sums over its motor steps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Score {
    pub steps: f64,
    pub looks: f64,
    pub price: f64,
    /// What is lost against the driver's own moves, by situation.
    pub losses: [f64; MOST],
    /// Motor steps by situation.
    pub moments: [f64; MOST],
}

impl Score {
    pub fn loss(&self) -> f64 {
        self.losses.iter().sum()
    }

    /// What is paid and lost.
    pub fn cost(&self) -> f64 {
        self.loss() + self.price
    }

    fn add(&mut self, moment: &Moment, action: usize, (looks, price): (IndexSet, f64)) {
        self.steps += 1.0;
        self.looks += looks.len() as f64;
        self.price += price;
        self.losses[moment.situation] += moment.loss(action);
        self.moments[moment.situation] += 1.0;
    }

    /// Both together.
    pub fn and(mut self, other: &Self) -> Self {
        self.steps += other.steps;
        self.looks += other.looks;
        self.price += other.price;
        for i in 0..MOST {
            self.losses[i] += other.losses[i];
            self.moments[i] += other.moments[i];
        }
        self
    }
}

/// Sum over episodes.
pub(super) fn sum(scores: &[Score]) -> Score {
    scores.iter().fold(Score::default(), Score::and)
}

/// A fixed choice of looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Fixed {
    /// Who is looked at.
    pub slots: IndexSet,
    /// At every so many motor steps.
    pub every: usize,
    /// Whether looks are remembered.
    pub remembers: bool,
}

/// Every subset without memory, and every subset at every rhythm with memory.
pub(super) fn choices(slots: usize) -> Vec<Fixed> {
    let subsets = || (0..1u64 << slots).map(IndexSet::from_bits);
    let plain = subsets().map(|slots| Fixed { slots, every: 1, remembers: false });
    let rhythms = subsets().flat_map(|slots| {
        let slowest = if slots.is_empty() { 1 } else { SLOWEST };
        (1..=slowest).map(move |every| Fixed { slots, every, remembers: true })
    });
    plain.chain(rhythms).collect()
}

/// `student` under a fixed choice of looks, episode by episode.
pub(super) fn fixed(
    subject: &Subject<'_>,
    student: &Student,
    choice: Fixed,
    episodes: &[&Episode],
) -> Vec<Score> {
    let paid = (choice.slots, subject.price(choice.slots));
    let mut scratch = student.scratch();
    replayed(student, episodes, |gaze, moment| {
        let due = gaze.clock().is_multiple_of(choice.every);
        if due {
            choice.slots.iter().for_each(|slot| gaze.look_again(student.layout(), slot, &moment.readings));
        }
        student.evaluate(gaze.input(), &mut scratch);
        (student.best_move(&scratch), if due { paid } else { (IndexSet::EMPTY, 0.0) })
    })
}

/// `student` with its own looks.
pub(super) fn adaptive(subject: &Subject<'_>, student: &Student, episodes: &[&Episode]) -> Vec<Score> {
    let mut scratch = student.scratch();
    replayed(student, episodes, |gaze, moment| {
        let (action, _) = decide(student, gaze, &moment.readings, &mut scratch);
        (action, (gaze.attended(), subject.price(gaze.attended())))
    })
}

/// Plays every episode: `step` looks and says the move, its looks and their price.
fn replayed(
    student: &Student,
    episodes: &[&Episode],
    mut step: impl FnMut(&mut Gaze, &Moment) -> (usize, (IndexSet, f64)),
) -> Vec<Score> {
    let mut gaze = Gaze::new(student.layout());
    let mut play = |episode: &&Episode| {
        gaze.reset();
        let mut score = Score::default();
        for moment in episode.iter() {
            let (action, paid) = step(&mut gaze, moment);
            score.add(moment, action, paid);
            gaze.advance(student.layout(), moment.action);
        }
        score
    };
    episodes.iter().map(&mut play).collect()
}
