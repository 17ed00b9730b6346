//! Transfer: what an experiment file may say, and a whole experiment in small.
#![allow(clippy::unwrap_used)]

use metal_lab::progress::Silent;
use metal_lab::transfer::{Arm, TRANSFER, Transfer, TransferOptions, execute, parse, planned_steps, render};
use metal_lab::{experiments, plan};

fn paper() -> plan::Plan {
    plan::parse(experiments::PAPER, &[]).unwrap()
}

/// The shipped experiment with few phases and fewer episodes.
fn small() -> Transfer {
    let mut file = parse(TRANSFER).unwrap();
    file.policies.retain(|name| name == "acl_phase3" || name == "foa");
    (file.episodes, file.runs, file.learning.episodes) = (vec![0, 1], 2, 3);
    file.world.truncate(2);
    let mut source = paper().file;
    metal_lab::reproduce::quick::cut(&mut source, 3, 60);
    Transfer::new(file, &plan::Plan::check(source).unwrap()).unwrap()
}

fn refusal(change: impl FnOnce(&mut metal_lab::transfer::TransferFile)) -> String {
    let mut file = parse(TRANSFER).unwrap();
    change(&mut file);
    Transfer::new(file, &paper()).unwrap_err().to_string()
}

#[test]
fn the_shipped_experiment_is_sound_and_needs_only_what_it_tests() {
    let transfer = Transfer::new(parse(TRANSFER).unwrap(), &paper()).unwrap();
    assert_eq!(transfer.lead_phase(), "attention_phase3");
    let phases: Vec<&str> = transfer.source.file.phase.keys().map(String::as_str).collect();
    assert_eq!(phases, ["attention_decision", "attention_phase3", "demonstration", "foa", "fusion"]);
    assert_eq!(transfer.worlds.len(), transfer.file.world.len());
    assert!(transfer.file.episodes.contains(&20), "the paper's");
}

#[test]
fn what_does_not_fit_is_refused_by_name() {
    assert!(refusal(|f| f.demonstration = "fusion".to_owned()).contains("in which an expert acts"));
    assert!(refusal(|f| f.policies[1] = "oracle".to_owned()).starts_with("policies[1]"));
    assert!(refusal(|f| f.episodes.clear()).starts_with("episodes"));
    let toy = "environment = { toy = {} }";
    let text = TRANSFER.replacen("environment = { miniature = {} }", toy, 1);
    let error = Transfer::new(parse(&text).unwrap(), &paper()).unwrap_err().to_string();
    assert!(error.starts_with("world[0].environment"), "{error}");
    assert!(parse(&format!("unknown = 1\n{TRANSFER}")).unwrap_err().to_string().contains("unknown"));
}

#[test]
fn a_whole_experiment_in_small() {
    let transfer = small();
    let options = TransferOptions { seeds: 2, seed: 1, quick: true };
    assert!(planned_steps(&transfer, options, true) < planned_steps(&transfer, options, false));
    let results = execute(&transfer, options, None, &Silent).unwrap();
    assert_eq!(
        results,
        execute(&transfer, options, None, &Silent).unwrap(),
        "the same seed, the same numbers"
    );
    let [none, one, scratch] = ["transfer-0", "transfer-1", "scratch-1"];
    let total = |arm: &str, policy: &str| results.tests[arm][policy]["total"].mean;
    // Without demonstrations a mind goes as it is; with them the full observer has learned.
    let name = &transfer.file.world[0].name;
    assert_eq!(results.worlds[name]["foa"]["total"].mean, total(none, "foa"));
    assert!(total(one, "foa") != total(none, "foa"));
    // Attention that was never learned cannot be tested, but can be learned.
    assert!(!results.tests[scratch].contains_key("acl_phase3") && results.learned.contains_key(scratch));
    assert_eq!(results.learning[scratch].reward.len(), 3);
    assert_eq!(results.drives[one].accumulated.len(), 50);
    let accumulated = results.drives[one].accumulated.last().unwrap().mean;
    assert!((accumulated / 50.0 - total(one, "acl_phase3")).abs() < 1e-9);
    assert!(results.expert["total"].mean > total(scratch, "foa"));
    let page = render(&results, "metal transfer").unwrap();
    for word in ["Quick run", "Fig. 11", "from scratch, 1 demonstrations", "<svg", "What transfers"] {
        assert!(page.contains(word), "{word}");
    }
    assert!(!page.contains("<script"));
    let text = serde_json::to_string(&results).unwrap();
    let again: metal_lab::transfer::TransferResults = serde_json::from_str(&text).unwrap();
    assert_eq!(again, results);
}

#[test]
fn arms_are_named_for_what_they_know() {
    let arm = Arm { newborn: true, episodes: 20 };
    assert_eq!(
        (arm.name().as_str(), arm.label().as_str()),
        ("scratch-20", "from scratch, 20 demonstrations")
    );
}
