//! Any text is settings of a flight or an error; settings that are accepted build a landing computer or an error.
#![no_main]

use libfuzzer_sys::fuzz_target;
use touchdown_link::settings::FlightSettings;

fuzz_target!(|text: &str| {
    if let Ok(settings) = toml::from_str::<FlightSettings>(text) {
        let _ = settings.computer();
        let _ = settings.link.parse::<touchdown_link::address::Address>();
    }
});
