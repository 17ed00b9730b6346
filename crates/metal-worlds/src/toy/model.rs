//! The toy's probabilities: situations, what is right in them, what experts see and say.

use metal_rl::random::Rng;

/// Motor actions, in the order of Eq. (12).
pub const ACTIONS: [&str; 5] = ["fast", "medium", "slow", "right", "left"];
const FAST: usize = 0;
const SLOW: usize = 2;
const RIGHT: usize = 3;
const LEFT: usize = 4;

/// Probabilities of straight road, left bend, right bend.
const CURVES: [f64; 3] = [0.5, 0.25, 0.25];
/// Probabilities of no obstacle, one at the left, one at the right, one ahead.
const OBSTACLES: [f64; 4] = [0.55, 0.15, 0.15, 0.15];
/// The right action for every curve and obstacle.
const RIGHT_ACTION: [[usize; 4]; 3] =
    [[FAST, RIGHT, LEFT, SLOW], [LEFT, SLOW, LEFT, SLOW], [RIGHT, RIGHT, SLOW, SLOW]];
/// Reward of a wrong action with something in the way, and without.
const CRASH: f64 = -30.0;
const SLIP: f64 = -10.0;
/// Probability that an expert sees another group than the true one.
const ERROR: f64 = 0.05;
/// Concentration of an expert's opinion around what it knows, and the floor that keeps it proper.
const CONCENTRATION: f64 = 40.0;
const FLOOR: f64 = 0.3;

/// One of the twelve states of the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Situation {
    /// 0 straight, 1 left, 2 right.
    pub curve: usize,
    /// 0 none, 1 left, 2 right, 3 ahead.
    pub obstacle: usize,
}

impl Situation {
    /// Straight road, nothing in the way.
    pub const FIRST: Self = Self { curve: 0, obstacle: 0 };
    /// Number of situations.
    pub const COUNT: usize = 12;

    /// All situations.
    pub fn all() -> impl Iterator<Item = Self> {
        (0..Self::COUNT).map(|i| Self { curve: i / 4, obstacle: i % 4 })
    }

    pub fn draw(rng: &mut Rng) -> Self {
        Self { curve: rng.pick(&CURVES), obstacle: rng.pick(&OBSTACLES) }
    }

    pub fn probability(self) -> f64 {
        CURVES[self.curve] * OBSTACLES[self.obstacle]
    }

    pub fn right_action(self) -> usize {
        RIGHT_ACTION[self.curve][self.obstacle]
    }

    pub fn reward(self, action: usize) -> f64 {
        match (action == self.right_action(), self.obstacle) {
            (true, _) => 0.0,
            (false, 0) => SLIP,
            (false, _) => CRASH,
        }
    }
}

/// One of the seven experts.
pub struct Expert {
    pub name: &'static str,
    pub price: f64,
    /// Number of groups it can tell apart.
    pub groups: usize,
    group: fn(Situation) -> usize,
}

const fn expert(name: &'static str, price: f64, groups: usize, group: fn(Situation) -> usize) -> Expert {
    Expert { name, price, groups, group }
}

/// The experts, named as the regions of Fig. 6c; the middle is cheaper than the sides, infrared cheapest (Fig. 7b).
pub const EXPERTS: [Expert; 7] = [
    expert("MN", 1.5, 3, middle_near),
    expert("MF", 1.5, 3, |s| s.curve),
    expert("LN", 2.0, 2, |s| usize::from(s.obstacle == 1)),
    expert("RN", 2.0, 2, |s| usize::from(s.obstacle == 2)),
    expert("LF", 2.0, 2, |s| usize::from(s.curve == 1)),
    expert("RF", 2.0, 2, |s| usize::from(s.curve == 2)),
    expert("IR", 1.0, 2, |s| usize::from(s.obstacle != 0)),
];

/// Something ahead hides the road; otherwise straight and bent roads look different.
fn middle_near(s: Situation) -> usize {
    match (s.obstacle, s.curve) {
        (3, _) => 0,
        (_, 0) => 1,
        _ => 2,
    }
}

impl Expert {
    /// The group this expert reports: the true one, or with probability 1/20 another one, uniformly.
    pub fn report(&self, situation: Situation, rng: &mut Rng) -> usize {
        let truth = (self.group)(situation);
        if rng.chance(ERROR) { (truth + 1 + rng.below(self.groups - 1)) % self.groups } else { truth }
    }

    /// Probability that this expert reports `group` in `situation`.
    pub fn report_probability(&self, group: usize, situation: Situation) -> f64 {
        if group == (self.group)(situation) { 1.0 - ERROR } else { ERROR / (self.groups - 1) as f64 }
    }

    /// Dirichlet concentrations of its opinion: 40 P(right action | reported group) + 0.3, where it knows how often
    /// it errs.
    pub fn concentrations(&self, group: usize) -> [f64; 5] {
        let mut mass = [0.0; 5];
        for s in Situation::all() {
            mass[s.right_action()] += s.probability() * self.report_probability(group, s);
        }
        let total: f64 = mass.iter().sum();
        mass.map(|m| CONCENTRATION * m / total + FLOOR)
    }
}
