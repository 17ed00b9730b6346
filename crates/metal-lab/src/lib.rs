//! Experiments as data, and what becomes of them: plans, training and testing over seeds, statistics, the numbers of a
//! run (`results.json`), the paper's printed numbers beside them, figures as SVG, and the self-contained HTML report.
#![forbid(unsafe_code)]

pub mod plan;
pub mod registry;
pub mod traffic;

pub mod catalogue;
pub mod checkpoint;
pub mod experiments;

pub mod demonstrations;
pub mod drives;
pub mod evaluate;
pub mod faults;
pub mod finish;
pub mod learn_on;
pub mod mind;
pub mod recorded;
pub mod reevaluate;
pub mod reproduce;
mod teach;
pub mod trace;
pub mod train;
pub mod transfer;
pub mod watched;

pub mod figures;
pub mod paper;
pub mod report;
pub mod results;
pub mod store;

pub mod progress;

pub mod bench;
pub mod ceiling;
pub mod partition;
pub mod prices;
pub mod task;

pub use metal_rl::measure::aliasing::bound as aliasing_bound;

#[cfg(doctest)]
mod guide;
