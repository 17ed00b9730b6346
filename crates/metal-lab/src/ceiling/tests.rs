//! A log where every number of the ceiling is known by hand, and the maze.

use super::replay::{Fixed, choices, sum};
use super::subject::Subject;
use super::*;
use crate::progress::Silent;
use metal_rl::num;
use metal_rl::set::IndexSet;

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

/// A log of a world where all is known by hand: X shows which of two moves is right, and shows the same for two motor
/// steps; Y shows nothing of it. The wrong move costs 10 more, all others 20. In three of ten pairs of steps it is the second
/// move that is right.
fn by_hand() -> Vec<log::Episode> {
    let mut rng = Streams::new(5).stream("log");
    let mut episode = || {
        let pair = |rng: &mut metal_rl::random::Rng| {
            let right = usize::from(rng.chance(0.3));
            let advantages: Vec<f64> = (0..4)
                .map(|a| {
                    if a == right {
                        0.0
                    } else if a < 2 {
                        -10.0
                    } else {
                        -20.0
                    }
                })
                .collect();
            [0, 1].map(|_| {
                let readings = vec![right as f32, rng.uniform() as f32];
                let advantages = advantages.clone();
                log::Moment { readings, advantages, action: rng.below(4), greedy: right, situation: 0 }
            })
        };
        (0..5).flat_map(|_| pair(&mut rng)).collect()
    };
    (0..60).map(|_| episode()).collect()
}

#[test]
fn the_ceiling_of_a_world_that_is_known_by_hand() {
    let plan = maze();
    let options =
        CeilingOptions { batches: 1000, rounds: 1, copies: 3, folds: 3, ..CeilingOptions::default() };
    let subject = Subject::new(&plan, &options).unwrap();
    let log = by_hand();
    let shares = trial::Shares::new(&log, 0, 3);
    let turn = trial::turn(&subject, &shares, &options, &Streams::new(2)).unwrap();
    let cost = |slots: u64, every, remembers| {
        let all = sum(turn.fixed(Fixed { slots: IndexSet::from_bits(slots), every, remembers }));
        (all.loss() / all.steps, all.price / all.steps)
    };
    let wrong = |m: &&log::Moment| m.greedy == 1;
    let judged: Vec<&log::Moment> = shares.judge.iter().flat_map(|e| e.iter()).collect();
    let blind = 10.0 * judged.iter().filter(|m| wrong(m)).count() as f64 / judged.len() as f64;
    for remembers in [false, true] {
        let (lost, price) = cost(0b00, 1, remembers);
        assert!((0.9..1.3).contains(&(lost / blind)) && price == 0.0, "nobody: the likelier move, {lost}");
        let (lost, price) = cost(0b01, 1, remembers);
        assert!(lost.abs() < 0.1 && (price - 0.1).abs() < 1e-9, "X tells all: {lost}");
        let (lost, price) = cost(0b11, 1, remembers);
        assert!(lost.abs() < 0.1 && (price - 0.2).abs() < 1e-9, "Y tells nothing more: {lost}");
        assert!(cost(0b10, 1, remembers).0 > 0.8 * blind, "Y tells nothing");
    }
    let (lost, price) = cost(0b01, 2, true);
    assert!(
        lost < 0.4 * blind && (price - 0.05).abs() < 1e-9,
        "what was seen a step ago still holds: {lost}"
    );
    let of = |looking, remembers| {
        let all = sum(turn.scores(rows::Row { looking, remembers }));
        all.cost() / all.steps
    };
    assert!((of(rows::Looking::AnyAlways, false) - 0.1).abs() < 0.1);
    assert!((of(rows::Looking::Adaptive, false) - 0.1).abs() < 0.1, "one look, and then no other");
    assert!(of(rows::Looking::AnyFixed, true) < 0.3);
    assert!(of(rows::Looking::Adaptive, true) < 0.35, "{}", of(rows::Looking::Adaptive, true));
}

#[test]
fn a_log_has_every_step_with_everything_that_was_to_be_seen() {
    let (plan, options) = (maze(), CeilingOptions { log_steps: 300, ..CeilingOptions::default().shrunk() });
    let subject = Subject::new(&plan, &options).unwrap();
    let streams = Streams::new(9);
    let driver = driver::taught(&subject, &options, &streams, &Silent).unwrap();
    let log = log::kept(&subject, &driver, &options, &streams, &Silent).unwrap();
    assert_eq!(log.iter().map(Vec::len).sum::<usize>(), 300);
    for pair in log.iter().flat_map(|e| e.windows(2)) {
        let [[x, y], [next_x, next_y]] =
            [0, 1].map(|i| [0, 1].map(|slot| (pair[i].readings[slot] * 3.0).round() as i32));
        let (dx, dy) = [(0, 1), (1, 0), (0, -1), (-1, 0)][pair[0].action];
        assert_eq!([next_x, next_y], [(x + dx).clamp(0, 3), (y + dy).clamp(0, 3)], "the maze of Eq. (14)");
        assert_eq!(num::max(&pair[0].advantages), 0.0);
        assert_eq!(pair[0].loss(pair[0].greedy), 0.0);
    }
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
