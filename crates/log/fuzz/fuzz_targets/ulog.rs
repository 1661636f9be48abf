//! A PX4 ULog of any bytes is a survey and a trial, or an error.
#![no_main]

use libfuzzer_sys::fuzz_target;
use touchdown_log_fuzz::{any_log, log_of};

fuzz_target!(|bytes: &[u8]| any_log(&log_of(
    &[0x55, 0x4c, 0x6f, 0x67, 0x01, 0x12, 0x35, 0x01],
    bytes
)));
