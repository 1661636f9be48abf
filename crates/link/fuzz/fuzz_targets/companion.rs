//! Any sequence of messages, bytes, ticks and pauses: no panic, no absurd setpoint, none after the pilot took over.
#![no_main]

use libfuzzer_sys::fuzz_target;
use touchdown_link_fuzz::Bench;

fuzz_target!(|bytes: &[u8]| {
    if let Some((first, script)) = bytes.split_first() {
        Bench::start(first % 4 != 0).script(script);
    }
});
