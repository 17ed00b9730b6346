//! One built-in world, sensor by sensor, for the Gymnasium classes.

use crate::errors::{environment_error, guarded, refuse, run_error};
use crate::tasks::Task;
use metal_rl::environment::{End, Environment};
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// A built-in world.
#[pyclass(frozen, module = "metal_rl._core")]
pub struct World {
    inner: Mutex<Box<dyn Environment>>,
}

impl World {
    fn lock(&self) -> MutexGuard<'_, Box<dyn Environment>> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// How the end of an episode is told: 0 it goes on, 1 the world is over, 2 somebody stopped the clock.
pub fn code(end: End) -> usize {
    match end {
        End::Running => 0,
        End::Terminal => 1,
        End::TimeLimit => 2,
    }
}

#[pymethods]
impl World {
    /// A world of `task`: the one for tests, or the one for learning.
    #[new]
    fn new(py: Python<'_>, task: &Task, testing: bool) -> PyResult<Self> {
        guarded(|| {
            if !task.native {
                return Err(refuse("task", "a Python task is its own world"));
            }
            let inner = task.inner.clone();
            let world = py.detach(|| if testing { inner.testing() } else { inner.training() });
            Ok(Self { inner: Mutex::new(world.map_err(run_error)?) })
        })
    }

    /// Begins the episode of `seed`.
    fn reset(&self, py: Python<'_>, seed: u64) -> PyResult<()> {
        guarded(|| py.detach(|| self.lock().reset(seed)).map_err(|e| environment_error(&e)))
    }

    /// Reads one sensor.
    fn sense<'py>(&self, py: Python<'py>, sensor: usize) -> PyResult<Bound<'py, PyArray1<f64>>> {
        guarded(|| {
            let reading = py.detach(|| {
                let mut world = self.lock();
                let Some(spec) = world.spec().sensors.get(sensor) else { return Ok(None) };
                let mut out = vec![0.0; spec.features.len()];
                world.sense(sensor, &mut out).map(|()| Some(out))
            });
            let reading = reading.map_err(|e| environment_error(&e))?;
            let reading = reading.ok_or_else(|| refuse("sensor", &format!("{sensor}: there is none")))?;
            Ok(reading.into_pyarray(py))
        })
    }

    /// Carries out a motor action: its reward, and how the episode stands (0 goes on, 1 over, 2 time limit).
    fn step(&self, py: Python<'_>, action: usize) -> PyResult<(f64, usize)> {
        guarded(|| {
            let outcome = py.detach(|| {
                let mut world = self.lock();
                let known = action < world.spec().actions.len();
                known.then(|| world.step(action)).transpose()
            });
            let outcome = outcome.map_err(|e| environment_error(&e))?;
            let outcome = outcome.ok_or_else(|| refuse("action", &format!("{action}: there is none")))?;
            Ok((outcome.motor_reward, code(outcome.end)))
        })
    }

    /// What an expert with ground truth would do now, if there is one.
    fn advise(&self) -> Option<usize> {
        self.lock().advise()
    }

    /// Facts about the last step, for records only.
    fn measures(&self) -> Vec<f64> {
        self.lock().measures().to_vec()
    }
}
