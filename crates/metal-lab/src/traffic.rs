//! tmp
#![allow(missing_docs)]
use std::sync::Arc;
pub fn driver() -> Option<Arc<dyn metal_worlds::highway::Driver>> { None }
pub fn planned_steps() -> Result<usize, crate::train::RunError> { Ok(0) }
pub fn train(_p: &dyn crate::progress::Progress) -> Result<Vec<u8>, crate::train::RunError> { Ok(vec![]) }
