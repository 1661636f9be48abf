//! An MCAP recording of any bytes is a survey and a trial, or an error.
#![no_main]

use libfuzzer_sys::fuzz_target;
use touchdown_log_fuzz::{any_log, log_of};

fuzz_target!(|bytes: &[u8]| any_log(&log_of(b"\x89MCAP0\r\n", bytes)));
