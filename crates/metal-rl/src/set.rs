//! A set of small indices: which sensors were read, which tiny agents were attended.

use serde::{Deserialize, Serialize};

/// A set of indices below 64, stored in one word.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct IndexSet(u64);

impl IndexSet {
    /// The largest number of different indices (0 … 63).
    pub const CAPACITY: usize = 64;
    /// The empty set.
    pub const EMPTY: Self = Self(0);

    /// {0, 1, … `n` − 1}.
    ///
    /// # Panics
    /// If `n` exceeds [`Self::CAPACITY`].
    #[must_use]
    pub fn first(n: usize) -> Self {
        assert!(n <= Self::CAPACITY, "an index set holds {} indices, not {n}", Self::CAPACITY);
        if n == Self::CAPACITY { Self(u64::MAX) } else { Self((1 << n) - 1) }
    }

    /// The set whose members are the set bits of `bits`.
    #[must_use]
    pub fn from_bits(bits: u64) -> Self {
        Self(bits)
    }

    /// The set as a word, bit i for index i.
    #[must_use]
    pub fn bits(self) -> u64 {
        self.0
    }

    /// Whether `index` is a member.
    #[must_use]
    pub fn contains(self, index: usize) -> bool {
        self.0 >> index & 1 == 1
    }

    /// This set and `index`.
    #[must_use]
    pub fn with(self, index: usize) -> Self {
        Self(self.0 | 1 << index)
    }

    /// This set without `index`.
    #[must_use]
    pub fn without(self, index: usize) -> Self {
        Self(self.0 & !(1 << index))
    }

    /// Members of either set.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Members of this set that are not in `other`.
    #[must_use]
    pub fn minus(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// Number of members.
    #[must_use]
    pub fn len(self) -> usize {
        self.0.count_ones() as usize
    }

    /// Whether there is no member.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Members in increasing order.
    pub fn iter(self) -> impl Iterator<Item = usize> {
        let mut bits = self.0;
        std::iter::from_fn(move || {
            if bits == 0 {
                return None;
            }
            let index = bits.trailing_zeros() as usize;
            bits &= bits - 1;
            Some(index)
        })
    }
}

impl FromIterator<usize> for IndexSet {
    fn from_iter<I: IntoIterator<Item = usize>>(indices: I) -> Self {
        indices.into_iter().fold(Self::EMPTY, Self::with)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn members_come_back_in_order() {
        let set: IndexSet = [5, 0, 63, 5].into_iter().collect();
        assert_eq!(set.iter().collect::<Vec<_>>(), [0, 5, 63]);
        assert_eq!(set.len(), 3);
        assert!(set.contains(63) && !set.contains(1));
        assert_eq!(set.without(63).minus(IndexSet::first(1)), IndexSet::EMPTY.with(5));
        assert_eq!(IndexSet::first(64).len(), 64);
    }
}
