//! Chores of the workspace. `cargo xtask bench [WORD]` runs all benchmarks (or those files whose name contains WORD) and
//! prints one table; the last column compares with the first row of the same group.

use std::io::{Error, ErrorKind, Write};
use std::process::{Command, ExitCode};
use xtask::MARK;

/// Benchmarks: package and file.
const BENCHES: [(&str, &str); 5] = [
    ("metal-worlds", "world"),
    ("metal-rl", "mind"),
    ("metal-rl", "growth"),
    ("metal-lab", "decisions"),
    ("metal-lab", "limits"),
];

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let done = match words.first().map(String::as_str) {
        Some("bench") => bench(words.get(1).map_or("", String::as_str)),
        _ => Err(Error::new(ErrorKind::InvalidInput, "cargo xtask bench [WORD] is all there is")),
    };
    if let Err(error) = done {
        let _ = writeln!(std::io::stderr(), "{error}");
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}

/// A measurement: group, name, seconds, of what.
type Row = (String, String, f64, String);

fn bench(word: &str) -> Result<(), Error> {
    let mut rows = Vec::new();
    for (package, file) in BENCHES.iter().filter(|(_, file)| file.contains(word)) {
        rows.extend(run(package, file)?);
    }
    print(&rows)
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
    let [mark, group, name, secs, what] = line.split('\t').collect::<Vec<_>>()[..] else { return None };
    let secs = secs.parse().ok()?;
    (mark == MARK).then(|| (group.to_owned(), name.to_owned(), secs, what.to_owned()))
}

fn print(rows: &[Row]) -> Result<(), Error> {
    let mut out = std::io::stdout().lock();
    writeln!(
        out,
        "| {:10} | {:58} | {:>10} | {:>12} | {:>6} |",
        "group", "what", "time", "per second", "ratio"
    )?;
    writeln!(out, "|{:-<12}|{:-<60}|{:->11}:|{:->13}:|{:->7}:|", "", "", "", "", "")?;
    for (group, name, secs, what) in rows {
        let first = rows.iter().find(|row| row.0 == *group).map_or(*secs, |row| row.2);
        let label = format!("{name}, per {what}");
        let (time, rate, ratio) = (micros(*secs), 1.0 / secs, secs / first);
        writeln!(out, "| {group:10} | {label:58} | {time:>10} | {rate:>12.0} | {ratio:>6.2} |")?;
    }
    Ok(())
}

/// A time in microseconds, or in nanoseconds where that is readable.
fn micros(secs: f64) -> String {
    if secs < 1e-6 { format!("{:.1} ns", secs * 1e9) } else { format!("{:.2} µs", secs * 1e6) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_measurements_are_read() {
        let line = format!("{MARK}\tworld\tnobody looks\t1.5e-6\tstep");
        assert_eq!(row(&line), Some(("world".into(), "nobody looks".into(), 1.5e-6, "step".into())));
        assert_eq!(row("running 1 test"), None);
        assert_eq!((micros(1.5e-6), micros(2e-9)), ("1.50 µs".to_owned(), "2.0 ns".to_owned()));
    }
}
