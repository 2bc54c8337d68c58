#![no_main]

libfuzzer_sys::fuzz_target!(init: drt_fuzz::alone(), |data: &[u8]| drt_fuzz::checkpoint::run(data));
