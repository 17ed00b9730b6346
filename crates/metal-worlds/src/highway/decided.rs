//! What red cars have decided: copies of a world ask the same again and again, above all while the learner is out of
//! their sight, and need not look and think each time. Decisions are remembered by all that a car's camera shows
//! depends on, bit by bit, so nothing but time tells whether one was remembered.

use super::kinematics::MotorAction;
use super::pose::Pose;
use super::traffic::CARS;
use std::cell::RefCell;
use thread_local::ThreadLocal;

/// Decisions that each thread remembers: the red cars of some twenty episodes, in 180 KiB.
const PLACES: usize = 2048;

/// All that decides what a red car's camera shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct View {
    road: usize,
    eye: [u64; 3],
    /// Where the bodies in sight are: the learner, then the other red car.
    seen: [Option<[u64; 2]>; CARS],
}

impl View {
    /// What there is to see from `eye` on a road of the world; bodies out of sight are `None`.
    pub fn new(road: usize, eye: Pose, seen: [Option<[f64; 2]>; CARS]) -> Self {
        let eye = [eye.x_m, eye.y_m, eye.heading_rad].map(f64::to_bits);
        Self { road, eye, seen: seen.map(|place| place.map(|at| at.map(f64::to_bits))) }
    }

    /// Where its decision is kept: every bit has its say.
    fn place(&self) -> usize {
        // An odd number near 2⁶⁴ / φ spreads neighbours; only the upper bits are well mixed.
        const SPREAD: u64 = 0x9E37_79B9_7F4A_7C15;
        let mix = |hash: u64, bits: u64| (hash.rotate_left(23) ^ bits).wrapping_mul(SPREAD);
        let seen = self.seen.iter().flat_map(|place| place.unwrap_or([1, 1]));
        let hash = self.eye.into_iter().chain(seen).fold(self.road as u64, mix);
        (hash >> (u64::BITS - PLACES.ilog2())) as usize
    }
}

/// One thread's memory: the last decision of each place.
#[derive(Debug)]
struct Memory(Box<[Option<(View, MotorAction)>]>);

/// What the red cars of all copies of a world have decided; each thread remembers for itself.
#[derive(Debug, Default)]
pub(super) struct Decided(ThreadLocal<RefCell<Memory>>);

impl Decided {
    /// What was decided before at this view, or what `decide` says.
    pub fn or_decide(&self, view: &View, decide: impl FnOnce() -> MotorAction) -> MotorAction {
        let memory = self.0.get_or(|| RefCell::new(Memory(vec![None; PLACES].into_boxed_slice())));
        let place = view.place();
        if let Some((known, action)) = memory.borrow().0[place]
            && known == *view
        {
            return action;
        }
        // Nothing is borrowed while it decides, so a mind that drives worlds of its own may do so.
        let action = decide();
        memory.borrow_mut().0[place] = Some((*view, action));
        action
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view(x_m: f64, seen: Option<[f64; 2]>) -> View {
        View::new(0, Pose { x_m, ..Pose::default() }, [seen, None])
    }

    #[test]
    fn who_sees_the_same_is_not_asked_again_and_whoever_sees_anything_else_is() {
        let decided = Decided::default();
        let mut asked = 0;
        let mut ask = |view: View, action: MotorAction| {
            decided.or_decide(&view, || {
                asked += 1;
                action
            })
        };
        let first = view(0.5, None);
        assert_eq!(ask(first, MotorAction::Fast), MotorAction::Fast);
        assert_eq!(ask(first, MotorAction::SlowDown), MotorAction::Fast);
        for other in [
            view(0.5_f64.next_up(), None),
            view(0.5, Some([1.0, 1.0])),
            View::new(1, Pose { x_m: 0.5, ..Pose::default() }, [None; 2]),
            View::new(0, Pose { x_m: 0.5, ..Pose::default() }, [None, Some([1.0, 1.0])]),
            View::new(0, Pose { x_m: 0.5, y_m: 1e-300, ..Pose::default() }, [None; 2]),
        ] {
            assert_eq!(ask(other, MotorAction::SlowDown), MotorAction::SlowDown);
        }
        assert_eq!(asked, 6);
    }

    #[test]
    fn views_that_share_a_place_displace_each_other_and_are_never_mixed_up() {
        let decided = Decided::default();
        let action = |k: usize| MotorAction::ALL[k % MotorAction::ALL.len()];
        for _ in 0..2 {
            for k in 0..3 * PLACES {
                assert_eq!(decided.or_decide(&view(k as f64, None), || action(k)), action(k));
            }
        }
    }

    #[test]
    fn places_are_spread() {
        let mut used = vec![0_u32; PLACES];
        (0..PLACES).for_each(|k| used[view(0.001 * k as f64, None).place()] += 1);
        // At random, 63 % of them would be used.
        assert!(used.iter().filter(|&&n| n > 0).count() > PLACES / 2);
    }
}
