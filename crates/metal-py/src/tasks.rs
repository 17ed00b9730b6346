//! Tasks as Python holds them.

use crate::errors::{Failure, guarded, refuse, run_error};
use crate::python_world::PythonTask;
use metal_lab::task::{NAMES, NamedTask, TableTask, Task as LabTask};
use pyo3::prelude::*;
use std::sync::Arc;

/// A task: a built-in world or a Python object that plays one.
#[pyclass(frozen, module = "metal_rl._core")]
pub struct Task {
    /// The task itself.
    pub inner: Arc<dyn LabTask + Send + Sync>,
    /// Where exceptions of Python are kept while they travel through Rust.
    pub failure: Failure,
    /// Whether Rust alone is enough to run it.
    pub native: bool,
}

#[pymethods]
impl Task {
    /// The built-in task `name` with `settings` in JSON.
    #[staticmethod]
    fn named(name: &str, settings: &str) -> PyResult<Self> {
        guarded(|| {
            let inner = Arc::new(NamedTask::with(name, settings).map_err(run_error)?);
            Ok(Self { inner, failure: Failure::default(), native: true })
        })
    }

    /// The task that the Python object `body` plays; an expert is watched in `watching`, tests happen in `testing`.
    #[staticmethod]
    fn python(
        body: &Bound<'_, PyAny>,
        watching: &Bound<'_, PyAny>,
        testing: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        guarded(|| {
            let failure = Failure::default();
            let inner = Arc::new(PythonTask::new(body, (watching, testing), failure.clone())?);
            Ok(Self { inner, failure, native: false })
        })
    }

    /// The task of a table with prices, both in JSON.
    #[staticmethod]
    fn table(table: &str, prices: &str) -> PyResult<Self> {
        guarded(|| {
            let read = |field: &'static str| move |e: serde_json::Error| refuse(field, &e.to_string());
            let raw = serde_json::from_str(table).map_err(read("table"))?;
            let prices = serde_json::from_str(prices).map_err(read("prices"))?;
            let inner = Arc::new(TableTask::new(&raw, &prices).map_err(run_error)?);
            Ok(Self { inner, failure: Failure::default(), native: true })
        })
    }

    /// Names of the built-in tasks.
    #[staticmethod]
    fn names() -> Vec<&'static str> {
        NAMES.to_vec()
    }

    /// The contract of the task in JSON.
    fn spec(&self) -> PyResult<String> {
        guarded(|| {
            let world = self.inner.training().map_err(|e| self.failure.or(e))?;
            serde_json::to_string(world.spec()).map_err(|e| refuse("task", &e.to_string()))
        })
    }

    /// Sensors that are experts' opinions.
    fn opinions(&self) -> Vec<usize> {
        self.inner.opinions()
    }
}
