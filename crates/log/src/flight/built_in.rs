//! The maps that come with the crate, and which of them fits a log.

use super::survey::Survey;
use crate::Map;
use crate::suggest::basic_string;

/// The file names that the maps go by, and their texts.
const MAPS: [(&str, &str); 2] = [
    ("px4.toml", include_str!("../../maps/px4.toml")),
    ("ardupilot.toml", include_str!("../../maps/ardupilot.toml")),
];

impl Map {
    /// The built-in map that makes a trial of the log, if one does: that of PX4 or of ArduPilot.
    #[must_use]
    pub fn built_in(survey: &Survey) -> Option<Self> {
        survey.recommended_map().and_then(Self::built_in_named)
    }

    /// The built-in map of this name: `px4` or `ardupilot`.
    #[must_use]
    pub fn built_in_named(name: &str) -> Option<Self> {
        let text = Self::built_in_text(name)?;
        Self::parse(&format!("the built-in map {name}"), text).ok()
    }

    /// The text of the built-in map of this name, to start an own one from.
    #[must_use]
    pub fn built_in_text(name: &str) -> Option<&'static str> {
        let file = format!("{name}.toml");
        MAPS.iter()
            .find(|(known, _)| *known == file)
            .map(|(_, text)| *text)
    }
}

impl Survey {
    /// The name of the built-in map for the log: the one whose clock and motor commands it has.
    #[must_use]
    pub fn recommended_map(&self) -> Option<&'static str> {
        let has = |topics: &[&str]| topics.iter().any(|key| self.topic_like(key).is_some());
        if has(&["vehicle_acceleration", "sensor_combined"]) && has(&["vehicle_attitude"]) {
            Some("px4")
        } else if has(&["IMU"]) && has(&["RCOU"]) {
            Some("ardupilot")
        } else {
            None
        }
    }

    /// The text of a map to start from, with all fields as comments.
    #[must_use]
    pub fn suggested_map(&self) -> String {
        let clock = self.topics.iter().max_by_key(|topic| topic.messages);
        let mut text = String::from("schema = 1\n");
        if let Some(clock) = clock {
            text.push_str(&format!("clock = {}\n", basic_string(&clock.key)));
        }
        text.push_str("\n[channels]\ntime_s = 'time_s'\n");
        for topic in &self.topics {
            for field in topic.fields.iter().filter(|field| field.count > 0) {
                let name = format!("{}.{}", topic.key, field.name);
                let name: String = name
                    .chars()
                    .map(|c| if c.is_control() { ' ' } else { c })
                    .collect();
                text.push_str(&format!("# '\"{name}\"'\n"));
            }
        }
        text
    }
}
