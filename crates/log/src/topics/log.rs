use super::extract::{Extractor, Series};
use super::formats::LogFormat;
use super::sink::{Loss, ReadError, Sink, short_kind};
use super::survey::{Survey, Surveyor};
use crate::hashing::Hashing;
use crate::{Findings, LogError};
use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Bytes at the start of a file that suffice to recognise its format.
const LOOK: usize = 64;

/// An opened log with topics.
#[derive(Debug, Clone)]
pub struct Log {
    path: String,
    format: LogFormat,
    input: Input,
}

/// Result of one pass over a log.
pub(super) struct Gathered {
    pub(super) survey: Survey,
    /// By the topic's key.
    pub(super) series: BTreeMap<String, Series>,
    pub(super) findings: Findings,
    pub(super) sha256: String,
}

#[derive(Debug, Clone)]
enum Input {
    File(PathBuf),
    Bytes(Vec<u8>),
}

impl Log {
    /// Opens a file if its content is a log with topics. Its name does not matter.
    ///
    /// # Errors
    /// [`LogError::Read`].
    pub fn open(path: impl AsRef<Path>) -> Result<Option<Self>, LogError> {
        let file = path.as_ref().to_owned();
        let path = file.display().to_string();
        let mut start = Vec::new();
        let read =
            touchdown_files::open(&file).and_then(|f| f.take(LOOK as u64).read_to_end(&mut start));
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

    /// Reads the whole log and summarises its content, in bounded memory.
    ///
    /// # Errors
    /// [`LogError::Read`] or [`LogError::NotALog`].
    pub fn survey(&self) -> Result<(Survey, Findings), LogError> {
        let mut surveyor = Surveyor::new(true);
        let (loss, _) = self.read(&mut surveyor, false)?;
        self.surveyed(surveyor, &loss)
    }

    /// The topics, and all columns that the names may mean, in one pass.
    pub(super) fn gather<'a>(
        &self,
        names: impl Iterator<Item = &'a str>,
        clocks: impl Iterator<Item = &'a str>,
    ) -> Result<Gathered, LogError> {
        let mut extractor = Extractor::new(names, clocks, self.bytes()?);
        let (loss, sha256) = self.read(&mut extractor, true)?;
        let (surveyor, series) = extractor.finish();
        let (survey, findings) = self.surveyed(surveyor, &loss)?;
        Ok(Gathered {
            survey,
            series,
            findings,
            sha256,
        })
    }

    /// The size of the log.
    pub(super) fn bytes(&self) -> Result<u64, LogError> {
        match &self.input {
            Input::Bytes(bytes) => Ok(bytes.len() as u64),
            Input::File(file) => {
                let metadata = std::fs::metadata(file).map_err(|source| LogError::Read {
                    path: self.path.clone(),
                    source,
                })?;
                Ok(metadata.len())
            }
        }
    }

    fn surveyed(&self, surveyor: Surveyor, loss: &Loss) -> Result<(Survey, Findings), LogError> {
        let mut findings = self.findings(loss);
        findings.warnings.extend(surveyor.warnings());
        let survey = surveyor.finish(
            &self.path,
            self.format,
            self.format.reader().stamps_since.to_owned(),
        );
        findings.rows_read = survey.messages();
        findings.rows_used = findings.rows_read;
        if findings.rows_read == 0 {
            let mut reason = format!("a {} without a whole message", self.format.name());
            for warning in &findings.warnings {
                reason.push_str(&format!("; {warning}"));
            }
            let path = self.path.clone();
            return Err(LogError::NoUsableRows { path, reason });
        }
        Ok((survey, findings))
    }

    fn findings(&self, loss: &Loss) -> Findings {
        let mut findings = Findings {
            corrupt_rows: loss.corrupt + loss.undecodable,
            truncated: loss.truncated,
            warnings: loss.notes.clone(),
            ..Findings::default()
        };
        if loss.truncated {
            let text = "the file ends inside a record; all records before it are used".to_owned();
            findings.warnings.push(text);
        }
        if loss.corrupt > 0 {
            findings.warnings.push(format!(
                "{} damaged sections were skipped, {} bytes in all",
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

    /// Reads the whole log, and returns its SHA-256 on request.
    fn read(&self, sink: &mut dyn Sink, hashed: bool) -> Result<(Loss, String), LogError> {
        let read = match &self.input {
            Input::Bytes(bytes) => self.dispatch(bytes.as_slice(), sink, hashed),
            Input::File(file) => match touchdown_files::open(file) {
                Ok(file) => self.dispatch(file, sink, hashed),
                Err(error) => Err(ReadError::Io(error)),
            },
        };
        read.map_err(|error| {
            let path = self.path.clone();
            match error {
                ReadError::Io(source) => LogError::Read { path, source },
                ReadError::Broken(found) => LogError::NotALog { path, found },
                ReadError::Excess(excess) => LogError::excess(&path, excess),
            }
        })
    }

    fn dispatch(
        &self,
        input: impl Read,
        sink: &mut dyn Sink,
        hashed: bool,
    ) -> Result<(Loss, String), ReadError> {
        let mut input = Hashing::new(input, hashed);
        let loss = (self.format.reader().read)(&mut input, sink);
        Ok((loss?, input.finish()?))
    }
}

impl Survey {
    /// The topic of a name. It is one of these:
    ///
    /// - the topic with this key;
    /// - the only topic whose name ends with it after a `/`, as in `/fmu/out/vehicle_attitude`, with or
    ///   without a version such as `_v1`;
    /// - the only topic with messages of this type, such as `sensor_msgs/Imu`.
    pub(super) fn topic_like(&self, key: &str) -> Option<&super::survey::Topic> {
        let only = |alike: &dyn Fn(&super::survey::Topic) -> bool| {
            let mut alike = self.topics.iter().filter(|topic| alike(topic));
            alike.next().filter(|_| alike.next().is_none())
        };
        let of_kind = || {
            let kind = short_kind(key);
            only(&|topic| topic.messages > 0 && topic.kind.as_ref() == Some(&kind))
        };
        self.topic(key)
            .or_else(|| only(&|topic| is_named(&topic.key, key)))
            .or_else(of_kind)
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

/// Whether a map may mean the topic of this key and type by a name.
pub(super) fn is_alike(key: &str, kind: &str, name: &str) -> bool {
    is_named(key, name) || !kind.is_empty() && kind == short_kind(name)
}

fn is_named(key: &str, name: &str) -> bool {
    let last = key.rsplit('/').next().unwrap_or_default();
    let bare = last
        .rsplit_once("_v")
        .filter(|(_, version)| !version.is_empty() && version.bytes().all(|b| b.is_ascii_digit()));
    let ends = key.strip_suffix(name);
    ends.is_some_and(|before| before.is_empty() || before.ends_with('/'))
        || bare.is_some_and(|(bare, _)| bare == name)
}
