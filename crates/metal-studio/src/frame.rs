//! What the page is told of one decision: what the mind saw, whom it asked, what it believed and what it did.

use metal_lab::plan::Plan;
use metal_lab::results::{PixelImage, Pose};
use metal_rl::decision::DecisionState;
use metal_rl::environment::Environment;
use metal_rl::policy::Choice;
use metal_rl::policy::Heard;
use metal_rl::view::Percept;
use metal_worlds::highway::Highway;
use metal_worlds::highway::camera::COLUMNS;
use serde::Serialize;

/// Where a frame comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// A mind drives in the studio's own world.
    Drive,
    /// A person drives.
    Demonstration,
    /// A run is training, and this is what it just did.
    Training,
    /// A mind drives a body.
    Body,
}

/// One decision, as the page draws it.
#[derive(Clone, Debug, Serialize)]
pub struct Frame {
    /// Number of the decision in this session, from 1.
    pub n: u64,
    /// Who decided.
    pub source: Source,
    /// Phase of learning, in a training run.
    pub phase: Option<String>,
    /// Episode within the drive or the phase.
    pub episode: usize,
    /// Motor step within the episode, from 0.
    pub step: usize,
    /// Seconds the motor step takes on the screen.
    pub secs: f64,
    /// Whether the move was carried out; if not, the frame only shows what would be done.
    pub done: bool,
    /// The situation of Table 1, if this is one.
    pub scene: Option<usize>,
    /// One entry per car on the stage: one, or two that are compared.
    pub lanes: Vec<LaneFrame>,
}

/// One mind's part of a frame.
#[derive(Clone, Debug, Default, Serialize)]
pub struct LaneFrame {
    /// Who is at the wheel.
    pub driver: String,
    /// Index of the road among the world's roads.
    pub road: usize,
    /// Learner and red cars where the decision was made.
    pub from: Vec<Pose>,
    /// Where the move has led.
    pub to: Vec<Pose>,
    /// The camera's picture, one digit per pixel, row by row.
    pub image: PixelImage,
    /// What the infra-red ring measures, scaled to [0, 1].
    pub infrared: Vec<f64>,
    /// Members asked, in order.
    pub asked: Vec<usize>,
    /// Price of each of these looks.
    pub prices: Vec<f64>,
    /// Sensors that were read.
    pub read: Vec<usize>,
    /// What each member said; null where nobody asked.
    pub opinions: Vec<Option<OpinionFrame>>,
    /// Values of all choices before each look and before the move, where the mind has them.
    pub values: Vec<Vec<f64>>,
    /// The motor action.
    pub action: usize,
    /// What the world's own expert would do, where somebody asked it.
    pub advice: Option<usize>,
    /// Reward of the move, 0 until it is carried out.
    pub motor: f64,
    /// Price of all looks together.
    pub look_price: f64,
    /// Whether something was hit.
    pub accident: bool,
    /// Whether the learner is off the road.
    pub off_road: bool,
    /// What the step has cost on the link to a body.
    pub link: Option<LinkFrame>,
}

/// What a step has cost on the link to a body, and what attention has saved there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LinkFrame {
    /// Bytes in both directions.
    pub bytes: f64,
    /// Milliseconds waited.
    pub ms: f64,
    /// Bytes that looking at everything would have cost more.
    pub saved_bytes: f64,
    /// Milliseconds that it would have taken longer.
    pub saved_ms: f64,
}

/// What a member said.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OpinionFrame {
    /// Scaled readings.
    pub reading: Vec<f64>,
    /// Degrees of support of the motor actions, Eq. (11).
    pub support: Vec<f64>,
    /// Values of the motor actions.
    pub values: Vec<f64>,
}

/// A number short enough for the wire.
fn short(x: f64) -> f64 {
    if x.is_finite() { (x * 1e4).round() / 1e4 } else { 0.0 }
}

/// Numbers short enough for the wire.
#[must_use]
pub fn shortened(values: &[f64]) -> Vec<f64> {
    values.iter().map(|&x| short(x)).collect()
}

impl LaneFrame {
    /// Fills in what the world looks like where a decision is made.
    pub fn see(&mut self, world: &mut Highway) {
        self.road = road_index(world);
        self.from = poses(world);
        self.image = picture(world);
        self.infrared = infrared(world);
    }

    /// Fills in who said what.
    pub fn hear(&mut self, plan: &Plan, state: &DecisionState) {
        self.asked = state.order().to_vec();
        let mut read = metal_rl::set::IndexSet::EMPTY;
        self.prices.clear();
        for &m in state.order() {
            let fresh = plan.members[m].sensors.iter().filter(|&&s| !read.contains(s));
            self.prices.push(fresh.map(|&s| plan.spec.sensors[s].price).sum());
            read = plan.members[m].sensors.iter().fold(read, |set, &s| set.with(s));
        }
        self.read = read.iter().collect();
        self.opinions = (0..state.members()).map(|m| state.opinion(m).map(opinion)).collect();
    }

    /// Notes the values behind one choice.
    pub fn overhear(&mut self, heard: &Heard<'_>) {
        if let Some(values) = heard.values {
            self.values.push(shortened(values));
        }
        if let Choice::Move(action) = heard.choice {
            self.action = action;
        }
    }

    /// Notes what the last step led to.
    pub fn settle(&mut self, world: &Highway) {
        let spec = world.spec();
        let measure = |name: &str| spec.measure(name).is_some_and(|i| world.measures()[i] > 0.5);
        (self.accident, self.off_road) = (measure("accident"), measure("off_road"));
        self.to = poses(world);
    }
}

fn opinion(opinion: metal_rl::decision::Opinion<'_>) -> OpinionFrame {
    let [reading, support, values] = [opinion.reading, opinion.support, opinion.values].map(shortened);
    OpinionFrame { reading, support, values }
}

/// Learner first, then the red cars.
fn poses(world: &Highway) -> Vec<Pose> {
    let all = std::iter::once(world.learner()).chain(world.cars().iter().copied());
    all.map(|p| Pose { x: short(p.x_m), y: short(p.y_m), heading_rad: short(p.heading_rad) }).collect()
}

/// One digit per pixel, one string per row.
fn picture(world: &Highway) -> PixelImage {
    let digits = ['0', '1', '2', '3'];
    world.class_image().chunks(COLUMNS).map(|row| row.iter().map(|&c| digits[c as usize]).collect()).collect()
}

fn infrared(world: &mut Highway) -> Vec<f64> {
    let Some(sensor) = world.spec().sensor("IR") else { return Vec::new() };
    let mut percept = Percept::new(world.spec(), metal_rl::view::Scaling::SquareRoot);
    match percept.look(world, sensor) {
        Ok(_) => percept.reading(sensor).map(shortened).unwrap_or_default(),
        Err(_) => Vec::new(),
    }
}

/// The world's road, counted among its roads.
#[must_use]
pub fn road_index(world: &Highway) -> usize {
    world.grounds().iter().position(|ground| std::ptr::eq(ground.road(), world.road())).unwrap_or(0)
}
