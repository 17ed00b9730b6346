//! Proposals for whole experiments: complete, ready to be run, the same every time, and refused where they make no sense.

use super::*;
use crate::plan;
use crate::progress::Silent;

fn cells() -> Plan {
    plan::parse(crate::experiments::PARTITION, &[]).unwrap()
}

fn brief(by: Criterion, groups: Option<usize>) -> PartitionOptions {
    let steps = if by == Criterion::Worth { 2000 } else { 300 };
    PartitionOptions { by, groups, steps, ..PartitionOptions::default() }
}

fn complaint(plan: &Plan, options: &PartitionOptions) -> String {
    run(plan, options, &Silent).unwrap_err().to_string()
}

#[test]
fn every_cell_is_in_one_group_and_the_experiment_can_be_read_again() {
    let plan = cells();
    for (by, groups) in [
        (Criterion::Alike, Some(7)),
        (Criterion::Alike, None),
        (Criterion::Worth, None),
        (Criterion::Random, Some(5)),
    ] {
        let proposal = run(&plan, &brief(by, groups), &Silent).unwrap();
        let mut sensors: Vec<String> = proposal.groups.iter().flat_map(|g| g.sensors.clone()).collect();
        sensors.sort();
        let mut all: Vec<String> = plan.spec.sensors.iter().map(|s| s.name.clone()).collect();
        all.sort();
        assert_eq!(sensors, all);
        let price: f64 = proposal.groups.iter().map(|g| g.price).sum();
        assert!((price - 12.0).abs() < 1e-9);
        assert!(groups.is_none_or(|wanted| proposal.groups.len() == wanted));
        let again = plan::parse(&proposal.experiment().unwrap(), &[]).unwrap();
        assert_eq!(again.file, proposal.plan.file);
        assert_eq!(again.members.len(), proposal.groups.len());
        let roster = &again.file.phase["attention"].roster;
        assert_eq!(roster, &proposal.groups.iter().map(|g| g.name.clone()).collect::<Vec<_>>());
        assert_eq!(&again.file.policy["acl"].roster, roster);
    }
}

#[test]
fn the_same_seed_proposes_the_same_and_the_picture_names_every_group() {
    let (plan, options) = (cells(), brief(Criterion::Worth, Some(4)));
    let propose = || run(&plan, &options, &Silent).unwrap();
    let proposal = propose();
    assert_eq!(proposal.groups, propose().groups);
    let (svg, table) = (draw(&proposal).unwrap(), text(&proposal));
    for group in &proposal.groups {
        assert!(svg.contains(&group.name) && table.contains(&group.sensors.join(" ")), "{}", group.name);
    }
    assert!(svg.starts_with("<svg") && svg.matches("class=\"onpicture\"").count() == 32);
}

#[test]
fn members_of_other_phases_stay_and_their_names_are_not_taken() {
    let mut file = cells().file;
    let mut kept = file.member["ALL"].clone();
    kept.sensors.truncate(2);
    file.member.insert("G1".to_owned(), kept);
    file.policy.get_mut("acl").unwrap().roster.insert(0, "G1".to_owned());
    file.policy.get_mut("acl").unwrap().acting = plan::Acting::RandomLooks(2.0);
    let proposal = run(&Plan::check(file).unwrap(), &brief(Criterion::Random, Some(2)), &Silent).unwrap();
    assert_eq!(proposal.plan.file.policy["acl"].roster, ["G1", "G2", "G3"]);
    assert_eq!(proposal.plan.file.phase["attention"].roster, ["G2", "G3"]);
    assert_eq!(proposal.plan.file.member["G1"].sensors.len(), 2);
}

#[test]
fn other_worlds_have_no_picture() {
    let sets = ["learner.expert={ mlp = {} }".to_owned()];
    let plan = plan::parse(crate::experiments::TOY, &sets).unwrap();
    let proposal = run(&plan, &brief(Criterion::Alike, Some(3)), &Silent).unwrap();
    assert_eq!((proposal.groups.len(), draw(&proposal)), (3, None));
}

#[test]
fn what_cannot_be_partitioned_is_refused_by_name() {
    let plan = cells();
    let (alike, default) = (brief(Criterion::Alike, Some(33)), PartitionOptions::default());
    assert!(complaint(&plan, &alike).contains("at most 32, one per sensor"));
    let phase = PartitionOptions { phase: Some("attentoin".to_owned()), ..default.clone() };
    assert!(complaint(&plan, &phase).contains("known: attention"));
    for (options, field) in [
        (PartitionOptions { steps: 0, ..default.clone() }, "steps"),
        (PartitionOptions { levels: 1, ..default.clone() }, "levels"),
        (PartitionOptions { chance: 1.5, ..default.clone() }, "chance"),
        (PartitionOptions { thrift: f64::NAN, ..default.clone() }, "thrift"),
        (PartitionOptions { groups: Some(0), ..default.clone() }, "groups"),
    ] {
        assert!(complaint(&plan, &options).contains(field), "{field}");
    }
    let one =
        plan::parse(crate::experiments::PARTITION, &["member.ALL.sensors=[\"r1c1\"]".to_owned()]).unwrap();
    assert!(complaint(&one, &default).contains("one sensor"));
    // Experts who are their own opinion cannot speak for several sensors.
    let toy = plan::parse(crate::experiments::TOY, &[]).unwrap();
    let refused = complaint(&toy, &brief(Criterion::Alike, Some(3)));
    assert!(refused.contains("in the places of MN, MF"), "{refused}");
    let few = PartitionOptions { steps: 60, ..default };
    assert!(complaint(&plan, &few).contains("steps: 60: too few"));
}
