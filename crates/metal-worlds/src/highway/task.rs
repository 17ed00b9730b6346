//! What the designer wants of a driver: the hierarchy of motor costs (Fig. 7a) and the prices of looks (Fig. 7b).

use super::kinematics::{FAST_MPS, TURN_RADPS};
use super::road::{BORDER_M, LANE_M};
use serde::{Deserialize, Serialize};

/// Gap to a car below which it is dangerously near, in metres.
pub const NEAR_GAP_M: f64 = 0.02;
/// Offset from the middle of the lane at which the body touches a line, in metres.
pub const LANE_FREE_M: f64 = 0.026;
/// Distance from the centre line at which being off the road costs all it can, in metres.
pub const LOST_M: f64 = 0.25;

/// What the cost of one motor action depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facts {
    /// Whether the learner touched a car during the action.
    pub contact: bool,
    /// Free distance to the nearest car after the action, in metres (infinite without cars).
    pub gap_m: f64,
    /// Distance from the centre line, left of the driver positive, in metres.
    pub offset_m: f64,
    /// Forward speed of the action, in metres per second.
    pub speed_mps: f64,
    /// Turning rate of the action, in radians per second.
    pub turn_radps: f64,
    /// Turning rate of the action before.
    pub last_turn_radps: f64,
}

/// Cost of one motor action by sub-behaviour; at most one entry is not 0: the first that applies (Fig. 7a).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotorCost {
    /// Accident, or dangerously near to one.
    pub accident: f64,
    /// Off the road.
    pub road: f64,
    /// Out of the lane.
    pub lane: f64,
    /// Slow or jerky.
    pub smooth: f64,
}

impl MotorCost {
    /// The whole cost, ≥ 0.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.accident + self.road + self.lane + self.smooth
    }
}

/// Weights of the sub-behaviours and prices of the sensors (reading R49).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Task {
    /// w₁ … w₄ of Sec. 4.3.1: accident, off the road, lane keeping, speed and smoothness.
    pub weights: [f64; 4],
    /// Prices of one look at MN, LN, RN, MF, LF, RF, IR (Fig. 7b).
    pub prices: [f64; 7],
}

impl Default for Task {
    /// The paper's weights; prices that sum to its 11 for vision and 12 for all.
    fn default() -> Self {
        Self { weights: [50.0, 30.0, 20.0, 2.0], prices: [1.5, 2.0, 2.0, 1.5, 2.0, 2.0, 1.0] }
    }
}

impl Task {
    /// The cost of one motor action. Fig. 7a, readings R47 and R48.
    ///
    /// # Formula
    /// cost = wₖ · nₖ for the first k with nₖ > 0; every n lies between 0 and 1. n₁ and n₂ start where the next lighter
    /// sub-behaviour ends (at w₂/w₁ and w₃/w₂), so a graver matter never costs less than a lighter one.
    #[must_use]
    pub fn motor_cost(&self, facts: &Facts) -> MotorCost {
        let [w1, w2, w3, w4] = self.weights;
        let accident = danger(facts, w2 / w1);
        let road = straying(facts.offset_m, w3 / w2);
        if accident > 0.0 {
            MotorCost { accident: w1 * accident, ..MotorCost::default() }
        } else if road > 0.0 {
            MotorCost { road: w2 * road, ..MotorCost::default() }
        } else {
            let lane = lane_departure(facts.offset_m);
            let smooth = if lane > 0.0 { 0.0 } else { w4 * hesitation(facts) };
            MotorCost { lane: w3 * lane, smooth, ..MotorCost::default() }
        }
    }
}

/// n₁: 1 in contact, `least` to 1 within [`NEAR_GAP_M`] of a car, else 0.
fn danger(facts: &Facts, least: f64) -> f64 {
    if facts.contact {
        1.0
    } else if facts.gap_m < NEAR_GAP_M {
        1.0 - (1.0 - least) * (facts.gap_m / NEAR_GAP_M).clamp(0.0, 1.0)
    } else {
        0.0
    }
}

/// n₂: 0 on the road, `least` at its border, 1 from [`LOST_M`] on.
fn straying(offset_m: f64, least: f64) -> f64 {
    let beyond = offset_m.abs() - BORDER_M;
    if beyond <= 0.0 { 0.0 } else { (least + (1.0 - least) * beyond / (LOST_M - BORDER_M)).min(1.0) }
}

/// n₃: 0 while the body is between the lines of the right lane, 1 in the middle of the wrong lane and at the border.
fn lane_departure(offset_m: f64) -> f64 {
    let from_lane = offset_m + 0.5 * LANE_M;
    let full = if from_lane > 0.0 { LANE_M } else { BORDER_M - 0.5 * LANE_M };
    ((from_lane.abs() - LANE_FREE_M) / (full - LANE_FREE_M)).clamp(0.0, 1.0)
}

/// n₄: 0.7 of what is missing to full speed, 0.3 of the change of turning.
fn hesitation(facts: &Facts) -> f64 {
    let slow = (1.0 - facts.speed_mps / FAST_MPS).clamp(0.0, 1.0);
    let jerk = ((facts.turn_radps - facts.last_turn_radps).abs() / (2.0 * TURN_RADPS)).min(1.0);
    0.7 * slow + 0.3 * jerk
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const GOOD: Facts = Facts {
        contact: false,
        gap_m: f64::INFINITY,
        offset_m: -0.07,
        speed_mps: FAST_MPS,
        turn_radps: 0.0,
        last_turn_radps: 0.0,
    };

    #[test]
    fn perfect_driving_is_free_and_each_fault_has_its_weight() {
        let cost = |facts: Facts| Task::default().motor_cost(&facts);
        assert_eq!(cost(GOOD).total(), 0.0);
        assert_eq!(cost(Facts { contact: true, offset_m: 0.3, ..GOOD }).total(), 50.0);
        assert_eq!(cost(Facts { offset_m: -0.3, ..GOOD }).road, 30.0);
        assert_eq!(cost(Facts { offset_m: 0.07, ..GOOD }).lane, 20.0);
        assert!((cost(Facts { speed_mps: 0.0, ..GOOD }).smooth - 1.4).abs() < 1e-12);
    }

    #[test]
    fn prices_sum_to_the_papers_columns() {
        let prices = Task::default().prices;
        assert_eq!(prices[..6].iter().sum::<f64>(), 11.0);
        assert_eq!(prices.iter().sum::<f64>(), 12.0);
    }

    proptest! {
        #[test]
        fn one_sub_behaviour_at_a_time_and_the_graver_never_cheaper(
            gap in -0.01..0.1, offset in -0.4..0.4, speed in 0.0..0.12, turn in -0.45..0.45, contact: bool,
        ) {
            let task = Task::default();
            let facts = Facts { contact, gap_m: gap, offset_m: offset, speed_mps: speed, turn_radps: turn, ..GOOD };
            let cost = task.motor_cost(&facts);
            let parts = [cost.accident, cost.road, cost.lane, cost.smooth];
            prop_assert!(parts.iter().filter(|&&c| c > 0.0).count() <= 1);
            let ranges = [(30.0, 50.0), (20.0, 30.0), (0.0, 20.0), (0.0, 2.0)];
            for (part, (low, high)) in parts.iter().zip(ranges) {
                prop_assert!(*part == 0.0 || (low - 1e-9..=high).contains(part));
            }
        }
    }
}
