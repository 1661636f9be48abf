//! A card is read or refused, and what was read is written and read again unchanged.
#![no_main]

use libfuzzer_sys::fuzz_target;
use touchdown_model::{Card, published};

fuzz_target!(|data: &[u8]| {
    let Ok(text) = std::str::from_utf8(data) else {
        return;
    };
    // Half of the inputs begin as a valid card, so that the fuzzer gets past the schema.
    let whole = text
        .strip_prefix('#')
        .map(|rest| format!("{}\n{rest}", published::EQ_11));
    let text = whole.as_deref().unwrap_or(text);
    if let Ok(card) = Card::parse(text, "fuzz.toml") {
        let again = Card::parse(&card.to_toml().unwrap(), "again.toml").unwrap();
        assert_eq!(card, again);
        let _ = card.thrust_model();
        let _ = card.ground_effect();
    }
});
