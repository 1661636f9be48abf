//! Any bytes are a table or an error; a table can be inspected, and its suggested map is a map
//! that finds its columns.
#![no_main]

use libfuzzer_sys::fuzz_target;
use touchdown_log::{LogError, Map, apply, inspect, parse_csv};

fuzz_target!(|bytes: &[u8]| {
    let Ok((table, _)) = parse_csv("fuzz.csv", bytes) else {
        return;
    };
    let map = match inspect(&table, None).suggested_map {
        Some(text) => {
            // The period, where no column is the time.
            let text = text.replace("\n# time_s = ", "\ntime_s = ");
            Map::parse("suggested.toml", &text).expect("a suggested map is a map")
        }
        None => Map::identity_for(&table).expect("there is a column time_s"),
    };
    match apply(&table, &map) {
        Ok((trial, _)) => assert!(!trial.is_empty()),
        // A foreign name can be one that a trial cannot bear.
        Err(LogError::NoUsableRows { .. } | LogError::Trial { .. }) => {}
        Err(error) => panic!("{error}"),
    }
});
