//! Observers: everything a figure, a record or a page may need to know of a run, and no way to change it.

use crate::decision::DecisionState;
use crate::environment::End;
use crate::member::Member;
use crate::view::Percept;

/// One motor step, as it happened.
#[derive(Clone, Copy, Debug)]
pub struct Step<'a> {
    /// Episode number within the phase, from 0.
    pub episode: usize,
    /// Motor step within the episode, from 0.
    pub index: usize,
    /// What was read.
    pub percept: &'a Percept,
    /// Who was consulted in which order, and what they said.
    pub state: &'a DecisionState,
    /// Motor action carried out.
    pub action: usize,
    /// Reward of the motor action (≤ 0 for a cost).
    pub motor_reward: f64,
    /// Price of the looks of this step (≥ 0).
    pub look_price: f64,
    /// What the environment reports of the step, named by its spec's `measures`.
    pub measures: &'a [f64],
    /// Whether the episode is over.
    pub end: End,
}

/// Watches a run.
pub trait Observer {
    /// After every motor step.
    fn on_step(&mut self, step: &Step<'_>);

    /// After every episode, when everybody has learned; `progress` of the phase in [0, 1].
    fn on_episode(&mut self, _episode: usize, _progress: f64) {}

    /// After every episode: the members as they then are.
    fn on_members(&mut self, _members: &[Member]) {}
}

/// Watches nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unobserved;

impl Observer for Unobserved {
    fn on_step(&mut self, _step: &Step<'_>) {}
}
