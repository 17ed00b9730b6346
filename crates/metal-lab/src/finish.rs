//! The end of a run: everything it found, written to its folder.

use crate::drives;
use crate::figures::FIGURES;
use crate::report::{ReportContext, ReportError, render};
use crate::reproduce::subsets::SUBSET;
use crate::reproduce::{Outcome, gather};
use crate::results::{Figures, Results};
use crate::store::{RecordKey, RunCard, Store, StoreError, records_csv};
use crate::train::RunError;

/// Why a run could not be written.
#[derive(Debug, thiserror::Error)]
pub enum FinishError {
    /// The run folder.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The drives behind some figures.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The report.
    #[error("report: {0}")]
    Report(#[from] ReportError),
    /// The results.
    #[error("results.json: {0}")]
    Json(#[from] serde_json::Error),
    /// The records.
    #[error("records.csv: {0}")]
    Csv(#[from] csv::Error),
}

/// Writes plan, minds, results, records, figures and report of a finished run; `command` is what was typed for it.
///
/// # Errors
/// If a file cannot be written.
pub fn write(outcome: &Outcome, store: &Store, command: &str) -> Result<Results, FinishError> {
    let card = RunCard {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        seed: outcome.options.seed,
        seeds: outcome.options.seeds,
        blind: outcome.blind,
        quick: outcome.options.quick,
    };
    write_minds(outcome, store)?;
    write_rivals(outcome, &card, store)?;
    let results = results(outcome)?;
    store.write("results.json", serde_json::to_string_pretty(&results)?.as_bytes())?;
    let tables = outcome.tables.iter().flat_map(|(roads, policies)| {
        policies.iter().flat_map(move |(policy, scenarios)| {
            scenarios.iter().map(move |(scenario, runs)| (RecordKey { policy, roads, scenario }, runs))
        })
    });
    store.write("records.csv", &records_csv(tables)?)?;
    write_figures(&results, store)?;
    let links = ["results.json", "records.csv", "plan.toml"].map(|name| (name.to_owned(), name.to_owned()));
    let context =
        ReportContext { command: command.to_owned(), links: links.to_vec(), ..ReportContext::default() };
    store.write("report.html", render(&results, &context)?.as_bytes())?;
    // Last, so that a folder with a card is a finished run.
    store.write_run(&outcome.plan, &card)?;
    Ok(results)
}

/// Every drawing of the report as an SVG file of its own, for slides and papers.
///
/// # Errors
/// If a file cannot be written.
pub fn write_figures(results: &Results, store: &Store) -> Result<(), StoreError> {
    for (name, draw) in FIGURES {
        for (panel, svg) in draw(results).iter().flat_map(|figure| figure.files()).enumerate() {
            store.write(&format!("figures/{name}-{}.svg", panel + 1), svg.as_bytes())?;
        }
    }
    Ok(())
}

/// Everything the run found, the driven figures included.
fn results(outcome: &Outcome) -> Result<Results, RunError> {
    let (mut results, driven) = (gather(outcome), drives::figures(outcome)?);
    results.figures = Figures {
        fig6: driven.fig6,
        camera_regions: driven.camera_regions,
        table1: driven.table1,
        fig11: driven.fig11,
        look_map: driven.look_map,
        aliasing_empirical: driven.aliasing_empirical,
        ..results.figures
    };
    Ok(results)
}

/// Every fixed choice of sensors that was trained with the whole budget, as a run of its own in a folder inside.
fn write_rivals(outcome: &Outcome, card: &RunCard, store: &Store) -> Result<(), StoreError> {
    store.retire_rivals()?;
    for (number, confirmed) in outcome.confirmed.iter().enumerate() {
        let inside = store.rival(number)?;
        for (seed, subset) in confirmed.trainings.iter().enumerate() {
            inside.write_mind(seed, SUBSET, &subset.trained.mind.freeze_for(&subset.plan))?;
        }
        if let Some(subset) = confirmed.trainings.first() {
            inside.write_run(&subset.plan, card)?;
        }
    }
    Ok(())
}

fn write_minds(outcome: &Outcome, store: &Store) -> Result<(), StoreError> {
    for (seed, phases) in outcome.trained.iter().enumerate() {
        for (phase, trained) in phases {
            store.write_mind(seed, phase, &trained.mind.freeze_for(&outcome.plan))?;
        }
    }
    Ok(())
}
