//! What every fuzz target of a reader of logs does.

use std::sync::LazyLock;
use touchdown_log::{Log, Map};

static BUILT_IN: LazyLock<Vec<Option<Map>>> =
    LazyLock::new(|| ["px4", "ardupilot", "ros"].map(Map::built_in_named).into());

/// Reads bytes that start like a log, in every way that there is.
pub fn any_log(bytes: &[u8]) {
    let log = Log::from_bytes("fuzz", bytes.to_vec()).expect("the start of a log");
    let Ok((survey, findings)) = log.survey() else {
        return;
    };
    assert_eq!(findings.rows_read, survey.messages());
    let _ = survey.lacks();
    let text = survey.suggested_map();
    let suggested = Map::parse("suggested.toml", &text).expect("a suggested map is a map");
    let maps = BUILT_IN.iter().map(Option::as_ref);
    for map in maps.chain([Some(&suggested), None]) {
        if let Ok((trial, _)) = log.trial(map) {
            // One row for a message of the clock at most; no map resamples.
            assert!(trial.len() <= survey.messages() && !trial.is_empty());
        }
    }
}
