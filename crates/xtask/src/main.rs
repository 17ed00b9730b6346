//! Chores of the workspace. `cargo xtask bench [WORD]` runs all benchmarks (or those files whose name contains WORD) and
//! prints one table; the last column compares with the first row of the same group. Where an amount grows within a group,
//! a second table gives the exponent, and `cargo xtask bench growth FILE.svg` draws it.

mod growth;

use std::io::{Error, ErrorKind, Write};
use std::path::Path;
use std::process::{Command, ExitCode};
use xtask::MARK;

/// Benchmarks: package and file.
const BENCHES: [(&str, &str); 6] = [
    ("metal-worlds", "world"),
    ("metal-rl", "mind"),
    ("metal-rl", "growth"),
    ("metal-lab", "growth_of_runs"),
    ("metal-lab", "decisions"),
    ("metal-lab", "limits"),
];

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let done = match words.first().map(String::as_str) {
        Some("bench") => bench(words.get(1).map_or("", String::as_str), words.get(2).map(Path::new)),
        _ => Err(Error::new(ErrorKind::InvalidInput, "cargo xtask bench [WORD [FILE.svg]] is all there is")),
    };
    if let Err(error) = done {
        let _ = writeln!(std::io::stderr(), "{error}");
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}

/// A measurement.
#[derive(Debug, PartialEq)]
struct Row {
    group: String,
    name: String,
    secs: f64,
    /// What took so long.
    what: String,
    /// What grows within the group.
    amount: Option<f64>,
}

fn bench(word: &str, chart: Option<&Path>) -> Result<(), Error> {
    let mut rows = Vec::new();
    for (package, file) in BENCHES.iter().filter(|(_, file)| file.contains(word)) {
        rows.extend(run(package, file)?);
    }
    print(&rows)?;
    growth::print(&rows)?;
    chart.map_or(Ok(()), |file| growth::draw(&rows, file))
}

/// Runs one benchmark file and reads its measurements.
fn run(package: &str, file: &str) -> Result<Vec<Row>, Error> {
    let output = Command::new(env!("CARGO"))
        .args(["bench", "--quiet", "--package", package, "--bench", file])
        .stderr(std::process::Stdio::inherit())
        .output()?;
    if !output.status.success() {
        return Err(Error::other(format!("the benchmark {file} of {package} failed")));
    }
    Ok(String::from_utf8_lossy(&output.stdout).lines().filter_map(row).collect())
}

/// Reads one line, if it is a measurement.
fn row(line: &str) -> Option<Row> {
    let fields: Vec<&str> = line.split('\t').collect();
    let (&[mark, group, name, secs, what], amount) = fields.split_first_chunk()?;
    let (secs, amount) = (secs.parse().ok()?, amount.first().and_then(|n| n.parse().ok()));
    let [group, name, what] = [group, name, what].map(str::to_owned);
    (mark == MARK).then_some(Row { group, name, secs, what, amount })
}

fn print(rows: &[Row]) -> Result<(), Error> {
    let mut out = std::io::stdout().lock();
    writeln!(
        out,
        "| {:10} | {:58} | {:>10} | {:>12} | {:>6} |",
        "group", "what", "time", "per second", "ratio"
    )?;
    writeln!(out, "|{:-<12}|{:-<60}|{:->11}:|{:->13}:|{:->7}:|", "", "", "", "", "")?;
    for Row { group, name, secs, what, .. } in rows {
        let first = rows.iter().find(|row| row.group == *group).map_or(*secs, |row| row.secs);
        let label = format!("{name}, per {what}");
        let (time, rate, ratio) = (duration(*secs), 1.0 / secs, secs / first);
        writeln!(out, "| {group:10} | {label:58} | {time:>10} | {rate:>12.0} | {ratio:>6.2} |")?;
    }
    Ok(())
}

/// A time in the unit in which it is readable.
fn duration(secs: f64) -> String {
    match secs {
        s if s < 1e-6 => format!("{:.1} ns", s * 1e9),
        s if s < 0.1 => format!("{:.2} µs", s * 1e6),
        s => format!("{s:.2} s"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_measurements_are_read() {
        let line = format!("{MARK}\tworld\tnobody looks\t1.5e-6\tstep");
        let [group, name, what] = ["world", "nobody looks", "step"].map(str::to_owned);
        let plain = Row { group, name, secs: 1.5e-6, what, amount: None };
        assert_eq!(row(&line).as_ref(), Some(&plain));
        assert_eq!(row(&format!("{line}\t4")), Some(Row { amount: Some(4.0), ..plain }));
        assert_eq!(row("running 1 test"), None);
        assert_eq!([1.5e-6, 2e-9, 3.0].map(duration), ["1.50 µs", "2.0 ns", "3.00 s"]);
    }
}
