//! A mixture as a student: two readings, of which the first tells the right move and the second nothing.

use super::*;
use crate::counterfactual::config::{CounterfactualConfig, FitConfig};
use crate::counterfactual::fit::learn;
use crate::counterfactual::judge::Judged;
use crate::counterfactual::student::rule::Rule;
use crate::counterfactual::student::{Scale, Student, StudentShape};
use crate::random::Streams;

fn shape() -> StudentShape {
    let rule = Rule::Adaptive { min_looks: 0, max_looks: 2 };
    StudentShape { blocks: vec![1, 1], prices: vec![2.0, 0.5], actions: 2, rule }
}

fn config(mixture: MixtureConfig, relative: bool) -> CounterfactualConfig {
    let fit = FitConfig { relative, ..FitConfig::default() };
    CounterfactualConfig { fit, mixture: Some(mixture), ..CounterfactualConfig::default() }
}

fn state(n: usize) -> Judged {
    let right = n % 2;
    Judged {
        full: vec![right as f32, (n / 2 * 7 % 10) as f32 / 10.0, 1.0, 1.0],
        clock: 0,
        looks: IndexSet::EMPTY,
        advantages: (0..2).map(|a| if a == right { 0.0 } else { -10.0 }).collect(),
        value: if right == 0 { -3.0 } else { -5.0 },
        stops: Vec::new(),
        appointments: None,
    }
}

fn taught(mixture: MixtureConfig, relative: bool) -> Student {
    let mut student = Student::new(&config(mixture, relative), &shape(), &Streams::new(3)).unwrap();
    let states: Vec<Judged> = (0..200).map(state).collect();
    learn(&mut student, &states.iter().collect::<Vec<_>>(), 1.0, &Streams::new(1));
    student
}

fn small() -> MixtureConfig {
    MixtureConfig { components: 4, factors: 1, draws: 3000, prior: 0.1, ..MixtureConfig::default() }
}

/// Values of both moves, both looks and moving now.
fn values(student: &Student, input: [f32; 4]) -> Vec<f64> {
    let mut scratch = student.scratch();
    student.evaluate(&input, &mut scratch);
    scratch.values
}

fn near(values: &[f64], expected: &[f64]) -> bool {
    values.iter().zip(expected).all(|(v, e)| (v - e).abs() < 0.7)
}

#[test]
fn the_look_that_tells_is_learned_and_so_is_what_may_follow_one() {
    for moves in [Moves::Marginal, Moves::Fitted] {
        let student = taught(MixtureConfig { moves, ..small() }, false);
        let blind = values(&student, [0.0; 4]);
        // A look at slot 1 tells nothing and costs 0.5, but the other may follow for 2.
        assert!(near(&blind, &[-5.0, -5.0, -2.0, -2.5, -5.0]), "{moves:?} {blind:?}");
        let (low, high) = (values(&student, [0.0, 0.0, 1.0, 0.0]), values(&student, [1.0, 0.0, 1.0, 0.0]));
        assert!(near(&low[..2], &[0.0, -10.0]) && near(&high[..2], &[-10.0, 0.0]), "{low:?} {high:?}");
    }
}

#[test]
fn a_reading_of_zero_is_not_a_missing_one() {
    let student = taught(small(), false);
    let (missing, zero) = (values(&student, [0.0; 4]), values(&student, [0.0, 0.0, 1.0, 0.0]));
    assert!((missing[1] - zero[1]).abs() > 3.0, "{missing:?} {zero:?}");
}

#[test]
fn the_value_of_information_sees_one_look_ahead_and_no_farther() {
    let looks = Looks::Expected;
    let student = taught(MixtureConfig { looks, ..small() }, false);
    let blind = values(&student, [0.0; 4]);
    assert!(near(&blind, &[-5.0, -5.0, -2.0, -5.5, -5.0]), "{blind:?}");
    let relative = values(&taught(MixtureConfig { looks, ..small() }, true), [0.0; 4]);
    assert!(near(&relative[2..], &[3.0, -0.5, -5.0]), "{relative:?}");
}

#[test]
fn looks_may_be_valued_by_what_they_add_to_moving_at_once() {
    let blind = values(&taught(small(), true), [0.0; 4]);
    assert!(near(&blind[2..], &[3.0, 2.5, -5.0]), "{blind:?}");
}

#[test]
fn other_units_say_the_same_and_so_does_a_thawed_student() {
    let mut student = taught(small(), false);
    let (input, bytes) = ([1.0, 0.4, 1.0, 1.0], student.freeze());
    let before = values(&student, input);
    let thawed = Student::thaw(&config(small(), false), &shape(), &bytes).unwrap();
    assert_eq!(values(&thawed, input), before);
    assert_eq!(thawed.freeze(), bytes);
    let other = MixtureConfig { prior: 0.2, ..small() };
    assert!(Student::thaw(&config(other, false), &shape(), &bytes).is_err());
    let worth = |student: &Student| {
        let mut scratch = student.scratch();
        student.evaluate(&input, &mut scratch);
        student.worth(1, &scratch)
    };
    let value = worth(&student);
    assert!((value + 5.0).abs() < 0.7, "the state's value with the best move: {value}");
    student.set_scale(Scale { advantage: 3.0, value: 40.0, centre: -7.0 });
    assert!(values(&student, input).iter().zip(&before).all(|(a, b)| (a - b).abs() < 1e-9));
    assert!((worth(&student) - value).abs() < 1e-9);
}

#[test]
fn a_newborn_knows_nothing_and_impossible_settings_are_named() {
    let student = Student::new(&config(small(), false), &shape(), &Streams::new(3)).unwrap();
    assert_eq!((values(&student, [1.0; 4]), student.weights()), (vec![0.0; 5], 0));
    let thawed = Student::thaw(&config(small(), false), &shape(), &student.freeze());
    assert!(thawed.is_ok());
    let refused =
        Student::new(&config(MixtureConfig { factors: 9, ..small() }, false), &shape(), &Streams::new(3));
    let message = refused.err().unwrap().to_string();
    assert!(message.contains("mixture.factors"), "{message}");
}

#[test]
fn the_same_seed_is_the_same_mixture() {
    assert_eq!(taught(small(), false).freeze(), taught(small(), false).freeze());
}
