//! Counterfactual roll-out policy iteration: attention and moves learned together from what *would* have happened.
//!
//! The student drives and looks as it can. At visited states a [`Judge`] says what every motor action would have been
//! worth under the student's own continuation (its own looks, its own prices): by default [`RollOuts`] in forked
//! worlds with common noise, or a [`judge::critic`] learned from the log where a world cannot be copied. Looks need no second world, because looking moves nothing: any order of looks can be
//! replayed on a fully observed state, so a look is worth −price + the best that is known with one reading more.
//! One network, or one mixture of Gaussians ([`student::mixture`]), holds the values for all sets of readings. In the order of the data:
//! [`config`] → [`student::gaze`] → [`student`] → [`judge::sight`] → [`judge`] → [`fit`] → [`mod@iterate`].
//!
//! Where the world is drawn from a model that can be asked ([`Believer`]), the model decides on moves and only looks are
//! learned.
//!
//! Not in the paper: it answers the question of the paper's introduction, whether attention beats "a fixed subset (or
//! a static combination) of sensors", on which its Phase III (see [`crate::policies::attention`]) stays open.

pub mod config;
pub mod fit;
pub mod iterate;
pub mod judge;
pub mod student;

pub use config::{CounterfactualConfig, FitConfig, Inputs, Unit};
pub use iterate::diary::Iterate;
pub use iterate::{CounterfactualError, Graduate, School, Term, iterate, iterate_term};
pub use judge::critic::CriticConfig;
pub use judge::roll_outs::RollOuts;
pub use judge::{Alone, Judge, JudgeConfig, Judged, Workers};
pub use student::believer::Believer;
pub use student::gaze::MemoryConfig;
pub use student::mixture::MixtureConfig;
pub use student::recollection::RecollectionConfig;
pub use student::rule::{LookRule, UnknownMember};
pub use student::{Student, StudentShape};
