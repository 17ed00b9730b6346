//! Stopwatch of the benchmarks: the shortest of many short rounds, so that whoever else uses the machine disturbs least.

use std::io::Write;
use std::time::{Duration, Instant};

/// What begins a line of measurement in the output of a benchmark.
pub const MARK: &str = "measured";

/// How long one benchmark is repeated.
const PATIENCE: Duration = Duration::from_millis(1500);

/// Shortest time of one round of `work`, in seconds, of all rounds within a second and a half.
///
/// A round should take about a millisecond: long against the clock's resolution, short against the scheduler's slices.
pub fn shortest_round_secs(mut work: impl FnMut()) -> f64 {
    let begin = Instant::now();
    let mut best = f64::INFINITY;
    while begin.elapsed() < PATIENCE {
        let round = Instant::now();
        work();
        best = best.min(round.elapsed().as_secs_f64());
    }
    best
}

/// Measures `work`, which does `count` times `what`, and prints one line: group, name, seconds per `what`, `what`.
///
/// # Errors
/// If nobody takes the line.
pub fn measure(
    (group, name): (&str, &str),
    (count, what): (usize, &str),
    work: impl FnMut(),
) -> std::io::Result<()> {
    tell((group, name), shortest_round_secs(work) / count as f64, what)
}

/// As [`measure`], of an `amount` that grows from row to row of the group.
///
/// # Errors
/// If nobody takes the line.
pub fn measure_growth(
    (group, name, amount): (&str, &str, f64),
    (count, what): (usize, &str),
    work: impl FnMut(),
) -> std::io::Result<()> {
    tell_growth((group, name, amount), shortest_round_secs(work) / count as f64, what)
}

/// As [`tell`], of an `amount` that grows from row to row of the group.
///
/// # Errors
/// If nobody takes the line.
pub fn tell_growth((group, name, amount): (&str, &str, f64), secs: f64, what: &str) -> std::io::Result<()> {
    writeln!(std::io::stdout().lock(), "{MARK}\t{group}\t{name}\t{secs:e}\t{what}\t{amount}")
}

/// Prints the line of a measurement that was made, or reckoned, elsewhere.
///
/// # Errors
/// If nobody takes the line.
pub fn tell((group, name): (&str, &str), secs: f64, what: &str) -> std::io::Result<()> {
    writeln!(std::io::stdout().lock(), "{MARK}\t{group}\t{name}\t{secs:e}\t{what}")
}
