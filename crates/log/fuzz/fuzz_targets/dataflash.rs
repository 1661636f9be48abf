//! A DataFlash log of ArduPilot of any bytes is a survey and a trial, or an error.
#![no_main]

use libfuzzer_sys::fuzz_target;
use touchdown_log_fuzz::{any_log, log_of};

fuzz_target!(|bytes: &[u8]| any_log(&log_of(&[0xa3, 0x95, 128], bytes)));
