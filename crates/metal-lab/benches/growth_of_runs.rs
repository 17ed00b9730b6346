//! How the time of a whole run (training, tests and screening of the paper's experiment, shortened) grows with threads,
//! seeds and episodes: seconds on the wall and seconds of processors, the shortest of a few runs.

use metal_lab::experiments;
use metal_lab::plan::{self, Plan};
use metal_lab::progress::Silent;
use metal_lab::reproduce::{Options, execute, quick};
use metal_rl::phase::Budget;
use std::error::Error;
use std::time::Instant;

/// How often each run is repeated.
const ROUNDS: usize = 2;

/// Clock ticks per second in which Linux counts processors' time.
const TICKS: f64 = 100.0;

/// The paper's experiment as `--quick` shortens it, with so many times its episodes.
fn shortened(times: usize) -> Result<Plan, Box<dyn Error>> {
    let mut file = quick::shrink(plan::parse(experiments::PAPER, &[])?.file);
    for phase in file.phase.values_mut() {
        phase.budget = match phase.budget {
            Budget::Episodes(n) => Budget::Episodes(n * times),
            Budget::Steps(n) => Budget::Steps(n * times),
        };
    }
    file.evaluation.runs *= times;
    if let Some(subsets) = &mut file.subsets {
        subsets.screening_runs *= times;
    }
    Ok(Plan::check(file)?)
}

/// Seconds that all threads of this process have computed; none where the system does not say so.
fn processor_secs() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    // After the name, which may contain anything: fields 14 and 15 of all.
    let fields = stat.rsplit_once(')')?.1.split_whitespace();
    let ticks: Vec<f64> = fields.skip(11).take(2).filter_map(|n| n.parse().ok()).collect();
    (ticks.len() == 2).then(|| (ticks[0] + ticks[1]) / TICKS)
}

/// Runs `times` as many episodes as the shortest run, for so many seeds; prints a row of `group`, in which `amount` grows.
fn measure(
    group: &str,
    amount: usize,
    (threads, seeds, times): (usize, usize, usize),
) -> Result<(), Box<dyn Error>> {
    let plan = shortened(times)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    let (mut wall, mut processors) = (f64::INFINITY, f64::INFINITY);
    for _ in 0..ROUNDS {
        let options = Options { seeds, seed: 1, quick: true, all_subsets: false };
        let (start, before) = (Instant::now(), processor_secs());
        pool.install(|| execute(plan.clone(), options, &Silent))?;
        wall = wall.min(start.elapsed().as_secs_f64());
        let spent = before.zip(processor_secs()).map(|(before, after)| after - before);
        processors = processors.min(spent.unwrap_or(f64::INFINITY));
    }
    let name = format!("{threads} threads, {seeds} seeds, {times} × episodes");
    let all = [("on the wall", wall), ("of processors", processors)];
    for (kind, secs) in all.into_iter().filter(|(_, secs)| secs.is_finite()) {
        xtask::tell_growth((&format!("{group}, time {kind}"), &name, amount as f64), secs, "run")?;
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    for threads in [1, 2] {
        measure("threads", threads, (threads, 2, 1))?;
    }
    for seeds in [1, 2, 4] {
        measure("seeds", seeds, (1, seeds, 1))?;
    }
    for times in [1, 2, 4] {
        measure("episodes", times, (1, 1, times))?;
    }
    Ok(())
}
