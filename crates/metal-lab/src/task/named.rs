//! Tasks that come with the program, by name.

use super::Task;
use crate::plan::PlanError;
use crate::registry::EnvironmentConfig;
use crate::train::RunError;
use metal_rl::environment::Environment;
use metal_rl::random::Streams;

/// Names of the tasks that come with the program.
pub const NAMES: [&str; 6] = ["highway", "maze", "puddle", "toy", "cube", "cube_nm"];

/// A task that comes with the program.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedTask {
    /// The world to learn in.
    pub training: EnvironmentConfig,
    /// The world to be tested in.
    pub testing: EnvironmentConfig,
}

impl NamedTask {
    /// The task called `name`, with its default settings.
    ///
    /// # Errors
    /// If there is none of that name.
    pub fn new(name: &str) -> Result<Self, RunError> {
        if !NAMES.contains(&name) {
            let message = format!("unknown task `{name}`; known: {}", NAMES.join(", "));
            return Err(PlanError::at("task", message).into());
        }
        Self::with(name, "{}")
    }

    /// The task called `name`, with settings in JSON (those of the environment in an experiment file).
    ///
    /// # Errors
    /// If there is none of that name, or its settings are impossible.
    pub fn with(name: &str, settings: &str) -> Result<Self, RunError> {
        let read = |e: serde_json::Error| PlanError::at(format!("environment.{name}"), e.to_string());
        let settings: serde_json::Value = serde_json::from_str(settings).map_err(read)?;
        let config = serde_json::json!({ name: settings });
        let training: EnvironmentConfig = serde_json::from_value(config).map_err(read)?;
        let mut testing = training.clone();
        testing.set_roads(&crate::registry::Roads::Test);
        other_rows(&mut testing);
        let task = Self { training, testing };
        task.training()?;
        Ok(task)
    }
}

/// Rows of a generated table that is tested on.
const TEST_ROWS: usize = 4000;

/// Generated tables are tested on rows nobody has learned from: a seed of their own.
fn other_rows(config: &mut EnvironmentConfig) {
    let change = |rows: &mut usize, seed: &mut u64| {
        *rows = TEST_ROWS;
        *seed = Streams::new(*seed).child("test rows").seed();
    };
    match config {
        EnvironmentConfig::Cube(c) => change(&mut c.rows, &mut c.seed),
        EnvironmentConfig::CubeNm(c) => change(&mut c.rows, &mut c.seed),
        _ => {}
    }
}

impl Task for NamedTask {
    fn training(&self) -> Result<Box<dyn Environment>, RunError> {
        Ok(self.training.build()?)
    }

    fn testing(&self) -> Result<Box<dyn Environment>, RunError> {
        Ok(self.testing.build()?)
    }

    fn opinions(&self) -> Vec<usize> {
        match &self.training {
            EnvironmentConfig::Toy(_) => (0..7).collect(),
            _ => Vec::new(),
        }
    }
}
