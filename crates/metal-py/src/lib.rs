//! The Rust half of the Python package `metal_rl`. What users see is in `python/metal_rl`; this module only carries
//! tasks, minds and numbers across, never a panic, and lets go of the interpreter while Rust works.

mod errors;
mod learning;
mod minds;
mod python_world;
mod tasks;
mod vector;
mod work;
mod worlds;

use pyo3::prelude::*;

/// Learning with priced sensors, in Rust.
#[pymodule]
mod _core {
    #[pymodule_export]
    use super::errors::MetalError;
    #[pymodule_export]
    use super::learning::{bench, check, default_recipe, learn};
    #[pymodule_export]
    use super::minds::{Mind, load};
    #[pymodule_export]
    use super::tasks::Task;
    #[pymodule_export]
    use super::vector::Vector;
    #[pymodule_export]
    use super::worlds::World;

    use pyo3::prelude::*;

    /// Tells Python the version of the library.
    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
