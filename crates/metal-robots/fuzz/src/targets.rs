//! What is done with foreign bytes: each function may refuse them, and must not panic, hang or ask for memory without
//! end; what is understood survives being said again. An ordinary test feeds the kept corpus to the same functions.

use metal_robots::bytes::{Reader, Writer};
use metal_robots::epuck::binary::{self, Firmware, Request};
use metal_robots::epuck::{Sensors, ascii, wifi};
use metal_robots::picture;
use metal_robots::webots::device::Kind;
use metal_robots::webots::frame::{self, Answer, Welcome};
use metal_robots::webots::robot::Robot;
use metal_robots::webots::supervisor::{Fact, Wish};
use metal_robots::webots::{Release, news, order};

const ASKED: [&[Request]; 4] = [
    &[Request::Speeds([1, -1]), Request::GetSteps],
    &[Request::Proximity, Request::Ground, Request::Temperature],
    &[Request::Picture],
    &[Request::Everything, Request::Acceleration],
];

/// The E-puck's serial language, both sides: nothing panics, and what is understood survives being said again.
pub fn sercom(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    if let Ok(command) = ascii::Command::decode(&text) {
        assert_eq!(ascii::Command::decode(command.encode().trim_end()), Ok(command));
    }
    if let Ok(answer) = ascii::Answer::decode(&text) {
        let _ = ascii::Answer::decode(answer.encode().trim_end()).expect("our own words");
    }
    if let Ok((requests, used)) = binary::decode_run(bytes) {
        assert!(used <= bytes.len());
        assert_eq!(binary::encode_run(&requests), bytes[..used], "a run has one spelling");
    }
    for asked in ASKED {
        for firmware in [Firmware::First, Firmware::Second] {
            if let Ok(answers) = binary::decode_answers(asked, firmware, bytes) {
                let said: Vec<u8> = answers.iter().flat_map(binary::encode_answer).collect();
                assert!(said.len() <= bytes.len());
            }
        }
    }
}

/// The e-puck2's language over Wi-Fi, both sides, and its pictures.
pub fn wifi(bytes: &[u8]) {
    if let Ok(command) = wifi::Command::decode(bytes) {
        assert_eq!(wifi::Command::decode(&command.encode()), Ok(command));
    }
    if let Ok(sensors) = Sensors::decode(bytes) {
        // Bytes, not values: a float that is no number is not equal to itself.
        let said = sensors.encode();
        assert_eq!(Sensors::decode(&said).expect("our own words").encode(), said);
    }
    let Some((&first, rest)) = bytes.split_first() else { return };
    if let Ok(answer) = wifi::Answer::decode(first, rest) {
        assert_eq!(answer.encode().len(), 1 + wifi::Answer::length(first).expect("a name that was read"));
    }
    for columns in [0, 1, usize::from(first), 52, 160] {
        let _ = picture::decode_bgra(columns, rest);
        if let Ok(seen) = picture::decode_565(columns, rest) {
            assert_eq!(metal_robots::picture::as_565(&seen), seen);
            let _ = picture::shrink(&seen);
        }
    }
}

/// The language of Webots' external controllers, both sides, in both releases.
pub fn webots(bytes: &[u8]) {
    let _ = (frame::read_hello(bytes), Welcome::read(bytes));
    if let Ok((Some(request), used)) = frame::Request::decode(bytes) {
        assert!(used <= bytes.len());
        let said = request.encode();
        let again = frame::Request::decode(&said).expect("our own words").0.expect("a request");
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
}

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
