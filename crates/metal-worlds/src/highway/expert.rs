//! The expert advisor of Phase I: a short look-ahead with ground truth, the real kinematics and the paths that the red
//! cars are going to take (reading R52).

use super::kinematics::{
    ACTION_SECS, BODY_RADIUS_M, MotorAction, SUBSTEP_SECS, SUBSTEPS, TURN_RADPS, Twist, advance,
};
use super::pose::Pose;
use super::road::{Place, Road};
use super::task::{Facts, LANE_FREE_M, Task};
use super::traffic::{CARS, car_twist, scripted_action};
use metal_rl::num;

/// Motor actions looked ahead.
const DEPTH: usize = 8;
/// Plans kept after each of them.
const BEAM: usize = 28;
/// What the expert adds to every car's radius, in metres: it keeps this clear of what it predicts.
const CARE_M: f64 = 0.025;
/// Plans that end alike within this distance, in metres, and this angle, in radians, are one plan: the beam stays wide.
const ALIKE: (f64, f64) = (0.012, 0.1);
/// What standing in the way of a car that is to come counts at a gap of 0, while plans are compared.
const THREAT: f64 = 60.0;

/// What the expert knows of the world.
#[derive(Clone, Copy, Debug)]
pub struct Knowledge<'a> {
    /// The road.
    pub road: &'a Road,
    /// What is wanted.
    pub task: &'a Task,
    /// The learner's body.
    pub learner: Pose,
    /// Turning rate of the learner's last action, in radians per second.
    pub last_turn_radps: f64,
    /// Where the red cars will be.
    pub paths: Paths,
}

/// A plan: its first action, where it has led and what it has cost.
#[derive(Clone, Copy, Debug)]
struct Plan {
    first: MotorAction,
    body: Pose,
    turn_radps: f64,
    cost: f64,
    /// Cost so far and an estimate of what is to come.
    outlook: f64,
}

/// The action of the cheapest plan found.
#[must_use]
pub fn advise(knowledge: &Knowledge) -> MotorAction {
    let root = Plan {
        first: MotorAction::Fast,
        body: knowledge.learner,
        turn_radps: knowledge.last_turn_radps,
        cost: 0.0,
        outlook: 0.0,
    };
    let mut beam = [root; BEAM];
    let mut width = 1;
    for depth in 0..DEPTH {
        let mut next = [root; BEAM];
        let mut kept = 0;
        for plan in &beam[..width] {
            for action in MotorAction::ALL {
                let mut longer = extend(knowledge, plan, action, depth);
                if depth == 0 {
                    longer.first = action;
                }
                kept = keep(&mut next, kept, longer);
            }
        }
        (beam, width) = (next, kept);
    }
    beam[0].first
}

/// Inserts `plan` into the sorted beam, if it is among the best and better than all that lead to the same place;
/// returns the number kept.
fn keep(beam: &mut [Plan; BEAM], kept: usize, plan: Plan) -> usize {
    if let Some(twin) = beam[..kept].iter().position(|other| alike(other, &plan)) {
        if beam[twin].outlook <= plan.outlook {
            return kept;
        }
        beam[twin..kept].rotate_left(1);
        return keep(beam, kept - 1, plan);
    }
    let at = beam[..kept].partition_point(|other| other.outlook <= plan.outlook);
    if at == BEAM {
        return kept;
    }
    let end = (kept + 1).min(BEAM);
    beam[at..end].rotate_right(1);
    beam[at] = plan;
    end
}

/// Whether two plans of the same length lead to the same place.
fn alike(one: &Plan, other: &Plan) -> bool {
    let near = |a: f64, b: f64| (a - b).abs() < ALIKE.0;
    one.turn_radps == other.turn_radps
        && near(one.body.x_m, other.body.x_m)
        && near(one.body.y_m, other.body.y_m)
        && num::wrap_angle(one.body.heading_rad - other.body.heading_rad).abs() < ALIKE.1
}

/// Where the cars are in the middle and at the end of an action.
type Path = [[Pose; CARS]; 2];

/// Where the red cars will be, as far as the expert looks ahead.
#[derive(Clone, Copy, Debug)]
pub struct Paths {
    cars: usize,
    actions: [Path; DEPTH],
}

impl Paths {
    /// The paths of `cars` that do what `drive` says: given the number of a car and where all cars are, its motion for
    /// the length of one action. Cars beyond [`CARS`] are left out.
    #[must_use]
    pub fn predict(cars: &[Pose], mut drive: impl FnMut(usize, &[Pose; CARS]) -> Twist) -> Self {
        let mut now = [Pose::default(); CARS];
        let cars = &cars[..cars.len().min(CARS)];
        now[..cars.len()].copy_from_slice(cars);
        let mut actions = [[now; 2]; DEPTH];
        for path in &mut actions {
            let before = now;
            for (car, pose) in now.iter_mut().enumerate().take(cars.len()) {
                let twist = drive(car, &before);
                path[0][car] = advance(*pose, twist, 0.5 * ACTION_SECS);
                path[1][car] = advance(path[0][car], twist, 0.5 * ACTION_SECS);
                *pose = path[1][car];
            }
        }
        Self { cars: cars.len(), actions }
    }

    /// The paths of cars of which nothing is known but where they are: they keep their lanes.
    #[must_use]
    pub fn lane_keepers(road: &Road, cars: &[Pose]) -> Self {
        Self::predict(cars, |car, poses| car_twist(scripted_action(road, &poses[car], &[])))
    }

    /// Free distance to the nearest car, in metres.
    fn gap_m(&self, body: &Pose, moment: &[Pose; CARS]) -> f64 {
        let gaps = moment[..self.cars].iter().map(|car| car.distance_m(body) - 2.0 * BODY_RADIUS_M);
        gaps.fold(f64::INFINITY, f64::min)
    }
}

/// The plan, one action longer.
fn extend(knowledge: &Knowledge, plan: &Plan, action: MotorAction, depth: usize) -> Plan {
    let path = &knowledge.paths.actions[depth];
    let twist = action.twist();
    let middle = advance(plan.body, twist, (SUBSTEPS / 2) as f64 * SUBSTEP_SECS);
    let body = advance(middle, twist, (SUBSTEPS - SUBSTEPS / 2) as f64 * SUBSTEP_SECS);
    let gap_then = knowledge.paths.gap_m(&middle, &path[0]) - CARE_M;
    let gap_m = knowledge.paths.gap_m(&body, &path[1]) - CARE_M;
    let place = knowledge.road.locate(body.x_m, body.y_m);
    let direction = place.direction(body.heading_rad);
    let facts = Facts {
        contact: gap_m.min(gap_then) <= 0.0,
        gap_m,
        offset_m: direction.sign() * place.offset_m,
        speed_mps: twist.speed_mps,
        turn_radps: twist.turn_radps,
        last_turn_radps: plan.turn_radps,
    };
    let cost = plan.cost + knowledge.task.motor_cost(&facts).total();
    let outlook = cost + to_come(&place, &body) + threat(&body, &knowledge.paths, depth);
    Plan { first: plan.first, body, turn_radps: twist.turn_radps, cost, outlook }
}

/// A guess at the cost of being where a car will pass within the horizon: without it the plans that begin to dodge in
/// time, and pay for it, are dropped before the others meet the car.
fn threat(body: &Pose, paths: &Paths, depth: usize) -> f64 {
    let later = paths.actions[depth + 1..].iter().map(|path| paths.gap_m(body, &path[1]));
    let nearest = later.fold(f64::INFINITY, f64::min);
    if nearest < CARE_M { THREAT * (1.0 - nearest / (2.0 * BODY_RADIUS_M)) } else { 0.0 }
}

/// A guess at the cost of getting back into the lane: how far out of it, and how wrong the heading is for returning.
fn to_come(place: &Place, body: &Pose) -> f64 {
    let direction = place.direction(body.heading_rad);
    let offset = place.lane_offset_m(direction);
    let wanted = (-8.0 * offset).clamp(-0.7, 0.7);
    let turns =
        (wanted - place.heading_error_rad(body.heading_rad, direction)).abs() / (TURN_RADPS * ACTION_SECS);
    let out = (offset.abs() - 0.5 * LANE_FREE_M).max(0.0);
    2.0 * turns * turns / (1.0 + turns) + 200.0 * out
}

#[cfg(test)]
mod tests {
    use super::super::road::Direction;
    use super::super::shape::ShapeRange;
    use super::*;

    /// The advice among cars that stand still.
    fn advice(learner: Pose, road: &Road, cars: &[Pose]) -> MotorAction {
        let paths = Paths::predict(cars, |_, _| Twist::default());
        advise(&Knowledge { road, task: &Task::default(), learner, last_turn_radps: 0.0, paths })
    }

    #[test]
    fn it_drives_fast_on_free_straights_and_never_into_a_car() {
        let road = Road::new(1, &ShapeRange::TRAINING);
        let arc = road.straightest_arc_m();
        let learner = road.pose_at(arc, -0.07, Direction::Along);
        assert_eq!(advice(learner, &road, &[]), MotorAction::Fast);
        let car = road.pose_at(arc + 0.15, -0.07, Direction::Along);
        assert_ne!(advice(learner, &road, &[car]), MotorAction::Fast);
    }

    #[test]
    fn it_leaves_the_lane_in_time_when_a_car_comes_in_it() {
        let road = Road::new(1, &ShapeRange::TRAINING);
        let (arc, task) = (road.straightest_arc_m(), Task::default());
        let mut learner = road.pose_at(arc, -0.07, Direction::Along);
        let mut car = road.pose_at(arc + 0.5, -0.07, Direction::Against);
        let mut last_turn_radps = 0.0;
        for _ in 0..14 {
            let comes = car_twist(MotorAction::Fast);
            let paths = Paths::predict(&[car], |_, _| comes);
            let action = advise(&Knowledge { road: &road, task: &task, learner, last_turn_radps, paths });
            last_turn_radps = action.twist().turn_radps;
            learner = advance(learner, action.twist(), ACTION_SECS);
            car = advance(car, comes, ACTION_SECS);
            assert!(car.distance_m(&learner) > 2.0 * BODY_RADIUS_M, "{learner:?} hits {car:?}");
        }
    }

    #[test]
    fn it_turns_back_into_its_lane() {
        let road = Road::new(1, &ShapeRange::TRAINING);
        let arc = road.straightest_arc_m();
        for direction in [Direction::Along, Direction::Against] {
            let edge = road.pose_at(arc, -direction.sign() * 0.13, direction);
            assert_eq!(advice(edge, &road, &[]), MotorAction::TurnLeft);
            let wrong = road.pose_at(arc, direction.sign() * 0.07, direction);
            assert_eq!(advice(wrong, &road, &[]), MotorAction::TurnRight);
        }
    }
}
