//! A world whose body is a Python object: Rust asks it for exactly the sensor, step or advice that is needed.

use crate::errors::{Failure, refuse};
use metal_lab::train::RunError;
use metal_rl::environment::{End, Environment, EnvironmentError, EnvironmentSpec, Outcome};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;

/// A Python object with `_reset(seed)`, `_sense(sensor)`, `_step(action)` and `_advise()` as an [`Environment`].
pub struct PythonWorld {
    body: Py<PyAny>,
    spec: EnvironmentSpec,
    failure: Failure,
}

/// How `_step` names the end of an episode.
const ENDS: [End; 3] = [End::Running, End::Terminal, End::TimeLimit];

/// The contract of a Python task.
pub fn spec_of(body: &Bound<'_, PyAny>) -> PyResult<EnvironmentSpec> {
    let text: String = body.call_method0("_spec")?.extract()?;
    serde_json::from_str(&text).map_err(|e| refuse("task", &e.to_string()))
}

impl PythonWorld {
    fn new(body: Py<PyAny>, spec: EnvironmentSpec, failure: Failure) -> Self {
        Self { body, spec, failure }
    }

    fn call<T>(&self, job: impl FnOnce(Python<'_>, &Bound<'_, PyAny>) -> PyResult<T>) -> Result<T, String> {
        Python::attach(|py| job(py, self.body.bind(py))).map_err(|error| {
            let text = error.to_string();
            self.failure.keep(error);
            text
        })
    }

    fn motor(&self, action: &str, reason: String) -> EnvironmentError {
        EnvironmentError::Motor { environment: self.spec.id.clone(), action: action.to_owned(), reason }
    }
}

impl Environment for PythonWorld {
    fn spec(&self) -> &EnvironmentSpec {
        &self.spec
    }

    fn reset(&mut self, seed: u64) -> Result<(), EnvironmentError> {
        let done = self.call(|_, body| body.call_method1("_reset", (seed,)).map(drop));
        done.map_err(|reason| self.motor("reset", reason))
    }

    fn sense(&mut self, sensor: usize, out: &mut [f64]) -> Result<(), EnvironmentError> {
        let read = self.call(|_, body| read_into(&body.call_method1("_sense", (sensor,))?, out));
        let name = &self.spec.sensors[sensor].name;
        let refused = |reason: String| EnvironmentError::Sensor {
            environment: self.spec.id.clone(),
            sensor: name.clone(),
            reason,
        };
        read.map_err(&refused)?;
        if out.iter().all(|x| x.is_finite()) {
            return Ok(());
        }
        let message =
            format!("{out:?}: not finite; declare the sensor with missing=True if readings may be absent");
        self.failure.keep(refuse(&format!("sensors.{name}"), &message));
        Err(refused(message))
    }

    fn step(&mut self, action: usize) -> Result<Outcome, EnvironmentError> {
        let stepped = self.call(|_, body| body.call_method1("_step", (action,))?.extract::<(f64, usize)>());
        let (motor_reward, end) = stepped.map_err(|reason| self.motor(&self.spec.actions[action], reason))?;
        if !motor_reward.is_finite() {
            let message = format!("{motor_reward}: a reward is finite");
            self.failure.keep(refuse("reward", &message));
            return Err(self.motor(&self.spec.actions[action], message));
        }
        Ok(Outcome { motor_reward, end: ENDS[end.min(2)] })
    }

    fn measures(&self) -> &[f64] {
        &[]
    }

    fn advise(&mut self) -> Option<usize> {
        let asked = self.call(|_, body| body.call_method0("_advise")?.extract::<Option<usize>>());
        asked.ok().flatten().filter(|a| *a < self.spec.actions.len())
    }

    fn fork(&self) -> Option<Box<dyn Environment>> {
        let copy = Python::attach(|py| {
            let copy = self.body.bind(py).call_method0("_fork").ok()?;
            (!copy.is_none()).then(|| copy.unbind())
        })?;
        Some(Box::new(Self::new(copy, self.spec.clone(), self.failure.clone())))
    }
}

/// Numbers of a numpy array, a sequence or a single number, which must be as many as `out` has room for.
pub fn read_into(value: &Bound<'_, PyAny>, out: &mut [f64]) -> PyResult<()> {
    if let Ok(array) = value.cast::<PyArray1<f64>>() {
        let view = array.readonly();
        if let Ok(slice) = view.as_slice() {
            return copy(slice, out);
        }
    }
    if let Ok(number) = value.extract::<f64>() {
        return copy(&[number], out);
    }
    copy(&value.extract::<Vec<f64>>()?, out)
}

fn copy(values: &[f64], out: &mut [f64]) -> PyResult<()> {
    if values.len() != out.len() {
        return Err(refuse("reading", &format!("{} numbers, but {} were declared", values.len(), out.len())));
    }
    out.copy_from_slice(values);
    Ok(())
}

/// A task whose worlds are one Python object, used by one thread at a time.
pub struct PythonTask {
    body: Py<PyAny>,
    testing: Py<PyAny>,
    watching: Py<PyAny>,
    spec: EnvironmentSpec,
    opinions: Vec<usize>,
    failure: Failure,
}

impl PythonTask {
    /// The task of `body`; tests happen in `testing`, and an expert is watched in `watching`.
    pub fn new(
        body: &Bound<'_, PyAny>,
        (watching, testing): (&Bound<'_, PyAny>, &Bound<'_, PyAny>),
        failure: Failure,
    ) -> PyResult<Self> {
        let opinions = body.call_method0("_opinions")?.extract()?;
        let spec = spec_of(body)?;
        let own = |object: &Bound<'_, PyAny>| object.clone().unbind();
        let (body, watching, testing) = (own(body), own(watching), own(testing));
        Ok(Self { body, testing, watching, spec, opinions, failure })
    }

    fn world(&self, body: &Py<PyAny>) -> Box<dyn Environment> {
        let body = Python::attach(|py| body.clone_ref(py));
        Box::new(PythonWorld::new(body, self.spec.clone(), self.failure.clone()))
    }
}

impl metal_lab::task::Task for PythonTask {
    fn training(&self) -> Result<Box<dyn Environment>, RunError> {
        Ok(self.world(&self.body))
    }

    fn testing(&self) -> Result<Box<dyn Environment>, RunError> {
        Ok(self.world(&self.testing))
    }

    fn watching(&self) -> Result<Box<dyn Environment>, RunError> {
        Ok(self.world(&self.watching))
    }

    fn is_parallel(&self) -> bool {
        false
    }

    fn opinions(&self) -> Vec<usize> {
        self.opinions.clone()
    }
}
