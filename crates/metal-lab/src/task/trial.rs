//! Testing whoever drives a task: greedy, nobody learns, everybody on the same episodes.

use super::Task;
use super::mind::Learned;
use crate::plan::PlanError;
use crate::train::RunError;
use metal_rl::environment::Environment;
use metal_rl::member::Member;
use metal_rl::observe::{Observer, Step};
use metal_rl::phase::Phase;
use metal_rl::policies::{Advisor, Blind, Fusion, Solo};
use metal_rl::policy::Policy;
use metal_rl::random::Streams;
use metal_rl::run::{Stage, run};
use metal_rl::set::IndexSet;
use metal_rl::view::Scaling;
use serde::{Deserialize, Serialize};

/// Who is at the wheel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Driver {
    /// The expert advisor of the task.
    Advisor,
    /// Always the same motor action.
    Blind(usize),
    /// The full observer.
    Observer,
    /// Everybody together, Eq. (7).
    Fusion,
    /// Attention control.
    Attention,
}

/// What happened in a trial: one entry per episode, looks over all steps.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Score {
    /// Sum of motor rewards of each episode.
    pub motor: Vec<f64>,
    /// Price of the looks of each episode (≥ 0).
    pub price: Vec<f64>,
    /// Motor steps of each episode.
    pub steps: Vec<usize>,
    /// How many motor steps had 0, 1, 2 … sensors read.
    pub looks: Vec<usize>,
    /// How often each sensor was read.
    pub sensors: Vec<usize>,
}

impl Score {
    /// Mean over episodes of motor reward minus price.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.mean(&self.motor) - self.mean(&self.price)
    }

    /// Mean motor reward of an episode.
    #[must_use]
    pub fn mean_motor(&self) -> f64 {
        self.mean(&self.motor)
    }

    /// Mean price of the looks of an episode.
    #[must_use]
    pub fn mean_price(&self) -> f64 {
        self.mean(&self.price)
    }

    /// Mean number of sensors read per motor step.
    #[must_use]
    pub fn looks_per_step(&self) -> f64 {
        let all: usize = self.looks.iter().enumerate().map(|(looks, steps)| looks * steps).sum();
        all as f64 / self.steps.iter().sum::<usize>().max(1) as f64
    }

    fn mean(&self, values: &[f64]) -> f64 {
        values.iter().sum::<f64>() / values.len().max(1) as f64
    }
}

/// Adds up a score.
#[derive(Default)]
pub(crate) struct Scorer {
    /// Finished episodes.
    pub score: Score,
    open: (f64, f64, usize),
}

impl Scorer {
    /// A scorer of a world with this many sensors.
    pub fn new(sensors: usize) -> Self {
        let score = Score { looks: vec![0; sensors + 1], sensors: vec![0; sensors], ..Score::default() };
        Self { score, open: (0.0, 0.0, 0) }
    }
}

impl Observer for Scorer {
    fn on_step(&mut self, step: &Step<'_>) {
        self.open.0 += step.motor_reward;
        self.open.1 += step.look_price;
        self.open.2 += 1;
        self.score.looks[step.percept.read().len()] += 1;
        for sensor in step.percept.read().iter() {
            self.score.sensors[sensor] += 1;
        }
    }

    fn on_episode(&mut self, _episode: usize, _progress: f64) {
        let (motor, price, steps) = std::mem::take(&mut self.open);
        self.score.motor.push(motor);
        self.score.price.push(price);
        self.score.steps.push(steps);
    }
}

/// Lets `driver` of `mind` take `episodes` of the task's testing world; the same `streams` give the same episodes.
///
/// # Errors
/// If the world fails, nobody controls attention yet, or an advisor is asked of a task without one.
pub fn trial(
    task: &dyn Task,
    mind: &Learned,
    driver: Driver,
    (episodes, streams): (usize, &Streams),
) -> Result<Score, RunError> {
    let mut environment = task.testing()?;
    let actions = mind.spec.actions.len();
    if driver == Driver::Advisor {
        environment.reset(0)?;
        environment.advise().ok_or_else(|| PlanError::at("driver", "this task has no expert advisor"))?;
    }
    let mut policy: Box<dyn Policy> = match driver {
        Driver::Advisor => Box::new(Advisor),
        Driver::Blind(action) => Box::new(Blind { action }),
        Driver::Observer => Box::new(Solo::new(mind.observer(), actions)),
        Driver::Fusion => Box::new(Fusion::new(mind.recipe.fuser.clone(), mind.everybody(), actions)),
        Driver::Attention => mind.controller.as_ref().ok_or_else(no_controller)?.policy(),
    };
    let mut members = mind.members.clone();
    let seat = Seat { members: &mut members, policy: policy.as_mut(), scaling: mind.recipe.scaling };
    drive(environment.as_mut(), seat, (episodes, streams))
}

/// Members, and who of them is at the wheel.
pub(crate) struct Seat<'a> {
    pub members: &'a mut [Member],
    pub policy: &'a mut dyn Policy,
    pub scaling: Scaling,
}

/// A greedy drive of `episodes`.
pub(crate) fn drive(
    environment: &mut dyn Environment,
    seat: Seat<'_>,
    (episodes, streams): (usize, &Streams),
) -> Result<Score, RunError> {
    let mut scorer = Scorer::new(environment.spec().sensors.len());
    let phase = Phase::evaluation("trial", IndexSet::first(seat.members.len()), episodes);
    let Seat { members, policy, scaling } = seat;
    run(&mut Stage { environment, members, policy, scaling }, &phase, &streams.child("trial"), &mut scorer)?;
    Ok(scorer.score)
}

fn no_controller() -> RunError {
    PlanError::at("attention", "nobody controls attention: Phase III did not take place").into()
}
