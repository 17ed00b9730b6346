//! How things stand, as every page is told.

use crate::demonstration::WANTED;
use crate::faults::Fault;
use crate::learned::Progress;
use crate::situations::Looked;
use crate::stage::Stage;
use crate::training::{State, Training};
use metal_lab::demonstrations::Quality;
use metal_worlds::highway::Scenario;
use serde::Serialize;

/// How things stand.
#[derive(Debug, Serialize)]
#[expect(clippy::struct_excessive_bools, reason = "each is a lamp of its own on the page")]
pub struct Status {
    view: &'static str,
    running: bool,
    times: f64,
    scenario: &'static str,
    scenarios: Vec<&'static str>,
    drivers: Vec<String>,
    at_the_wheel: Vec<usize>,
    faults: Vec<Fault>,
    braked: bool,
    scene: Option<usize>,
    situations: Vec<Looked>,
    demonstration: Option<DemonstrationStatus>,
    saved: Option<String>,
    training: Option<TrainingStatus>,
    is_run: bool,
    span: (u64, u64),
    pages: usize,
    wheel: u64,
    notice: Option<String>,
}

#[derive(Debug, Serialize)]
struct DemonstrationStatus {
    quality: Quality,
    wanted: usize,
    undoable: usize,
    unsaved: bool,
}

#[derive(Debug, Serialize)]
struct TrainingStatus {
    state: State,
    progress: Progress,
}

impl Status {
    /// How things stand on `stage`.
    #[must_use]
    pub fn of(stage: &Stage) -> Self {
        let training =
            |t: &Training| TrainingStatus { state: t.control.state(), progress: t.learned.progress() };
        let view = match (stage.hub.shows_training(), &stage.demonstration) {
            _ if stage.body.is_some() => "body",
            (true, _) => "training",
            (false, Some(_)) => "demonstration",
            (false, None) => "drive",
        };
        Self {
            view,
            running: stage.clock.is_running(),
            times: stage.clock.times(),
            scenario: stage.scenario.name(),
            scenarios: Scenario::ALL.iter().map(|s| s.name()).collect(),
            drivers: stage.subject.drivers.iter().map(|d| d.label.clone()).collect(),
            at_the_wheel: match &stage.body {
                Some(body) => vec![body.driver],
                None => stage.lanes.iter().map(|l| l.driver).collect(),
            },
            faults: stage.lanes[0].world.faults.clone(),
            braked: stage.hub.braked(),
            scene: stage.scene,
            situations: stage.situations.clone(),
            demonstration: stage.demonstration.as_ref().map(|d| DemonstrationStatus {
                quality: d.quality(),
                wanted: WANTED,
                undoable: d.undoable(),
                unsaved: d.is_unsaved(),
            }),
            saved: stage.saved.clone(),
            training: stage.training.as_ref().map(training),
            is_run: stage.subject.is_run(),
            span: stage.hub.span(),
            pages: stage.hub.pages(),
            wheel: stage.hub.wheel(),
            notice: stage.notice.clone(),
        }
    }
}
