//! Units of the student's readings: how far from what it usually is, in standard deviations of what was seen.

use crate::counterfactual::student::gaze::Layout;
use serde::{Deserialize, Serialize};

/// Smallest standard deviation, as a share of a reading's range: rare events are not blown up any further.
const SMALLEST: f64 = 0.02;

/// Centre and gain of every number of a full reading, in the order of [`Layout::readings_of`]. What was not seen stays 0,
/// which is then neither low nor high but usual.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Units {
    centres: Vec<f32>,
    gains: Vec<f32>,
}

impl Units {
    /// The units of network inputs in which everybody was looked at.
    #[must_use]
    pub fn of<'d>(layout: &Layout, full: impl Iterator<Item = &'d [f32]>) -> Self {
        let width = layout.readings_of(&vec![0.0; layout.width()]).len();
        let (mut sums, mut squares, mut count) = (vec![0.0; width], vec![0.0; width], 0.0);
        for input in full {
            count += 1.0;
            for ((sum, square), &x) in sums.iter_mut().zip(&mut squares).zip(layout.readings_of(input)) {
                let x = f64::from(x);
                *sum += x;
                *square += x * x;
            }
        }
        let n = f64::max(count, 1.0);
        let centre = |sum: &f64| sum / n;
        let spread = |(sum, square): (&f64, &f64)| (square / n - centre(sum) * centre(sum)).max(0.0).sqrt();
        let gain = |sums| (1.0 / f64::max(spread(sums), SMALLEST)) as f32;
        Self {
            centres: sums.iter().map(|sum| centre(sum) as f32).collect(),
            gains: sums.iter().zip(&squares).map(gain).collect(),
        }
    }

    /// Whether there is a unit for every reading.
    pub(in crate::counterfactual) fn fits(&self, layout: &Layout) -> bool {
        let readings = layout.readings_of(&vec![0.0; layout.width()]).len();
        self.centres.len() == readings && self.gains.len() == readings
    }

    /// Brings an input to these units: readings that were looked at, and remembered ones.
    pub fn apply(&self, layout: &Layout, input: &mut [f32]) {
        for slot in 0..layout.slots() {
            if layout.is_seen(slot, input) {
                self.convert(layout.block(slot), layout.block(slot), input);
            }
        }
        self.apply_to_memories(layout, input);
    }

    /// The same where every reading is there, whatever was looked at.
    pub fn apply_to_all(&self, layout: &Layout, input: &mut [f32]) {
        for slot in 0..layout.slots() {
            self.convert(layout.block(slot), layout.block(slot), input);
        }
        self.apply_to_memories(layout, input);
    }

    fn apply_to_memories(&self, layout: &Layout, input: &mut [f32]) {
        for slot in 0..layout.slots() {
            for depth in 0..layout.depth() {
                if let Some(place) = layout.memory(slot, depth, input) {
                    self.convert(layout.block(slot), place, input);
                }
            }
        }
    }

    /// Brings everybody's readings to these units.
    pub fn convert_readings(&self, readings: &mut [f32]) {
        self.convert(0..readings.len(), 0..readings.len(), readings);
    }

    /// Everybody's readings back from these units.
    pub fn undo(&self, readings: &mut [f32]) {
        for (x, (centre, gain)) in readings.iter_mut().zip(self.centres.iter().zip(&self.gains)) {
            *x = *x / gain + centre;
        }
    }

    fn convert(&self, of: std::ops::Range<usize>, place: std::ops::Range<usize>, input: &mut [f32]) {
        let units = self.centres[of.clone()].iter().zip(&self.gains[of]);
        for (x, (centre, gain)) in input[place].iter_mut().zip(units) {
            *x = (*x - centre) * gain;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::counterfactual::student::gaze::{Gaze, MemoryConfig};
    use crate::set::IndexSet;

    #[test]
    fn readings_and_memories_are_counted_from_what_is_usual_and_the_unseen_stays_nothing() {
        let layout = Layout::new(&[1, 1], MemoryConfig { looks: 1, steps: 4, ..MemoryConfig::default() }, 2);
        let seen = |a: f64, b: f64| {
            let mut gaze = Gaze::new(&layout);
            gaze.look(&layout, 0, &[a]);
            gaze.look(&layout, 1, &[b]);
            gaze
        };
        let (low, high) = (seen(0.4, 0.5), seen(0.6, 0.5));
        let units = Units::of(&layout, [low.input(), high.input()].into_iter());
        let near =
            |input: &[f32], expected: &[f32]| input.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-4);
        let mut full = high.input().to_vec();
        units.apply(&layout, &mut full);
        assert!(near(&full[..4], &[1.0, 0.0, 1.0, 1.0]), "{full:?}");

        // A step later the first slot is remembered, and nothing is seen.
        let mut later = high;
        later.advance(&layout, 0);
        let mut remembered = later.input().to_vec();
        units.apply(&layout, &mut remembered);
        assert!(near(&remembered[..5], &[0.0, 0.0, 0.0, 0.0, 1.0]), "{remembered:?}");

        // Who knows everything is told in the same units what somebody else did not look at.
        let mut told = low.input().to_vec();
        layout.mark(IndexSet::EMPTY, &mut told);
        units.apply_to_all(&layout, &mut told);
        assert!(near(&told[..4], &[-1.0, 0.0, 0.0, 0.0]), "{told:?}");
    }

    #[test]
    fn what_never_changes_is_not_blown_up() {
        let layout = Layout::new(&[1], MemoryConfig::default(), 2);
        let mut gaze = Gaze::new(&layout);
        gaze.look(&layout, 0, &[0.5]);
        let units = Units::of(&layout, std::iter::once(gaze.input()));
        let mut other = gaze.input().to_vec();
        other[0] = 0.52;
        units.apply(&layout, &mut other);
        assert!((other[0] - 1.0).abs() < 1e-3, "{other:?}");
    }
}
