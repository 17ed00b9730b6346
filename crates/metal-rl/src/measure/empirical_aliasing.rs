//! Aliasing counted in a log instead of bounded by assumption: do states that need different actions look alike in
//! the decision space? Beside Eqs. (17)-(19), which define the case, this is what one observes
//! (reading R64).

use crate::measure::statistics::{Estimate, wilson};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// One logged moment at which everybody was heard (Phase II).
#[derive(Clone, Copy, Debug)]
pub struct LoggedState<'a> {
    /// State of the full observer, scaled to [0, 1] per entry. Eq. (2).
    pub state: &'a [f64],
    /// The full observer's greedy action. Eq. (6).
    pub action: usize,
    /// All degrees of support, one tiny agent after the other, each entry in [0, 1]. Eq. (19).
    pub decision: &'a [f64],
}

/// How coarsely to look.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Resolution {
    /// States are physically distinct if they fall into different cells of a grid of this width (> 0).
    pub state_cell: f64,
    /// Quantisation levels of a degree of support, q_dec ≥ 2.
    pub support_levels: u32,
}

/// What was counted.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EmpiricalAliasing {
    /// Pairs of physically distinct states with different full-observer actions: they ought to look different.
    pub opposed_pairs: u64,
    /// Those of them with equal decision codes.
    pub aliased_pairs: u64,
    /// Aliased per opposed pair, with Wilson's interval. Pairs share states, so the interval is too narrow;
    /// `affected` has the honest one.
    pub pair_rate: Option<Estimate>,
    /// Share of logged states that have at least one aliased partner, with Wilson's interval over states.
    pub affected: Option<Estimate>,
    /// Number of different decision codes seen.
    pub codes: usize,
}

/// Counts aliased pairs in a log, in O(n log n).
#[must_use]
pub fn count(log: &[LoggedState<'_>], resolution: Resolution) -> EmpiricalAliasing {
    let cells =
        classes(log, |l| l.state.iter().map(|&x| (x / resolution.state_cell).floor() as i64).collect());
    let codes = classes(log, |l| l.decision.iter().map(|&p| level(p, resolution.support_levels)).collect());
    let everything: Vec<usize> = (0..log.len()).collect();
    let opposed: u64 = opponents(log, &cells, &everything).iter().sum();
    let (mut aliased, mut affected, groups) = (0, 0, members(&codes));
    for group in groups.values() {
        let partners = opponents(log, &cells, group);
        aliased += partners.iter().sum::<u64>();
        affected += partners.iter().filter(|&&n| n > 0).count() as u64;
    }
    EmpiricalAliasing {
        opposed_pairs: opposed / 2,
        aliased_pairs: aliased / 2,
        pair_rate: wilson(aliased / 2, opposed / 2),
        affected: wilson(affected, log.len() as u64),
        codes: groups.len(),
    }
}

/// Quantisation level 0 … `levels` − 1 of a support.
fn level(support: f64, levels: u32) -> i64 {
    ((support * f64::from(levels)).floor() as i64).clamp(0, i64::from(levels) - 1)
}

/// Numbers the distinct keys of the log: equal numbers mean equal keys.
fn classes(log: &[LoggedState<'_>], key: impl Fn(&LoggedState<'_>) -> Vec<i64>) -> Vec<usize> {
    let mut numbers = BTreeMap::new();
    log.iter()
        .map(|l| {
            let next = numbers.len();
            *numbers.entry(key(l)).or_insert(next)
        })
        .collect()
}

/// Positions of every class.
fn members(classes: &[usize]) -> BTreeMap<usize, Vec<usize>> {
    let mut members: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (i, &class) in classes.iter().enumerate() {
        members.entry(class).or_default().push(i);
    }
    members
}

/// For every member of `group`, how many members have another action and another cell: by inclusion and exclusion,
/// all − same action − same cell + same both.
fn opponents(log: &[LoggedState<'_>], cells: &[usize], group: &[usize]) -> Vec<u64> {
    let (mut by_action, mut by_cell, mut by_both) = (BTreeMap::new(), BTreeMap::new(), BTreeMap::new());
    for &i in group {
        *by_action.entry(log[i].action).or_insert(0_u64) += 1;
        *by_cell.entry(cells[i]).or_insert(0_u64) += 1;
        *by_both.entry((log[i].action, cells[i])).or_insert(0_u64) += 1;
    }
    let count = |&i: &usize| {
        group.len() as u64 + by_both[&(log[i].action, cells[i])]
            - by_action[&log[i].action]
            - by_cell[&cells[i]]
    };
    group.iter().map(count).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const COARSE: Resolution = Resolution { state_cell: 0.25, support_levels: 4 };

    /// The definition, pair by pair.
    fn slow_pairs(log: &[LoggedState<'_>]) -> (u64, u64) {
        let cell =
            |l: &LoggedState<'_>| l.state.iter().map(|x| (x / 0.25).floor() as i64).collect::<Vec<_>>();
        let code = |l: &LoggedState<'_>| l.decision.iter().map(|&p| level(p, 4)).collect::<Vec<_>>();
        let (mut opposed, mut aliased) = (0, 0);
        for (i, a) in log.iter().enumerate() {
            for b in &log[..i] {
                if a.action != b.action && cell(a) != cell(b) {
                    opposed += 1;
                    aliased += u64::from(code(a) == code(b));
                }
            }
        }
        (opposed, aliased)
    }

    proptest! {
        #[test]
        fn counting_by_classes_equals_counting_by_pairs(
            raw in prop::collection::vec((0.0..1.0_f64, 0..3_usize, 0.0..1.0_f64), 0..60)
        ) {
            let log: Vec<_> = raw
                .iter()
                .map(|(s, a, d)| LoggedState {
                    state: std::slice::from_ref(s), action: *a, decision: std::slice::from_ref(d)
                })
                .collect();
            let counted = count(&log, COARSE);
            prop_assert_eq!((counted.opposed_pairs, counted.aliased_pairs), slow_pairs(&log));
        }
    }

    #[test]
    fn states_that_need_the_same_action_may_look_alike() {
        let state = |state, action| LoggedState { state, action, decision: &[0.6, 0.4] };
        let counted = count(&[state(&[0.1], 0), state(&[0.9], 0)], COARSE);
        assert_eq!((counted.opposed_pairs, counted.pair_rate), (0, None));
        let counted = count(&[state(&[0.1], 0), state(&[0.9], 1)], COARSE);
        assert_eq!((counted.opposed_pairs, counted.aliased_pairs, counted.codes), (1, 1, 1));
        assert_eq!(counted.affected, wilson(2, 2));
    }

    #[test]
    fn finer_levels_tell_more_apart() {
        let log = [
            LoggedState { state: &[0.1], action: 0, decision: &[0.55, 0.45] },
            LoggedState { state: &[0.9], action: 1, decision: &[0.65, 0.35] },
        ];
        let aliased =
            |support_levels| count(&log, Resolution { state_cell: 0.1, support_levels }).aliased_pairs;
        assert_eq!((aliased(2), aliased(10)), (1, 0));
    }
}
