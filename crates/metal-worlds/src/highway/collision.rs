//! Contact of bodies: upright discs that block, slide along each other with friction and never jump (reading R42).

use super::kinematics::BODY_RADIUS_M;
use super::pose::Pose;

/// Friction between two bodies' sides.
pub const FRICTION: f64 = 0.4;
/// Rounds over all pairs: three bodies in a heap settle within a few.
const ROUNDS: usize = 4;

/// Two bodies touched in this move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Lower index of the two.
    pub first: usize,
    /// Higher index of the two.
    pub second: usize,
    /// Share of the approach that the first body made, 0 to 1: above ½ it drove into the second.
    pub first_share: f64,
}

/// Takes back what bodies drove into each other in one move.
///
/// Each of two overlapping bodies gives back overlap in proportion to how far it drove towards the other. So a body
/// that stood still is not pushed, and none is moved back farther than it came (but for the second order of gliding
/// past each other, at most 4 mm at full speed). The rest of the move slides along the other body, shortened by
/// friction. `report` hears each contact once per round in which it is settled.
pub fn settle(before: &[Pose], now: &mut [Pose], mut report: impl FnMut(Contact)) {
    for _ in 0..ROUNDS {
        let mut quiet = true;
        for first in 0..now.len() {
            for second in first + 1..now.len() {
                if let Some(contact) = separate(before, now, first, second) {
                    report(contact);
                    quiet = false;
                }
            }
        }
        if quiet {
            return;
        }
    }
}

/// Separates one pair, if it overlaps.
fn separate(before: &[Pose], now: &mut [Pose], first: usize, second: usize) -> Option<Contact> {
    let (a, b) = (now[first], now[second]);
    let distance = a.distance_m(&b);
    let overlap = 2.0 * BODY_RADIUS_M - distance;
    if overlap <= 1e-12 {
        return None;
    }
    let normal =
        if distance > 1e-9 { [(b.x_m - a.x_m) / distance, (b.y_m - a.y_m) / distance] } else { [1.0, 0.0] };
    let towards = |i: usize, sign: f64| {
        let (dx, dy) = (now[i].x_m - before[i].x_m, now[i].y_m - before[i].y_m);
        (sign * (dx * normal[0] + dy * normal[1])).max(0.0)
    };
    let (came_first, came_second) = (towards(first, 1.0), towards(second, -1.0));
    let came = came_first + came_second;
    let first_share = if came > 0.0 { came_first / came } else { 0.5 };
    give_back(&before[first], &mut now[first], normal, -overlap * first_share);
    give_back(&before[second], &mut now[second], normal, overlap * (1.0 - first_share));
    Some(Contact { first, second, first_share })
}

/// Shifts a body by `push` along the normal and shortens its sliding by friction.
fn give_back(before: &Pose, now: &mut Pose, normal: [f64; 2], push: f64) {
    let tangent = [-normal[1], normal[0]];
    let (dx, dy) = (now.x_m - before.x_m, now.y_m - before.y_m);
    let slide = dx * tangent[0] + dy * tangent[1];
    let brake = slide.abs().min(FRICTION * push.abs()) * -slide.signum();
    now.x_m += push * normal[0] + brake * tangent[0];
    now.y_m += push * normal[1] + brake * tangent[1];
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn at(x_m: f64, y_m: f64) -> Pose {
        Pose { x_m, y_m, heading_rad: 0.0 }
    }

    #[test]
    fn who_stands_still_is_not_pushed_and_not_at_fault() {
        let before = [at(0.0, 0.0), at(0.08, 0.0)];
        let mut now = [at(0.012, 0.0), at(0.08, 0.0)];
        let mut heard = Vec::new();
        settle(&before, &mut now, |c| heard.push(c));
        assert_eq!(now[1], before[1]);
        assert!((now[0].x_m - 0.006).abs() < 1e-12);
        assert_eq!(heard, [Contact { first: 0, second: 1, first_share: 1.0 }]);
    }

    #[test]
    fn a_glancing_body_slides_on() {
        let before = [at(0.0, 0.05), at(0.06, 0.0)];
        let mut now = [at(0.012, 0.05), at(0.06, 0.0)];
        settle(&before, &mut now, |_| {});
        assert!(now[0].distance_m(&now[1]) >= 2.0 * BODY_RADIUS_M - 1e-9);
        assert!(now[0].y_m > 0.05, "it is led around");
    }

    proptest! {
        #[test]
        fn contact_is_fair_and_never_jumps(
            angle in -3.1..3.1, gap in 0.0..0.01, ax in -0.015..0.015, ay in -0.015..0.015,
            bx in -0.015..0.015, by in -0.015..0.015,
        ) {
            let (sin, cos) = metal_rl::num::sin_cos(angle);
            let d = 2.0 * BODY_RADIUS_M + gap;
            let before = [at(0.0, 0.0), at(d * cos, d * sin)];
            let moved = [at(ax, ay), at(before[1].x_m + bx, before[1].y_m + by)];
            let mut now = moved;
            settle(&before, &mut now, |_| {});
            prop_assert!(now[0].distance_m(&now[1]) >= 2.0 * BODY_RADIUS_M - 1e-9);
            for i in 0..2 {
                let came = moved[i].distance_m(&before[i]);
                // Friction lengthens the way back by a factor √(1 + 0.4²); two bodies that glide past each other
                // overlap by t²/4r more than they approached, t being what they glided.
                let glide2 = (ax - bx) * (ax - bx) + (ay - by) * (ay - by);
                let extra = glide2 / (3.9 * BODY_RADIUS_M);
                prop_assert!(now[i].distance_m(&moved[i]) <= 1.08 * (came + extra), "a jump");
            }
            let mut swapped = [moved[1], moved[0]];
            settle(&[before[1], before[0]], &mut swapped, |_| {});
            prop_assert!(swapped[1].distance_m(&now[0]) < 1e-9, "names do not matter");
        }
    }
}
