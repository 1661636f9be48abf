//! An MCAP recording of any bytes is a survey and a trial, or an error.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let start = *b"\x89MCAP0\r\n";
    touchdown_log_fuzz::any_log(&[&start, bytes].concat());
});
