//! Attention control against its exact optimum: the regression test of the paper's phase III.
#![allow(clippy::unwrap_used)]

use metal_lab::experiments;
use metal_lab::plan;
use metal_lab::progress::Silent;
use metal_lab::reproduce::{Options, Outcome, execute};
use metal_lab::trace::EpisodeRecord;
use metal_worlds::toy::optimum;

/// Test runs of one policy.
fn runs<'a>(outcome: &'a Outcome, policy: &str) -> Vec<&'a EpisodeRecord> {
    outcome.tables["training"][policy]["mix"].iter().flatten().collect()
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let n = values.len() as f64;
    values.sum::<f64>() / n
}

fn totals(runs: &[&EpisodeRecord]) -> Vec<f64> {
    runs.iter().map(|r| r.per_step(r.motor + r.perceptual)).collect()
}

/// Mean total and the half width of its 99.9 % interval over the test runs.
fn total(runs: &[&EpisodeRecord]) -> (f64, f64) {
    let totals = totals(runs);
    let m = mean(totals.iter().copied());
    let variance = mean(totals.iter().map(|t| (t - m) * (t - m)));
    (m, 3.29 * (variance / totals.len() as f64).sqrt())
}

#[test]
fn attention_comes_near_the_optimum_and_nobody_beats_it() {
    let plan = plan::parse(experiments::TOY, &["evaluation.runs=8000".into()]).unwrap();
    let options = Options { seeds: 1, seed: 1, quick: false, all_subsets: false };
    let outcome = execute(plan, options, &Silent).unwrap();
    let of = |policy: &str| total(&runs(&outcome, policy));
    let (acl, _) = of("acl");
    let looks = mean(runs(&outcome, "acl").iter().map(|r| r.look_count() as f64));
    assert!(acl >= -6.8, "attention control earns {acl} per move");
    assert!((1.8..=3.3).contains(&looks), "attention control takes {looks} looks per move");
    for other in ["blind", "fusion", "fusion_log_pool"] {
        assert!(acl > of(other).0 + 1.0, "attention control earns {acl}, {other} {:?}", of(other));
    }
    let (blind, width) = of("blind");
    assert!((blind - -12.25).abs() <= width, "blind earns {blind} ± {width}, by the model −12.25");
    // The oracle sees the situation itself, so it is no policy of looks.
    let best = optimum().value;
    for policy in ["acl", "blind", "fusion", "fusion_log_pool"] {
        let (total, width) = of(policy);
        assert!(total - width <= best, "{policy} earns {total} ± {width}, more than the optimum {best}");
    }
    assert!(of("oracle").0 > best, "the oracle pays for no look");
}
