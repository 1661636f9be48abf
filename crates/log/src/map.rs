use crate::{Column, LogError, Place, Table, suggest};
use serde::Deserialize;
use sindy_expr::Expr;
use std::collections::BTreeMap;
use std::path::Path;
use toml::Spanned;
use touchdown_trial::TIME_CHANNEL;

/// The version of the map's format that this crate reads.
const SCHEMA: i64 = 1;
/// Longest running median, in samples.
const LONGEST_MEDIAN: i64 = 1001;

/// How the channels of a trial follow from the columns of a table; a TOML file.
///
/// ```toml
/// schema = 1
/// description = "A thrust stand"
///
/// [channels]                       # channel = 'expression over columns'; time_s is required
/// time_s = '"Time (s)"'            # odd column names in double quotes
/// throttle = '("ESC signal (µs)" - 1000) / 1000'
/// thrust_n = '9.80665e-3 * "Thrust (gf)"'
/// rotor_rpm = '"Motor Electrical Speed (RPM)"'
///
/// [filter]                         # optional
/// keep = '"Thrust (gf)" > -50'     # rows are kept where it is not 0 (nor NaN)
/// median = { rotor_rpm = 5 }       # running median of a channel, in samples, odd
///
/// [[windows]]                      # optional, several; both ends included, of time_s
/// from_s = 9.0
/// to_s = 42.2
/// file = "log10.csv"               # optional: only for files whose path ends so
///
/// [resample]                       # optional: linear, gaps stay gaps
/// period_s = 0.01
/// max_gap_s = 0.5                  # optional: join neighbours up to this far apart
///
/// [vehicle]                        # optional
/// mass_kg = 0.027                  # known to the expressions as mass_kg
/// ```
///
/// The expressions know the columns by name, `row` (the row's number in the file from 0) and,
/// if given, `mass_kg`; a column of one of these names comes before them. Windows with a `file`
/// hold for that file only; a file for which no window holds is used whole. Each window is
/// resampled on a grid of its own, so that nothing is joined across its ends.
#[derive(Debug, Clone)]
pub struct Map {
    pub(crate) path: String,
    description: String,
    pub(crate) channels: Vec<Rule>,
    pub(crate) keep: Option<Rule>,
    pub(crate) medians: Vec<(String, usize)>,
    pub(crate) windows: Vec<Window>,
    pub(crate) resample: Option<Resample>,
    mass_kg: Option<f64>,
}

/// One expression and where it stands.
#[derive(Debug, Clone)]
pub(crate) struct Rule {
    /// The channel; empty for the row filter.
    pub(crate) channel: String,
    pub(crate) place: Place,
    pub(crate) expr: Expr,
}

#[derive(Debug, Clone)]
pub(crate) struct Window {
    pub(crate) from_s: f64,
    pub(crate) to_s: f64,
    pub(crate) file: Option<String>,
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct Resample {
    pub(crate) period_s: f64,
    pub(crate) max_gap_s: Option<f64>,
}

/// The row filter, and running medians in samples by channel.
type Filter = (Option<Rule>, Vec<(String, usize)>);

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawMap {
    schema: Spanned<i64>,
    #[serde(default)]
    description: String,
    channels: BTreeMap<String, Spanned<String>>,
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
}

impl Map {
    /// Reads and checks a map.
    ///
    /// # Errors
    /// [`LogError::Read`], or one with the line and key of what is wrong.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, LogError> {
        let path = path.as_ref();
        let name = path.display().to_string();
        match std::fs::read_to_string(path) {
            Ok(text) => Self::parse(&name, &text),
            Err(source) => Err(LogError::Read { path: name, source }),
        }
    }

    /// Checks a map in memory; `path` names it in errors.
    ///
    /// # Errors
    /// [`LogError::MapToml`], [`LogError::MapValue`] or [`LogError::MapExpression`].
    pub fn parse(path: &str, text: &str) -> Result<Self, LogError> {
        let source = Source { path, text };
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let raw: RawMap = toml::from_str(text).map_err(|error| source.toml_error(&error))?;
        source.check(&raw.schema, "schema", *raw.schema.get_ref() == SCHEMA, "1")?;
        if !raw.channels.contains_key(TIME_CHANNEL) {
            return Err(LogError::MapValue {
                at: Box::new(source.place(0, "channels.time_s")),
                expected: "an expression for the time in seconds".to_owned(),
                found: "no such key".to_owned(),
            });
        }
        let mut channels: Vec<(usize, Rule)> = Vec::new();
        for (channel, text) in &raw.channels {
            let key = format!("channels.{channel}");
            let named = !channel.is_empty()
                && channel
                    .bytes()
                    .all(|b| b.is_ascii_alphanumeric() || b"_.".contains(&b));
            if !named {
                return Err(LogError::MapValue {
                    at: Box::new(source.place(text.span().start, "channels")),
                    expected: "a channel name of letters, digits, _ and .".to_owned(),
                    found: format!("{channel:?}"),
                });
            }
            channels.push((text.span().start, source.rule(channel, &key, text)?));
        }
        channels.sort_by_key(|&(start, _)| start);
        let (keep, medians) = raw.filter.map_or(Ok((None, Vec::new())), |filter| {
            source.filter(&filter, &raw.channels)
        })?;
        Ok(Self {
            path: path.to_owned(),
            description: raw.description,
            channels: channels.into_iter().map(|(_, rule)| rule).collect(),
            keep,
            medians,
            windows: raw
                .windows
                .into_iter()
                .map(|window| source.window(window))
                .collect::<Result<_, _>>()?,
            resample: raw.resample.map(|r| source.resample(&r)).transpose()?,
            mass_kg: raw
                .vehicle
                .and_then(|vehicle| vehicle.mass_kg)
                .map(|mass| source.positive(&mass, "vehicle.mass_kg"))
                .transpose()?,
        })
    }

    /// The map of a table that has our own channel names: every column of numbers is the channel
    /// of its name, as it is.
    ///
    /// # Errors
    /// [`LogError::NeedsMap`] with a map to start from, if there is no column `time_s` of numbers.
    pub fn identity_for(table: &Table) -> Result<Self, LogError> {
        if table.column(TIME_CHANNEL).is_none_or(Column::is_text) {
            return Err(LogError::NeedsMap {
                path: table.path.clone(),
                columns: table.column_names(),
                suggested: suggest::map_text(table),
            });
        }
        let place = Place {
            map: table.path.clone(),
            line: 1,
            key: String::new(),
        };
        Ok(Self {
            path: String::new(),
            description: String::new(),
            channels: table
                .columns
                .iter()
                .filter(|column| !column.is_text())
                .map(|column| Rule {
                    channel: column.name.clone(),
                    place: place.clone(),
                    expr: Expr::variable(&column.name),
                })
                .collect(),
            keep: None,
            medians: Vec::new(),
            windows: Vec::new(),
            resample: None,
            mass_kg: None,
        })
    }

    /// The map's file; empty for an [identity](Self::identity_for).
    #[must_use]
    pub fn path(&self) -> &str {
        &self.path
    }

    /// What the map says of itself.
    #[must_use]
    pub fn description(&self) -> &str {
        &self.description
    }

    /// The channels that it makes, in its order.
    pub fn channels(&self) -> impl ExactSizeIterator<Item = &str> {
        self.channels.iter().map(|rule| rule.channel.as_str())
    }

    /// The vehicle's mass in kg, if the map tells it.
    #[must_use]
    pub fn mass_kg(&self) -> Option<f64> {
        self.mass_kg
    }
}

/// The text of a map, for telling places in it.
struct Source<'a> {
    path: &'a str,
    text: &'a str,
}

impl Source<'_> {
    fn place(&self, start: usize, key: &str) -> Place {
        let before = self.text.as_bytes().iter().take(start);
        Place {
            map: self.path.to_owned(),
            line: 1 + before.filter(|&&b| b == b'\n').count(),
            key: key.to_owned(),
        }
    }

    fn toml_error(&self, error: &toml::de::Error) -> LogError {
        let start = error.span().map_or(0, |span| span.start);
        let mut at = self.place(start, "");
        // The key that the line sets; the message names a key itself where that is at fault.
        let line = self.text.lines().nth(at.line - 1).unwrap_or_default();
        if let Some((key, _)) = line.split_once('=') {
            at.key = key.trim().to_owned();
        }
        LogError::MapToml {
            at: Box::new(at),
            message: error.message().trim_end().replace('\n', "; "),
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

    fn positive(&self, value: &Spanned<f64>, key: &str) -> Result<f64, LogError> {
        let number = *value.get_ref();
        let good = number > 0.0 && number.is_finite();
        self.check(value, key, good, "a finite number above 0")?;
        Ok(number)
    }

    fn rule(&self, channel: &str, key: &str, text: &Spanned<String>) -> Result<Rule, LogError> {
        let place = self.place(text.span().start, key);
        match Expr::parse(text.get_ref()) {
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
        channels: &BTreeMap<String, Spanned<String>>,
    ) -> Result<Filter, LogError> {
        let keep = filter
            .keep
            .as_ref()
            .map(|text| self.rule("", "filter.keep", text))
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
