//! What is badly posed about a task, in words.

use super::check::{Check, SensorCheck};
use std::fmt::Write;

/// A gain this small, against the rewards themselves, says that there is nothing to see.
const NOTHING_TO_SEE: f64 = 0.05;
/// A sensor with this share of the gain sees as much as all together.
const NEARLY_ALL: f64 = 0.95;
/// Looks at everybody that cost less than this share of what they are worth are nothing to save.
const TOO_CHEAP: f64 = 0.01;
/// Spans of rewards between which minds learn without anybody's thinking of units.
const SPANS: std::ops::RangeInclusive<f64> = 1e-4..=1e4;

/// What is badly posed, whatever is learned.
pub(super) fn problems(check: &Check) -> Vec<String> {
    let mut all: Vec<String> = rewards(check).into_iter().collect();
    all.extend(check.sensors.iter().flat_map(|s| sensor(check, s)));
    if check.sensors.iter().all(|s| s.price == 0.0) {
        all.push("every look is free: attention has nothing to save".to_owned());
    }
    all
}

/// What seems badly posed to those who learned.
pub(super) fn warnings(check: &Check) -> Vec<String> {
    sight(check).into_iter().chain(prices(check)).collect()
}

/// What a step's reward, and what the choice of a motor action can make of an episode, differ by.
fn width(check: &Check) -> f64 {
    let totals = check.blind.iter().map(|c| c.motor);
    let (low, high) = totals.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
    (check.rewards.1 - check.rewards.0).max(high - low)
}

fn rewards(check: &Check) -> Option<String> {
    let (span, width) = (check.rewards.1 - check.rewards.0, width(check));
    if width == 0.0 {
        return Some("every motor action earns the same: there is nothing to learn".to_owned());
    }
    let odd = span > 0.0 && !SPANS.contains(&span);
    odd.then(|| format!("rewards of a step span {span:.3e}: choose a unit in which they are about 1"))
}

fn sensor(check: &Check, sensor: &SensorCheck) -> Vec<String> {
    let SensorCheck { name, price, .. } = sensor;
    let mut found = Vec::new();
    if sensor.changing == 0.0 {
        found.push(format!("sensor {name} never changes"));
    }
    if sensor.outside > 0.0 {
        let share = 100.0 * sensor.outside;
        found.push(format!("sensor {name}: {share:.1} % of its readings are outside their declared range"));
    }
    let width = width(check);
    if width > 0.0 && *price > width {
        found.push(format!(
            "sensor {name} costs {price}, more than any motor action can win or lose ({width:.3})"
        ));
    }
    found
}

/// What there is to see.
fn sight(check: &Check) -> Option<String> {
    let blind = check.best_blind()?;
    let (gain, steps) = (check.gain(), check.options.steps);
    let scale = blind.motor.abs().max(check.everything.abs());
    if gain <= NOTHING_TO_SEE * scale {
        return Some(format!(
            "with all sensors {:.3}, without a look {:.3}: this task does not need attention, or is not learned in {steps} steps",
            check.everything, blind.motor
        ));
    }
    if check.sensors.len() < 2 {
        return None;
    }
    let told = |s: &&SensorCheck| s.alone - blind.motor;
    let best = check.sensors.iter().max_by(|a, b| a.alone.total_cmp(&b.alone))?;
    if told(&best) >= NEARLY_ALL * gain {
        return Some(format!(
            "sensor {} alone does as well as all: perhaps there is no choice to learn",
            best.name
        ));
    }
    (told(&best) <= NOTHING_TO_SEE * gain).then(|| {
        "no sensor tells anything alone: looks pay only in company, which is hard to find out".to_owned()
    })
}

/// How looks compare with what they are worth.
fn prices(check: &Check) -> Option<String> {
    let gain = check.gain();
    let cheapest = check.sensors.iter().min_by(|a, b| a.cost.total_cmp(&b.cost))?;
    if gain > 0.0 && cheapest.cost > gain {
        return Some(format!(
            "reading {}, the cheapest, before every move costs {:.3} per episode, and seeing everything is worth {gain:.3}: \
             hardly any look can pay",
            cheapest.name, cheapest.cost
        ));
    }
    (check.everything_cost > 0.0 && check.everything_cost < TOO_CHEAP * gain).then(|| {
        format!(
            "reading everything before every move costs {:.3} per episode and is worth {gain:.3}: attention has hardly anything to save",
            check.everything_cost
        )
    })
}

/// The findings on a terminal.
#[must_use]
pub fn check_text(check: &Check) -> String {
    let mut out = format!(
        "{}: motor reward per episode, mean of {} episodes; who sees something learned from {} steps once\n\n",
        check.task, check.options.episodes, check.options.steps
    );
    if let Some(blind) = check.best_blind() {
        let _ = writeln!(out, "blind          {:>12.3}  always `{}`", blind.motor, blind.action);
    }
    let _ =
        writeln!(out, "at random      {:>12.3}  {:.1} motor steps per episode", check.random, check.steps);
    let _ =
        writeln!(out, "all sensors    {:>12.3}  looks cost {:.3}", check.everything, check.everything_cost);
    let _ = writeln!(out, "reward of a step: {:.3} to {:.3}\n", check.rewards.0, check.rewards.1);
    let name_width = check.sensors.iter().map(|s| s.name.chars().count()).max().unwrap_or(0).max(6);
    let _ = writeln!(
        out,
        "{:name_width$}  {:>9}  {:>6}  {:>9}  {:>9}",
        "sensor", "price", "bits", "alone", "looks cost"
    );
    for s in &check.sensors {
        let _ = writeln!(
            out,
            "{:name_width$}  {:>9.3}  {:>6.2}  {:>9.3}  {:>9.3}",
            s.name, s.price, s.bits, s.alone, s.cost
        );
    }
    for problem in &check.problems {
        let _ = writeln!(out, "problem: {problem}");
    }
    for warning in &check.warnings {
        let _ = writeln!(out, "warning: {warning}");
    }
    out
}

#[cfg(test)]
mod tests {
    use super::super::check::{CheckOptions, Constant};
    use super::*;

    fn sensor(name: &str, price: f64, alone: f64) -> SensorCheck {
        let name = name.to_owned();
        SensorCheck { name, price, changing: 1.0, outside: 0.0, bits: 2.0, alone, cost: price }
    }

    fn sound() -> Check {
        let constant = |action: &str, motor| Constant { action: action.to_owned(), motor };
        Check {
            task: "X-v0".into(),
            options: CheckOptions::default(),
            blind: vec![constant("left", -0.5), constant("right", -0.6)],
            random: -0.55,
            steps: 1.0,
            rewards: (-1.0, 0.0),
            sensors: vec![sensor("a", 0.02, -0.3), sensor("b", 0.03, -0.4)],
            everything: -0.1,
            everything_cost: 0.05,
            problems: Vec::new(),
            warnings: Vec::new(),
        }
    }

    fn said(change: impl Fn(&mut Check)) -> String {
        let mut check = sound();
        change(&mut check);
        [problems(&check), warnings(&check)].concat().join("\n")
    }

    #[test]
    fn a_sound_task_has_no_problems_and_every_fault_is_said() {
        assert_eq!(said(|_| ()), "");
        assert!(said(|c| c.sensors[1].changing = 0.0).contains("b never changes"));
        assert!(said(|c| c.sensors[0].outside = 0.25).contains("25.0 %"));
        assert!(said(|c| c.sensors[0].price = 7.0).contains("a costs 7"));
        assert!(said(|c| c.everything = -0.49).contains("does not need attention"));
        assert!(said(|c| c.sensors[0].alone = -0.1).contains("a alone"));
        assert!(said(|c| c.sensors.iter_mut().for_each(|s| s.alone = -0.5)).contains("in company"));
        assert!(said(|c| c.sensors.iter_mut().for_each(|s| s.price = 0.0)).contains("free"));
        assert!(said(|c| c.sensors.iter_mut().for_each(|s| s.cost = 0.9)).contains("hardly any look"));
        assert!(said(|c| c.everything_cost = 0.001).contains("hardly anything to save"));
        assert!(said(|c| c.rewards = (0.0, 1e6)).contains("unit"));
        assert!(
            said(|c| {
                c.rewards = (0.0, 0.0);
                c.blind.truncate(1);
            })
            .contains("nothing to learn")
        );
    }

    #[test]
    fn the_text_has_a_line_for_every_sensor_and_problem() {
        let check = Check { problems: vec!["odd".into()], warnings: vec!["dear".into()], ..sound() };
        let text = check_text(&check);
        for part in ["X-v0", "always `left`", "\na ", "\nb ", "problem: odd", "warning: dear"] {
            assert!(text.contains(part), "{part}: {text}");
        }
    }
}
