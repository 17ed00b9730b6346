//! From runs to the tables: means per seed, then a Student interval over seeds.

use crate::evaluate::measures;
use crate::results::{Costs, Estimate, Measures, Table2Cell};
use crate::trace::EpisodeRecord;
use metal_rl::measure::statistics::student;

/// Runs of one policy in one scenario on one set of roads: one list per seed.
pub type RunsBySeed = Vec<Vec<EpisodeRecord>>;

/// An estimate over seeds; none without values, or if one of them is no number: JSON has no NaN.
#[must_use]
pub fn over_seeds(values: &[f64]) -> Option<Estimate> {
    student(values).filter(|_| values.iter().all(|v| v.is_finite()))
}

/// The same of shares: an interval does not leave [0, 1].
#[must_use]
pub fn share_over_seeds(values: &[f64]) -> Option<Estimate> {
    let estimate = over_seeds(values)?;
    let [lo, hi] = [estimate.lo, estimate.hi].map(|end| end.map(|v| v.clamp(0.0, 1.0)));
    Some(Estimate { lo, hi, ..estimate })
}

/// Whether a measure is a share of runs or steps.
#[must_use]
pub fn is_share(measure: &str) -> bool {
    measure.ends_with("_rate") || measure == "speed_smoothness"
}

/// One cell of the main table: every measure that has values, mean per seed, interval over seeds.
#[must_use]
pub fn cell(runs: &RunsBySeed) -> Measures {
    let driven = runs.iter().filter(|r| !r.is_empty());
    let per_seed: Vec<Vec<(&str, f64)>> = driven.map(|r| measures(r)).collect();
    let names = per_seed.first().map_or(&[][..], Vec::as_slice).iter().map(|(name, _)| *name);
    let measured = names.enumerate().filter_map(|(i, name)| {
        let values: Vec<f64> = per_seed.iter().map(|m| m[i].1).collect();
        let estimate = if is_share(name) { share_over_seeds(&values) } else { over_seeds(&values) };
        Some((name.to_owned(), estimate?))
    });
    measured.collect()
}

/// One cell of Table 2: runs parted by accident. Intervals are over runs here, as the paper's cells are of runs;
/// none without runs.
#[must_use]
pub fn table2_cell(runs: &[&EpisodeRecord]) -> Option<Table2Cell> {
    let accident: Vec<&EpisodeRecord> = runs.iter().copied().filter(|r| r.driving.accident).collect();
    let peace: Vec<&EpisodeRecord> = runs.iter().copied().filter(|r| !r.driving.accident).collect();
    Some(Table2Cell {
        runs: runs.len() as u64,
        accidents: accident.len() as u64,
        all: costs(runs)?,
        accident: costs(&accident),
        no_accident: costs(&peace),
    })
}

fn costs(runs: &[&EpisodeRecord]) -> Option<Costs> {
    let over = |f: &dyn Fn(&EpisodeRecord) -> f64| {
        over_seeds(&runs.iter().map(|r| r.per_step(f(r))).collect::<Vec<_>>())
    };
    let (motor, perceptual) = (over(&|r| r.motor)?, over(&|r| r.perceptual)?);
    Some(Costs { motor, perceptual, total: over(&|r| r.motor + r.perceptual)? })
}

/// Ratio of total costs, mean over scenarios, paired by seed; `ours` and `theirs`: scenario → seed → runs.
#[must_use]
pub fn ratio(ours: &[&RunsBySeed], theirs: &[&RunsBySeed]) -> Option<Estimate> {
    let seeds = ours.first()?.len();
    let mut ratios = Vec::new();
    for seed in 0..seeds {
        let mut sum = 0.0;
        for (a, b) in ours.iter().zip(theirs) {
            let (a, b) = (total(&a[seed]), total(b.get(seed)?));
            if b >= 0.0 {
                return None;
            }
            sum += a / b;
        }
        ratios.push(sum / ours.len() as f64);
    }
    over_seeds(&ratios)
}

/// Mean total reward per motor step.
#[must_use]
pub fn total(runs: &[EpisodeRecord]) -> f64 {
    runs.iter().map(|r| r.per_step(r.motor + r.perceptual)).sum::<f64>() / runs.len().max(1) as f64
}

/// Mean motor reward per motor step.
#[must_use]
pub fn motor(runs: &[EpisodeRecord]) -> f64 {
    runs.iter().map(|r| r.per_step(r.motor)).sum::<f64>() / runs.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_no_value_is_left_out() {
        assert!(cell(&vec![Vec::new()]).is_empty());
        assert_eq!(table2_cell(&[]), None);
        assert_eq!(over_seeds(&[1.0, f64::NAN]), None);
        assert_eq!(share_over_seeds(&[0.0, 0.5]).unwrap().band(), Some((0.0, 1.0)));
        assert_eq!(over_seeds(&[-2.0]), Some(Estimate::point(-2.0, 1)));
    }
}
