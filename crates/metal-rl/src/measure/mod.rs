//! Pure functions from events to numbers (Sec. 3.3): structural measures, driving behaviour, aliasing, statistics.

pub mod aliasing;
pub mod behaviour;
pub mod curve;
pub mod empirical_aliasing;
pub mod looks;
pub mod statistics;
