//! What of an input is known together or not at all: a reading, a memory with its age, or what is always known.

use crate::counterfactual::student::gaze::Layout;
use crate::set::IndexSet;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// A stretch of features.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Block {
    /// Where it begins in the input.
    source: usize,
    /// Its features.
    features: Range<usize>,
    /// The number of the input that is above 0 if the block is known; none: it always is.
    flag: Option<usize>,
    /// The slot whose reading it is, if it is one of this motor step.
    slot: Option<usize>,
}

/// The blocks of an input that are worth a model, and where their features lie; behind them lie the targets.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Blocks {
    blocks: Vec<Block>,
    features: usize,
    targets: usize,
}

impl Blocks {
    /// The blocks of a student that may look at `visible` only: of the others nothing is ever known.
    pub fn new(layout: &Layout, visible: IndexSet, targets: usize) -> Self {
        let (mut blocks, mut features) = (Vec::new(), 0);
        for part in layout.parts() {
            let shown = part.owner.is_none_or(|slot| visible.contains(slot));
            if !shown || part.place.is_empty() {
                continue;
            }
            let length = part.place.len();
            blocks.push(Block {
                source: part.place.start,
                features: features..features + length,
                flag: part.flag,
                slot: part.owner.filter(|_| part.now),
            });
            features += length;
        }
        Self { blocks, features, targets }
    }

    /// Numbers per moment without the targets.
    pub fn features(&self) -> usize {
        self.features
    }

    /// Numbers per moment with the targets.
    pub fn width(&self) -> usize {
        self.features + self.targets
    }

    /// Where the targets lie.
    pub fn targets(&self) -> Range<usize> {
        self.features..self.width()
    }

    /// The features of every block; the last one is that of the targets.
    pub fn ranges(&self) -> Vec<Range<usize>> {
        self.blocks.iter().map(|block| block.features.clone()).chain([self.targets()]).collect()
    }

    /// The features of this motor step's reading of `slot`, if it is ever shown.
    pub fn reading(&self, slot: usize) -> Option<Range<usize>> {
        self.blocks.iter().find(|block| block.slot == Some(slot)).map(|block| block.features.clone())
    }

    /// Reads an input: its features, and which blocks are known. Targets are unknown, and nothing is written for them.
    pub fn read(&self, input: &[f32], x: &mut [f64], seen: &mut [bool]) {
        for (block, seen) in self.blocks.iter().zip(seen.iter_mut()) {
            *seen = block.flag.is_none_or(|flag| input[flag] > 0.0);
            if *seen {
                let source = &input[block.source..block.source + block.features.len()];
                for (x, &value) in x[block.features.clone()].iter_mut().zip(source) {
                    *x = f64::from(value);
                }
            }
        }
        seen[self.blocks.len()] = false;
    }

    /// Which blocks that come and go are known: one number each, for linear functions of it.
    pub fn bits(&self, seen: &[bool], out: &mut [f64]) {
        let flagged = self.blocks.iter().zip(seen).filter(|(block, _)| block.flag.is_some());
        for ((_, &seen), out) in flagged.zip(out) {
            *out = f64::from(u8::from(seen));
        }
    }

    /// How many numbers [`Self::bits`] writes.
    pub fn flags(&self) -> usize {
        self.blocks.iter().filter(|block| block.flag.is_some()).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::counterfactual::student::gaze::{Gaze, MemoryConfig};

    #[test]
    fn what_was_not_looked_at_is_unknown_and_what_never_can_be_has_no_place() {
        let memory = MemoryConfig { looks: 1, steps: 4, actions: 1, recurrent: 0 };
        let layout = Layout::new(&[2, 1, 1], memory, 2);
        let blocks = Blocks::new(&layout, IndexSet::first(2), 2);
        // Readings of 2 + 1, memories of 3 + 2 with their ages, two actions and the time unseen, two targets.
        assert_eq!((blocks.features(), blocks.width(), blocks.flags()), (11, 13, 4));
        let mut gaze = Gaze::new(&layout);
        gaze.look(&layout, 0, &[0.1, 0.2]);
        gaze.advance(&layout, 1);
        gaze.look(&layout, 1, &[0.7]);
        let (mut x, mut seen, mut bits) = (vec![f64::NAN; 13], vec![true; 6], vec![0.0; 4]);
        blocks.read(gaze.input(), &mut x, &mut seen);
        assert_eq!(seen, [false, true, true, false, true, false]);
        assert!(x[0].is_nan() && (x[2] - 0.7).abs() < 1e-6 && x[5] == 1.0, "{x:?}");
        assert_eq!(x[8..11], [0.0, 1.0, 0.0]);
        blocks.bits(&seen, &mut bits);
        assert_eq!(bits, [0.0, 1.0, 1.0, 0.0]);
        assert_eq!((blocks.reading(1), blocks.reading(2)), (Some(2..3), None));
    }
}
