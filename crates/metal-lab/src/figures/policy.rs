//! How policies, scenarios and sensors are named, ordered and coloured, everywhere alike.

use super::chart::Ink;
use crate::results::Results;

/// The policies with a name of their own, in the order of the report; fixed subsets follow.
pub const ORDER: [&str; 12] = [
    "acl",
    "acl_phase3",
    "acl_decision",
    "acl_paper",
    "foa",
    "foa_paper",
    "fusion",
    "fusion_log_pool",
    "best_fixed",
    "random",
    "blind",
    "oracle",
];

/// The policy's name for people.
#[must_use]
pub fn label(policy: &str, results: &Results) -> String {
    let known = match policy {
        "acl" => "Attention control (ACL)",
        "acl_phase3" => "ACL by the paper's Phase III",
        "acl_decision" => "Phase III in the decision space",
        "acl_paper" => "Phase III as printed",
        "foa" => "Full observer (FOA)",
        "foa_paper" => "FOA, paper's learner",
        "fusion" => "Fusion",
        "fusion_log_pool" => "Fusion, log pool",
        "random" => "Random attention",
        "blind" => "Best blind action",
        "oracle" => "Expert (oracle)",
        "best_fixed" => return best_fixed_label(results),
        other => return other.strip_prefix("fixed:").map_or(other.to_owned(), |set| format!("Fixed {set}")),
    };
    known.to_owned()
}

fn best_fixed_label(results: &Results) -> String {
    let set = results.best_fixed.as_deref().map(|key| key.strip_prefix("fixed:").unwrap_or(key));
    set.map_or("Best fixed choice".to_owned(), |set| format!("Best fixed ({set})"))
}

/// A name short enough to stand beside a bar or a point.
#[must_use]
pub fn short_label(policy: &str) -> String {
    let known = match policy {
        "acl" => "ACL",
        "acl_phase3" => "ACL, Phase III",
        "acl_decision" => "Phase III, decision space",
        "acl_paper" => "Phase III as printed",
        "foa" => "FOA",
        "foa_paper" => "FOA, paper's learner",
        "fusion" => "fusion",
        "fusion_log_pool" => "fusion, log pool",
        "best_fixed" => "best fixed choice",
        "random" => "random attention",
        "blind" => "best blind action",
        "oracle" => "expert (oracle)",
        other => other.strip_prefix("fixed:").unwrap_or(other),
    };
    known.to_owned()
}

/// The policy's colour.
#[must_use]
pub fn ink(policy: &str) -> Ink {
    Ink(match policy {
        "acl" => "acl",
        "acl_phase3" => "acl-phase3",
        "acl_decision" => "acl-decision",
        "acl_paper" => "acl-paper",
        "foa" => "foa",
        "foa_paper" => "foa-paper",
        "fusion" => "fusion",
        "fusion_log_pool" => "fusion-pool",
        "random" => "random",
        "blind" => "blind",
        "oracle" => "oracle",
        _ => "fixed",
    })
}

/// The keys of a table in the order of the report: those of [`ORDER`], then all others.
#[must_use]
pub fn ordered<'a>(keys: impl Iterator<Item = &'a String> + Clone) -> Vec<&'a str> {
    let known = ORDER.into_iter().filter_map(|p| keys.clone().find(|k| *k == p)).map(String::as_str);
    let others = keys.clone().map(String::as_str).filter(|k| !ORDER.contains(k));
    known.chain(others).collect()
}

/// The scenario's name for people.
#[must_use]
pub fn scenario_label(scenario: &str) -> &str {
    match scenario {
        "mix" => "Mix of all",
        "free_road" => "Free road",
        "approaching" => "A car is approaching",
        "from_behind" => "Nearing a car from behind",
        other => other,
    }
}

/// The sensors, in the paper's order, and their colours.
pub const SENSORS: [(&str, Ink); 7] = [
    ("MN", Ink("mn")),
    ("LN", Ink("ln")),
    ("RN", Ink("rn")),
    ("MF", Ink("mf")),
    ("LF", Ink("lf")),
    ("RF", Ink("rf")),
    ("IR", Ink("ir")),
];

/// The sensor's colour; `None` stands for no look at all.
#[must_use]
pub fn sensor_ink(sensor: Option<&str>) -> Ink {
    let known = |name: &str| SENSORS.iter().find(|(s, _)| *s == name).map(|&(_, ink)| ink);
    sensor.and_then(known).unwrap_or(Ink("none"))
}

/// The colour of a number of looks; seven and more look alike.
#[must_use]
pub fn looks_ink(looks: usize) -> Ink {
    const INKS: [&str; 8] = ["look0", "look1", "look2", "look3", "look4", "look5", "look6", "look7"];
    Ink(INKS[looks.min(7)])
}
