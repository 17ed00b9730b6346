//! `metal check`: whether a task is well posed.

use crate::args::Check;
use crate::bar::Bar;
use crate::commands::{csv_task, listen_to_ctrl_c, say, say_json};
use metal_lab::bench::{self, CheckOptions};
use metal_lab::task::{NamedTask, Task};
use std::path::Path;

/// Checks the task and prints what was found.
pub fn run(request: &Check) -> anyhow::Result<()> {
    listen_to_ctrl_c()?;
    let task: Box<dyn Task> = match &request.target {
        Some(target) => Box::new(csv_task(Path::new(&request.task), target, request.prices.as_deref())?),
        None => Box::new(NamedTask::with(&request.task, &request.settings)?),
    };
    let (episodes, steps) = (request.episodes as usize, request.steps as usize);
    let options = CheckOptions { seed: request.seed, episodes, steps };
    let sensors = task.training()?.spec().sensors.len();
    let bar = Bar::new(bench::planned_check_steps(&options, sensors) as u64);
    let found = bench::check(task.as_ref(), &options, &bar);
    bar.finish();
    let found = found?;
    if request.json { say_json(&found) } else { say(&bench::check_text(&found)) }
}
