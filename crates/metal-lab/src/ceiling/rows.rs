//! The rows of the table: ways of looking, of which the best of each kind is taken.

use super::lesson::SLOWEST;
use super::replay::Fixed;

/// How looks are chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Looking {
    /// A subset of so many members, always.
    Always(usize),
    /// Any subset, always.
    AnyAlways,
    /// Any subset at every so many motor steps.
    Every(usize),
    /// Any subset at any rhythm: what attention has to beat.
    AnyFixed,
    /// By need.
    Adaptive,
}

/// A row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Row {
    pub looking: Looking,
    pub remembers: bool,
}

impl Row {
    /// All rows, in the order of the table.
    pub fn all(slots: usize) -> Vec<Self> {
        let plain = |looking| Self { looking, remembers: false };
        let mindful = |looking| Self { looking, remembers: true };
        let sizes = || (0..=slots).map(Looking::Always);
        let mut rows: Vec<Self> = sizes().map(plain).collect();
        rows.extend([Looking::AnyAlways, Looking::Adaptive].map(plain));
        rows.extend(sizes().map(mindful));
        rows.push(mindful(Looking::AnyAlways));
        rows.extend((2..=SLOWEST).map(Looking::Every).map(mindful));
        rows.extend([Looking::AnyFixed, Looking::Adaptive].map(mindful));
        rows
    }

    /// Whether `choice` is one of this row's.
    pub fn allows(self, choice: &Fixed) -> bool {
        let always = choice.every == 1;
        choice.remembers == self.remembers
            && match self.looking {
                Looking::Always(size) => always && choice.slots.len() == size,
                Looking::AnyAlways => always,
                Looking::Every(every) => choice.every == every,
                Looking::AnyFixed => true,
                Looking::Adaptive => false,
            }
    }

    /// Its name.
    pub fn name(self) -> String {
        match self.looking {
            Looking::Always(0) => "nobody".to_owned(),
            Looking::Always(1) => "best single".to_owned(),
            Looking::Always(size) => format!("best of {size}"),
            Looking::AnyAlways => "best subset".to_owned(),
            Looking::Every(every) => format!("best at every {every}. step"),
            Looking::AnyFixed => "best fixed choice of all".to_owned(),
            Looking::Adaptive => "adaptive looks".to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ceiling::replay::choices;

    #[test]
    fn every_choice_has_its_row_and_looks_by_need_have_none() {
        let choices = choices(3);
        assert_eq!(choices.len(), 8 + 7 * SLOWEST + 1);
        let rows = Row::all(3);
        for choice in &choices {
            let homes: Vec<_> = rows.iter().filter(|row| row.allows(choice)).map(|row| row.looking).collect();
            assert!(homes.iter().any(|l| matches!(l, Looking::Always(_) | Looking::Every(_))), "{choice:?}");
            assert_eq!(homes.contains(&Looking::AnyFixed), choice.remembers);
        }
    }
}
