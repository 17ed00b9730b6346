//! The E-puck's serial language, both sides: nothing panics, and what is understood survives being said again.
#![no_main]

use libfuzzer_sys::fuzz_target;
use metal_robots::epuck::ascii;
use metal_robots::epuck::binary::{self, Firmware, Request};

const ASKED: [&[Request]; 4] = [
    &[Request::Speeds([1, -1]), Request::GetSteps],
    &[Request::Proximity, Request::Ground, Request::Temperature],
    &[Request::Picture],
    &[Request::Everything, Request::Acceleration],
];

fuzz_target!(|bytes: &[u8]| {
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
});
