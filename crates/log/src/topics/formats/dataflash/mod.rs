//! Reads ArduPilot's DataFlash logs.
//!
//! A record is `A3 95`, a type and the number of bytes that the format of that type states. Formats
//! are records themselves. A record of unknown type means damage. Reading continues at the next two
//! complete records in succession.

mod format;

use super::stream::Stream;
use super::{LogFormat, Reader};
use crate::limits::NameBudget;
use crate::topics::sink::{Layout, Loss, ReadError, Scalar, Sink, Wanted};
use format::{Format, text};
use std::io::Read;

const HEAD: [u8; 2] = [0xa3, 0x95];
/// The type of the records that define formats, and their length.
const FMT: u8 = 128;
const FMT_LENGTH: usize = 89;
/// First bytes of a file: the format of formats.
const MAGIC: [u8; 3] = [HEAD[0], HEAD[1], FMT];
/// Largest number of topics of one log. Each instance of a type is a topic.
const MOST_TOPICS: usize = 4096;
/// Number of complete records in succession after which reading continues behind damage. With one,
/// random bytes pass too often; more would lose short undamaged parts.
const WHOLE_IN_A_ROW: usize = 2;

struct DataFlash<'s> {
    sink: &'s mut dyn Sink,
    formats: Vec<Option<Format>>,
    topics: usize,
    budget: NameBudget,
    last_ns: Option<i64>,
    values: Vec<f64>,
    loss: Loss,
}

pub(super) const READER: Reader = Reader {
    format: LogFormat::DataFlash,
    name: "ArduPilot DataFlash log",
    magic: &MAGIC,
    stamps_since: "the start of the vehicle",
    maps: &["ardupilot"],
    read,
};

/// Reads a whole log.
fn read(input: &mut dyn Read, sink: &mut dyn Sink) -> Result<Loss, ReadError> {
    let mut stream = Stream::new(input);
    let mut reader = DataFlash {
        sink,
        formats: (0..256).map(|_| None).collect(),
        topics: 0,
        budget: NameBudget::default(),
        last_ns: None,
        values: Vec::new(),
        loss: Loss::default(),
    };
    reader.bootstrap();
    reader.run(&mut stream)?;
    if reader.topics == 0 {
        return Err(ReadError::broken(
            LogFormat::DataFlash,
            "without a whole record",
        ));
    }
    Ok(reader.loss)
}

impl DataFlash<'_> {
    /// The format of formats, known beforehand.
    fn bootstrap(&mut self) {
        let mut body = [0; FMT_LENGTH - 3];
        body[..2].copy_from_slice(&[FMT, FMT_LENGTH as u8]);
        body[2..5].copy_from_slice(b"FMT");
        body[6..11].copy_from_slice(b"BBnNZ");
        body[22..53].copy_from_slice(b"Type,Length,Name,Format,Columns");
        if let Some((of, format)) = Format::parse(&body) {
            self.define(of, format);
        }
    }

    fn run(&mut self, stream: &mut Stream<'_>) -> Result<(), ReadError> {
        while let Some(head) = stream.peek(3)? {
            let Some(length) = self.length(head) else {
                self.resynchronise(stream)?;
                continue;
            };
            let Some(record) = stream.peek(length)? else {
                break;
            };
            let (kind, body) = (record[2], &record[3..]);
            self.take(kind, body);
            self.budget.check()?;
            stream.advance(length);
        }
        let rest = stream.window();
        if rest.starts_with(&HEAD[..rest.len().min(2)]) && !rest.is_empty() {
            self.loss.truncated = true;
            self.loss.skipped_bytes += rest.len() as u64;
        }
        Ok(())
    }

    /// The length of the record with this head.
    fn length(&self, head: &[u8]) -> Option<usize> {
        if head[..2] != HEAD {
            return None;
        }
        match head[2] {
            FMT => Some(FMT_LENGTH),
            kind => self.formats[usize::from(kind)].as_ref().map(|f| f.length),
        }
    }

    /// Skips damage. Zeros at the end of a file do not count as damage.
    fn resynchronise(&mut self, stream: &mut Stream<'_>) -> Result<(), ReadError> {
        let (mut skipped, mut blank) = (0, true);
        loop {
            let filler = stream
                .peek(1)?
                .is_some_and(|byte| byte[0] == 0 || byte[0] == 0xff);
            blank &= filler;
            stream.advance(1);
            skipped += 1;
            let there = stream.fill((WHOLE_IN_A_ROW + 1) * 256)?;
            let window = &stream.window()[..there];
            if window.is_empty() && blank {
                return Ok(());
            }
            if window.is_empty() || self.goes_on(window) {
                self.loss.corrupt += 1;
                self.loss.skipped_bytes += skipped;
                return Ok(());
            }
        }
    }

    fn goes_on(&self, window: &[u8]) -> bool {
        let mut rest = window;
        for row in 0..WHOLE_IN_A_ROW {
            if rest.len() < 3 {
                return row > 0 && rest.is_empty();
            }
            let Some(length) = self.length(rest) else {
                return false;
            };
            let Some(after) = rest.get(length..) else {
                return row > 0;
            };
            rest = after;
        }
        true
    }

    fn take(&mut self, kind: u8, body: &[u8]) {
        if kind == FMT {
            match Format::parse(body) {
                Some((of, format)) => self.define(of, format),
                None => self.loss.undecodable += 1,
            }
        }
        let Some(format) = self.formats[usize::from(kind)].as_mut() else {
            return;
        };
        let read = |&(scalar, at, to_ns): &(Scalar, usize, i64)| {
            (scalar.read(body, at) as i64).saturating_mul(to_ns)
        };
        let stamp_ns = format.stamp.as_ref().map(read).or(self.last_ns);
        self.last_ns = stamp_ns;
        let instance = format.instance.map_or(0, |at| u32::from(body[at]));
        let topic = match format
            .topics
            .iter()
            .position(|(known, ..)| *known == instance)
        {
            Some(at) => at,
            None if self.topics < MOST_TOPICS => {
                let mut names = format.names.iter().chain(&format.texts);
                if names.any(|name| self.budget.name(name).is_none()) {
                    return;
                }
                let layout = Layout {
                    name: format.name.clone(),
                    kind: String::new(),
                    instance,
                    fields: format.names.clone(),
                    texts: format.texts.clone(),
                };
                let wanted = self.sink.topic(self.topics, &layout);
                format.topics.push((instance, self.topics, wanted));
                self.topics += 1;
                format.topics.len() - 1
            }
            None => return,
        };
        let (_, id, wanted) = &format.topics[topic];
        self.values.clear();
        if let Wanted::Fields(fields) = wanted {
            let values = fields.iter().map(|&field| {
                let (kind, at) = format.places[field];
                kind.read(body, at)
            });
            self.values.extend(values);
        }
        self.sink.message(*id, stamp_ns, &self.values);
        match format.name.as_str() {
            "PARM" => self.parameter(kind, body),
            // A record without its fields changes nothing.
            "FMTU" => drop(self.units(kind, body)),
            _ => {}
        }
    }

    fn define(&mut self, of: u8, format: Format) {
        let known = &mut self.formats[usize::from(of)];
        // Some writers repeat a format.
        let same = |old: &Format| {
            (&old.name, &old.names, old.length) == (&format.name, &format.names, format.length)
        };
        if !known.as_ref().is_some_and(same) {
            if let Some(letter) = format.unknown {
                self.loss.note(format!(
                    "{}: fields from number {} on are omitted, because the type {letter:?} is not known",
                    format.name,
                    format.fields.len() + 1
                ));
            }
            *known = Some(format);
        }
    }

    /// `PARM`: name and value. The last fields may be more.
    fn parameter(&mut self, kind: u8, body: &[u8]) {
        let Some(format) = &self.formats[usize::from(kind)] else {
            return;
        };
        let value = format.field("Value").map(|(kind, at)| kind.read(body, at));
        if let (Some(name), Some(value)) = (format.bytes("Name", body), value) {
            self.sink.parameter(&text(name), value);
        }
    }

    /// `FMTU`: the unit `#` marks the field that numbers the instance.
    fn units(&mut self, kind: u8, body: &[u8]) -> Option<()> {
        let own = self.formats[usize::from(kind)].as_ref()?;
        let (_, at) = own.field("FmtType")?;
        let (of, units) = (*body.get(at)?, own.bytes("UnitIds", body)?);
        let format = self.formats[usize::from(of)].as_mut()?;
        let field = units.iter().position(|&unit| unit == b'#');
        let field = field.and_then(|field| format.fields.get(field));
        format.instance = field
            .map(|&(.., at)| at)
            .filter(|&at| at < format.length - 3);
        Some(())
    }
}
