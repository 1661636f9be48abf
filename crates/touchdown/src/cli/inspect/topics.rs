//! What is shown of a log with topics.

use std::collections::HashSet;

use touchdown_log::{Map, Survey, Topic};

use crate::cli::identify::show;

/// Format, numbers and time base in a line.
pub(super) fn about(survey: &Survey) -> String {
    let map = match survey.recommended_map() {
        Some(name) => format!("; the built-in map {name} fits"),
        None => String::new(),
    };
    format!(
        "{}, {} topics, {} messages, {} parameters; times count from {}, {} s{map}",
        survey.format.name(),
        survey.topics.len(),
        survey.messages(),
        survey.parameters.len(),
        survey.zero,
        show::digits(survey.duration_s)
    )
}

/// A row a topic.
pub(super) fn table(survey: &Survey) -> (Vec<String>, Vec<Vec<String>>) {
    let header = [
        "topic",
        "messages",
        "rate Hz",
        "first s",
        "last s",
        "gaps",
        "longest s",
        "fields",
    ];
    let number = |v: Option<f64>| v.map_or_else(String::new, show::digits);
    let rows = survey.topics.iter().map(|topic| {
        vec![
            topic.key.clone(),
            topic.messages.to_string(),
            number(topic.rate_hz),
            number(topic.first_s),
            number(topic.last_s),
            topic.gaps.to_string(),
            number(topic.longest_step_s),
            fields(topic),
        ]
    });
    (header.map(String::from).into(), rows.collect())
}

/// The names of a topic's fields; elements of one array are told once.
fn fields(topic: &Topic) -> String {
    let mut names: Vec<String> = Vec::new();
    let mut seen = HashSet::new();
    for name in topic.fields.iter().map(|f| &f.name).chain(&topic.texts) {
        let mut short = String::new();
        let mut inside = false;
        for c in name.chars() {
            inside &= c != ']';
            if !inside {
                short.push(c);
            }
            inside |= c == '[';
        }
        if seen.insert(short.clone()) {
            names.push(short);
        }
    }
    names.join(" ")
}

/// The built-in map that fits, or one to start from.
pub(super) fn map_text(survey: &Survey) -> String {
    let fits = survey.recommended_map().and_then(Map::built_in_text);
    fits.map_or_else(|| survey.suggested_map(), str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_elements_of_an_array_are_told_once() {
        let field = |name: &str| touchdown_log::Field {
            name: name.to_owned(),
            count: 0,
            sum: 0.0,
            min: None,
            max: None,
        };
        let names = [
            "esc[0].rpm",
            "esc[0].volt",
            "esc[1].rpm",
            "esc[1].volt",
            "n",
        ];
        let topic = Topic {
            name: "esc".to_owned(),
            instance: 0,
            key: "esc".to_owned(),
            kind: None,
            messages: 0,
            first_s: None,
            last_s: None,
            rate_hz: None,
            longest_step_s: None,
            gaps: 0,
            gaps_s: 0.0,
            absent_stamps: 0,
            backward_stamps: 0,
            fields: names.map(field).into(),
            texts: vec!["id".to_owned()],
        };
        assert_eq!(fields(&topic), "esc[].rpm esc[].volt n id");
    }
}
