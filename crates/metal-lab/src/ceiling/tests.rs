//! A maze where every number of the ceiling is known by hand.

use super::replay::{Fixed, choices, fixed, sum};
use super::subject::Subject;
use super::*;
use crate::progress::Silent;
use metal_rl::num;
use metal_rl::set::IndexSet;

/// Discount of the recipe.
const GAMMA: f64 = 0.93;

const MAZE: &str = r#"
title = "maze"
scaling = "linear"
[environment.maze]
[learner.unused.mlp]
[member.X]
sensors = ["X"]
learner = "unused"
[member.Y]
sensors = ["Y"]
learner = "unused"
[attention.acl.counterfactual]
memory = { looks = 1, steps = 10, actions = 1 }
[phase.attention]
roster = ["X", "Y"]
acting = { attention = "acl" }
teaching = "nobody"
rate = "full"
budget = { steps = 1000 }
[policy.acl]
after = "attention"
roster = ["X", "Y"]
acting = { attention = "acl" }
[evaluation]
runs = 10
"#;

fn maze() -> Plan {
    crate::plan::parse(MAZE, &[]).unwrap()
}

fn options() -> CeilingOptions {
    CeilingOptions {
        seeds: 1,
        driver_steps: 4000,
        driver_iterations: 8,
        log_steps: 1500,
        folds: 3,
        batches: 800,
        rounds: 1,
        copies: 2,
        runs: 100,
        ..CeilingOptions::default()
    }
}

fn line<'a>(report: &'a CeilingReport, name: &str, remembers: bool) -> &'a Line {
    report.lines.iter().find(|l| l.name == name && l.remembers == remembers).unwrap()
}

#[test]
fn in_the_maze_either_coordinate_is_enough_and_half_its_looks_are_remembered() {
    let report = run(&maze(), &options(), &Silent).unwrap();
    // From everywhere the way to the north-east corner takes as many steps as there are to the north and to the east;
    // from the 15 cells that is 3.2 on average, and every motor step costs 1.
    assert!((report.logs[0].motor + 1.0).abs() < 0.01, "{}", report.logs[0].motor);
    let near = |a: f64, b: f64| (a - b).abs() < 0.03;
    for remembers in [false, true] {
        let one = line(&report, "best single", remembers);
        assert!(near(one.motor.mean, -1.0) && near(one.total.mean, -1.1), "{one:?}");
        let both = line(&report, "best of 2", remembers);
        assert!(near(both.motor.mean, -1.0) && near(both.total.mean, -1.2), "{both:?}");
        let nobody = line(&report, "nobody", remembers);
        assert!(nobody.lost.mean > 0.1 && nobody.price.mean == 0.0, "{nobody:?}");
        let adaptive = line(&report, "adaptive looks", remembers);
        assert!(adaptive.total.mean > one.total.mean - 0.03, "{adaptive:?}");
    }
    // Where x was seen a step ago and the last move is remembered, x is known.
    let half = line(&report, "best at every 2. step", true);
    let price = half.price.mean;
    assert!(near(half.motor.mean, -1.0) && (0.05..0.075).contains(&price), "{half:?}");
    let wheel = half.driven.as_ref().unwrap();
    assert!(near(wheel.motor.mean, -1.0), "{wheel:?}");
    let own = report.ratios.iter().find(|r| r.remembers && r.to == "best fixed choice of all").unwrap();
    assert!(own.ratio.mean < 1.03, "{own:?}");
}

#[test]
fn who_sees_nothing_loses_what_can_be_told_by_hand() {
    let (plan, options) = (maze(), options());
    let subject = Subject::new(&plan, &options).unwrap();
    let streams = Streams::new(9);
    let driver = driver::taught(&subject, &options, &streams, &Silent).unwrap();
    let log = log::kept(&subject, &driver, &options, &streams, &Silent).unwrap();
    let moments = || log.iter().flatten();
    assert_eq!(moments().count(), options.log_steps);
    // At the northern border, n steps from the goal, going north costs 2 and leads nowhere, instead of 1 and a step on.
    let bump = |n: f64| 1.0 + num::pow(GAMMA, n);
    let mut costs = [0.0, 0.0];
    for moment in moments() {
        let [x, y] = [moment.readings[0], moment.readings[1]].map(|r| f64::from((r * 3.0).round()));
        for (action, (at, ahead)) in [(0, (y, 3.0 - x)), (1, (x, 3.0 - y))] {
            let by_hand = if at == 3.0 { bump(ahead) } else { 0.0 };
            assert!((-moment.advantages[action] - by_hand).abs() < 1e-9, "{moment:?}");
            costs[action] += by_hand / options.log_steps as f64;
        }
    }
    // One constant move is the best that nobody's eyes allow.
    let episodes: Vec<&log::Episode> = log.iter().collect();
    let blind = lesson::forgetful(&subject, &episodes, &options, &streams).unwrap();
    let nobody = Fixed { slots: IndexSet::EMPTY, every: 1, remembers: false };
    let score = sum(&fixed(&subject, &blind, nobody, &episodes));
    assert!((score.loss() / score.steps - costs[0].min(costs[1])).abs() < 1e-9, "{costs:?} {score:?}");
}

#[test]
fn every_sensor_is_paid_once_and_every_choice_is_replayed() {
    let plan =
        crate::plan::parse(&MAZE.replace("sensors = [\"Y\"]", "sensors = [\"X\", \"Y\"]"), &[]).unwrap();
    let subject = Subject::new(&plan, &CeilingOptions::default()).unwrap();
    assert!((subject.price(IndexSet::first(2)) - 0.2).abs() < 1e-12, "X is read once");
    assert_eq!(choices(2).len(), 4 + 1 + 3 * 4);
}

#[test]
fn shares_take_turns_and_never_meet() {
    let log: Vec<log::Episode> = (0..9).map(|_| Vec::new()).collect();
    let place = |e: &log::Episode| log.iter().position(|other| std::ptr::eq(other, e)).unwrap();
    let mut judged = Vec::new();
    for turn in 0..3 {
        let shares = trial::Shares::new(&log, turn, 3);
        let all = shares.teach.iter().chain(&shares.choose).chain(&shares.judge);
        let mut places: Vec<usize> = all.map(|e| place(e)).collect();
        places.sort_unstable();
        assert_eq!(places, (0..9).collect::<Vec<_>>());
        judged.extend(shares.judge.iter().map(|e| place(e)));
    }
    judged.sort_unstable();
    assert_eq!(judged, (0..9).collect::<Vec<_>>(), "everything is judged once");
}

#[test]
fn the_same_seed_gives_the_same_report_on_any_number_of_threads() {
    let options = CeilingOptions { seed: 4, ..CeilingOptions::default() }.shrunk();
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| run(&maze(), &options, &Silent)).unwrap()
    };
    let report = on(1);
    assert_eq!(report, on(3));
    assert!(text(&report).contains("adaptive looks"));
    assert!(draw(&report).iter().all(|(_, svg)| svg.starts_with("<svg") && svg.contains("learned")));
}

#[test]
fn what_cannot_be_measured_is_named() {
    let refused =
        |plan: &Plan, options: &CeilingOptions| run(plan, options, &Silent).unwrap_err().to_string();
    let options = CeilingOptions { phase: Some("nowhere".into()), ..CeilingOptions::default() };
    assert!(refused(&maze(), &options).contains("phase: unknown phase `nowhere`; known: attention"));
    let few = CeilingOptions { log_steps: 1, ..CeilingOptions::default().shrunk() };
    assert!(refused(&maze(), &few).starts_with("log_steps: 1 episodes"), "{}", refused(&maze(), &few));
    let crowd: Vec<String> =
        (0..11).map(|i| format!("[member.M{i}]\nsensors = [\"X\"]\nlearner = \"unused\"")).collect();
    let names: Vec<String> = (0..11).map(|i| format!("\"M{i}\"")).collect();
    let text = MAZE.replace("[attention.acl", &format!("{}\n[attention.acl", crowd.join("\n")));
    let text = text.replacen("roster = [\"X\", \"Y\"]", &format!("roster = [{}]", names.join(", ")), 1);
    let text = text.replace(
        "after = \"attention\"\nroster = [\"X\", \"Y\"]",
        &format!("after = \"attention\"\nroster = [{}]", names.join(", ")),
    );
    let plan = crate::plan::parse(&text, &[]).unwrap();
    assert!(
        refused(&plan, &CeilingOptions::default()).starts_with("phase.attention.roster: 11 members: 1 to 10")
    );
}
