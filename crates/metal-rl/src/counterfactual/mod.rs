//! Counterfactual roll-out policy iteration: attention and moves learned together from what *would* have happened.
//!
//! The student drives and looks as it can. At visited states a [`Judge`] says what every motor action would have been
//! worth under the student's own continuation (its own looks, its own prices): by default [`RollOuts`] in forked
//! worlds with common noise, or a [`critic`] learned from the log where a world cannot be copied. Looks need no second world, because looking moves nothing: any order of looks can be
//! replayed on a fully observed state, so a look is worth −price + the best that is known with one reading more.
//! One network, or one mixture of Gaussians ([`mixture`]), holds the values for all sets of readings. In the order of the data:
//! [`config`] → [`gaze`] → [`student`] → [`sight`] → [`judge`] → [`fit`] → [`mod@iterate`].
//!
//! Where the world is drawn from a model that can be asked ([`Believer`]), the model decides on moves and only looks are
//! learned.
//!
//! Not in the paper: it answers the question of the paper's introduction, whether attention beats "a fixed subset (or
//! a static combination) of sensors", on which its Phase III (see [`crate::policies::attention`]) stays open.

pub mod appointment;
mod approximator;
mod believer;
pub mod config;
pub mod critic;
pub mod diary;
mod eyes;
pub mod fit;
pub mod gaze;
pub mod iterate;
pub mod judge;
pub mod log;
pub mod mixture;
mod purse;
pub mod recollection;
pub mod roll_outs;
pub mod rule;
pub mod sight;
pub mod student;
mod trial;
mod units;

pub use believer::Believer;
pub use config::{CounterfactualConfig, FitConfig, Inputs, Unit};
pub use critic::CriticConfig;
pub use diary::Iterate;
pub use gaze::MemoryConfig;
pub use iterate::{CounterfactualError, Graduate, School, Term, iterate, iterate_term};
pub use judge::{Alone, Judge, JudgeConfig, Judged, Workers};
pub use mixture::MixtureConfig;
pub use recollection::RecollectionConfig;
pub use roll_outs::RollOuts;
pub use rule::{LookRule, UnknownMember};
pub use student::{Student, StudentShape};
