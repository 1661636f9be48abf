//! What every fuzz target of a reader of logs does.

use touchdown_log::{Log, LogFormat, Map, Survey};

/// Bytes as a log that starts with `magic`. A whole log has it already, so that a search may begin with real files.
pub fn log_of(magic: &[u8], bytes: &[u8]) -> Vec<u8> {
    if bytes.starts_with(magic) {
        return bytes.to_vec();
    }
    [magic, bytes].concat()
}

/// Reads bytes that start like a log, in every way that there is.
pub fn any_log(bytes: &[u8]) {
    let log = Log::from_bytes("fuzz", bytes.to_vec()).expect("the start of a log");
    let Ok((survey, findings)) = log.survey() else {
        return;
    };
    counts_add_up(&survey, bytes.len());
    let _ = survey.lacks();
    let text = survey.suggested_map();
    let suggested = Map::parse("suggested.toml", &text).expect("a suggested map is a map");
    let built_in = ["px4", "ardupilot", "ros"]
        .map(|name| Map::built_in_named(name).expect("a built-in map is a map"));
    let maps = built_in.into_iter().chain([&suggested]);
    for map in maps.map(Some).chain([None]) {
        let Ok((trial, again)) = log.trial(map) else {
            continue;
        };
        // One row for a message of the clock at most; no map resamples.
        let most = map.map_or(survey.messages(), |map| survey.rows_by(map));
        assert!(trial.len() <= most && !trial.is_empty());
        assert_eq!(trial.len(), again.rows_used);
        // Only who looks at values finds messages that cannot be decoded.
        assert!(again.rows_read >= survey.messages());
        assert!(
            findings.truncated == again.truncated && findings.corrupt_rows >= again.corrupt_rows
        );
    }
}

/// What is told of topics and fields does not contradict itself, nor what the bytes can hold.
fn counts_add_up(survey: &Survey, bytes: usize) {
    // The shortest record of a message. What is compressed may hold any number.
    let shortest = match survey.format {
        LogFormat::Ulog => 5,
        LogFormat::DataFlash => 3,
        _ => 0,
    };
    assert!(survey.messages() > 0 && survey.messages() * shortest <= bytes);
    for topic in &survey.topics {
        assert!(survey.topic(&topic.key) == Some(topic), "{}", topic.key);
        let stamped = topic.messages - topic.absent_stamps;
        let ends = [topic.first_s, topic.last_s];
        assert!(ends.iter().all(|end| end.is_some() == (stamped > 0)));
        assert!(topic.gaps + topic.backward_stamps <= stamped.saturating_sub(1));
        for field in &topic.fields {
            assert!(field.count <= topic.messages, "{}", field.name);
            assert_eq!(field.min.is_some(), field.count > 0, "{}", field.name);
            assert!(field.min <= field.max, "{}", field.name);
        }
    }
}
