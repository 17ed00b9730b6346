//! The mind of METAL: tiny agents that each see one sensor, a full observer, and an attention controller that learns
//! whom to consult before each motor action, paying for every look.
//!
//! In the order in which data flows:
//! [`environment`] → [`view`] → [`member`] (with its [`learner`]) → [`decision`] → [`policy`] → [`mod@run`] → [`teach`].
#![forbid(unsafe_code)]

pub mod belief;
pub mod environment;
pub mod view;

pub mod learner;
pub mod learners;
pub mod support;

pub mod decision;
pub mod member;

pub mod explore;
pub mod fuse;
pub mod policies;
pub mod policy;

pub mod phase;
pub mod returns;
pub mod run;
pub mod teach;

pub mod counterfactual;

pub mod measure;
pub mod observe;
pub mod partition;

pub mod num;
pub mod random;
pub mod set;
