//! Quality of the learned driving: accidents and their faults, smoothness of path and speed, keeping to the road.
//! Sec. 3.3 (behavioural measures), Table 2; readings R66, R67.

use serde::{Deserialize, Serialize};

/// One run, step by step: all slices have one entry per motor step.
#[derive(Clone, Copy, Debug)]
pub struct DrivingRun<'a> {
    /// Whether the car touched anything during the step.
    pub contact: &'a [bool],
    /// Whether the contact was the driver's own fault (meaningless without contact).
    pub own_fault: &'a [bool],
    /// Whether the car was off the road at the end of the step.
    pub off_road: &'a [bool],
    /// Change of heading during the step, in radians, to the left.
    pub turn_rad: &'a [f64],
    /// Distance driven during the step, in metres.
    pub distance_m: &'a [f64],
    /// Speed during the step, in metres per second.
    pub speed_mps: &'a [f64],
    /// Distance from the middle of the own lane, in metres; the sign says the side.
    pub lane_offset_m: &'a [f64],
}

/// Driving quality of one run. Shares and means are `None` where there is nothing to divide by.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Driving {
    /// Motor steps.
    pub steps: usize,
    /// Whether there was any contact: the "accident" of Table 2.
    pub accident: bool,
    /// Steps with contact.
    pub contact_steps: usize,
    /// Separate accidents (a contact after a step without one) the driver caused, judged at their first step.
    pub accidents_own_fault: usize,
    /// Separate accidents somebody else caused.
    pub accidents_other_fault: usize,
    /// Σ |turn\[t\] − turn\[t−1\]| / Σ distance, in radians per metre: how jerkily it steers. 0 on straights and on
    /// circles alike.
    pub turn_change_rad_per_m: Option<f64>,
    /// Mean |turn\[t\] − turn\[t−1\]|, in radians per step.
    pub turn_change_rad_per_step: Option<f64>,
    /// Share of steps (from the second) whose speed differs from the step before.
    pub speed_change_share: Option<f64>,
    /// Share of steps off the road.
    pub off_road_share: Option<f64>,
    /// Mean |lane offset|, in metres.
    pub lane_offset_m: Option<f64>,
}

/// Speeds closer than this, in metres per second, are one speed.
const SAME_SPEED_MPS: f64 = 1e-9;

/// Measures one run.
///
/// # Panics
/// If the slices differ in length.
#[must_use]
pub fn driving(run: &DrivingRun<'_>) -> Driving {
    let steps = run.contact.len();
    for length in [run.own_fault.len(), run.off_road.len(), run.turn_rad.len(), run.distance_m.len()] {
        assert_eq!(length, steps, "one entry per motor step");
    }
    assert_eq!((run.speed_mps.len(), run.lane_offset_m.len()), (steps, steps), "one entry per motor step");
    let (accidents_own_fault, accidents_other_fault) = accidents_by_fault(run.contact, run.own_fault);
    let turn_change: f64 = changes(run.turn_rad).sum();
    let speed_changes = changes(run.speed_mps).filter(|&d| d > SAME_SPEED_MPS).count() as f64;
    let contact_steps = count(run.contact);
    Driving {
        steps,
        accident: contact_steps > 0,
        contact_steps,
        accidents_own_fault,
        accidents_other_fault,
        turn_change_rad_per_m: ratio(turn_change, run.distance_m.iter().sum()),
        turn_change_rad_per_step: ratio(turn_change, steps.saturating_sub(1) as f64),
        speed_change_share: ratio(speed_changes, steps.saturating_sub(1) as f64),
        off_road_share: ratio(count(run.off_road) as f64, steps as f64),
        lane_offset_m: ratio(run.lane_offset_m.iter().map(|o| o.abs()).sum(), steps as f64),
    }
}

/// Number of runs with an accident. Table 2.
#[must_use]
pub fn accident_runs(runs: &[Driving]) -> usize {
    runs.iter().filter(|r| r.accident).count()
}

/// Accidents that (the driver, somebody else) caused.
fn accidents_by_fault(contact: &[bool], own_fault: &[bool]) -> (usize, usize) {
    let begins = |&t: &usize| contact[t] && (t == 0 || !contact[t - 1]);
    let (own, other): (Vec<usize>, Vec<usize>) =
        (0..contact.len()).filter(begins).partition(|&t| own_fault[t]);
    (own.len(), other.len())
}

fn count(flags: &[bool]) -> usize {
    flags.iter().filter(|&&f| f).count()
}

/// |x[t] − x[t−1]|
fn changes(values: &[f64]) -> impl Iterator<Item = f64> {
    values.windows(2).map(|w| (w[1] - w[0]).abs())
}

fn ratio(numerator: f64, denominator: f64) -> Option<f64> {
    (denominator > 0.0).then(|| numerator / denominator)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run<'a>(contact: &'a [bool], own_fault: &'a [bool], turn_rad: &'a [f64], speed: &'a [f64]) -> Driving {
        driving(&DrivingRun {
            contact,
            own_fault,
            off_road: contact,
            turn_rad,
            distance_m: speed,
            speed_mps: speed,
            lane_offset_m: turn_rad,
        })
    }

    #[test]
    fn a_long_contact_is_one_accident() {
        let contact = [false, true, true, false, true];
        let fault = [false, true, false, false, false];
        let d = run(&contact, &fault, &[0.0; 5], &[1.0; 5]);
        assert_eq!((d.accident, d.contact_steps), (true, 3));
        assert_eq!((d.accidents_own_fault, d.accidents_other_fault), (1, 1));
        assert_eq!(d.off_road_share, Some(0.6));
        assert_eq!(accident_runs(&[d, run(&[false], &[false], &[0.0], &[1.0])]), 1);
    }

    #[test]
    fn a_circle_is_smooth_and_a_zigzag_is_not() {
        let no = [false; 4];
        let circle = run(&no, &no, &[0.2; 4], &[0.5; 4]);
        let zigzag = run(&no, &no, &[0.5, -0.5, 0.5, -0.5], &[0.5; 4]);
        assert_eq!(circle.turn_change_rad_per_m, Some(0.0));
        assert_eq!((zigzag.turn_change_rad_per_step, zigzag.turn_change_rad_per_m), (Some(1.0), Some(1.5)));
        assert_eq!(zigzag.lane_offset_m, Some(0.5));
    }

    #[test]
    fn changing_speed_is_counted_not_weighed() {
        let no = [false; 5];
        assert_eq!(run(&no, &no, &[0.0; 5], &[1.0, 1.0, 2.0, 2.0, 9.0]).speed_change_share, Some(0.5));
    }

    #[test]
    fn nothing_driven_measures_nothing() {
        let d = run(&[], &[], &[], &[]);
        assert_eq!((d.turn_change_rad_per_m, d.off_road_share, d.accident), (None, None, false));
    }
}
