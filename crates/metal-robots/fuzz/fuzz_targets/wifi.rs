//! The e-puck2's language over Wi-Fi, both sides, and its pictures.
#![no_main]

use libfuzzer_sys::fuzz_target;
use metal_robots::epuck::Sensors;
use metal_robots::epuck::wifi::{Answer, Command};
use metal_robots::picture;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(command) = Command::decode(bytes) {
        assert_eq!(Command::decode(&command.encode()), Ok(command));
    }
    if let Ok(sensors) = Sensors::decode(bytes) {
        // Bytes, not values: a float that is no number is not equal to itself.
        let said = sensors.encode();
        assert_eq!(Sensors::decode(&said).expect("our own words").encode(), said);
    }
    let Some((&first, rest)) = bytes.split_first() else { return };
    if let Ok(answer) = Answer::decode(first, rest) {
        assert_eq!(answer.encode().len(), 1 + Answer::length(first).expect("a name that was read"));
    }
    for columns in [0, 1, usize::from(first), 52, 160] {
        let _ = picture::decode_bgra(columns, rest);
        if let Ok(seen) = picture::decode_565(columns, rest) {
            assert_eq!(metal_robots::picture::as_565(&seen), seen);
            let _ = picture::shrink(&seen);
        }
    }
});
