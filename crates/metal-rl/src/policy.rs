//! Trait [`Policy`]: before every motor action, whom to consult next, or how to move. Eqs. (8, 9).

use crate::decision::DecisionState;
use crate::explore::Exploration;
use crate::random::Rng;

/// A_ACL = A_motor ∪ A_perceptual. Eqs. (8, 9).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Choice {
    /// Consult this member (a perceptual action). Eq. (9).
    Consult(usize),
    /// Carry out this motor action. Eq. (12).
    Move(usize),
}

/// Everything a policy may know when it chooses.
#[derive(Clone, Copy, Debug)]
pub struct Situation<'a> {
    /// Who said what so far in this motor step.
    pub state: &'a DecisionState,
    /// The expert advisor's action, for policies that ask for it (Phase I).
    pub advice: Option<usize>,
    /// How far to stray from the best choice.
    pub exploration: Exploration,
    /// Share of the phase that is over, in [0, 1].
    pub progress: f64,
}

/// One motor step as a policy experienced it: the looks it paid for, then the move and what it earned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Experience {
    /// Reward of the motor action.
    pub motor_reward: f64,
    /// Whether the world ended (a time limit is no end).
    pub terminal: bool,
}

/// Chooses looks and moves; learns, if it learns, from its own experience.
pub trait Policy: Send {
    /// Whether [`Situation::advice`] is needed.
    fn wants_advice(&self) -> bool {
        false
    }

    /// The next look or the move. Consulting somebody twice in a motor step is an error of the policy.
    fn choose(&mut self, situation: &Situation<'_>, rng: &mut Rng) -> Choice;

    /// What the last move led to. Called once after every motor action of a phase in which the policy learns.
    fn experience(&mut self, _experience: Experience) {}

    /// The episode is over: learn from it. If a time limit ended it, one more decision was asked for after the last
    /// experience and not carried out, so that its value can stand for the future that was cut off.
    fn learn(&mut self) {}

    /// A new episode begins; `learning` says whether experience will follow.
    fn begin(&mut self, _learning: bool) {}

    /// What the last choice was weighed by, if looks are weighed against moves here: values of all moves, then of looks
    /// by slot of the roster; empty if that choice was left to chance. For pages and figures.
    fn weighed(&self) -> Option<&[f64]> {
        None
    }
}

/// One choice of a policy that is overheard: a look or a move.
#[derive(Clone, Copy, Debug)]
pub struct Heard<'a> {
    /// Who had said what so far.
    pub state: &'a DecisionState,
    /// See [`Policy::weighed`].
    pub values: Option<&'a [f64]>,
    /// What was chosen.
    pub choice: Choice,
}

/// Told of every choice; nothing can be changed.
pub type Ear<'a> = &'a mut (dyn FnMut(&Heard<'_>) + Send);
