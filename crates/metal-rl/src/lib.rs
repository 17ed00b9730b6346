//! The mind of METAL: tiny agents that each see one sensor, a full observer, and an attention controller that learns
//! whom to consult before each motor action, paying for every look.
#![forbid(unsafe_code)]

pub mod environment;
pub mod learner;
pub mod learners;
pub mod num;
pub mod random;
pub mod set;
pub mod support;
pub mod view;
