//! The figures that need somebody to drive, one file each: the road and the camera's view (Fig. 6), the situations of
//! Table 1, a drive on a test road (Fig. 11), what is looked at where, and aliasing counted in the decision space.

mod aliasing;
mod look_map;
pub(crate) mod picture;
mod road_view;
mod situations;
mod test_drive;

use crate::evaluate::Candidate;
use crate::plan::{Acting, Plan};
use crate::registry::{Roads, highway, roads_name};
use crate::reproduce::Outcome;
use crate::reproduce::table::total;
use crate::results::Figures;
use crate::train::RunError;
use metal_rl::random::Streams;
use metal_worlds::highway::{Highway, HighwayConfig, Scenario, Steering};

/// The driver whose looks are drawn.
const DRIVER: &str = "acl";

/// The driven parts of the figures; all others are empty. Worlds other than the highway give none; without the policy
/// `acl` there is only what needs no driver (Fig. 6), without `foa` no aliasing is counted.
///
/// # Errors
/// If the world fails.
pub fn figures(outcome: &Outcome) -> Result<Figures, RunError> {
    let Some(garage) = Garage::of(outcome) else { return Ok(Figures::default()) };
    let road_only = Figures {
        fig6: Some(road_view::draw(&mut garage.world(&Roads::Training, Scenario::Mix))?),
        camera_regions: road_view::regions(),
        ..Figures::default()
    };
    let drivers = drivers(outcome);
    let Some(middling) = middling(outcome).and_then(|seed| drivers.get(seed)) else { return Ok(road_only) };
    Ok(Figures {
        table1: situations::rows(&garage, &drivers)?,
        fig11: Some(test_drive::record(&garage, middling)?),
        look_map: Some(look_map::draw(&garage, middling)?),
        aliasing_empirical: aliasing::rows(&garage, outcome, &drivers)?,
        ..road_only
    })
}

/// Where the worlds of the figures come from: the highway of the plan, on the roads and for the task of a figure.
struct Garage<'a> {
    config: &'a HighwayConfig,
    steering: Steering,
    streams: Streams,
}

impl<'a> Garage<'a> {
    fn of(outcome: &'a Outcome) -> Option<Self> {
        let (config, steering) = outcome.plan.file.environment.as_highway()?;
        Some(Self { config, steering, streams: Streams::new(outcome.options.seed).child("figures") })
    }

    fn world(&self, roads: &Roads, scenario: Scenario) -> Highway {
        self.longer_world(roads, scenario, self.config.horizon)
    }

    fn longer_world(&self, roads: &Roads, scenario: Scenario, horizon: usize) -> Highway {
        let config = HighwayConfig { roads: roads.clone(), scenario, horizon, ..self.config.clone() };
        highway(&config, self.steering.clone())
    }
}

/// Attention control as each seed learned it; nobody if the plan has none.
fn drivers(outcome: &Outcome) -> Vec<Candidate<'_>> {
    let plan = &outcome.plan;
    let Some(row) = plan.file.policy.get(DRIVER) else { return Vec::new() };
    let (Acting::Attention(_), Some(phase)) = (&row.acting, &row.after) else { return Vec::new() };
    let driver = |mind| Candidate {
        plan,
        mind,
        acting: &row.acting,
        roster: plan.roster(&row.roster),
        blind: outcome.blind,
    };
    outcome.trained.iter().filter_map(|seed| Some(driver(&seed.get(phase)?.mind))).collect()
}

/// The seed whose driver costs the median on the road of learning: neither the luckiest nor the unluckiest is shown.
fn middling(outcome: &Outcome) -> Option<usize> {
    let scenario = outcome.plan.file.environment.training_scenario();
    let runs = outcome.tables.get(&roads_name(&Roads::Training))?.get(DRIVER)?.get(&scenario)?;
    let totals: Vec<f64> = runs.iter().map(|seed| total(seed)).collect();
    let mut seeds: Vec<usize> = (0..totals.len()).collect();
    seeds.sort_by(|&a, &b| totals[a].total_cmp(&totals[b]));
    seeds.get(seeds.len() / 2).copied()
}

/// Names of the sensors that consulting `members` in this order reads, each once.
fn sensors_read(plan: &Plan, members: &[usize]) -> Vec<String> {
    let mut read: Vec<usize> = Vec::new();
    for sensor in members.iter().flat_map(|&m| &plan.members[m].sensors) {
        if !read.contains(sensor) {
            read.push(*sensor);
        }
    }
    read.into_iter().map(|s| plan.spec.sensors[s].name.clone()).collect()
}
