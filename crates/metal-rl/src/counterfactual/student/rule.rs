//! Who decides on looks: the student, or a rule that was fixed before. Every rival of adaptive attention is one of these
//! rules under the same recipe.

use crate::set::IndexSet;
use serde::{Deserialize, Serialize};

/// How looks are chosen; members by name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum LookRule {
    /// The student looks where it expects to gain more than the price, one look after the other. What costs nothing is
    /// looked at before every move and not counted.
    Adaptive {
        /// Fewest looks before a move. Without memory a student cannot know how long it has not looked: whoever skips
        /// one look skips all of them, so there it should be 1.
        #[serde(default)]
        min_looks: usize,
        /// Most looks before a move, ≥ 1.
        max_looks: usize,
    },
    /// After each look the student appoints the next one: with whom, and in how many motor steps.
    Appointed {
        /// Most looks before a move, ≥ 1.
        max_looks: usize,
        /// Motor steps that it may look ahead, ≥ 1.
        ahead: usize,
    },
    /// Always these members, "a fixed subset of sensors for all states" (Sec. 1).
    Fixed(Vec<String>),
    /// These members at every `steps`-th motor step, nobody in between.
    Every {
        /// Motor steps from one set of looks to the next, ≥ 1.
        steps: usize,
        /// Members looked at.
        members: Vec<String>,
    },
    /// Everybody, always.
    All,
}

impl Default for LookRule {
    fn default() -> Self {
        Self::Adaptive { min_looks: 0, max_looks: 4 }
    }
}

/// A rule names a member that is not on the roster.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is not on the roster")]
pub struct UnknownMember(pub String);

/// A rule in terms of slots, the places on the roster.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Rule {
    /// So many looks, freely chosen.
    Adaptive {
        /// Fewest looks before a move.
        min_looks: usize,
        /// Most looks before a move.
        max_looks: usize,
    },
    /// Freely chosen looks, each appointed in advance.
    Appointed {
        /// Most looks before a move.
        max_looks: usize,
        /// Motor steps that may be looked ahead.
        ahead: usize,
    },
    /// A constant set at motor steps 0, `every`, 2 `every` …
    Scheduled {
        /// Slots looked at.
        slots: IndexSet,
        /// Motor steps between looks.
        every: usize,
    },
}

impl LookRule {
    /// The rule for a roster of these names.
    ///
    /// # Errors
    /// If it names a member who is not among them.
    pub fn resolve(&self, roster: &[String]) -> Result<Rule, UnknownMember> {
        Ok(match self {
            Self::Adaptive { min_looks, max_looks } => {
                Rule::Adaptive { min_looks: *min_looks, max_looks: *max_looks }
            }
            Self::Appointed { max_looks, ahead } => Rule::Appointed { max_looks: *max_looks, ahead: *ahead },
            Self::Fixed(members) => Rule::Scheduled { slots: slots(members, roster)?, every: 1 },
            Self::Every { steps, members } => {
                Rule::Scheduled { slots: slots(members, roster)?, every: *steps }
            }
            Self::All => Rule::Scheduled { slots: IndexSet::first(roster.len()), every: 1 },
        })
    }
}

fn slots(members: &[String], roster: &[String]) -> Result<IndexSet, UnknownMember> {
    let slot = |name: &String| {
        roster.iter().position(|known| known == name).ok_or_else(|| UnknownMember(name.clone()))
    };
    members.iter().map(slot).collect()
}

impl Rule {
    /// The slots that must be looked at in motor step `clock`; none if the student is free to choose.
    #[must_use]
    pub fn due(self, clock: usize) -> Option<IndexSet> {
        match self {
            Self::Adaptive { .. } | Self::Appointed { .. } => None,
            Self::Scheduled { slots, every } if clock.is_multiple_of(every) => Some(slots),
            Self::Scheduled { .. } => Some(IndexSet::EMPTY),
        }
    }

    /// Whether the student decides.
    #[must_use]
    pub fn is_free(self) -> bool {
        matches!(self, Self::Adaptive { .. } | Self::Appointed { .. })
    }

    /// Whether looks are appointed in advance.
    #[must_use]
    pub fn appoints(self) -> bool {
        matches!(self, Self::Appointed { .. })
    }

    /// Most looks before a move.
    #[must_use]
    pub fn most_looks(self) -> usize {
        match self {
            Self::Adaptive { max_looks, .. } | Self::Appointed { max_looks, .. } => max_looks,
            Self::Scheduled { slots, .. } => slots.len(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_are_resolved_by_name_and_fall_due_by_the_clock() {
        let roster: Vec<String> = ["a", "b", "c"].map(String::from).to_vec();
        let every = LookRule::Every { steps: 3, members: vec!["c".into(), "a".into()] };
        let rule = every.resolve(&roster).unwrap();
        let both = IndexSet::EMPTY.with(0).with(2);
        let due: Vec<_> = (0..5).map(|clock| rule.due(clock).unwrap()).collect();
        assert_eq!(due, [both, IndexSet::EMPTY, IndexSet::EMPTY, both, IndexSet::EMPTY]);
        assert_eq!(LookRule::All.resolve(&roster).unwrap().due(7), Some(IndexSet::first(3)));
        assert_eq!(LookRule::default().resolve(&roster).unwrap().due(0), None);
        let stranger = LookRule::Fixed(vec!["d".into()]).resolve(&roster);
        assert_eq!(stranger, Err(UnknownMember("d".into())));
    }
}
