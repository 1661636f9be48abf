//! Checks the text of a map.

use super::{Join, Map, Resample, Rule, Topic, Vehicle, Window};
use crate::limits::{MAP_BYTES, MAP_RULES};
use crate::{LogError, Place};
use serde::Deserialize;
use serde::de::{self, Deserializer, SeqAccess, Visitor};
use sindy_expr::Expr;
use std::collections::BTreeMap;
use std::fmt;
use toml::Spanned;
use touchdown_files::TomlError;
use touchdown_trial::TIME_CHANNEL;

/// The version of the map's format that this crate reads.
const SCHEMA: i64 = 1;
/// Longest running median, in samples: a second at 1 kHz. A longer one is a typing error.
const LONGEST_MEDIAN: i64 = 1001;

/// The row filter, and running medians in samples by channel.
type Filter = (Option<Rule>, Vec<(String, usize)>);

/// The version alone: a map of another version may have other keys.
#[derive(Deserialize)]
struct RawVersion {
    schema: Option<Spanned<i64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawMap {
    #[serde(rename = "schema")]
    _schema: i64,
    #[serde(default)]
    description: String,
    clock: Option<Spanned<OneOrMore>>,
    #[serde(default)]
    optional: Vec<Spanned<String>>,
    #[serde(default)]
    define: BTreeMap<String, Spanned<OneOrMore>>,
    channels: BTreeMap<String, Spanned<OneOrMore>>,
    #[serde(default)]
    topics: BTreeMap<String, RawTopic>,
    filter: Option<RawFilter>,
    #[serde(default)]
    windows: Vec<RawWindow>,
    resample: Option<RawResample>,
    vehicle: Option<RawVehicle>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawFilter {
    keep: Option<Spanned<String>>,
    #[serde(default)]
    median: BTreeMap<String, Spanned<i64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawWindow {
    from_s: Spanned<f64>,
    to_s: Spanned<f64>,
    file: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawResample {
    period_s: Spanned<f64>,
    max_gap_s: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawVehicle {
    mass_kg: Option<Spanned<f64>>,
    rotor_radius_m: Option<Spanned<f64>>,
    arm_m: Option<Spanned<f64>>,
    rotors: Option<Spanned<i64>>,
    measured_rotors: Option<Spanned<i64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawTopic {
    join: Option<Spanned<String>>,
    valid: Option<Spanned<OneOrMore>>,
    offset_s: Option<Spanned<f64>>,
    limit_s: Option<Spanned<f64>>,
}

/// A text or a list of texts.
struct OneOrMore(Vec<String>);

impl<'de> Deserialize<'de> for OneOrMore {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Texts;
        impl<'de> Visitor<'de> for Texts {
            type Value = OneOrMore;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a string or a list of strings")
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<OneOrMore, E> {
                Ok(OneOrMore(vec![text.to_owned()]))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<OneOrMore, A::Error> {
                let mut texts = Vec::new();
                while let Some(text) = list.next_element()? {
                    texts.push(text);
                }
                if texts.is_empty() {
                    return Err(de::Error::invalid_length(0, &self));
                }
                Ok(OneOrMore(texts))
            }
        }
        deserializer.deserialize_any(Texts)
    }
}

/// The text of a map, for the places in errors.
pub(super) struct Source<'a> {
    pub(super) path: &'a str,
    pub(super) text: &'a str,
}

impl Source<'_> {
    /// Checks the map.
    pub(super) fn map(&self) -> Result<Map, LogError> {
        let text = self.text.strip_prefix('\u{feff}').unwrap_or(self.text);
        self.at_most("", text.len(), MAP_BYTES, "bytes of text")?;
        self.check_version(text)?;
        let raw: RawMap = toml::from_str(text).map_err(|error| self.toml_error(text, &error))?;
        if !raw.channels.contains_key(TIME_CHANNEL) {
            return Err(LogError::MapValue {
                at: Box::new(self.place(0, "channels.time_s")),
                expected: "an expression for the time in seconds".to_owned(),
                found: "no such key".to_owned(),
            });
        }
        let mut optional = Vec::new();
        for channel in &raw.optional {
            let name = channel.get_ref();
            let known = name != TIME_CHANNEL && raw.channels.contains_key(name);
            self.check(channel, "optional", known, "a channel other than time_s")?;
            optional.push(name.clone());
        }
        let (keep, medians) = raw
            .filter
            .as_ref()
            .map_or(Ok((None, Vec::new())), |filter| {
                self.filter(filter, &raw.channels)
            })?;
        Ok(Map {
            path: self.path.to_owned(),
            clocks: raw.clock.map(|clock| {
                let place = self.place(clock.span().start, "clock");
                (place, clock.into_inner().0)
            }),
            optional,
            defines: self.rules("define", &raw.define)?,
            channels: self.rules("channels", &raw.channels)?,
            topics: raw
                .topics
                .iter()
                .map(|(name, topic)| self.topic(name, topic))
                .collect::<Result<_, _>>()?,
            description: raw.description,
            keep,
            medians,
            windows: raw
                .windows
                .into_iter()
                .map(|window| self.window(window))
                .collect::<Result<_, _>>()?,
            resample: raw.resample.map(|r| self.resample(&r)).transpose()?,
            vehicle: raw
                .vehicle
                .map_or(Ok(Vehicle::default()), |vehicle| self.vehicle(&vehicle))?,
        })
    }

    fn vehicle(&self, raw: &RawVehicle) -> Result<Vehicle, LogError> {
        let positive = |value: &Option<Spanned<f64>>, key: &str| {
            let value = value.as_ref().map(|value| self.positive(value, key));
            value.transpose()
        };
        let count = |value: &Option<Spanned<i64>>, key: &str| {
            let Some(value) = value else { return Ok(None) };
            let rotors = u32::try_from(*value.get_ref()).unwrap_or(0);
            self.check(value, key, rotors > 0, "a whole number, at least 1")?;
            Ok(Some(rotors))
        };
        Ok(Vehicle {
            mass_kg: positive(&raw.mass_kg, "vehicle.mass_kg")?,
            rotor_radius_m: positive(&raw.rotor_radius_m, "vehicle.rotor_radius_m")?,
            arm_m: positive(&raw.arm_m, "vehicle.arm_m")?,
            rotors: count(&raw.rotors, "vehicle.rotors")?,
            measured_rotors: count(&raw.measured_rotors, "vehicle.measured_rotors")?,
        })
    }

    /// The expressions of a table in the map, in its order, with alternatives together.
    fn rules(
        &self,
        table: &str,
        texts: &BTreeMap<String, Spanned<OneOrMore>>,
    ) -> Result<Vec<Rule>, LogError> {
        let count = texts.values().map(|texts| texts.get_ref().0.len()).sum();
        self.at_most(table, count, MAP_RULES, "expressions")?;
        let mut named: Vec<(&String, &Spanned<OneOrMore>)> = texts.iter().collect();
        named.sort_by_key(|(_, texts)| texts.span().start);
        let mut rules = Vec::new();
        for (name, texts) in named {
            let well_named = !name.is_empty()
                && name
                    .bytes()
                    .all(|b| b.is_ascii_alphanumeric() || b"_.".contains(&b));
            let start = texts.span().start;
            if !well_named {
                return Err(LogError::MapValue {
                    at: Box::new(self.place(start, table)),
                    expected: "a channel name of letters, digits, _ and .".to_owned(),
                    found: format!("{name:?}"),
                });
            }
            let key = format!("{table}.{name}");
            for text in &texts.get_ref().0 {
                rules.push(self.rule(name, &key, start, text)?);
            }
        }
        Ok(rules)
    }

    fn topic(&self, name: &str, topic: &RawTopic) -> Result<Topic, LogError> {
        let key = |key: &str| format!("topics.{name}.{key}");
        let join = match &topic.join {
            None => Join::Linear,
            Some(text) => {
                let known = Join::NAMES.iter().find(|(name, _)| name == text.get_ref());
                self.check(text, &key("join"), known.is_some(), "linear, hold or once")?;
                known.map_or(Join::Linear, |&(_, join)| join)
            }
        };
        if let Some(offset) = &topic.offset_s {
            self.check(
                offset,
                &key("offset_s"),
                offset.get_ref().is_finite(),
                "a finite number",
            )?;
        }
        let limit_s = topic.limit_s.as_ref();
        let valid = topic.valid.as_ref().map(|texts| {
            let at = texts.span().start;
            let rules = texts.get_ref().0.iter();
            rules
                .map(|text| self.rule("", &key("valid"), at, text))
                .collect::<Result<Vec<Rule>, LogError>>()
        });
        Ok(Topic {
            name: name.to_owned(),
            join,
            valid: valid.transpose()?.unwrap_or_default(),
            offset_s: topic.offset_s.as_ref().map_or(0.0, |s| *s.get_ref()),
            limit_s: limit_s
                .map(|s| self.positive(s, &key("limit_s")))
                .transpose()?,
        })
    }

    /// Checks the version before any other key. A text that is not TOML, or a version that is no number, is refused
    /// where all keys are read.
    fn check_version(&self, text: &str) -> Result<(), LogError> {
        let raw = toml::from_str::<RawVersion>(text).ok();
        let Some(found) = raw.and_then(|raw| raw.schema) else {
            return Ok(());
        };
        let expected = format!("{SCHEMA}, the only version of maps that this program knows");
        self.check(&found, "schema", *found.get_ref() == SCHEMA, &expected)
    }

    fn place(&self, start: usize, key: &str) -> Place {
        let before = self.text.as_bytes().iter().take(start);
        Place {
            map: self.path.to_owned(),
            line: 1 + before.filter(|&&b| b == b'\n').count(),
            key: key.to_owned(),
        }
    }

    fn toml_error(&self, text: &str, error: &toml::de::Error) -> LogError {
        let wrong = TomlError::new(text, error);
        LogError::MapToml {
            at: Box::new(Place {
                map: self.path.to_owned(),
                line: wrong.line.unwrap_or(1),
                key: wrong.key,
            }),
            message: wrong.message,
        }
    }

    fn check<T: ToString>(
        &self,
        value: &Spanned<T>,
        key: &str,
        good: bool,
        expected: &str,
    ) -> Result<(), LogError> {
        if good {
            return Ok(());
        }
        Err(LogError::MapValue {
            at: Box::new(self.place(value.span().start, key)),
            expected: expected.to_owned(),
            found: value.get_ref().to_string(),
        })
    }

    fn at_most(&self, key: &str, found: usize, most: usize, what: &str) -> Result<(), LogError> {
        if found <= most {
            return Ok(());
        }
        Err(LogError::MapValue {
            at: Box::new(self.place(0, key)),
            expected: format!("at most {most} {what}"),
            found: found.to_string(),
        })
    }

    fn positive(&self, value: &Spanned<f64>, key: &str) -> Result<f64, LogError> {
        let number = *value.get_ref();
        let good = number > 0.0 && number.is_finite();
        self.check(value, key, good, "a finite number above 0")?;
        Ok(number)
    }

    fn rule(&self, channel: &str, key: &str, start: usize, text: &str) -> Result<Rule, LogError> {
        let place = self.place(start, key);
        match Expr::parse(text) {
            Ok(expr) => Ok(Rule {
                channel: channel.to_owned(),
                place,
                expr,
            }),
            Err(source) => Err(LogError::MapExpression {
                at: Box::new(place),
                source: Box::new(source),
            }),
        }
    }

    fn filter(
        &self,
        filter: &RawFilter,
        channels: &BTreeMap<String, Spanned<OneOrMore>>,
    ) -> Result<Filter, LogError> {
        let keep = filter
            .keep
            .as_ref()
            .map(|text| self.rule("", "filter.keep", text.span().start, text.get_ref()))
            .transpose()?;
        let mut medians = Vec::new();
        for (channel, samples) in &filter.median {
            let key = format!("filter.median.{channel}");
            if channel == TIME_CHANNEL || !channels.contains_key(channel) {
                let known: Vec<&str> = channels
                    .keys()
                    .map(String::as_str)
                    .filter(|name| *name != TIME_CHANNEL)
                    .collect();
                return Err(LogError::MapValue {
                    at: Box::new(self.place(samples.span().start, &key)),
                    expected: format!("one of the channels {}", known.join(", ")),
                    found: format!("{channel:?}"),
                });
            }
            let number = *samples.get_ref();
            let good = (1..=LONGEST_MEDIAN).contains(&number) && number % 2 == 1;
            self.check(samples, &key, good, "an odd number of samples, 1 to 1001")?;
            medians.push((channel.clone(), usize::try_from(number).unwrap_or(1)));
        }
        Ok((keep, medians))
    }

    fn window(&self, window: RawWindow) -> Result<Window, LogError> {
        let (from_s, to_s) = (*window.from_s.get_ref(), *window.to_s.get_ref());
        self.check(
            &window.from_s,
            "windows.from_s",
            !from_s.is_nan(),
            "a number",
        )?;
        let expected = format!("a number above from_s = {from_s}");
        self.check(&window.to_s, "windows.to_s", from_s < to_s, &expected)?;
        let file = window.file;
        Ok(Window { from_s, to_s, file })
    }

    fn resample(&self, resample: &RawResample) -> Result<Resample, LogError> {
        Ok(Resample {
            period_s: self.positive(&resample.period_s, "resample.period_s")?,
            max_gap_s: resample
                .max_gap_s
                .as_ref()
                .map(|gap| self.positive(gap, "resample.max_gap_s"))
                .transpose()?,
        })
    }
}
