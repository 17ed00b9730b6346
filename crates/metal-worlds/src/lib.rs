//! placeholder
pub mod puddle;
