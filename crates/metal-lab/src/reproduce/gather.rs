//! From an [`Outcome`] to the [`Results`] that are written, drawn and printed.

use super::curves::{learning_curve, looks_over_learning};
use super::table::{cell, over_seeds, ratio, table2_cell};
use super::{Outcome, subsets};
use crate::evaluate::measures;
use crate::paper;
use crate::registry::{Roads, roads_name};
use crate::results::{
    Estimate, Figures, FrontPoint, Policies, Results, SCHEMA, SeedPoint, Stage, Table2, Table3Row, lookup,
};
use crate::trace::{EpisodeRecord, Trace};
use metal_rl::measure::aliasing;
use std::collections::BTreeMap;

/// Every number of the report, but for the figures that need a drive (see [`crate::drives`]).
#[must_use]
pub fn gather(outcome: &Outcome) -> Results {
    let main = roads_name(&Roads::Training);
    let roads = |name: &str| outcome.tables.get(name).map(|t| policies(t, outcome)).unwrap_or_default();
    let others = outcome.tables.keys().filter(|name| **name != main);
    Results {
        schema: SCHEMA,
        quick: outcome.options.quick,
        seeds: outcome.options.seeds as u32,
        roads: main.clone(),
        policies: roads(&main),
        table3: table3(),
        figures: figures(outcome),
        other_roads: others.map(|name| (name.clone(), roads(name))).collect(),
        table2: table2(outcome),
        ratios: ratios(outcome),
        best_fixed: outcome.best_fixed.clone(),
        paper: Some(paper::numbers()),
        cpu_seconds: outcome.busy.clone(),
        versions: versions(&outcome.plan.spec.id),
        config: serde_json::to_value(&outcome.plan.file).unwrap_or_default(),
    }
}

fn policies(
    table: &BTreeMap<String, BTreeMap<String, Vec<Vec<EpisodeRecord>>>>,
    outcome: &Outcome,
) -> Policies {
    let cells = |s: &BTreeMap<String, Vec<Vec<EpisodeRecord>>>| {
        s.iter().map(|(name, runs)| (name.clone(), cell(runs))).collect()
    };
    let mut policies: Policies =
        table.iter().map(|(name, scenarios)| (name.clone(), cells(scenarios))).collect();
    name_best(&mut policies, outcome);
    policies
}

/// Enters the best fixed subset once more, under the name `best_fixed`.
fn name_best<T: Clone>(policies: &mut BTreeMap<String, T>, outcome: &Outcome) {
    let best = outcome.best_fixed.as_ref().and_then(|name| policies.get(name).cloned());
    policies.extend(best.map(|b| ("best_fixed".to_owned(), b)));
}

/// Table 3 as computed: the paper's five rows.
fn table3() -> Vec<Table3Row> {
    let rows = aliasing::TABLE_3.iter().filter_map(|row| {
        let bound = aliasing::bound(row.levels, row.merged_states, row.actions).ok()?;
        let (k, q, actions) = (row.merged_states as u32, row.levels as u32, row.actions as u32);
        Some(Table3Row { k, q, actions, p0: bound.collision, p: bound.all_actions })
    });
    rows.collect()
}

/// Table 2 twice: ten runs as in the paper (the first of each seed in turn), and all of them.
fn table2(outcome: &Outcome) -> BTreeMap<String, Table2> {
    let Some(table) = outcome.tables.get(&roads_name(&Roads::Training)) else { return BTreeMap::new() };
    let style = |most: usize| -> Table2 {
        let cells = |scenarios: &BTreeMap<String, Vec<Vec<EpisodeRecord>>>| {
            let cell = |runs: &Vec<Vec<EpisodeRecord>>| table2_cell(&interleave(runs, most));
            scenarios.iter().filter_map(|(name, runs)| Some((name.clone(), cell(runs)?))).collect()
        };
        let mut rows: Table2 =
            table.iter().map(|(policy, scenarios)| (policy.clone(), cells(scenarios))).collect();
        name_best(&mut rows, outcome);
        rows
    };
    BTreeMap::from([("ten_runs".to_owned(), style(10)), ("full".to_owned(), style(usize::MAX))])
}

/// The first run of every seed, then the second …, `most` in all.
fn interleave(runs: &[Vec<EpisodeRecord>], most: usize) -> Vec<&EpisodeRecord> {
    let longest = runs.iter().map(Vec::len).max().unwrap_or(0);
    (0..longest).flat_map(|i| runs.iter().filter_map(move |seed| seed.get(i))).take(most).collect()
}

/// Ratios of total costs over the scenarios of Table 2.
fn ratios(outcome: &Outcome) -> BTreeMap<String, Estimate> {
    let mut ratios = BTreeMap::new();
    let best = outcome.best_fixed.clone().unwrap_or_default();
    for ours in ["acl", "acl_phase3", "acl_decision", "acl_paper"] {
        for (name, theirs) in [("foa", "foa"), ("fusion", "fusion"), ("best_fixed", best.as_str())] {
            for (roads, table) in &outcome.tables {
                let Some(estimate) = ratio_on(table, ours, theirs) else { continue };
                let suffix = if *roads == main_roads() { String::new() } else { format!("@{roads}") };
                ratios.insert(format!("{ours}/{name}{suffix}"), estimate);
            }
        }
    }
    ratios
}

fn main_roads() -> String {
    roads_name(&Roads::Training)
}

fn ratio_on(
    table: &BTreeMap<String, BTreeMap<String, Vec<Vec<EpisodeRecord>>>>,
    ours: &str,
    theirs: &str,
) -> Option<Estimate> {
    let runs = |policy: &str| -> Option<Vec<&Vec<Vec<EpisodeRecord>>>> {
        lookup::SCENARIOS.iter().map(|s| table.get(policy)?.get(*s)).collect()
    };
    ratio(&runs(ours)?, &runs(theirs)?)
}

fn figures(outcome: &Outcome) -> Figures {
    let traces = |phase: &str| -> Vec<&Trace> {
        outcome.trained.iter().filter_map(|seed| seed.get(phase).map(|t| &t.trace)).collect()
    };
    let learned = outcome.plan.file.policy.iter().filter_map(|(name, row)| {
        let phase = row.after.as_ref()?;
        // Only the policy that learned in the phase has a learning curve of its own.
        (outcome.plan.file.phase[phase].acting == row.acting).then_some((name, phase))
    });
    let attention = outcome.plan.file.policy.get("acl").and_then(|row| row.after.as_ref());
    Figures {
        learning_curves: learned
            .map(|(name, phase)| {
                let seeds: Vec<Vec<&Trace>> = traces(phase).into_iter().map(|t| vec![t]).collect();
                (name.clone(), learning_curve(&seeds))
            })
            .collect(),
        looks_histograms: attention
            .map(|phase| looks_over_learning(&traces(phase), 8, outcome.plan.spec.sensors.len()))
            .unwrap_or_default(),
        subset_front: front(outcome),
        sensitivity: sensitivity(outcome),
        ..Figures::default()
    }
}

fn front(outcome: &Outcome) -> Vec<FrontPoint> {
    let spec = &outcome.plan.spec;
    let names =
        |sensors: metal_rl::set::IndexSet| sensors.iter().map(|s| spec.sensors[s].name.clone()).collect();
    let mut points: Vec<FrontPoint> = outcome
        .screened
        .iter()
        .filter_map(|s| {
            let totals: Vec<f64> = s.motor.iter().map(|m| m - s.price).collect();
            let (motor, total) = (over_seeds(&s.motor)?, over_seeds(&totals)?);
            Some(FrontPoint {
                sensors: names(s.rival.sensors),
                every: s.rival.every,
                price: s.price,
                motor,
                total,
                stage: Stage::Screened,
            })
        })
        .collect();
    let scenario = outcome.plan.file.environment.training_scenario();
    for rival in outcome.confirmed.iter().map(|confirmed| confirmed.rival) {
        let (policy, sensors) = (subsets::name(&outcome.plan, rival), rival.sensors);
        let table = outcome.tables.get(&main_roads()).and_then(|t| t.get(&policy)?.get(&scenario));
        let Some(runs) = table else { continue };
        let measures = cell(runs);
        let price = sensors.iter().map(|s| spec.sensors[s].price).sum::<f64>() / rival.every as f64;
        let (Some(&motor), Some(&total)) = (measures.get("motor"), measures.get("total")) else { continue };
        let (sensors, every) = (names(sensors), rival.every);
        points.push(FrontPoint { sensors, every, price, motor, total, stage: Stage::Confirmed });
    }
    points
}

/// What each seed reached in the scenario of learning.
fn sensitivity(outcome: &Outcome) -> BTreeMap<String, Vec<SeedPoint>> {
    let Some(table) = outcome.tables.get(&main_roads()) else { return BTreeMap::new() };
    let scenario = outcome.plan.file.environment.training_scenario();
    let row = |(policy, cells): (&String, &BTreeMap<String, Vec<Vec<EpisodeRecord>>>)| {
        let runs = cells.get(&scenario)?;
        Some((
            policy.clone(),
            runs.iter().enumerate().filter_map(|(seed, runs)| seed_point(seed, runs)).collect(),
        ))
    };
    let mut rows = table.iter().filter_map(row).collect();
    name_best(&mut rows, outcome);
    rows
}

fn seed_point(seed: usize, runs: &[EpisodeRecord]) -> Option<SeedPoint> {
    let measured = measures(runs);
    let of = |name: &str| measured.iter().find(|(n, v)| *n == name && v.is_finite()).map(|(_, v)| *v);
    let (motor, perceptual, total, looks) = (of("motor")?, of("perceptual")?, of("total")?, of("looks")?);
    Some(SeedPoint { seed: seed as u64, motor, perceptual, total, looks })
}

fn versions(world: &str) -> BTreeMap<String, String> {
    let rows = [
        ("metal", env!("CARGO_PKG_VERSION")),
        ("rustc", env!("METAL_RUSTC_VERSION")),
        ("git", env!("METAL_GIT_REVISION")),
        ("world", world),
    ];
    rows.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned())).collect()
}
