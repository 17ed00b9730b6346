//! The learners: one file or folder each, all behind [`crate::learner::Learner`].
mod frozen;
mod settings;
pub mod nn;
pub mod mlp;
