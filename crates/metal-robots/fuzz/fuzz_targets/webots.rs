//! The language of Webots' external controllers, both sides, in both releases.
#![no_main]

use libfuzzer_sys::fuzz_target;
use metal_robots::bytes::{Reader, Writer};
use metal_robots::webots::Release;
use metal_robots::webots::device::Kind;
use metal_robots::webots::frame::{Answer, Request, Welcome, read_hello};
use metal_robots::webots::robot::Robot;
use metal_robots::webots::supervisor::{Fact, Wish};
use metal_robots::webots::{news, order};

fuzz_target!(|bytes: &[u8]| {
    let _ = (read_hello(bytes), Welcome::read(bytes));
    if let Ok((Some(request), used)) = Request::decode(bytes) {
        assert!(used <= bytes.len());
        let said = request.encode();
        let again = Request::decode(&said).expect("our own words").0.expect("a request");
        assert_eq!(again.encode(), said);
    }
    if let Ok((answer, used)) = Answer::decode(bytes) {
        assert!(used <= bytes.len());
        let said = answer.encode();
        assert_eq!(Answer::decode(&said).expect("our own words").0.encode(), said);
        configured(&answer.news);
    }
    configured(bytes);
    for release in [Release::R2023b, Release::R2025a] {
        (0..100).filter_map(Kind::of).for_each(|kind| drop(order::read_all(Some(kind), release, bytes)));
        let _ = order::read_all(None, release, bytes);
        supervised(release, bytes);
    }
});

/// A robot that describes itself, and then its news.
fn configured(bytes: &[u8]) {
    let Ok((robot, used)) = Robot::decode(bytes) else { return };
    assert!(used <= bytes.len());
    let said = robot.encode();
    assert_eq!(Robot::decode(&said).expect("our own words").0.encode(), said);
    let _ = news::read_all(&robot, &bytes[used..], |_| {});
}

fn supervised(release: Release, bytes: &[u8]) {
    let Some((&op, rest)) = bytes.split_first() else { return };
    if let Ok(Some(wish)) = Wish::read(op, release, &mut Reader::new(rest)) {
        let mut said = Writer::new();
        wish.write(release, &mut said);
    }
    if let Ok(Some(fact)) = Fact::read(op, release, &mut Reader::new(rest)) {
        let mut said = Writer::new();
        fact.write(release, &mut said);
    }
}
