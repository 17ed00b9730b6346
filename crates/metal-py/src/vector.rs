//! Many worlds of one task, stepped on threads of Rust.

use crate::errors::{environment_error, guarded, refuse, run_error};
use crate::tasks::Task;
use crate::worlds::code;
use metal_rl::environment::{End, Environment, EnvironmentError};
use metal_rl::random::Streams;
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use rayon::prelude::*;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// One of the worlds, and what its last step brought.
struct Lane {
    world: Box<dyn Environment>,
    streams: Streams,
    episode: u64,
    over: bool,
    reading: Vec<f64>,
    outcome: (f64, usize),
}

impl Lane {
    fn begin(&mut self, seed: Option<u64>) -> Result<(), EnvironmentError> {
        if let Some(seed) = seed {
            self.streams = Streams::new(seed);
            self.episode = 0;
        }
        self.world.reset(self.streams.nth(self.episode).seed())?;
        self.episode += 1;
        self.over = false;
        self.outcome = (0.0, 0);
        self.read()
    }

    /// A step; the one after the end of an episode begins the next (Gymnasium's autoreset at the next step).
    fn step(&mut self, action: usize) -> Result<(), EnvironmentError> {
        if self.over {
            return self.begin(None);
        }
        let outcome = self.world.step(action)?;
        self.over = outcome.end != End::Running;
        self.outcome = (outcome.motor_reward, code(outcome.end));
        self.read()
    }

    fn read(&mut self) -> Result<(), EnvironmentError> {
        let (mut at, sensors) = (0, self.world.spec().sensors.len());
        for sensor in 0..sensors {
            let size = self.world.spec().sensors[sensor].features.len();
            self.world.sense(sensor, &mut self.reading[at..at + size])?;
            at += size;
        }
        Ok(())
    }
}

/// Many worlds of one task.
#[pyclass(frozen, module = "metal_rl._core")]
pub struct Vector {
    lanes: Mutex<Vec<Lane>>,
    count: usize,
    width: usize,
    actions: usize,
}

/// Observations, one row per world.
type Rows<'py> = Bound<'py, PyArray2<f32>>;
/// Observations, rewards and how each episode stands.
type Stepped<'py> = (Rows<'py>, Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<i64>>);

impl Vector {
    fn lock(&self) -> MutexGuard<'_, Vec<Lane>> {
        self.lanes.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn rows<'py>(&self, py: Python<'py>, flat: Vec<f32>) -> PyResult<Rows<'py>> {
        let rows = flat.len() / self.width;
        PyArray1::from_vec(py, flat).reshape([rows, self.width])
    }
}

/// All readings, one world after the other.
fn readings(lanes: &[Lane]) -> Vec<f32> {
    lanes.iter().flat_map(|l| l.reading.iter().map(|&x| x as f32)).collect()
}

#[pymethods]
impl Vector {
    /// `count` worlds of a built-in task.
    #[new]
    fn new(py: Python<'_>, task: &Task, testing: bool, count: usize) -> PyResult<Self> {
        guarded(|| {
            if !task.native || count == 0 {
                return Err(refuse("num_envs", "at least one world, and of a built-in task"));
            }
            let inner = task.inner.clone();
            let lane = |i: usize| {
                let world = if testing { inner.testing()? } else { inner.training()? };
                let width = world.spec().sensors.iter().map(|s| s.features.len()).sum();
                let (streams, reading) = (Streams::new(i as u64), vec![0.0; width]);
                Ok(Lane { world, streams, episode: 0, over: true, reading, outcome: (0.0, 0) })
            };
            let lanes =
                py.detach(|| (0..count).map(lane).collect::<Result<Vec<_>, _>>()).map_err(run_error)?;
            let (width, actions) = (lanes[0].reading.len(), lanes[0].world.spec().actions.len());
            Ok(Self { lanes: Mutex::new(lanes), count, width, actions })
        })
    }

    /// Begins an episode everywhere; a world without a seed goes on with its next one.
    fn reset<'py>(&self, py: Python<'py>, seeds: Vec<Option<u64>>) -> PyResult<Rows<'py>> {
        guarded(|| {
            if seeds.len() != self.count {
                return Err(refuse("seed", &format!("{} seeds for {} worlds", seeds.len(), self.count)));
            }
            let begin = |(lane, seed): (&mut Lane, &Option<u64>)| lane.begin(*seed);
            let begun = py.detach(|| {
                let mut lanes = self.lock();
                lanes.par_iter_mut().zip(&seeds).try_for_each(begin).map(|()| readings(&lanes))
            });
            self.rows(py, begun.map_err(|e| environment_error(&e))?)
        })
    }

    /// One step everywhere.
    fn step<'py>(&self, py: Python<'py>, actions: Vec<usize>) -> PyResult<Stepped<'py>> {
        guarded(|| {
            if actions.len() != self.count || actions.iter().any(|a| *a >= self.actions) {
                let message = format!("{actions:?}: {} actions below {}", self.count, self.actions);
                return Err(refuse("action", &message));
            }
            let step = |(lane, action): (&mut Lane, &usize)| lane.step(*action);
            let stepped = py.detach(|| {
                let mut lanes = self.lock();
                lanes.par_iter_mut().zip(&actions).try_for_each(step)?;
                let outcomes: (Vec<f64>, Vec<i64>) =
                    lanes.iter().map(|l| (l.outcome.0, l.outcome.1 as i64)).unzip();
                Ok((readings(&lanes), outcomes))
            });
            let (flat, (rewards, ends)) = stepped.map_err(|e| environment_error(&e))?;
            Ok((self.rows(py, flat)?, PyArray1::from_vec(py, rewards), PyArray1::from_vec(py, ends)))
        })
    }
}
