//! Learning and comparing.

use crate::errors::{guarded, refuse};
use crate::minds::Mind;
use crate::tasks::Task;
use crate::work::without_gil;
use metal_lab::bench::{BenchOptions, CheckOptions, bench as compare, check as examine, check_text, text};
use metal_lab::task::{Recipe, learn as learn_task};
use metal_rl::observe::Unobserved;
use metal_rl::random::Streams;
use pyo3::prelude::*;

fn recipe(text: &str) -> PyResult<Recipe> {
    serde_json::from_str(text).map_err(|e| refuse("recipe", &e.to_string()))
}

/// The default recipe with `steps` motor steps from Phase II on, in JSON.
#[pyfunction]
pub fn default_recipe(steps: usize) -> PyResult<String> {
    serde_json::to_string(&Recipe::of_steps(steps)).map_err(|e| refuse("recipe", &e.to_string()))
}

/// Learns `task` after `recipe` (JSON).
#[pyfunction]
pub fn learn(py: Python<'_>, task: &Task, recipe: &str, seed: u64) -> PyResult<Mind> {
    guarded(|| {
        let recipe = self::recipe(recipe)?;
        let mind =
            without_gil(py, task, |task, _| learn_task(task, &recipe, &Streams::new(seed), &mut Unobserved))?;
        Ok(Mind::new(mind, seed))
    })
}

/// Compares everybody on `task`: results in JSON, and as text.
#[pyfunction]
pub fn bench(py: Python<'_>, task: &Task, recipe: &str, options: &str) -> PyResult<(String, String)> {
    guarded(|| {
        let recipe = self::recipe(recipe)?;
        let options: BenchOptions =
            serde_json::from_str(options).map_err(|e| refuse("options", &e.to_string()))?;
        let done = without_gil(py, task, |task, bar| compare(task, &recipe, &options, bar))?;
        let json = serde_json::to_string(&done).map_err(|e| refuse("bench", &e.to_string()))?;
        Ok((json, text(&done)))
    })
}

/// Says whether `task` is well posed: findings in JSON, and as text.
#[pyfunction]
pub fn check(py: Python<'_>, task: &Task, options: &str) -> PyResult<(String, String)> {
    guarded(|| {
        let options: CheckOptions =
            serde_json::from_str(options).map_err(|e| refuse("options", &e.to_string()))?;
        let found = without_gil(py, task, |task, bar| examine(task, &options, bar))?;
        let json = serde_json::to_string(&found).map_err(|e| refuse("check", &e.to_string()))?;
        Ok((json, check_text(&found)))
    })
}
