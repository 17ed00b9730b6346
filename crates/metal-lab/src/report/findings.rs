//! What the numbers say, in sentences made from the numbers alone: which goals are met, and all that speaks against
//! attention control.

use serde::Serialize;

use crate::figures::{number, policy};
use crate::paper;
use crate::results::{Estimate, Results, lookup::SCENARIOS};

/// One goal: what is asked, what was reached, what the paper has.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Goal {
    /// The goal in words.
    pub text: String,
    /// Our number.
    pub ours: String,
    /// The paper's number.
    pub paper: String,
    /// `met`, `missed` or `not run`.
    pub state: &'static str,
}

/// The goals of the experiment, in the order of importance.
#[must_use]
pub fn goals(results: &Results) -> Vec<Goal> {
    let mix = |policy, measure| results.estimate(policy, "mix", measure);
    let versus = |other, limit| below("", results.cost_ratio("acl", other), limit);
    let mut goals = vec![
        Goal {
            text: "total cost of ACL ÷ FOA, mean of the three scenarios".into(),
            ..versus("foa", paper::RATIO_TO_FOA)
        },
        Goal {
            text: "total cost of ACL ÷ fusion, mean of the three scenarios".into(),
            ..versus("fusion", paper::RATIO_TO_FUSION)
        },
        below("looks before a motor decision, of 7", mix("acl", "looks"), paper::LOOKS),
        accidents(mix("acl", "accident_rate"), mix("fusion", "accident_rate")),
    ];
    goals.extend(["foa", "fusion", "best_fixed"].map(|other| beats(results, other)));
    goals
}

fn below(text: &str, ours: Option<Estimate>, limit: f64) -> Goal {
    let digits = 2;
    Goal {
        text: text.to_owned(),
        ours: ours.map_or("not run".to_owned(), |e| number::estimate(&e, digits)),
        paper: number::fixed(limit, digits),
        state: state(ours.map(|e| e.mean <= limit)),
    }
}

fn accidents(acl: Option<Estimate>, fusion: Option<Estimate>) -> Goal {
    let both = acl.zip(fusion);
    let share = |e: &Estimate| number::percent(e.mean);
    Goal {
        text: "runs with an accident: no more than fusion".to_owned(),
        ours: both.map_or("not run".to_owned(), |(a, f)| format!("{} against {}", share(&a), share(&f))),
        paper: "6 of 20 against 12 of 20".to_owned(),
        state: state(both.map(|(a, f)| a.mean <= f.mean)),
    }
}

fn beats(results: &Results, other: &str) -> Goal {
    let total = |policy, scenario: &&str| Some(results.estimate(policy, scenario, "total")?.mean);
    let wins: Option<Vec<bool>> =
        SCENARIOS.iter().map(|s| Some(total("acl", s)? > total(other, s)?)).collect();
    let count = |wins: &Vec<bool>| wins.iter().filter(|&&w| w).count();
    let paper = if other == "best_fixed" { "not shown" } else { "3 of 3" };
    Goal {
        text: format!("scenarios in which ACL is cheaper than {}", policy::short_label(other)),
        ours: wins.as_ref().map_or("not run".to_owned(), |w| format!("{} of 3", count(w))),
        paper: paper.to_owned(),
        state: state(wins.as_ref().map(|w| count(w) == 3)),
    }
}

fn state(is_met: Option<bool>) -> &'static str {
    match is_met {
        Some(true) => "met",
        Some(false) => "missed",
        None => "not run",
    }
}

/// The first sentence of the report.
#[must_use]
pub fn headline(results: &Results) -> String {
    let Some(total) = results.estimate("acl", "mix", "total") else {
        return "Attention control was not evaluated in this run.".to_owned();
    };
    let mut sentence = format!(
        "On the {} roads attention control costs {} per motor step",
        results.roads,
        number::estimate(&total, 2)
    );
    let ratios =
        [("foa", "the full observer", paper::RATIO_TO_FOA), ("fusion", "fusion", paper::RATIO_TO_FUSION)];
    let ratio = |&(key, name, paper): &(&str, &str, f64)| {
        let ours = results.cost_ratio("acl", key)?;
        let ours = number::fixed(ours.mean, 2);
        Some(format!("{ours} × the cost of {name} (paper: {})", number::fixed(paper, 2)))
    };
    let parts: Vec<String> = ratios.iter().filter_map(ratio).collect();
    if !parts.is_empty() {
        sentence += &format!(": {}", parts.join(" and "));
    }
    if let Some(looks) = results.estimate("acl", "mix", "looks") {
        sentence += &format!(", with {} looks of 7 (paper: 2.1)", number::fixed(looks.mean, 2));
    }
    sentence + "."
}

/// What must be said beside the headline: a simpler way that costs less over the mix, and how many goals are missed.
#[must_use]
pub fn caveat(results: &Results) -> Option<String> {
    let total = |policy: &str| results.estimate(policy, "mix", "total");
    let ours = total("acl")?;
    let cheaper = |rival: &&str| total(rival).filter(|theirs| theirs.mean > ours.mean);
    let rivals = ["best_fixed", "foa", "fusion", "fusion_log_pool", "random", "blind"];
    let named = rivals.iter().filter_map(|rival| {
        let theirs = number::fixed(cheaper(rival)?.mean, 2);
        Some(format!("{} ({theirs})", policy::label(rival, results)))
    });
    let named: Vec<String> = named.collect();
    let missed = goals(results).iter().filter(|g| g.state == "missed").count();
    let mut sentences = Vec::new();
    if !named.is_empty() {
        sentences.push(format!("Cheaper than attention control: {}.", named.join(", ")));
    }
    if missed > 0 {
        let goals = if missed == 1 { "goal is" } else { "goals are" };
        sentences.push(format!("{missed} {goals} missed."));
    }
    (!sentences.is_empty()).then(|| sentences.join(" "))
}

/// Everything in the numbers that speaks against attention control, each with its numbers.
#[must_use]
pub fn against(results: &Results) -> Vec<String> {
    let mut found = Vec::new();
    for scenario in ["mix", "free_road", "approaching", "from_behind"] {
        for rival in policy::ORDER.iter().filter(|p| !["acl", "oracle"].contains(p)) {
            found.extend(cheaper_rival(results, rival, scenario));
        }
    }
    found.extend(cheaper_subsets(results));
    found.extend(["foa", "fusion", "best_fixed"].iter().filter_map(|rival| safer_rival(results, rival)));
    found.extend(results.other_roads.iter().flat_map(|(roads, policies)| {
        let total = |policy: &str| crate::results::lookup::find(policies, policy, "mix", "total");
        let rivals = ["foa", "fusion", "best_fixed"];
        rivals.into_iter().filter_map(move |rival| {
            sentence(
                (&policy::label(rival, results), &format!("on the {roads} roads")),
                (total(rival)?, total("acl")?),
            )
        })
    }));
    found
}

fn cheaper_rival(results: &Results, rival: &str, scenario: &str) -> Option<String> {
    let total = |policy| results.estimate(policy, scenario, "total");
    let place = match scenario {
        "mix" => "over the mix of scenarios".to_owned(),
        other => format!("in “{}”", policy::scenario_label(other)),
    };
    sentence((&policy::label(rival, results), &place), (total(rival)?, total("acl")?))
}

fn sentence((rival, place): (&str, &str), (theirs, ours): (Estimate, Estimate)) -> Option<String> {
    let sure = match (theirs.band(), ours.band()) {
        (Some(_), Some(_)) if theirs.is_apart_from(&ours) => "the intervals do not overlap",
        (Some(_), Some(_)) => "the intervals overlap",
        _ => "no interval known",
    };
    (theirs.mean > ours.mean).then(|| {
        let [theirs, ours] = [theirs, ours].map(|e| number::estimate(&e, 2));
        format!("{rival} is cheaper than attention control {place}: {theirs} against {ours}; {sure}.")
    })
}

fn cheaper_subsets(results: &Results) -> Option<String> {
    let ours = results.estimate("acl", "mix", "total")?;
    let subsets = &results.figures.subset_front;
    let cheaper: Vec<String> =
        subsets.iter().filter(|s| s.total.mean > ours.mean).map(|s| s.words("+")).collect();
    (!cheaper.is_empty()).then(|| {
        let shown = cheaper.iter().take(6).cloned().collect::<Vec<_>>().join(", ");
        let more = if cheaper.len() > 6 { ", …" } else { "" };
        format!(
            "{} of {} fixed choices cost less in total than attention control ({shown}{more}), those only screened on \
             few seeds included.",
            cheaper.len(),
            subsets.len()
        )
    })
}

fn safer_rival(results: &Results, rival: &str) -> Option<String> {
    let rate = |policy| results.estimate(policy, "mix", "accident_rate");
    let (theirs, ours) = (rate(rival)?, rate("acl")?);
    (theirs.mean < ours.mean).then(|| {
        format!(
            "{} has fewer runs with an accident than attention control: {} against {}.",
            policy::label(rival, results),
            number::percent(theirs.mean),
            number::percent(ours.mean)
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    fn results(acl: f64, fixed: f64) -> Results {
        let scenario = |v: f64| {
            let totals = BTreeMap::from([("total".to_owned(), Estimate::interval(v, v - 0.5, v + 0.5, 5))]);
            ["mix", "free_road", "approaching", "from_behind"]
                .iter()
                .map(|s| ((*s).to_owned(), totals.clone()))
                .collect()
        };
        let policies =
            BTreeMap::from([("acl".to_owned(), scenario(acl)), ("best_fixed".to_owned(), scenario(fixed))]);
        Results { policies, roads: "test".to_owned(), ..Results::default() }
    }

    #[test]
    fn a_better_fixed_subset_is_named_with_its_numbers() {
        let found = against(&results(-14.0, -12.0));
        assert_eq!(found.len(), 4);
        assert!(found[0].contains("−12.00") && found[0].contains("do not overlap"), "{}", found[0]);
        assert!(caveat(&results(-14.0, -12.0)).unwrap().contains("Best fixed choice (−12.00)"));
        assert_eq!(caveat(&results(-12.0, -14.0)), None);
        assert!(against(&results(-12.0, -14.0)).is_empty());
    }

    #[test]
    fn goals_without_numbers_are_not_run_rather_than_missed() {
        let goals = goals(&results(-12.0, -14.0));
        let state = |part: &str| goals.iter().find(|g| g.text.contains(part)).unwrap().state;
        assert_eq!(state("÷ FOA"), "not run");
        assert_eq!(state("best fixed choice"), "met");
        assert!(headline(&Results::default()).contains("not evaluated"));
    }
}
