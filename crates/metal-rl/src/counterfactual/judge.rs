//! Judges: what every motor action would have been worth at a sight. The one here rolls all of them out in copies of
//! the world; a critic learned from logs can take its place where there are no copies (real robots).

use super::gaze::Gaze;
use super::sight::Sight;
use super::student::{Next, Scratch, Student};
use crate::decision::{Content, DecisionDims, DecisionState, Encoding};
use crate::environment::{End, Environment, EnvironmentError};
use crate::member::Member;
use crate::num;
use crate::view::{Percept, Scaling};

/// A sight with its labels: to learn from, through any set of looks.
#[derive(Clone, Debug, PartialEq)]
pub struct Judged {
    /// The network's input as if everybody had been looked at.
    pub full: Vec<f32>,
    /// Motor steps since the beginning of the episode.
    pub clock: usize,
    /// Value of each motor action minus that of the best, ≤ 0.
    pub advantages: Vec<f64>,
    /// Value of the best motor action.
    pub value: f64,
}

/// The work of a judge on some sights: labels, and the motor steps simulated for them.
pub type Verdict = Result<(Vec<Judged>, usize), EnvironmentError>;

/// Says what every motor action is worth at a sight.
///
/// The values must be those under the student's *own* continuation, its looks paid at the pupil's share of their price: a
/// teacher who sees more than the student values what the student cannot do.
pub trait Judge {
    /// Labels for `sights`, in their order, and how many motor steps they took.
    ///
    /// # Errors
    /// If a world fails.
    fn judge(&self, sights: Vec<Sight>, pupil: &Pupil<'_>) -> Verdict;
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

/// Sights in one piece of work.
const PIECE: usize = 64;

/// Roll-outs: at each sight the world is copied once per motor action, all copies with the same noise. The action is
/// carried out, the student drives on for `horizon` steps, and its own value stands for the rest.
pub struct RollOuts<'a> {
    /// Who does the work.
    pub workers: &'a dyn Workers,
}

impl Judge for RollOuts<'_> {
    /// # Panics
    /// If the copy of a world cannot be copied itself.
    fn judge(&self, sights: Vec<Sight>, pupil: &Pupil<'_>) -> Verdict {
        let mut pieces: Vec<Vec<Sight>> = Vec::new();
        for sight in sights {
            match pieces.last_mut() {
                Some(piece) if piece.len() < PIECE => piece.push(sight),
                _ => pieces.push(vec![sight]),
            }
        }
        let work = |piece: Vec<Sight>| {
            let Some(first) = piece.first() else { return Ok((Vec::new(), 0)) };
            let mut desk = Desk::new(*pupil, first.world.as_ref());
            let judged = piece.into_iter().map(|s| desk.judge(s)).collect::<Result<_, EnvironmentError>>()?;
            Ok((judged, desk.steps))
        };
        let (mut judged, mut steps) = (Vec::new(), 0);
        for verdict in self.workers.map(pieces, &work) {
            let (piece, taken) = verdict?;
            judged.extend(piece);
            steps += taken;
        }
        Ok((judged, steps))
    }
}

/// Working memory of one worker.
struct Desk<'a> {
    pupil: Pupil<'a>,
    student: &'a Student,
    encoding: Encoding,
    percept: Percept,
    state: DecisionState,
    block: Vec<f64>,
    scratch: Scratch,
    gaze: Gaze,
    steps: usize,
}

impl<'a> Desk<'a> {
    fn new(pupil: Pupil<'a>, world: &dyn Environment) -> Self {
        let student = pupil.student;
        let inputs = pupil.members.iter().map(|m| m.view.dims()).collect();
        let dims = DecisionDims { member_inputs: inputs, actions: student.actions() };
        Self {
            pupil,
            student,
            encoding: Encoding { content: student.config().content, ..Encoding::default() },
            percept: Percept::new(world.spec(), pupil.scaling),
            state: DecisionState::new(&dims),
            block: Vec::new(),
            scratch: student.scratch(),
            gaze: Gaze::new(student.layout()),
            steps: 0,
        }
    }

    fn judge(&mut self, mut sight: Sight) -> Result<Judged, EnvironmentError> {
        let actions = self.student.actions();
        let mut values = Vec::with_capacity(actions);
        for action in 0..actions {
            let mut world = sight.world.fork().expect("a copied world can be copied");
            self.gaze.clone_from(&sight.gaze);
            values.push(self.roll_out(world.as_mut(), action)?);
        }
        self.percept.clear();
        self.state.clear();
        self.gaze.clone_from(&sight.gaze);
        for slot in 0..self.pupil.roster.len() {
            self.look(sight.world.as_mut(), slot)?;
        }
        let value = num::max(&values);
        values.iter_mut().for_each(|v| *v -= value);
        let full = self.gaze.input().to_vec();
        Ok(Judged { full, clock: sight.gaze.clock(), advantages: values, value })
    }

    /// What `action` is worth from here: r + γ (looks and moves of the student) + … + its own value of what is left.
    fn roll_out(&mut self, world: &mut dyn Environment, mut action: usize) -> Result<f64, EnvironmentError> {
        let (horizon, gamma) = (self.student.config().horizon, self.student.config().gamma);
        let (mut total, mut discount) = (0.0, 1.0);
        for step in 1.. {
            let outcome = world.step(action)?;
            self.steps += 1;
            total += discount * outcome.motor_reward;
            discount *= gamma;
            if outcome.end == End::Terminal {
                break;
            }
            self.gaze.advance(self.student.layout(), action);
            let (next, price) = self.decide(world)?;
            total -= discount * price;
            if step == horizon || outcome.end == End::TimeLimit {
                if self.student.config().bootstrap {
                    total += discount * self.student.worth(&self.gaze, next, &self.scratch);
                }
                break;
            }
            action = next;
        }
        Ok(total)
    }

    /// The student's looks, then its move; and the price of the looks as it is learned from.
    fn decide(&mut self, world: &mut dyn Environment) -> Result<(usize, f64), EnvironmentError> {
        self.percept.clear();
        self.state.clear();
        let mut price = 0.0;
        loop {
            match self.student.next(&self.gaze, &mut self.scratch) {
                Next::Move(action) => return Ok((action, self.pupil.price_share * price)),
                Next::Look(slot) => price += self.look(world, slot)?,
            }
        }
    }

    fn look(&mut self, world: &mut dyn Environment, slot: usize) -> Result<f64, EnvironmentError> {
        let index = self.pupil.roster[slot];
        let member = &self.pupil.members[index];
        self.block.resize(self.student.layout().block(slot).len(), 0.0);
        let price = if self.encoding.content == Content::Readings {
            // What the member makes of its reading is not asked for, so it is not computed.
            member.read(world, &mut self.percept, &mut self.block)?
        } else {
            let price = member.consult(index, world, &mut self.percept, &mut self.state)?;
            if let Some(opinion) = self.state.opinion(index) {
                self.encoding.write(&opinion, &mut self.block);
            }
            price
        };
        self.gaze.look(self.student.layout(), slot, &self.block);
        Ok(price)
    }
}
