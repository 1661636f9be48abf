//! Any text is a map or an error; a map makes a trial of a small table or an error.
#![no_main]

use libfuzzer_sys::fuzz_target;
use touchdown_log::{Map, apply, parse_csv};

fuzz_target!(|text: &str| {
    let Ok(map) = Map::parse("fuzz.toml", text) else {
        return;
    };
    let (table, _) = parse_csv("t.csv", b"t,x,\"ESC (\xc2\xb5s)\"\n0,1,2\n1,,3\n2,5,4\n").unwrap();
    let _ = apply(&table, &map);
});
