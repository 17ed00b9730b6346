//! Draws what `cargo xtask bench growth FILE.svg` measured: reads lines "group, amount, seconds" (separated by tabs), writes
//! an SVG. Both axes count doublings, so that a power law is a straight line and its slope the exponent.

use metal_lab::figures::Figure;
use metal_lab::figures::chart::{Ink, LineChart, LinePoint, Series};
use metal_rl::num;
use std::io::{Error, IsTerminal, Read, Write};

/// Colours, one per group.
const INKS: [&str; 10] = [
    "fusion",
    "fusion-pool",
    "acl",
    "acl-paper",
    "foa-paper",
    "foa",
    "oracle",
    "random",
    "fixed",
    "acl-decision",
];

/// Groups in the order in which they come: (amount, seconds).
type Groups = Vec<(String, Vec<(f64, f64)>)>;

fn read(text: &str) -> Groups {
    let mut groups: Groups = Vec::new();
    for line in text.lines() {
        let [group, amount, secs] = line.split('\t').collect::<Vec<_>>()[..] else { continue };
        let (Ok(amount), Ok(secs)) = (amount.parse(), secs.parse()) else { continue };
        match groups.iter_mut().find(|(name, _)| name == group) {
            Some((_, points)) => points.push((amount, secs)),
            None => groups.push((group.to_owned(), vec![(amount, secs)])),
        }
    }
    groups
}

fn doublings(from: f64, to: f64) -> f64 {
    num::ln(to / from) / num::ln(2.0)
}

fn series((group, points): &(String, Vec<(f64, f64)>), ink: &'static str) -> Series {
    let (amount, secs) = points[0];
    let point =
        |&(n, t): &(f64, f64)| LinePoint { x: doublings(amount, n), y: doublings(secs, t), band: None };
    let points = points.iter().map(point).collect();
    Series { label: group.clone(), ink: Ink(ink), width: 2.0, dashed: group.contains("wall"), points }
}

/// As many doublings of time as of what grows.
fn linear(longest: f64) -> Series {
    let at = |x: f64| LinePoint { x, y: x, band: None };
    let points = vec![at(0.0), at(longest)];
    Series { label: "as much time as amount".to_owned(), ink: Ink::MUTED, width: 1.0, dashed: true, points }
}

fn chart(groups: &Groups) -> LineChart {
    let mut lines: Vec<Series> =
        groups.iter().zip(INKS.iter().cycle()).map(|(group, ink)| series(group, ink)).collect();
    let longest = lines.iter().flat_map(|l| &l.points).map(|p| p.x).fold(0.0, f64::max);
    lines.insert(0, linear(longest));
    LineChart {
        title: "How time grows".to_owned(),
        x_label: "doublings of the amount".to_owned(),
        y_label: "doublings of the time".to_owned(),
        series: lines,
    }
}

fn main() -> Result<(), Error> {
    let mut text = String::new();
    if std::io::stdin().is_terminal() {
        // Nobody measured anything: it was started with all the others.
        return Ok(());
    }
    std::io::stdin().read_to_string(&mut text)?;
    let panels = vec![chart(&read(&text)).draw()];
    let figure = Figure { id: "growth", caption: String::new(), panels };
    figure.files().iter().try_for_each(|file| std::io::stdout().write_all(file.as_bytes()))
}
