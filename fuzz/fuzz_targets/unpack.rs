#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| drt_fuzz::formats::unpack(data));
