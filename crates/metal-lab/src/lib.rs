//! Experiments as data, and what becomes of them: the numbers of a run (`results.json`), the paper's printed numbers
//! to set beside them, figures as SVG, and the self-contained HTML report.
#![forbid(unsafe_code)]

pub mod figures;
pub mod paper;
pub mod report;
pub mod results;
