//! What each policy was given to learn from, said from the configuration of the run.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::figures::policy;
use crate::plan::PlanFile;
use crate::plan::file::{PhaseFile, SubsetsFile};
use crate::results::Results;
use metal_rl::phase::Budget;

/// Who, and what they learned in.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Row {
    /// Policies that were given the same.
    pub who: String,
    /// Phases and their length, in order.
    pub what: String,
}

/// One row per budget; none if the results hold no configuration of an experiment.
#[must_use]
pub fn rows(results: &Results) -> Vec<Row> {
    let Ok(file) = PlanFile::deserialize(&results.config) else { return Vec::new() };
    let mut groups: Vec<(String, Vec<String>)> = Vec::new();
    for name in policy::ordered(file.policy.keys()) {
        let what = chain(&file.phase, file.policy[name].after.as_deref());
        let who = policy::label(name, results);
        match groups.iter_mut().find(|(known, _)| *known == what) {
            Some((_, all)) => all.push(who),
            None => groups.push((what, vec![who])),
        }
    }
    let mut rows: Vec<Row> =
        groups.into_iter().map(|(what, who)| Row { who: who.join("; "), what }).collect();
    rows.extend(file.subsets.as_ref().map(|subsets| fixed(&file, subsets)));
    rows
}

/// `200 steps of demonstration, then 600 episodes of fusion`.
fn chain(phases: &BTreeMap<String, PhaseFile>, last: Option<&str>) -> String {
    let mut parts = Vec::new();
    let mut at = last;
    while let Some((name, row)) = at.and_then(|name| Some((name, phases.get(name)?))) {
        parts.push(format!("{} of {}", amount(row.budget), words(name)));
        at = row.after.as_deref();
    }
    parts.reverse();
    if parts.is_empty() { "no learning".to_owned() } else { parts.join(", then ") }
}

fn amount(budget: Budget) -> String {
    match budget {
        Budget::Episodes(n) => format!("{n} episodes"),
        Budget::Steps(n) => format!("{n} steps"),
    }
}

fn words(phase: &str) -> String {
    phase.replace('_', " ")
}

/// The phases a subset watches stay as they are; the steps of all others become one phase of its own.
fn fixed(file: &PlanFile, subsets: &SubsetsFile) -> Row {
    let is_watched = |name: &&String| file.phase.get(*name).is_some_and(|row| row.acting.is_watched());
    let (watched, driven): (Vec<&String>, Vec<&String>) = subsets.budget_of.iter().partition(is_watched);
    let part = |name: &&String| {
        let row = file.phase.get(*name)?;
        Some(format!("{} of {}", amount(row.budget), words(name)))
    };
    let watched: Vec<String> = watched.iter().filter_map(part).collect();
    let driven: Vec<String> = driven.iter().filter_map(part).collect();
    let learner = subsets.learner.as_ref().and_then(|name| file.learner.get(name));
    let learner = learner.map_or("that of attention control", |l| l.name());
    let screened = crate::figures::number::percent(subsets.screening_share);
    Row {
        who: "Fixed choices, confirmed".to_owned(),
        what: format!(
            "{}as many steps as {} have together, by one learner ({learner}) on its constant set; {screened} of \
             that while screening",
            if watched.is_empty() { String::new() } else { format!("{}, then ", watched.join(", ")) },
            driven.join(" and "),
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_experiment_is_told_phase_by_phase() {
        let plan = crate::plan::parse(crate::experiments::PAPER, &[]).unwrap();
        let config = serde_json::to_value(&plan.file).unwrap();
        let rows = rows(&Results { config, ..Results::default() });
        let what = |who: &str| &rows.iter().find(|r| r.who.contains(who)).unwrap().what;
        assert_eq!(what("FOA"), "200 steps of demonstration, then 1200 episodes of foa");
        assert!(what("(ACL)").ends_with("600 episodes of fusion, then 180000 steps of attention"));
        assert!(
            what("Phase III").ends_with("600 episodes of fusion, then 1800 episodes of attention phase3")
        );
        assert_eq!(what("oracle"), "no learning");
        let fixed = what("Fixed choices");
        assert!(fixed.contains("180000 steps of attention have together"), "{fixed}");
        assert!(fixed.contains("(that of attention control)"), "{fixed}");
    }

    #[test]
    fn results_without_a_plan_have_no_budgets() {
        assert!(rows(&Results::default()).is_empty());
    }
}
