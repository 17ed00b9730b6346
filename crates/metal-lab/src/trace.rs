//! What happened in a run, episode by episode: the source of learning curves, tables and record files.

use crate::progress::Progress;
use metal_rl::environment::EnvironmentSpec;
use metal_rl::measure::behaviour::{Driving, DrivingRun, driving};
use metal_rl::observe::{Observer, Step};
use metal_worlds::highway::kinematics::ACTION_SECS;
use serde::{Deserialize, Serialize};

/// One episode in numbers. Costs are sums over its motor steps (rewards, so ≤ 0 where they hurt).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EpisodeRecord {
    /// Sum of motor rewards.
    pub motor: f64,
    /// Minus the sum of prices paid for looks.
    pub perceptual: f64,
    /// Sensors read per motor step, in order (the full observer reads six).
    pub looks: Vec<u8>,
    /// Quality of the driving, all zero in worlds without cars.
    pub driving: Driving,
    /// Mean speed, m/s.
    pub speed_mps: f64,
}

impl EpisodeRecord {
    /// Motor steps.
    #[must_use]
    pub fn steps(&self) -> usize {
        self.looks.len()
    }

    /// `sum` per motor step.
    #[must_use]
    pub fn per_step(&self, sum: f64) -> f64 {
        sum / self.steps().max(1) as f64
    }

    /// Looks of all steps.
    #[must_use]
    pub fn look_count(&self) -> usize {
        self.looks.iter().map(|&l| usize::from(l)).sum()
    }
}

/// What a driving world reports of each step; a measure it does not have stays zero.
#[derive(Clone, Debug, Default)]
struct Log {
    contact: Vec<bool>,
    own_fault: Vec<bool>,
    off_road: Vec<bool>,
    turn_rad: Vec<f64>,
    distance_m: Vec<f64>,
    speed_mps: Vec<f64>,
    lane_offset_m: Vec<f64>,
    looks: Vec<u8>,
    motor: f64,
    perceptual: f64,
}

/// Columns of a world's report.
const COLUMNS: [&str; 6] = ["accident", "fault", "off_road", "turn_radps", "speed_mps", "lane_offset_m"];

/// Records every episode of a run.
#[derive(Clone, Debug)]
pub struct Trace {
    columns: [Option<usize>; 6],
    log: Log,
    /// Finished episodes.
    pub episodes: Vec<EpisodeRecord>,
}

impl Trace {
    /// An empty trace for a world.
    #[must_use]
    pub fn new(spec: &EnvironmentSpec) -> Self {
        Self { columns: COLUMNS.map(|name| spec.measure(name)), log: Log::default(), episodes: Vec::new() }
    }

    /// The trace of a run that has come as far as `episodes`.
    #[must_use]
    pub fn of(spec: &EnvironmentSpec, episodes: Vec<EpisodeRecord>) -> Self {
        Self { episodes, ..Self::new(spec) }
    }

    /// Motor steps of all finished episodes.
    #[must_use]
    pub fn steps(&self) -> usize {
        self.episodes.iter().map(EpisodeRecord::steps).sum()
    }

    /// Motor steps of the last finished episode.
    #[must_use]
    pub fn last_episode_steps(&self) -> usize {
        self.episodes.last().map_or(0, EpisodeRecord::steps)
    }

    /// Looks of every motor step of the run.
    #[must_use]
    pub fn looks(&self) -> Vec<usize> {
        self.episodes.iter().flat_map(|e| e.looks.iter().map(|&l| usize::from(l))).collect()
    }
}

impl Observer for Trace {
    fn on_step(&mut self, step: &Step<'_>) {
        let value = |column: usize| self.columns[column].map_or(0.0, |i| step.measures[i]);
        let (contact, fault, off_road) = (value(0) > 0.5, value(1) > 0.5, value(2) > 0.5);
        let (turn_radps, speed, offset) = (value(3), value(4), value(5));
        let log = &mut self.log;
        log.contact.push(contact);
        log.own_fault.push(fault);
        log.off_road.push(off_road);
        log.turn_rad.push(turn_radps * ACTION_SECS);
        log.distance_m.push(speed * ACTION_SECS);
        log.speed_mps.push(speed);
        log.lane_offset_m.push(offset);
        log.looks.push(u8::try_from(step.percept.read().len()).unwrap_or(u8::MAX));
        log.motor += step.motor_reward;
        log.perceptual -= step.look_price;
    }

    fn on_episode(&mut self, _episode: usize, _progress: f64) {
        let log = std::mem::take(&mut self.log);
        let driving = driving(&DrivingRun {
            contact: &log.contact,
            own_fault: &log.own_fault,
            off_road: &log.off_road,
            turn_rad: &log.turn_rad,
            distance_m: &log.distance_m,
            speed_mps: &log.speed_mps,
            lane_offset_m: &log.lane_offset_m,
        });
        let speed_mps = log.speed_mps.iter().sum::<f64>() / log.speed_mps.len().max(1) as f64;
        let (motor, perceptual) = (log.motor, log.perceptual);
        self.episodes.push(EpisodeRecord { motor, perceptual, looks: log.looks, driving, speed_mps });
    }
}

/// Writes the trace and moves the progress bar.
pub struct Watcher<'a> {
    /// What happened so far.
    pub trace: Trace,
    /// Who is told how far it is.
    pub progress: &'a dyn Progress,
}

impl Observer for Watcher<'_> {
    fn on_step(&mut self, step: &Step<'_>) {
        self.trace.on_step(step);
    }

    fn on_episode(&mut self, episode: usize, progress: f64) {
        self.trace.on_episode(episode, progress);
        self.progress.steps(self.trace.last_episode_steps());
    }
}
