//! Survey of a log: topics, rates, gaps and ranges of values, counted in one pass.

use super::LogFormat;
use super::fields::{FieldSums, UnitedNames};
use super::sink::{Layout, Sink, Wanted};
use super::steps::Steps;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// Messages of a topic.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Topic {
    /// The name in the log.
    pub name: String,
    /// Counts the sources of one kind from 0.
    pub instance: u32,
    /// Its name in the expressions of a map: the name, with `#` and the instance if that is not 0.
    pub key: String,
    /// The type of its messages, such as `sensor_msgs/Imu`, where the format states it.
    pub kind: Option<String>,
    /// Number of messages.
    pub messages: usize,
    /// Stamp of the first, in s from the log's zero.
    pub first_s: Option<f64>,
    /// Stamp of the last, in s from the log's zero.
    pub last_s: Option<f64>,
    /// Messages per second, without the gaps.
    pub rate_hz: Option<f64>,
    /// Longest time between two messages, in s.
    pub longest_step_s: Option<f64>,
    /// Steps ten times as long as the median and longer than 0.05 s.
    pub gaps: usize,
    /// Sum of the gaps, in s.
    pub gaps_s: f64,
    /// Number of messages without a stamp.
    pub absent_stamps: usize,
    /// Number of messages whose stamp is not after the previous one.
    pub backward_stamps: usize,
    /// The fields that hold numbers.
    pub fields: Vec<Field>,
    /// The fields that hold text.
    pub texts: Vec<String>,
}

/// The values of a field of a topic.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Field {
    /// The name in the topic.
    pub name: String,
    /// Number of finite values.
    pub count: usize,
    /// Sum of the finite values.
    pub sum: f64,
    /// The smallest.
    pub min: Option<f64>,
    /// The largest.
    pub max: Option<f64>,
}

/// Summary of a log.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Survey {
    /// The file.
    pub path: String,
    /// Its format, recognised by its content.
    pub format: LogFormat,
    /// The zero of the stamps.
    pub zero: String,
    /// From the first stamp to the last, in s.
    pub duration_s: f64,
    /// The topics, in the order of their names.
    pub topics: Vec<Topic>,
    /// The vehicle's parameters, with their first values.
    pub parameters: BTreeMap<String, f64>,
}

impl Survey {
    /// The topic with this name in expressions.
    #[must_use]
    pub fn topic(&self, key: &str) -> Option<&Topic> {
        self.topics.iter().find(|topic| topic.key == key)
    }

    /// Number of messages of all topics.
    #[must_use]
    pub fn messages(&self) -> usize {
        self.topics.iter().map(|topic| topic.messages).sum()
    }
}

impl Topic {
    /// The field of this name.
    #[must_use]
    pub fn field(&self, name: &str) -> Option<&Field> {
        self.fields.iter().find(|field| field.name == name)
    }
}

/// The name of a topic in expressions.
pub(super) fn key(name: &str, instance: u32) -> String {
    match instance {
        0 => name.to_owned(),
        _ => format!("{name}#{instance}"),
    }
}

struct TopicCounts {
    name: String,
    kind: String,
    instance: u32,
    names: UnitedNames,
    texts: UnitedNames,
    messages: usize,
    absent: usize,
    /// Number of messages with a stamp when the stamps were last shifted.
    settled: usize,
    first_ns: Option<i64>,
    last_ns: Option<i64>,
    steps: Option<Box<Steps>>,
    fields: Vec<FieldSums>,
}

/// Link from a reader's topic to a topic of the survey. Several topics of a reader may share a name.
#[derive(Clone, Default)]
struct Source {
    /// Place in `topics`.
    topic: usize,
    /// Index in the topic of each of its fields.
    fields: Vec<usize>,
    /// Whether these are the topic's first fields, in their order.
    in_order: bool,
    /// Index in the topic of each of its texts.
    texts: Vec<usize>,
}

/// Largest number of stored parameters: PX4 has about 2000, ArduPilot 1500. It bounds the memory for
/// a damaged file.
const MOST_PARAMETERS: usize = 20_000;

/// The sink that makes the survey.
pub(super) struct Surveyor {
    /// Whether values are counted, or only names and numbers of messages.
    deep: bool,
    topics: Vec<TopicCounts>,
    /// By the reader's number.
    sources: Vec<Source>,
    known: HashMap<(String, u32), usize>,
    parameters: BTreeMap<String, f64>,
    changed: BTreeMap<String, f64>,
    latest_ns: Option<i64>,
    jumps: usize,
    longest_jump_ns: i64,
}

/// Least jump between the stamps of neighbouring messages that is reported, ns: one minute.
const JUMP_NS: i64 = 60_000_000_000;

impl Surveyor {
    pub(super) fn new(deep: bool) -> Self {
        Self {
            deep,
            topics: Vec::new(),
            sources: Vec::new(),
            known: HashMap::new(),
            parameters: BTreeMap::new(),
            changed: BTreeMap::new(),
            latest_ns: None,
            jumps: 0,
            longest_jump_ns: 0,
        }
    }

    /// Warnings, one sentence each.
    pub(super) fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        if self.jumps > 0 {
            let times = match self.jumps {
                1 => "once".to_owned(),
                jumps => format!("{jumps} times"),
            };
            let longest_s = self.longest_jump_ns as f64 * 1e-9;
            warnings.push(format!(
                "time jumps {times} by more than a minute, by up to {longest_s:.0} s"
            ));
        }
        if !self.changed.is_empty() {
            let names: Vec<&str> = self.changed.keys().take(8).map(String::as_str).collect();
            warnings.push(format!(
                "{} parameters change during the log, such as {}; the first values count",
                self.changed.len(),
                names.join(", ")
            ));
        }
        warnings
    }

    pub(super) fn finish(self, path: &str, format: LogFormat, zero: String) -> Survey {
        let s = |ns: i64| ns as f64 * 1e-9;
        let mut topics: Vec<Topic> = Vec::with_capacity(self.topics.len());
        let (mut first, mut last) = (i64::MAX, i64::MIN);
        for seen in self.topics {
            if let (Some(start), Some(end)) = (seen.first_ns, seen.last_ns) {
                (first, last) = (first.min(start), last.max(end));
            }
            let steps = seen.steps.as_ref().map(|steps| steps.summary());
            let steps = steps.unwrap_or_default();
            let fields = seen.names.into_names().into_iter().zip(&seen.fields);
            let finite = |value: f64| value.is_finite().then_some(value);
            topics.push(Topic {
                key: key(&seen.name, seen.instance),
                kind: Some(seen.kind).filter(|kind| !kind.is_empty()),
                name: seen.name,
                instance: seen.instance,
                messages: seen.messages,
                first_s: seen.first_ns.map(s),
                last_s: seen.last_ns.map(s),
                rate_hz: steps.rate_hz,
                longest_step_s: steps.longest_s,
                gaps: steps.gaps,
                gaps_s: steps.gaps_s,
                absent_stamps: seen.absent,
                backward_stamps: seen.steps.map_or(0, |steps| steps.backward),
                fields: fields
                    .map(|(name, running)| Field {
                        name,
                        count: running.count,
                        sum: running.sum,
                        min: finite(running.min),
                        max: finite(running.max),
                    })
                    .collect(),
                texts: seen.texts.into_names(),
            });
        }
        topics.sort_by(|a, b| (&a.name, a.instance).cmp(&(&b.name, b.instance)));
        Survey {
            path: path.to_owned(),
            format,
            zero,
            duration_s: if first <= last {
                s(last.saturating_sub(first))
            } else {
                0.0
            },
            topics,
            parameters: self.parameters,
        }
    }
}

impl Sink for Surveyor {
    fn topic(&mut self, id: usize, layout: &Layout) -> Wanted {
        let named = (layout.name.clone(), layout.instance);
        let place = *self.known.entry(named).or_insert_with(|| {
            self.topics.push(TopicCounts {
                name: layout.name.clone(),
                kind: layout.kind.clone(),
                instance: layout.instance,
                names: UnitedNames::default(),
                texts: UnitedNames::default(),
                messages: 0,
                absent: 0,
                settled: 0,
                first_ns: None,
                last_ns: None,
                steps: self.deep.then(Box::default),
                fields: Vec::new(),
            });
            self.topics.len() - 1
        });
        let known = self.sources.len().max(id + 1);
        self.sources.resize(known, Source::default());
        let seen = &mut self.topics[place];
        let source = &mut self.sources[id];
        source.topic = place;
        // A topic of a reader only ever gets more fields.
        seen.names.unite(&layout.fields, &mut source.fields);
        seen.texts.unite(&layout.texts, &mut source.texts);
        let mut places = source.fields.iter().enumerate();
        source.in_order = places.all(|(field, &place)| field == place);
        seen.fields.resize(seen.names.len(), FieldSums::EMPTY);
        if self.deep {
            Wanted::Fields((0..layout.fields.len()).collect())
        } else {
            Wanted::Stamps
        }
    }

    fn message(&mut self, id: usize, stamp_ns: Option<i64>, values: &[f64]) {
        let source = &self.sources[id];
        let seen = &mut self.topics[source.topic];
        seen.messages += 1;
        match stamp_ns {
            None => seen.absent += 1,
            Some(stamp) => {
                seen.first_ns.get_or_insert(stamp);
                seen.last_ns = Some(stamp);
                if let Some(steps) = &mut seen.steps {
                    steps.push(stamp);
                }
                let latest = self.latest_ns.unwrap_or(stamp);
                let jump = stamp.saturating_sub(latest).saturating_abs();
                if jump <= JUMP_NS || seen.messages > 1 {
                    self.latest_ns = Some(stamp);
                    if jump > JUMP_NS {
                        self.jumps += 1;
                        self.longest_jump_ns = self.longest_jump_ns.max(jump);
                    }
                }
            }
        }
        if source.in_order {
            let fields = seen.fields.iter_mut().zip(values);
            fields.for_each(|(running, &value)| running.push(value));
            return;
        }
        for (&place, &value) in source.fields.iter().zip(values) {
            if let Some(running) = seen.fields.get_mut(place) {
                running.push(value);
            }
        }
    }

    fn shift(&mut self, ids: &[usize], by_ns: i64) {
        let topics: BTreeSet<usize> = ids.iter().map(|&id| self.sources[id].topic).collect();
        for place in topics {
            let seen = &mut self.topics[place];
            let stamped = seen.messages - seen.absent;
            let moved = |stamp: i64| stamp.saturating_add(by_ns);
            if seen.settled == 0 {
                seen.first_ns = seen.first_ns.map(moved);
            }
            if seen.settled < stamped {
                seen.last_ns = seen.last_ns.map(moved);
            }
            seen.settled = stamped;
        }
    }

    fn parameter(&mut self, name: &str, value: f64) {
        match self.parameters.get(name) {
            Some(&first) if first == value || (first.is_nan() && value.is_nan()) => {}
            Some(_) => {
                self.changed.insert(name.to_owned(), value);
            }
            None if self.parameters.len() < MOST_PARAMETERS => {
                self.parameters.insert(name.to_owned(), value);
            }
            None => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_sources_of_one_topic_count_by_the_names_of_their_fields() {
        let layout = |fields: &[&str]| Layout {
            name: "a".to_owned(),
            fields: fields.iter().map(|&field| field.to_owned()).collect(),
            ..Layout::default()
        };
        let mut surveyor = Surveyor::new(true);
        surveyor.topic(0, &layout(&["x", "y"]));
        surveyor.message(0, Some(0), &[1.0, 10.0]);
        // Another says nothing at first, and then the same in another order, and more.
        surveyor.topic(1, &layout(&[]));
        surveyor.message(1, Some(1), &[]);
        surveyor.topic(1, &layout(&["y", "z", "x"]));
        surveyor.message(1, Some(2), &[20.0, 300.0, 2.0]);
        surveyor.message(0, Some(3), &[4.0, 40.0]);
        let survey = surveyor.finish("log", LogFormat::Mcap, String::new());
        let fields = survey.topics[0].fields.iter();
        let sums: Vec<_> = fields.map(|f| (f.name.as_str(), f.count, f.sum)).collect();
        assert_eq!(sums, [("x", 3, 7.0), ("y", 3, 70.0), ("z", 1, 300.0)]);
        assert_eq!(survey.messages(), 4);
    }
}
