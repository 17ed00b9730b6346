//! Judges: what every motor action would have been worth where the student drove. [`RollOuts`] carries all of them out in
//! copies of the world; the [`Critic`] learns it from the log where there are no copies (real robots, other people's
//! simulators).

pub mod critic;
pub(in crate::counterfactual) mod eyes;
pub mod log;
pub mod roll_outs;
pub mod sight;

use self::critic::{Critic, CriticConfig};
use self::roll_outs::RollOuts;
use self::sight::Sight;
use super::iterate::{CounterfactualError, School};
use super::student::Student;
use super::student::appointment::{Diary, Kept};
use super::student::recollection::Footstep;
use crate::environment::EnvironmentError;
use crate::learner::LearnerError;
use crate::learners::frozen;
use crate::member::Member;
use crate::observe::Observer;
use crate::phase::Phase;
use crate::policies::Counterfactual;
use crate::random::{Rng, Streams};
use crate::run::{Stage, run};
use crate::set::IndexSet;
use crate::view::Scaling;
use serde::{Deserialize, Serialize};

/// A sight with its labels: to learn from, through any set of looks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Judged {
    /// The network's input as if everybody had been looked at.
    pub full: Vec<f32>,
    /// Motor steps since the beginning of the episode.
    pub clock: usize,
    /// Slots that the student looked at before its move.
    pub looks: IndexSet,
    /// Value of each motor action after these looks, minus that of the best.
    pub advantages: Vec<f64>,
    /// Value of the best motor action after these looks.
    pub value: f64,
    /// What moving was worth after these looks (first) and after others. Empty if looks leave no trace: then moves are
    /// worth the same after any.
    pub stops: Vec<Stop>,
    /// What appointments were worth that the student could have made here, if it makes any.
    pub appointments: Option<Appointed>,
}

/// Appointments that could have been made at a moment, judged.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Appointed {
    /// Looks that were taken before.
    pub looks: IndexSet,
    /// The appointments, the student's own among them.
    pub kept: Vec<Kept>,
}

impl Appointed {
    /// Whether all of them are in such a diary, with looks among `all`.
    pub(super) fn fits(&self, diary: Diary, all: IndexSet) -> bool {
        let known = |kept: &Kept| kept.appointment.slot < diary.slots && kept.appointment.wait <= diary.ahead;
        self.looks.minus(all).is_empty() && self.kept.iter().all(known)
    }
}

/// What it is worth to stop looking and to make the move that the student finds best then.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stop {
    /// Slots that were looked at before the move, and are remembered after it.
    pub looks: IndexSet,
    /// Value of the move, minus that of the best move after the student's own looks.
    pub worth: f64,
}

impl Judged {
    /// What moving after looks at `mask` turned out to be worth, if the move is `action` where looks leave no trace; and
    /// whether it was judged for these very looks. Others stand in where it was not: those that differ least.
    #[must_use]
    pub fn stop(&self, mask: IndexSet, action: usize) -> (f64, bool) {
        let differ = |s: &Stop| s.looks.minus(mask).union(mask.minus(s.looks)).len();
        let nearest =
            self.stops.iter().reduce(|best, next| if differ(next) < differ(best) { next } else { best });
        nearest.map_or((self.advantages[action], true), |s| (s.worth, s.looks == mask))
    }
}

/// The work of a judge on some sights: labels, and the motor steps simulated for them.
pub type Verdict = Result<(Vec<Judged>, usize), EnvironmentError>;

/// A drive of the student's own, from which it is to be taught.
pub struct Drive<'a> {
    /// The student that is taught: whose future is judged.
    pub student: &'a Student,
    /// Who drives: the student itself, or one that was given up for it.
    pub driver: &'a Student,
    /// Exploration and budget.
    pub phase: Phase,
    /// Motor steps after which episodes begin anew.
    pub limit: usize,
    /// Share of the price of looking that counts.
    pub price_share: f64,
    /// All randomness of the drive and of judging it.
    pub streams: Streams,
}

/// What a judge says after a drive.
#[derive(Default)]
pub struct Labels {
    /// Moments with what every move was worth.
    pub judged: Vec<Judged>,
    /// All motor steps of the drive, if the student has a recollection that is to learn from them.
    pub trail: Vec<Footstep>,
    /// Motor steps in copies of the world.
    pub rolled_steps: usize,
}

impl Labels {
    /// Takes in those of another drive.
    pub(super) fn add(&mut self, more: Self) {
        let before = self.judged.len();
        let later = |step: Footstep| Footstep { judged: step.judged.map(|i| before + i), ..step };
        self.trail.extend(more.trail.into_iter().map(later));
        self.judged.extend(more.judged);
        self.rolled_steps += more.rolled_steps;
    }
}

/// Lets the student drive and says what every motor action would have been worth on the way.
///
/// The values must be those under the student's *own* continuation, its looks paid at their share of the price: a
/// teacher who sees more than the student values what the student cannot do.
pub trait Judge {
    /// Labels for a drive in the school's world.
    ///
    /// # Errors
    /// If the world fails, or cannot be copied where copies are needed.
    fn labels(
        &mut self,
        school: &mut School<'_>,
        drive: &Drive<'_>,
        observer: &mut dyn Observer,
    ) -> Result<Labels, CounterfactualError>;

    /// Lets the student drive in the school's validation world, only to see how good it is.
    ///
    /// # Errors
    /// If the world fails.
    fn watch(
        &mut self,
        school: &mut School<'_>,
        drive: &Drive<'_>,
        observer: &mut dyn Observer,
    ) -> Result<(), CounterfactualError> {
        let mut driver = Counterfactual::new(drive.student.clone(), school.roster.clone());
        let mut stage = Stage {
            environment: &mut *school.validation,
            members: &mut *school.members,
            policy: &mut driver,
            scaling: school.scaling,
        };
        run(&mut stage, &drive.phase, &drive.streams, observer)?;
        Ok(())
    }

    /// What it carries from one drive to the next, as bytes; nothing, unless a judge says otherwise.
    fn freeze(&self) -> Vec<u8> {
        Vec::new()
    }

    /// Takes up where it stood when it became `bytes`, as the judge of such a student.
    ///
    /// # Errors
    /// If the bytes are damaged or another judge's.
    fn thaw(&mut self, _student: &Student, bytes: &[u8]) -> Result<(), LearnerError> {
        if bytes.is_empty() { Ok(()) } else { Err(frozen::foreign("judge")) }
    }
}

/// How moves are judged.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum JudgeConfig {
    /// By roll-outs in copies of the world.
    #[default]
    RollOuts,
    /// By a critic learned from the log of all drives, where there are no copies.
    Critic(CriticConfig),
}

impl JudgeConfig {
    /// The judge of these settings.
    #[must_use]
    pub fn build<'a>(&self, workers: &'a dyn Workers, streams: &Streams) -> Box<dyn Judge + 'a> {
        match self {
            Self::RollOuts => Box::new(RollOuts { workers }),
            Self::Critic(config) => Box::new(Critic::new(config.clone(), streams)),
        }
    }
}

/// Whose future is judged.
#[derive(Clone, Copy)]
pub struct Pupil<'a> {
    /// The student that drives on.
    pub student: &'a Student,
    /// All members of the mind.
    pub members: &'a [Member],
    /// Which of them each slot is.
    pub roster: &'a [usize],
    /// How readings are scaled.
    pub scaling: Scaling,
    /// Share of the price of looking that counts.
    pub price_share: f64,
}

impl<'a> Pupil<'a> {
    /// The student of a drive.
    #[must_use]
    pub fn of(school: &'a School<'_>, drive: &Drive<'a>) -> Self {
        Self {
            student: drive.student,
            members: school.members,
            roster: &school.roster,
            scaling: school.scaling,
            price_share: drive.price_share,
        }
    }
}

/// Does independent pieces of work, perhaps several at a time. The mind starts no threads itself; results must not
/// depend on who does them when.
pub trait Workers: Sync {
    /// Calls `work` on every piece and returns the results in the order of the pieces.
    fn map(&self, pieces: Vec<Vec<Sight>>, work: &(dyn Fn(Vec<Sight>) -> Verdict + Sync)) -> Vec<Verdict>;
}

/// Does one piece after the other.
#[derive(Clone, Copy, Debug, Default)]
pub struct Alone;

impl Workers for Alone {
    fn map(&self, pieces: Vec<Vec<Sight>>, work: &(dyn Fn(Vec<Sight>) -> Verdict + Sync)) -> Vec<Verdict> {
        pieces.into_iter().map(work).collect()
    }
}

/// Looks that a student who looked at `own` could have taken instead: none, one less, one more, a single one; each with
/// those that cost nothing.
pub(super) fn other_looks(student: &Student, own: IndexSet, rng: &mut Rng) -> [IndexSet; 4] {
    let (kept, gifts) = (student.kept(), student.gifts());
    let mut any = |from: IndexSet| from.iter().nth(rng.below(from.len().max(1)));
    let (out, into, single) = (any(own.minus(gifts)), any(kept.minus(own)), any(kept));
    [
        gifts,
        out.map_or(own, |slot| own.without(slot)),
        into.map_or(own, |slot| own.with(slot)),
        single.map_or(own, |slot| gifts.with(slot)),
    ]
}
