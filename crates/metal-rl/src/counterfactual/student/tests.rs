use super::*;
use crate::counterfactual::config::NetworkConfig;

fn shape(rule: Rule) -> StudentShape {
    StudentShape { blocks: vec![2, 1, 1], prices: vec![1.0, 2.0, 3.0], actions: 2, rule }
}

fn student(rule: Rule) -> Student {
    Student::new(&CounterfactualConfig::default(), &shape(rule), &Streams::new(1)).unwrap()
}

#[test]
fn a_schedule_is_kept_whatever_the_values_say() {
    let rule = Rule::Scheduled { slots: IndexSet::EMPTY.with(0).with(2), every: 2 };
    let student = student(rule);
    let (mut gaze, mut scratch) = (Gaze::new(student.layout()), student.scratch());
    assert_eq!(student.next(&mut gaze, &mut scratch), Next::Look(0));
    gaze.look(student.layout(), 0, &[0.1, 0.2]);
    assert_eq!(student.next(&mut gaze, &mut scratch), Next::Look(2));
    gaze.look(student.layout(), 2, &[0.1]);
    assert!(matches!(student.next(&mut gaze, &mut scratch), Next::Move(_)));
    gaze.advance(student.layout(), 0);
    assert!(matches!(student.next(&mut gaze, &mut scratch), Next::Move(_)), "nobody looks in between");
}

#[test]
fn a_free_student_looks_as_often_as_it_may_and_must() {
    let looks = |min_looks, values: [f64; 6], attended| {
        let student = student(Rule::Adaptive { min_looks, max_looks: 2 });
        let mut scratch = student.scratch();
        scratch.values = values.to_vec();
        student.preferred_look(attended, &scratch)
    };
    let (nobody, one) = (IndexSet::EMPTY, IndexSet::EMPTY.with(1));
    let curious = [-9.0, 9.0, 1.0, 3.0, 2.0, -9.0];
    assert_eq!(looks(0, curious, nobody), Some((1, 3.0)));
    assert_eq!(looks(0, curious, one), Some((2, 2.0)));
    assert_eq!(looks(0, curious, one.with(2)), None);
    let sure = [-9.0, -9.0, 1.0, 3.0, 2.0, 5.0];
    assert_eq!(looks(0, sure, nobody), None);
    assert_eq!(looks(1, sure, nobody), Some((1, 3.0)));
    assert_eq!(looks(1, sure, one), None);
}

#[test]
fn what_costs_nothing_is_looked_at_before_every_move_and_is_no_choice() {
    let rule = Rule::Adaptive { min_looks: 0, max_looks: 1 };
    let gift = IndexSet::EMPTY.with(1);
    let shape = StudentShape { prices: vec![1.0, 0.0, 3.0], ..shape(rule) };
    let student = Student::new(&CounterfactualConfig::default(), &shape, &Streams::new(1)).unwrap();
    let (mut gaze, mut scratch) = (Gaze::new(student.layout()), student.scratch());
    assert_eq!(student.next(&mut gaze, &mut scratch), Next::Look(1));
    gaze.look(student.layout(), 1, &[0.1]);
    assert_ne!(student.next(&mut gaze, &mut scratch), Next::Look(1));
    assert_eq!(student.kept(), IndexSet::first(3).without(1), "nobody to be dismissed");
    assert_eq!(student.open_looks(gift), student.kept(), "one look may still be taken");
    assert_eq!(student.open_looks(gift.with(0)), IndexSet::EMPTY);
    let mut rng = crate::random::Rng::new(1);
    let others = crate::counterfactual::judge::other_looks(&student, gift.with(2), &mut rng);
    assert!(others.iter().all(|looks| looks.contains(1)), "{others:?}");
    let fixed = student.under(Rule::Scheduled { slots: IndexSet::EMPTY.with(0), every: 2 });
    assert_eq!(fixed.gifts(), IndexSet::EMPTY, "a rule that was fixed stays what it is");
}

#[test]
fn what_is_weighed_is_highest_for_what_is_chosen() {
    let mut rng = crate::random::Rng::new(4);
    for relative in [false, true] {
        let fit = crate::counterfactual::FitConfig { relative, ..Default::default() };
        let config = CounterfactualConfig { fit, ..CounterfactualConfig::default() };
        let rule = Rule::Adaptive { min_looks: 0, max_looks: 3 };
        let student = Student::new(&config, &shape(rule), &Streams::new(1)).unwrap();
        let (mut scratch, mut chosen) = (student.scratch(), [0; 2]);
        for _ in 0..200 {
            scratch.values.iter_mut().for_each(|value| *value = rng.range(-1.0, 1.0));
            let mut weighed = Vec::new();
            student.weigh(&scratch, &mut weighed);
            let look = student.preferred_look(IndexSet::EMPTY, &scratch);
            let choice = look.map_or(student.best_move(&scratch), |(slot, _)| student.actions() + slot);
            assert_eq!(weighed.len(), 5, "two moves, three looks");
            assert_eq!(num::argmax(&weighed), choice);
            chosen[usize::from(look.is_some())] += 1;
        }
        assert!(chosen.iter().all(|&n| n > 10), "{chosen:?}");
    }
    let mut nothing = Vec::new();
    let fixed = student(Rule::Scheduled { slots: IndexSet::EMPTY.with(0), every: 1 });
    fixed.weigh(&fixed.scratch(), &mut nothing);
    assert!(nothing.is_empty() && !fixed.weighs_looks(), "whoever may not choose weighs nothing");
}

#[test]
fn caution_lowers_moving_by_disagreement_and_leaves_looks_alone() {
    let network = |caution| NetworkConfig { ensemble: 3, caution, ..NetworkConfig::default() };
    let values = |caution| {
        let config = CounterfactualConfig { network: network(caution), ..Default::default() };
        let shape = shape(Rule::Adaptive { min_looks: 0, max_looks: 3 });
        let student = Student::new(&config, &shape, &Streams::new(1)).unwrap();
        let mut scratch = student.scratch();
        student.evaluate(&[0.3; 7], &mut scratch);
        scratch.values
    };
    let (plain, careful) = (values(0.0), values(1.0));
    assert!(careful[0] < plain[0] && careful[1] < plain[1]);
    assert_eq!(plain[2..5], careful[2..5]);
    assert!(careful[5] < plain[5]);
}

#[test]
fn only_its_own_settings_thaw_a_student() {
    let rule = Rule::Adaptive { min_looks: 0, max_looks: 3 };
    let (config, bytes) = (CounterfactualConfig::default(), student(rule).freeze());
    let thawed = Student::thaw(&config, &shape(rule), &bytes).unwrap();
    assert_eq!(thawed.freeze(), bytes);
    let other = CounterfactualConfig { gamma: 0.5, ..config.clone() };
    assert!(Student::thaw(&other, &shape(rule), &bytes).is_err());
    assert!(Student::thaw(&config, &shape(Rule::Adaptive { min_looks: 0, max_looks: 2 }), &bytes).is_err());
    assert!(Student::thaw(&config, &shape(rule), &bytes[..40]).is_err());
}
