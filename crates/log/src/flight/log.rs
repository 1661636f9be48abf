use super::extract::{Extractor, Series};
use super::join;
use super::sink::{Loss, ReadError, Sink};
use super::survey::{Survey, Surveyor};
use super::{bag, dataflash, mcap, ulog};
use crate::suggest::nearest;
use crate::{Column, ColumnKind, Findings, LogError, Map, Table};
use serde::Serialize;
use sha2::{Digest, Sha256};
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use touchdown_trial::TIME_CHANNEL;

/// Bytes at the start of a file by which its format is told.
const LOOK: usize = 64;

/// The formats of logs with topics.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum LogFormat {
    /// PX4's ULog.
    Ulog,
    /// ArduPilot's DataFlash log.
    DataFlash,
    /// MCAP, of ROS 1, ROS 2 or JSON.
    Mcap,
    /// A bag of ROS 1.
    Rosbag,
}

impl LogFormat {
    /// The format's usual name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ulog => "PX4 ULog",
            Self::DataFlash => "ArduPilot DataFlash log",
            Self::Mcap => "MCAP recording",
            Self::Rosbag => "ROS 1 bag",
        }
    }

    /// What stamps count from.
    const fn zero(self) -> &'static str {
        match self {
            Self::Ulog => "the start of the log",
            Self::DataFlash => "the start of the vehicle",
            Self::Mcap | Self::Rosbag => "the first message",
        }
    }

    /// The format of a file that starts so.
    #[must_use]
    pub fn of(start: &[u8]) -> Option<Self> {
        if start.starts_with(&ulog::MAGIC) {
            Some(Self::Ulog)
        } else if start.starts_with(&dataflash::MAGIC) {
            Some(Self::DataFlash)
        } else if start.starts_with(&mcap::MAGIC) {
            Some(Self::Mcap)
        } else if start.starts_with(&bag::MAGIC) {
            Some(Self::Rosbag)
        } else {
            None
        }
    }
}

/// A log with topics, opened.
#[derive(Debug, Clone)]
pub struct Log {
    path: String,
    format: LogFormat,
    input: Input,
}

#[derive(Debug, Clone)]
enum Input {
    File(PathBuf),
    Bytes(Vec<u8>),
}

impl Log {
    /// Opens a file if it is a log with topics, whatever its name ends with.
    ///
    /// # Errors
    /// [`LogError::Read`].
    pub fn open(path: impl AsRef<Path>) -> Result<Option<Self>, LogError> {
        let file = path.as_ref().to_owned();
        let path = file.display().to_string();
        let mut start = Vec::new();
        let read = File::open(&file).and_then(|f| f.take(LOOK as u64).read_to_end(&mut start));
        if let Err(source) = read {
            return Err(LogError::Read { path, source });
        }
        Ok(LogFormat::of(&start).map(|format| Self {
            path,
            format,
            input: Input::File(file),
        }))
    }

    /// As [`open`](Self::open) for bytes in memory; `path` names them.
    #[must_use]
    pub fn from_bytes(path: &str, bytes: Vec<u8>) -> Option<Self> {
        LogFormat::of(&bytes).map(|format| Self {
            path: path.to_owned(),
            format,
            input: Input::Bytes(bytes),
        })
    }

    /// Its format.
    #[must_use]
    pub fn format(&self) -> LogFormat {
        self.format
    }

    /// The path as it was given.
    #[must_use]
    pub fn path(&self) -> &str {
        &self.path
    }

    /// Reads the whole log and tells what it holds, in memory that does not grow with the log.
    ///
    /// # Errors
    /// [`LogError::Read`] or [`LogError::NotALog`].
    pub fn survey(&self) -> Result<(Survey, Findings), LogError> {
        self.look(true)
    }

    /// As [`survey`](Self::survey) without the values of fields, the rates and the gaps.
    ///
    /// # Errors
    /// As [`survey`](Self::survey).
    pub fn outline(&self) -> Result<(Survey, Findings), LogError> {
        self.look(false)
    }

    fn look(&self, deep: bool) -> Result<(Survey, Findings), LogError> {
        let mut surveyor = Surveyor::new(deep);
        let loss = self.read(&mut surveyor)?;
        let mut findings = self.findings(&loss);
        findings.warnings.extend(surveyor.warnings());
        let survey = surveyor.finish(&self.path, self.format, self.format.zero().to_owned());
        findings.rows_read = survey.messages();
        findings.rows_used = findings.rows_read;
        if findings.rows_read == 0 {
            return Err(LogError::NoUsableRows {
                path: self.path.clone(),
                reason: format!("a {} without a message", self.format.name()),
            });
        }
        Ok((survey, findings))
    }

    /// The columns that a map names, brought to the stamps of its clock: one row for each message
    /// of that topic, `time_s` beside.
    ///
    /// # Errors
    /// [`LogError::UnknownColumn`] where there is no such topic or field, [`LogError::MapValue`]
    /// for a clock that is none, and those of [`survey`](Self::survey).
    pub fn table(&self, map: &Map, survey: &Survey) -> Result<(Table, Findings), LogError> {
        let mut wanted: BTreeMap<String, Vec<String>> = BTreeMap::new();
        let mut columns: Vec<(String, String, String)> = Vec::new();
        for name in map.inputs() {
            let Some((topic, field)) = survey.resolve(name) else {
                continue;
            };
            columns.push((name.to_owned(), topic.clone(), field.clone()));
            let fields = wanted.entry(topic).or_default();
            if !fields.contains(&field) {
                fields.push(field);
            }
        }
        let mut findings = Findings::default();
        let clock = clock(map, survey, wanted.keys(), &mut findings)?;
        wanted.entry(clock.clone()).or_default();

        let mut extractor = Extractor::new(&wanted);
        let loss = self.read(&mut extractor)?;
        let mut series = extractor.finish();
        findings = self.findings(&loss).then(findings);
        let (mut clock_s, mut joins) = (Vec::new(), BTreeMap::new());
        for (key, series) in &mut series {
            let offset_s = map.offset_s(key);
            series.time_s.iter_mut().for_each(|t| *t += offset_s);
            let repairs = join::repair(series, *key == clock);
            warn(&mut findings, key, series, repairs);
            let (how, limit) = map.join(key);
            let usual = || join::usual_limit_s(&series.time_s);
            joins.insert(key.clone(), (how, limit.unwrap_or_else(usual)));
            if *key == clock {
                clock_s.clone_from(&series.time_s);
            }
        }
        let mut table = Table {
            path: self.path.clone(),
            sha256: self.sha256()?,
            row_numbers: (0..clock_s.len()).collect(),
            columns: Vec::new(),
        };
        for (name, topic, field) in columns {
            let Some(source) = series.get(&topic) else {
                continue;
            };
            let place = wanted[&topic].iter().position(|known| *known == field);
            let values = &source.columns[place.unwrap_or(0)];
            let values = if topic == clock {
                values.clone()
            } else {
                let (how, limit_s) = joins[&topic];
                join::join(&source.time_s, values, &clock_s, how, limit_s)
            };
            table.columns.push(number_column(name, values));
        }
        if table.column(TIME_CHANNEL).is_none() {
            table
                .columns
                .push(number_column(TIME_CHANNEL.to_owned(), clock_s));
        }
        findings.rows_read = table.len();
        findings.rows_used = table.len();
        Ok((table, findings))
    }

    fn findings(&self, loss: &Loss) -> Findings {
        let mut findings = Findings {
            corrupt_rows: loss.corrupt + loss.undecodable,
            truncated: loss.truncated,
            warnings: loss.notes.clone(),
            ..Findings::default()
        };
        if loss.truncated {
            let text = "the file breaks off inside of a record; all before it is used".to_owned();
            findings.warnings.push(text);
        }
        if loss.corrupt > 0 {
            findings.warnings.push(format!(
                "{} damaged stretches were passed over, {} bytes in all",
                loss.corrupt, loss.skipped_bytes
            ));
        }
        if loss.undecodable > 0 {
            findings.warnings.push(format!(
                "{} messages do not fit their definition and were dropped",
                loss.undecodable
            ));
        }
        findings
    }

    fn read(&self, sink: &mut dyn Sink) -> Result<Loss, LogError> {
        let read = match &self.input {
            Input::Bytes(bytes) => self.dispatch(bytes.as_slice(), sink),
            Input::File(file) => match File::open(file) {
                Ok(file) => self.dispatch(file, sink),
                Err(error) => Err(ReadError::Io(error)),
            },
        };
        read.map_err(|error| {
            let path = self.path.clone();
            match error {
                ReadError::Io(source) => LogError::Read { path, source },
                ReadError::Broken(found) => LogError::NotALog { path, found },
            }
        })
    }

    fn dispatch(&self, input: impl Read, sink: &mut dyn Sink) -> Result<Loss, ReadError> {
        match self.format {
            LogFormat::Ulog => ulog::read(input, sink),
            LogFormat::DataFlash => dataflash::read(input, sink),
            LogFormat::Mcap => mcap::read(input, sink),
            LogFormat::Rosbag => bag::read(input, sink),
        }
    }

    /// SHA-256 of the file's bytes in lower-case hexadecimal.
    ///
    /// # Errors
    /// [`LogError::Read`].
    pub fn sha256(&self) -> Result<String, LogError> {
        let digest = match &self.input {
            Input::Bytes(bytes) => hex_digest(bytes.as_slice()),
            Input::File(file) => File::open(file).and_then(hex_digest),
        };
        digest.map_err(|source| LogError::Read {
            path: self.path.clone(),
            source,
        })
    }
}

/// SHA-256 of all that can be read.
pub(super) fn hex_digest(mut input: impl Read) -> io::Result<String> {
    let mut hash = Sha256::new();
    let mut block = vec![0; 1 << 18];
    loop {
        match input.read(&mut block) {
            Ok(0) => break,
            Ok(read) => hash.update(&block[..read]),
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(hash.finalize().iter().map(|b| format!("{b:02x}")).collect())
}

pub(super) fn number_column(name: String, values: Vec<f64>) -> Column {
    let kind = ColumnKind::Number;
    Column { name, kind, values }
}

/// The topic whose stamps are the rows: the first that the map names and the log has; without
/// one in the map, that with most messages among the topics in use.
fn clock<'a>(
    map: &Map,
    survey: &Survey,
    used: impl Iterator<Item = &'a String>,
    findings: &mut Findings,
) -> Result<String, LogError> {
    let Some((place, clocks)) = map.clocks() else {
        let used: BTreeSet<&String> = used.collect();
        let most = survey
            .topics
            .iter()
            .filter(|topic| used.is_empty() || used.contains(&topic.key))
            .max_by_key(|topic| topic.messages);
        let key = most.map(|topic| topic.key.clone()).unwrap_or_default();
        let text = format!("the map names no clock; the rows are the messages of {key}");
        findings.warnings.push(text);
        return Ok(key);
    };
    let found = clocks.iter().find_map(|name| survey.topic_like(name));
    found.map(|topic| topic.key.clone()).ok_or_else(|| {
        let keys: Vec<&str> = survey.topics.iter().map(|t| t.key.as_str()).collect();
        let near = clocks
            .first()
            .and_then(|name| nearest(name, keys.iter().copied()));
        LogError::MapValue {
            at: Box::new(place.clone()),
            expected: match near {
                Some(near) => format!("a topic of {} (did you mean {near:?}?)", survey.path),
                None => format!("a topic of {}, one of {}", survey.path, keys.join(", ")),
            },
            found: clocks.join(", "),
        }
    })
}

fn warn(findings: &mut Findings, key: &str, series: &Series, repairs: join::Repairs) {
    for (count, what) in [
        (series.absent, "messages without a stamp were left out"),
        (repairs.dropped, "messages out of order were left out"),
        (
            repairs.resets,
            "times the clock was set back; time goes on there",
        ),
    ] {
        if count > 0 {
            findings.warnings.push(format!("{key}: {count} {what}"));
        }
    }
}

impl Survey {
    /// The topic of this key, or the only one whose name ends so after a `/`, as in
    /// `/fmu/out/vehicle_attitude`; with or without a version such as `_v1`.
    pub(super) fn topic_like(&self, key: &str) -> Option<&super::survey::Topic> {
        self.topic(key).or_else(|| {
            let mut alike = self.topics.iter().filter(|topic| {
                let last = topic.key.rsplit('/').next().unwrap_or_default();
                let bare = last.rsplit_once("_v").filter(|(_, version)| {
                    !version.is_empty() && version.bytes().all(|b| b.is_ascii_digit())
                });
                last == key || bare.is_some_and(|(bare, _)| bare == key)
            });
            alike.next().filter(|_| alike.next().is_none())
        })
    }

    /// The topic and the field that a name such as `vehicle_attitude.q[0]` means.
    pub(crate) fn resolve(&self, name: &str) -> Option<(String, String)> {
        name.match_indices('.').rev().find_map(|(dot, _)| {
            let (topic, field) = (self.topic_like(&name[..dot])?, &name[dot + 1..]);
            topic.field(field)?;
            Some((topic.key.clone(), field.to_owned()))
        })
    }

    /// The value that a name such as `param.THR_MDL_FAC` means.
    pub(crate) fn parameter(&self, name: &str) -> Option<f64> {
        self.parameters.get(name.strip_prefix("param.")?).copied()
    }
}
