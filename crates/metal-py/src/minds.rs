//! Learned minds: they act through a reader of sensors, are tested, saved and loaded.

use crate::errors::{Failure, environment_error, guarded, refuse, run_error};
use crate::python_world::read_into;
use crate::tasks::Task;
use crate::work::without_gil;
use metal_lab::task::{Driver, Learned, load as load_mind, save as save_mind, trial};
use metal_rl::environment::{Environment, EnvironmentError, EnvironmentSpec, Outcome};
use metal_rl::phase::Phase;
use metal_rl::random::Streams;
use metal_rl::run::{Stage, decide};
use pyo3::prelude::*;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// A mind that was learned.
#[pyclass(frozen, module = "metal_rl._core")]
pub struct Mind {
    inner: Learned,
    seed: u64,
    notes: BTreeMap<String, String>,
}

impl Mind {
    /// A mind learned from `seed`.
    pub fn new(inner: Learned, seed: u64) -> Self {
        Self { inner, seed, notes: BTreeMap::new() }
    }
}

/// The drivers by name.
fn driver(name: &str) -> PyResult<Driver> {
    Ok(match name {
        "METAL" => Driver::Attention,
        "all sensors" => Driver::Observer,
        "fusion" => Driver::Fusion,
        "expert" => Driver::Advisor,
        other => {
            let message = format!("`{other}`: METAL, all sensors, fusion or expert");
            return Err(refuse("driver", &message));
        }
    })
}

#[pymethods]
impl Mind {
    /// One decision: `reader(sensor)` is called for exactly the sensors the mind asks for. Returns the index of the
    /// motor action, the indices of the sensors read in order, and the price of the looks.
    fn act(&self, reader: Bound<'_, PyAny>) -> PyResult<(usize, Vec<usize>, f64)> {
        guarded(|| {
            let failure = Failure::default();
            let controller = self.inner.controller.as_ref();
            let mut policy = controller.ok_or_else(|| refuse("attention", "nothing was learned"))?.policy();
            let mut body =
                Reader { reader: reader.unbind(), spec: self.inner.spec.clone(), failure: failure.clone() };
            let mut members = self.inner.members.clone();
            let scaling = self.inner.recipe.scaling;
            let phase = Phase::evaluation("act", self.inner.tiny_agents(), 1);
            let mut stage =
                Stage { environment: &mut body, members: &mut members, policy: policy.as_mut(), scaling };
            let decided = decide(&mut stage, &phase, &Streams::new(0))
                .map_err(|e| failure.take().unwrap_or_else(|| environment_error(&e)))?;
            Ok((decided.action, decided.order, decided.look_price))
        })
    }

    /// Greedy test of `driver` over `course` (episodes, seed) of `task`, in JSON.
    fn evaluate(&self, py: Python<'_>, task: &Task, driver: &str, course: (usize, u64)) -> PyResult<String> {
        guarded(|| {
            let ((episodes, seed), driver) = (course, self::driver(driver)?);
            let spec = without_gil(py, task, |task, _| Ok(task.testing()?.spec().clone()))?;
            if spec.sensors != self.inner.spec.sensors || spec.actions != self.inner.spec.actions {
                let message = format!("{}: other sensors or actions than {}", spec.id, self.inner.spec.id);
                return Err(refuse("task", &message));
            }
            let runs = (episodes, &Streams::new(seed));
            let score = without_gil(py, task, |task, _| trial(task, &self.inner, driver, runs))?;
            serde_json::to_string(&score).map_err(|e| refuse("score", &e.to_string()))
        })
    }

    /// Writes the mind as safetensors with its card.
    fn save(&self, path: PathBuf, notes: BTreeMap<String, String>) -> PyResult<()> {
        guarded(|| save_mind(&self.inner, &path, self.seed, notes).map_err(run_error))
    }

    /// The contract of the task, in JSON.
    fn spec(&self) -> PyResult<String> {
        serde_json::to_string(&self.inner.spec).map_err(|e| refuse("spec", &e.to_string()))
    }

    /// How it was learned, in JSON.
    fn recipe(&self) -> PyResult<String> {
        serde_json::to_string(&self.inner.recipe).map_err(|e| refuse("recipe", &e.to_string()))
    }

    /// The seed it was learned from.
    #[getter]
    fn seed(&self) -> u64 {
        self.seed
    }

    /// What was kept with it.
    #[getter]
    fn notes(&self) -> BTreeMap<String, String> {
        self.notes.clone()
    }
}

/// The mind in a safetensors file.
#[pyfunction]
pub fn load(path: PathBuf) -> PyResult<Mind> {
    guarded(|| {
        let (inner, card) = load_mind(&path).map_err(run_error)?;
        Ok(Mind { inner, seed: card.seed, notes: card.notes })
    })
}

/// Sensors without a world: whoever holds them reads on demand.
struct Reader {
    reader: Py<PyAny>,
    spec: EnvironmentSpec,
    failure: Failure,
}

impl Reader {
    fn no_body(&self) -> EnvironmentError {
        let reason = "a reader has no body".to_owned();
        EnvironmentError::Motor { environment: self.spec.id.clone(), action: String::new(), reason }
    }
}

impl Environment for Reader {
    fn spec(&self) -> &EnvironmentSpec {
        &self.spec
    }

    fn reset(&mut self, _seed: u64) -> Result<(), EnvironmentError> {
        Err(self.no_body())
    }

    fn sense(&mut self, sensor: usize, out: &mut [f64]) -> Result<(), EnvironmentError> {
        let name = &self.spec.sensors[sensor].name;
        let read = Python::attach(|py| read_into(&self.reader.bind(py).call1((name,))?, out));
        read.map_err(|error| {
            let reason = error.to_string();
            self.failure.keep(error);
            EnvironmentError::Sensor { environment: self.spec.id.clone(), sensor: name.clone(), reason }
        })
    }

    fn step(&mut self, _action: usize) -> Result<Outcome, EnvironmentError> {
        Err(self.no_body())
    }

    fn measures(&self) -> &[f64] {
        &[]
    }
}
