#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| metal_robots_fuzz::targets::webots(bytes));
