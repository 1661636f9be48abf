//! The built-in maps, and the choice among them for a log.

use super::LogFormat;
use super::survey::{Survey, Topic};
use crate::Map;
use crate::inspection::suggest::basic_string;
use crate::map::Rule;
use std::sync::LazyLock;
use touchdown_trial::TIME_CHANNEL;

/// A built-in map.
struct BuiltIn {
    name: &'static str,
    text: &'static str,
    /// A channel that the map must produce to fit; it must also find its clock.
    needs: &'static str,
}

static BUILT_IN: [BuiltIn; 4] = [
    BuiltIn {
        name: "px4",
        text: include_str!("../../maps/px4.toml"),
        needs: "tilt_rad",
    },
    BuiltIn {
        name: "ros",
        text: include_str!("../../maps/ros.toml"),
        needs: TIME_CHANNEL,
    },
    BuiltIn {
        name: "fly",
        text: include_str!("../../maps/fly.toml"),
        needs: "tilt_rad",
    },
    BuiltIn {
        name: "ardupilot",
        text: include_str!("../../maps/ardupilot.toml"),
        needs: "throttle",
    },
];

/// Those of [`BUILT_IN`] in their order.
static MAPS: LazyLock<Vec<Map>> = LazyLock::new(|| {
    let maps = BUILT_IN
        .iter()
        .map(|known| Map::parse(&format!("the built-in map {}", known.name), known.text));
    maps.filter_map(Result::ok).collect()
});

/// The quantities that identification needs, and their channels.
const WANTED: [(&str, &str); 4] = [
    ("specific force", "specific_force_mps2"),
    ("tilt", "tilt_rad"),
    ("throttle", "throttle"),
    ("height", "height_m"),
];

/// The built-in maps for logs of this format, in the order in which they are tried.
fn of_format(format: LogFormat) -> impl Iterator<Item = (&'static BuiltIn, &'static Map)> {
    let named = |name: &&str| BUILT_IN.iter().position(|known| known.name == *name);
    let places = format.reader().maps.iter().filter_map(named);
    places.filter_map(|at| Some((&BUILT_IN[at], MAPS.get(at)?)))
}

impl Map {
    /// The built-in map that makes a trial of the log, if one does: that of PX4, of ArduPilot, of ROS or of
    /// `touchdown fly`.
    #[must_use]
    pub fn built_in(survey: &Survey) -> Option<&'static Self> {
        Some(survey.fitting()?.1)
    }

    /// The built-in map of this name: `px4`, `ardupilot`, `ros` or `fly`.
    #[must_use]
    pub fn built_in_named(name: &str) -> Option<&'static Self> {
        let at = BUILT_IN.iter().position(|known| known.name == name)?;
        MAPS.get(at)
    }

    /// The built-in maps for logs of a format.
    pub(super) fn built_in_for(format: LogFormat) -> impl Iterator<Item = &'static Self> {
        of_format(format).map(|(_, map)| map)
    }

    /// The text of the built-in map of this name, as a start for one's own.
    #[must_use]
    pub fn built_in_text(name: &str) -> Option<&'static str> {
        let mut all = BUILT_IN.iter();
        all.find(|known| known.name == name).map(|known| known.text)
    }
}

impl Survey {
    /// The name of the built-in map that fits the log: the log has its clock and its necessary
    /// channel, such as the attitude for PX4 and the motors for ArduPilot.
    #[must_use]
    pub fn recommended_map(&self) -> Option<&'static str> {
        Some(self.fitting()?.0.name)
    }

    fn fitting(&self) -> Option<(&'static BuiltIn, &'static Map)> {
        of_format(self.format).find(|(known, map)| {
            let clocks = map.clocks().map_or(&[][..], |(_, clocks)| clocks);
            let has_clock = clocks.iter().any(|name| self.topic_like(name).is_some());
            has_clock && self.makes(map, known.needs)
        })
    }

    fn makes(&self, map: &Map, channel: &str) -> bool {
        let left_out = self.resolved(map).left_out;
        !left_out.iter().any(|(name, _)| name == channel)
    }

    /// Largest number of rows that the map can produce: the messages of its clock.
    #[must_use]
    pub fn rows_by(&self, map: &Map) -> usize {
        let clocks = map.clocks().map_or(&[][..], |(_, clocks)| clocks);
        let clock = clocks.iter().find_map(|name| self.topic_like(name));
        let most = || self.topics.iter().map(|topic| topic.messages).max();
        clock.map_or_else(|| most().unwrap_or(0), |topic| topic.messages)
    }

    /// Data that the log lacks for the identification of thrust and ground effect by its built-in
    /// map, one sentence each.
    #[must_use]
    pub fn lacks(&self) -> Vec<String> {
        let Some(map) = Map::built_in(self).or_else(|| Map::built_in_for(self.format).last())
        else {
            return Vec::new();
        };
        let left_out = self.resolved(map).left_out;
        let lacking = WANTED
            .iter()
            .filter(|(_, channel)| left_out.iter().any(|(name, _)| name == channel));
        lacking
            .map(|(what, channel)| format!("{what}: {}", self.cause(map, channel)))
            .collect()
    }

    /// The reason why the map cannot produce a channel.
    fn cause(&self, map: &Map, channel: &str) -> String {
        let missed = self.missed(map, &map.defines, &rules_of(&map.channels, channel));
        let (topics, names): (Vec<&MissingName>, Vec<&MissingName>) =
            missed.iter().partition(|missed| missed.is_topic);
        let list = |missed: &[&MissingName]| {
            let names: Vec<&str> = missed.iter().map(|missed| missed.name.as_str()).collect();
            names.join(", ")
        };
        let of_kind = |missed: &&MissingName| {
            let alike = |topic: &&Topic| {
                topic.messages > 0 && topic.kind.as_deref() == Some(missed.name.as_str())
            };
            let topics = self.topics.iter().filter(alike);
            topics.map(|topic| topic.key.as_str()).collect::<Vec<_>>()
        };
        let many = topics.iter().map(of_kind).find(|topics| topics.len() > 1);
        match many {
            Some(many) => format!(
                "the choice among {} is not clear; name one of them in a map",
                many.join(", ")
            ),
            None if topics.is_empty() => format!("there is no {}", list(&names)),
            None if names.is_empty() => format!("there is no topic of {}", list(&topics)),
            None => format!(
                "there is no topic of {}, and no {}",
                list(&topics),
                list(&names)
            ),
        }
    }

    /// The names that the log lacks for each of the rules; none if one rule can be used. A rule that
    /// lacks all names of another rule, and more, is ignored.
    fn missed(&self, map: &Map, defines: &[Rule], rules: &[&Rule]) -> Vec<MissingName> {
        let each: Vec<Vec<MissingName>> = rules
            .iter()
            .map(|rule| {
                let names = rule.expr.variables().into_iter();
                let mut missed = Vec::new();
                for one in names.flat_map(|name| self.missed_by_name(map, defines, name)) {
                    if !missed.contains(&one) {
                        missed.push(one);
                    }
                }
                missed
            })
            .collect();
        let is_within = |a: &[MissingName], b: &[MissingName]| a.iter().all(|one| b.contains(one));
        let least = each.iter().filter(|missed| {
            let mut others = each.iter();
            !others.any(|other| other.len() < missed.len() && is_within(other, missed))
        });
        let mut all = Vec::new();
        for one in least.flatten() {
            if !all.contains(one) {
                all.push(one.clone());
            }
        }
        all
    }

    fn missed_by_name(&self, map: &Map, defines: &[Rule], name: &str) -> Vec<MissingName> {
        if self.knows(map, name) || self.parameter(name).is_some() {
            return Vec::new();
        }
        // Only definitions above it, so that the recursion ends.
        let first = defines.iter().position(|rule| rule.channel == name);
        if let Some(first) = first {
            return self.missed(map, &defines[..first], &rules_of(defines, name));
        }
        let topic = topic_of(map, name);
        let is_topic = !name.starts_with("param.") && self.topic_like(topic).is_none();
        let name = if is_topic { topic } else { name }.to_owned();
        vec![MissingName { name, is_topic }]
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

/// A missing topic, field or parameter.
#[derive(Clone, PartialEq)]
struct MissingName {
    name: String,
    is_topic: bool,
}

fn rules_of<'a>(rules: &'a [Rule], name: &str) -> Vec<&'a Rule> {
    rules.iter().filter(|rule| rule.channel == name).collect()
}

/// The topic in a name such as `sensor_msgs/Imu.orientation.x`. The map's tables of topics tell
/// which topic names contain dots.
fn topic_of<'a>(map: &Map, name: &'a str) -> &'a str {
    let said = map.topics.iter().map(|topic| topic.name.as_str());
    let within = |topic: &&str| {
        let rest = name.strip_prefix(topic);
        rest.is_some_and(|rest| rest.starts_with('.'))
    };
    let after = name.rfind('/').map_or(0, |slash| slash + 1);
    let first = name[after..]
        .find('.')
        .map_or(name.len(), |dot| after + dot);
    let length = said.filter(within).map(str::len).max().unwrap_or(first);
    &name[..length]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_every_built_in_map_is_one() {
        assert_eq!(MAPS.len(), BUILT_IN.len());
        for (known, map) in BUILT_IN.iter().zip(MAPS.iter()) {
            assert!(map.channels().any(|channel| channel == known.needs));
            for (_, channel) in WANTED {
                assert!(map.optional.iter().any(|optional| optional == channel));
            }
        }
    }
}
