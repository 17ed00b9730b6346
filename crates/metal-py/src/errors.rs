//! Errors of Rust as exceptions of Python, with the field they are about. No panic gets across.

use metal_lab::plan::PlanError;
use metal_lab::train::RunError;
use metal_rl::environment::EnvironmentError;
use pyo3::exceptions::{PyKeyboardInterrupt, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, PoisonError};

pyo3::create_exception!(
    metal_rl,
    MetalError,
    PyValueError,
    "A task, recipe or file that cannot be used; `field` says where, the message what was found and what is allowed."
);

/// The Python exception that stopped a world, kept while the error travels through Rust.
#[derive(Clone, Default)]
pub struct Failure(Arc<Mutex<Option<PyErr>>>);

impl Failure {
    /// Keeps the first exception; those that follow are its consequences.
    pub fn keep(&self, error: PyErr) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
    }

    /// The exception that was kept, if there is one.
    pub fn take(&self) -> Option<PyErr> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    /// The exception that was kept, or else what Rust made of it.
    pub fn or(&self, error: RunError) -> PyErr {
        self.take().unwrap_or_else(|| run_error(error))
    }
}

/// A refusal with its field as an attribute.
pub fn refuse(field: &str, message: &str) -> PyErr {
    plan_error(&PlanError::at(field, message))
}

fn plan_error(error: &PlanError) -> PyErr {
    Python::attach(|py| {
        let exception = MetalError::new_err(error.to_string());
        match exception.value(py).setattr("field", &error.field) {
            Ok(()) => exception,
            Err(other) => other,
        }
    })
}

/// What a run stopped for.
pub fn run_error(error: RunError) -> PyErr {
    match error {
        RunError::Plan(e) => plan_error(&e),
        RunError::World(e) => refuse(&e.field, &e.message),
        RunError::Learner(e) => refuse("learner", &e.to_string()),
        RunError::Environment(e) => environment_error(&e),
        RunError::Counterfactual(e) => refuse("attention", &e.to_string()),
        RunError::Checkpoint(e) => refuse("checkpoint", &e.to_string()),
        RunError::Demonstrations(e) => refuse("demonstrations", &e.to_string()),
        RunError::Interrupted => PyKeyboardInterrupt::new_err(()),
    }
}

/// What a world failed with.
pub fn environment_error(error: &EnvironmentError) -> PyErr {
    PyRuntimeError::new_err(error.to_string())
}

/// Carries out `job`; a panic becomes a RuntimeError.
pub fn guarded<T>(job: impl FnOnce() -> PyResult<T>) -> PyResult<T> {
    catch_unwind(AssertUnwindSafe(job)).unwrap_or_else(|panic| Err(panicked(panic.as_ref())))
}

/// A panic as an exception.
pub fn panicked(panic: &(dyn std::any::Any + Send)) -> PyErr {
    let text = panic.downcast_ref::<&str>().map(|s| (*s).to_owned());
    let text = text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default();
    PyRuntimeError::new_err(format!("metal_rl: internal error, please report it: {text}"))
}
