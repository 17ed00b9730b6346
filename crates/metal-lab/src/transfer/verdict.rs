//! What transfers and what does not, found from the numbers and said in sentences.

use super::{Arm, TransferResults};
use crate::figures::{number, policy};
use crate::results::{Estimate, Measures};

/// The sentences, the most important first.
#[must_use]
pub fn sentences(results: &TransferResults) -> Vec<String> {
    let parts =
        [as_they_are(results), causes(results), demonstrations(results), scratch(results), learning(results)];
    parts.into_iter().flatten().collect()
}

fn total(measures: Option<&Measures>) -> Option<Estimate> {
    measures?.get("total").copied()
}

fn text(estimate: &Estimate) -> String {
    let interval = number::interval(estimate, 1).map(|i| format!(" {i}")).unwrap_or_default();
    format!("{}{interval}", number::fixed(estimate.mean, 1))
}

/// Whether two means differ beyond their intervals.
fn compared(one: &Estimate, other: &Estimate) -> &'static str {
    match (one.is_apart_from(other), one.mean > other.mean) {
        (true, true) => "better than",
        (true, false) => "worse than",
        _ => "not told apart from",
    }
}

/// How everybody does without a demonstration, against where they come from.
fn as_they_are(results: &TransferResults) -> Vec<String> {
    let here = results.experiment.world.first().and_then(|w| results.worlds.get(&w.name));
    let sentence = |name: &String| {
        let there = total(results.worlds.get("source")?.get(name))?;
        let here = total(here?.get(name))?;
        Some(format!(
            "{} as it comes: {} per motor step here, {} {} where it learned.",
            policy::short_label(name),
            text(&here),
            compared(&here, &there),
            text(&there)
        ))
    };
    results.experiment.policies.iter().filter_map(sentence).collect()
}

/// Which difference costs the lead policy most, one at a time.
fn causes(results: &TransferResults) -> Vec<String> {
    let lead = &results.experiment.policies[0];
    let of = |name: &String| Some((name.clone(), total(results.worlds.get(name)?.get(lead))?));
    let worlds: Vec<_> = results.experiment.world.iter().filter_map(|w| of(&w.name)).collect();
    let [_, (_, base), rest @ ..] = worlds.as_slice() else { return Vec::new() };
    let Some(worst) = rest.iter().min_by(|a, b| a.1.mean.total_cmp(&b.1.mean)) else { return Vec::new() };
    vec![format!(
        "Road and objects alone cost {} {}; of the single differences “{}” is the gravest with {}, {} them alone.",
        policy::short_label(lead),
        text(base),
        worst.0,
        text(&worst.1),
        compared(&worst.1, base)
    )]
}

/// What the most demonstrations change.
fn demonstrations(results: &TransferResults) -> Vec<String> {
    let arms = results.experiment.arms();
    let seen = |name: &str, arm: &Arm| total(results.tests.get(&arm.name())?.get(name));
    let known: Vec<&Arm> = arms.iter().filter(|arm| !arm.newborn).collect();
    let (Some(fewest), Some(most)) =
        (known.iter().min_by_key(|a| a.episodes), known.iter().max_by_key(|a| a.episodes))
    else {
        return Vec::new();
    };
    let sentence = |name: &String| {
        let (before, after) = (seen(name, fewest)?, seen(name, most)?);
        let label = policy::short_label(name);
        if before == after {
            return Some(format!(
                "{label}: demonstrations change nothing. Its choices depend on what it reads, not on what its members \
                 have learned, and in Phase I only members learn."
            ));
        }
        Some(format!(
            "{label} after {} demonstrations: {}, {} {} before.",
            most.episodes,
            text(&after),
            compared(&after, &before),
            text(&before)
        ))
    };
    results.experiment.policies.iter().filter_map(sentence).collect()
}

/// Newborn minds with the same demonstrations.
fn scratch(results: &TransferResults) -> Vec<String> {
    let arms = results.experiment.arms();
    let Some(newborn) = arms.iter().find(|arm| arm.newborn) else { return Vec::new() };
    let known = Arm { newborn: false, episodes: newborn.episodes };
    let sentence = |name: &String| {
        let of = |arm: &Arm| total(results.tests.get(&arm.name())?.get(name));
        let (ours, theirs) = (of(&known)?, of(newborn)?);
        Some(format!(
            "{} with {} demonstrations: transferred {}, from scratch {}: {} learning from scratch.",
            policy::short_label(name),
            newborn.episodes,
            text(&ours),
            text(&theirs),
            compared(&ours, &theirs)
        ))
    };
    results.experiment.policies.iter().filter_map(sentence).collect()
}

/// What learning on comes to.
fn learning(results: &TransferResults) -> Vec<String> {
    let arms = results.experiment.arms();
    let lead = policy::short_label(&results.experiment.policies[0]);
    let sentence = |arm: &Arm| {
        let end = total(results.learned.get(&arm.name()))?;
        let curve = results.learning.get(&arm.name())?;
        let (first, sum) = (curve.moving_average.first()?, curve.accumulated.last()?);
        Some(format!(
            "{lead} {}, learning on for {} episodes: first episode {}, in sum {} [{}], tested afterwards {}.",
            arm.label(),
            curve.reward.len(),
            number::fixed(first.mean, 1),
            number::fixed(sum.mean, 0),
            sum.band()
                .map(|(lo, hi)| format!("{}, {}", number::fixed(lo, 0), number::fixed(hi, 0)))
                .unwrap_or_default(),
            text(&end)
        ))
    };
    arms.iter().filter_map(sentence).collect()
}
