//! Long work without the interpreter, and Ctrl-C all the same.

use crate::errors::{guarded, panicked};
use crate::tasks::Task;
use metal_lab::progress::Progress;
use metal_lab::task::Task as LabTask;
use metal_lab::train::RunError;
use metal_rl::belief::Belief;
use metal_rl::environment::{Environment, EnvironmentError, EnvironmentSpec, Outcome};
use metal_rl::random::Streams;
use pyo3::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

/// How often Python is asked whether somebody pressed Ctrl-C.
const ASK: Duration = Duration::from_millis(50);

/// Carries out `job` on `task` with the interpreter released.
///
/// A Python task stays on the calling thread, where Python itself hears Ctrl-C. Rust alone works on a thread of its
/// own while this one listens; its worlds then fail at their next step.
pub fn without_gil<T: Send>(
    py: Python<'_>,
    task: &Task,
    job: impl FnOnce(&dyn LabTask, &Bar) -> Result<T, RunError> + Send,
) -> PyResult<T> {
    let stop = Arc::new(AtomicBool::new(false));
    let bar = Bar(stop.clone());
    if !task.native {
        let inner = task.inner.clone();
        return py.detach(|| guarded(|| job(inner.as_ref(), &bar).map_err(|e| task.failure.or(e))));
    }
    let stoppable = Stoppable { inner: task.inner.clone(), stop: stop.clone() };
    let mut interrupt = None;
    let finished = py.detach(|| {
        std::thread::scope(|scope| {
            let (done, listen) = channel::<()>();
            let worker = scope.spawn(move || {
                // Dropped when the job ends, even by a panic: that wakes the listener.
                let _done = done;
                job(&stoppable, &bar)
            });
            while listen.recv_timeout(ASK) == Err(RecvTimeoutError::Timeout) {
                if let Err(error) = Python::attach(|py| py.check_signals()) {
                    interrupt.get_or_insert(error);
                    stop.store(true, Ordering::Relaxed);
                }
            }
            worker.join()
        })
    });
    if let Some(error) = interrupt {
        return Err(error);
    }
    finished.map_err(|panic| panicked(panic.as_ref()))?.map_err(|e| task.failure.or(e))
}

/// Tells the library when to stop.
pub struct Bar(Arc<AtomicBool>);

impl Progress for Bar {
    fn steps(&self, _steps: usize) {}

    fn interrupted(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// A task whose worlds fail once somebody pressed Ctrl-C.
struct Stoppable {
    inner: Arc<dyn LabTask + Send + Sync>,
    stop: Arc<AtomicBool>,
}

impl Stoppable {
    fn wrap(&self, inner: Box<dyn Environment>) -> Box<dyn Environment> {
        Box::new(StoppableWorld { inner, stop: self.stop.clone() })
    }
}

impl LabTask for Stoppable {
    fn training(&self) -> Result<Box<dyn Environment>, RunError> {
        Ok(self.wrap(self.inner.training()?))
    }

    fn testing(&self) -> Result<Box<dyn Environment>, RunError> {
        Ok(self.wrap(self.inner.testing()?))
    }

    fn watching(&self) -> Result<Box<dyn Environment>, RunError> {
        Ok(self.wrap(self.inner.watching()?))
    }

    fn is_parallel(&self) -> bool {
        self.inner.is_parallel()
    }

    fn opinions(&self) -> Vec<usize> {
        self.inner.opinions()
    }
}

struct StoppableWorld {
    inner: Box<dyn Environment>,
    stop: Arc<AtomicBool>,
}

impl Environment for StoppableWorld {
    fn spec(&self) -> &EnvironmentSpec {
        self.inner.spec()
    }

    fn reset(&mut self, seed: u64) -> Result<(), EnvironmentError> {
        self.inner.reset(seed)
    }

    fn sense(&mut self, sensor: usize, out: &mut [f64]) -> Result<(), EnvironmentError> {
        self.inner.sense(sensor, out)
    }

    fn step(&mut self, action: usize) -> Result<Outcome, EnvironmentError> {
        if self.stop.load(Ordering::Relaxed) {
            let action = self.spec().actions[action].clone();
            let environment = self.spec().id.clone();
            return Err(EnvironmentError::Motor { environment, action, reason: "interrupted".to_owned() });
        }
        self.inner.step(action)
    }

    fn measures(&self) -> &[f64] {
        self.inner.measures()
    }

    fn advise(&mut self) -> Option<usize> {
        self.inner.advise()
    }

    fn fork(&self) -> Option<Box<dyn Environment>> {
        let inner = self.inner.fork()?;
        Some(Box::new(Self { inner, stop: self.stop.clone() }))
    }

    fn belief(&self) -> Option<Belief> {
        self.inner.belief()
    }

    fn imagine(&self, streams: &Streams) -> Option<Box<dyn Environment>> {
        let inner = self.inner.imagine(streams)?;
        Some(Box::new(Self { inner, stop: self.stop.clone() }))
    }
}
