//! Questions that the report and the figures ask of the results.

use super::{Estimate, Policies, Results};

/// The three scenarios of Table 2, in the paper's order.
pub const SCENARIOS: [&str; 3] = ["free_road", "approaching", "from_behind"];

/// One estimate of a table, if it was measured.
#[must_use]
pub fn find(policies: &Policies, policy: &str, scenario: &str, measure: &str) -> Option<Estimate> {
    policies.get(policy)?.get(scenario)?.get(measure).copied()
}

impl Results {
    /// The estimate of `measure` for `policy` in `scenario`, if it was measured.
    #[must_use]
    pub fn estimate(&self, policy: &str, scenario: &str, measure: &str) -> Option<Estimate> {
        find(&self.policies, policy, scenario, measure)
    }

    /// How the total cost of `policy` compares with that of `other`: the mean of the ratios in the three scenarios of
    /// Table 2, the reading under which the paper's own table gives 0.72 and 0.60. Below one, `policy` is cheaper.
    ///
    /// The interval comes from `ratios` if the run wrote one; otherwise only the mean is known. Absent if a scenario is
    /// missing or `other` costs nothing.
    #[must_use]
    pub fn cost_ratio(&self, policy: &str, other: &str) -> Option<Estimate> {
        if let Some(&ratio) = self.ratios.get(&format!("{policy}/{other}")) {
            return Some(ratio);
        }
        let mut sum = 0.0;
        for scenario in SCENARIOS {
            let ours = self.estimate(policy, scenario, "total")?.mean;
            let theirs = self.estimate(other, scenario, "total")?.mean;
            if theirs >= 0.0 {
                return None;
            }
            sum += ours / theirs;
        }
        let n = self.estimate(policy, SCENARIOS[0], "total")?.n;
        Some(Estimate::point(sum / SCENARIOS.len() as f64, n))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    fn results(totals: &[(&str, f64)]) -> Results {
        let measures = |v: f64| BTreeMap::from([("total".to_owned(), Estimate::point(v, 5))]);
        let scenarios = |v: f64| SCENARIOS.iter().map(|s| ((*s).to_owned(), measures(v))).collect();
        Results {
            policies: totals.iter().map(|&(p, v)| (p.to_owned(), scenarios(v))).collect(),
            ..Results::default()
        }
    }

    #[test]
    fn a_ratio_below_one_means_cheaper() {
        let ratio = results(&[("acl", -10.0), ("foa", -20.0)]).cost_ratio("acl", "foa").unwrap();
        assert!((ratio.mean - 0.5).abs() < 1e-12);
    }

    #[test]
    fn a_missing_or_free_opponent_has_no_ratio() {
        let found = results(&[("acl", -10.0), ("foa", 0.0)]);
        assert_eq!(found.cost_ratio("acl", "foa"), None);
        assert_eq!(found.cost_ratio("acl", "fusion"), None);
    }
}
