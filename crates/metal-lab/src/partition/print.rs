//! The proposal as a table.

use super::{Criterion, Proposal};
use crate::figures::number::{fixed, percent};
use std::fmt::Write;

/// The table, with a word on what its numbers mean.
#[must_use]
pub fn text(proposal: &Proposal) -> String {
    let mut out = String::new();
    head(&mut out, proposal);
    let sensors: Vec<String> = proposal.groups.iter().map(|g| g.sensors.join(" ")).collect();
    let _ = writeln!(out, "group  price  tells  apart  sensors");
    for (group, sensors) in proposal.groups.iter().zip(sensors) {
        let apart = group.apart.map_or("–".to_owned(), |apart| fixed(apart, 2));
        let (price, tells) = (fixed(group.price, 2), fixed(group.tells, 2));
        let _ = writeln!(out, "{:5}  {price:>5}  {tells:>5}  {apart:>5}  {sensors}", group.name);
    }
    let price: f64 = proposal.groups.iter().map(|g| g.price).sum();
    let _ = writeln!(out, "{:5}  {:>5}  {:>5}", "all", fixed(price, 2), fixed(proposal.everything, 2));
    out
}

fn head(out: &mut String, proposal: &Proposal) {
    let how = match proposal.options.by {
        Criterion::Alike => "sensors that say the same (agglomerative clustering)",
        Criterion::Worth => "sensors that together tell the action for their price (optimisation)",
        Criterion::Random => "sensors dealt at random",
    };
    let steps: usize = proposal.actions.iter().map(|(_, n)| n).sum();
    let share = |(name, n): &(String, usize)| format!("{name} {}", percent(*n as f64 / steps.max(1) as f64));
    let _ = writeln!(
        out,
        "{}: {} groups of {how}, from {steps} steps of the expert in {} episodes\n\
         the expert: {}\n\
         tells: share of the expert's actions explained by a linear rule in episodes it was not fitted to\n\
         apart: mean information distance of the sensors of a group, 0 alike, 1 independent; silhouette {}\n",
        proposal.world,
        proposal.groups.len(),
        proposal.episodes,
        proposal.actions.iter().map(share).collect::<Vec<_>>().join(", "),
        fixed(proposal.silhouette, 2),
    );
}
