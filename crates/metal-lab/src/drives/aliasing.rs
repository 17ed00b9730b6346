//! Aliasing counted instead of bounded (Sec. 6.1): on drives of attention control, how often do two states in which
//! the full observer acts differently fall on one point of the decision space?

use super::Garage;
use crate::evaluate::{Candidate, drive};
use crate::mind::Mind;
use crate::plan::Acting;
use crate::registry::Roads;
use crate::reproduce::Outcome;
use crate::reproduce::table::share_over_seeds;
use crate::results::AliasingRow;
use crate::train::RunError;
use metal_rl::decision::DecisionState;
use metal_rl::environment::{End, Environment};
use metal_rl::measure::empirical_aliasing::{LoggedState, Resolution, count};
use metal_rl::num;
use metal_rl::observe::{Observer, Step};
use metal_rl::phase::{Phase, Sensing};
use metal_rl::policy::{Choice, Policy, Situation};
use metal_rl::random::{Rng, Streams};
use metal_rl::run::{Stage, run};
use metal_rl::set::IndexSet;
use metal_worlds::highway::Scenario;

/// Quantisation levels of a degree of support: those of Table 3.
const LEVELS: [u32; 2] = [4, 10];
/// States are distinct if some scaled feature falls into another tenth of its range.
const STATE_CELL: f64 = 0.1;
/// Drives per seed.
const DRIVES: usize = 40;

/// A space: its name, and where a moment lies in it.
type Space = (&'static str, fn(&Moment) -> &[f64]);

/// The rows of every space and level, means over seeds; none if the plan has no full observer.
pub fn rows(
    garage: &Garage<'_>,
    outcome: &Outcome,
    drivers: &[Candidate<'_>],
) -> Result<Vec<AliasingRow>, RunError> {
    let Some(observers) = observers(outcome) else { return Ok(Vec::new()) };
    let mut logs = Vec::new();
    for (i, (driver, (member, mind))) in drivers.iter().zip(observers).enumerate() {
        logs.push(log(garage, driver, (member, mind), &garage.streams.child("aliasing").nth(i as u64))?);
    }
    let spaces: [Space; 2] = [
        ("decision space, all tiny agents heard", |m| &m.heard),
        ("decision space as attended", |m| &m.attended),
    ];
    let rows = spaces.iter().flat_map(|space| LEVELS.map(|q| row(&logs, space, q)));
    Ok(rows.flatten().collect())
}

/// The full observer and, per seed, the mind in which it went on learning alone.
fn observers(outcome: &Outcome) -> Option<Vec<(usize, &Mind)>> {
    let row = outcome.plan.file.policy.get("foa")?;
    let Acting::Solo(name) = &row.acting else { return None };
    let (member, phase) = (outcome.plan.member(name)?, row.after.as_ref()?);
    outcome.trained.iter().map(|seed| Some((member, &seed.get(phase)?.mind))).collect()
}

fn row(logs: &[Vec<Moment>], (space, decision): &Space, q: u32) -> Option<AliasingRow> {
    let resolution = Resolution { state_cell: STATE_CELL, support_levels: q };
    let rate = |log: &Vec<Moment>| {
        let logged =
            log.iter().map(|m| LoggedState { state: &m.state, action: m.action, decision: decision(m) });
        count(&logged.collect::<Vec<_>>(), resolution).pair_rate.map(|rate| rate.mean)
    };
    let rates: Vec<f64> = logs.iter().filter_map(rate).collect();
    Some(AliasingRow { space: (*space).to_owned(), q, rate: share_over_seeds(&rates)? })
}

/// One moment of a drive, as everybody would have seen it.
struct Moment {
    /// What the full observer sees, scaled to [0, 1].
    state: Vec<f64>,
    /// What it would do.
    action: usize,
    /// Degrees of support of all tiny agents.
    heard: Vec<f64>,
    /// The same with zeros for those the driver left alone, and who they are.
    attended: Vec<f64>,
}

/// Logs drives of `driver`. First it drives as it likes; then the same actions are driven again with everybody
/// listening. Looking changes nothing, so the second drive goes through the same states.
fn log(
    garage: &Garage<'_>,
    driver: &Candidate<'_>,
    (observer, mind): (usize, &Mind),
    streams: &Streams,
) -> Result<Vec<Moment>, RunError> {
    let mut world = garage.world(&Roads::Training, Scenario::Mix);
    let mut tape = Tape::default();
    drive(driver, &mut world, (DRIVES, streams), &mut tape)?;
    let mut members = driver.mind.members.clone();
    members[observer] = mind.members[observer].clone();
    let phase = Phase {
        sensing: Sensing::Everyone,
        ..Phase::evaluation("replay", driver.roster.with(observer), DRIVES)
    };
    let mut policy = Replay { actions: tape.steps.iter().map(|s| s.0).collect(), at: 0 };
    let mut stage = Stage {
        environment: &mut world as &mut dyn Environment,
        members: &mut members,
        policy: &mut policy,
        scaling: driver.plan.file.scaling,
    };
    let mut listener = Listener {
        tape,
        observer,
        tiny: driver.roster.minus(IndexSet::EMPTY.with(observer)),
        log: Vec::new(),
    };
    run(&mut stage, &phase, streams, &mut listener)?;
    Ok(listener.log)
}

/// What was done and who was attended, step by step, and how each step ended.
#[derive(Default)]
struct Tape {
    steps: Vec<(usize, IndexSet, End)>,
}

impl Observer for Tape {
    fn on_step(&mut self, step: &Step<'_>) {
        self.steps.push((step.action, step.state.attended(), step.end));
    }
}

/// Does again what was done.
struct Replay {
    actions: Vec<usize>,
    at: usize,
}

impl Policy for Replay {
    fn choose(&mut self, _situation: &Situation<'_>, _rng: &mut Rng) -> Choice {
        self.at += 1;
        Choice::Move(self.actions[self.at - 1])
    }
}

/// Writes down what everybody says.
struct Listener {
    tape: Tape,
    observer: usize,
    tiny: IndexSet,
    log: Vec<Moment>,
}

impl Observer for Listener {
    fn on_step(&mut self, step: &Step<'_>) {
        let (action, attended, end) = self.tape.steps[self.log.len()];
        assert_eq!((step.action, step.end), (action, end), "looking changed the world");
        let Some(full) = step.state.opinion(self.observer) else { return };
        self.log.push(Moment {
            state: full.reading.to_vec(),
            action: num::argmax(full.values),
            heard: supports(step.state, self.tiny, self.tiny),
            attended: supports(step.state, self.tiny, attended),
        });
    }
}

/// Per member of `tiny`: whether it is among `attended`, and if so its degrees of support, else zeros.
fn supports(state: &DecisionState, tiny: IndexSet, attended: IndexSet) -> Vec<f64> {
    let mut all = Vec::new();
    for m in tiny.iter() {
        let opinion = state.opinion(m).filter(|_| attended.contains(m));
        all.push(f64::from(u8::from(opinion.is_some())));
        match opinion {
            Some(opinion) => all.extend_from_slice(opinion.support),
            None => all.resize(all.len() + state.actions(), 0.0),
        }
    }
    all
}
