#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| metal_fuzz::targets::course::course(bytes));
