//! placeholder
pub mod maze;
pub mod toy;
