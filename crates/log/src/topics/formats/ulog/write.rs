use super::format::Formats;
use super::{MAGIC, SYNC};
use crate::limits::NameBudget;
use std::io::{self, Write};

/// Messages between two marks at which a reader of a damaged log can go on.
const MARKED_EVERY: usize = 500;

/// Writes a ULog: formats and parameters first, then topics and their messages.
///
/// ```
/// use touchdown_log::{Log, UlogWriter};
///
/// let mut writer = UlogWriter::new(Vec::new(), 1_000_000)?;
/// writer.format("vehicle_acceleration", "float[3] xyz")?;
/// writer.parameter("THR_MDL_FAC", 0.3)?;
/// let topic = writer.topic("vehicle_acceleration", 0)?;
/// writer.message(topic, 1_004_000, &[0.0, 0.0, -9.81])?;
/// let log = Log::from_bytes("made.ulg", writer.finish()?).unwrap();
/// let (survey, _) = log.survey()?;
/// assert_eq!(survey.topics[0].first_s, Some(0.004));
/// assert_eq!(survey.topics[0].field("xyz[2]").unwrap().min, Some(f64::from(-9.81_f32)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct UlogWriter<W> {
    out: W,
    formats: Formats,
    topics: Vec<super::Places>,
    messages: usize,
    buffer: Vec<u8>,
}

/// A topic of a [`UlogWriter`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct UlogTopic(u16);

fn invalid(what: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, what)
}

impl<W: Write> UlogWriter<W> {
    /// A log that starts at this time, in µs.
    ///
    /// # Errors
    /// What `out` refuses.
    pub fn new(mut out: W, start_us: u64) -> io::Result<Self> {
        out.write_all(&MAGIC)?;
        out.write_all(&[1])?;
        out.write_all(&start_us.to_le_bytes())?;
        let mut writer = Self {
            out,
            formats: Formats::default(),
            topics: Vec::new(),
            messages: 0,
            buffer: Vec::new(),
        };
        writer.put(b'B', &[0; 40])?;
        Ok(writer)
    }

    /// Defines the fields of topics of this name, such as `float[3] xyz;uint8_t valid`. The writer adds
    /// the stamp before them.
    ///
    /// # Errors
    /// [`io::ErrorKind::InvalidInput`] for fields that cannot be read, and once there are topics.
    pub fn format(&mut self, name: &str, fields: &str) -> io::Result<()> {
        let text = format!(
            "{name}:uint64_t timestamp;{};",
            fields.trim_end_matches(';')
        );
        if !self.topics.is_empty() {
            return Err(invalid(format!("format {name:?} after the first topic")));
        }
        let defined = self.formats.define(text.as_bytes());
        defined.map_err(|what| invalid(format!("{what}: {text}")))?;
        self.put(b'F', text.as_bytes())
    }

    /// Writes a parameter of the vehicle.
    ///
    /// # Errors
    /// Errors of the output.
    pub fn parameter(&mut self, name: &str, value: f32) -> io::Result<()> {
        self.keyed(b'P', &format!("float {name}"), &value.to_le_bytes())
    }

    /// Writes a property of the log, such as `sys_name`.
    ///
    /// # Errors
    /// Errors of the output.
    pub fn info(&mut self, name: &str, text: &str) -> io::Result<()> {
        let key = format!("char[{}] {name}", text.len());
        self.keyed(b'I', &key, text.as_bytes())
    }

    fn keyed(&mut self, kind: u8, key: &str, value: &[u8]) -> io::Result<()> {
        let length = u8::try_from(key.len()).map_err(|_| invalid(format!("key {key:?}")))?;
        let body = [&[length][..], key.as_bytes(), value].concat();
        self.put(kind, &body)
    }

    /// Announces a topic whose format is defined.
    ///
    /// # Errors
    /// [`io::ErrorKind::InvalidInput`] without a usable format.
    pub fn topic(&mut self, name: &str, instance: u8) -> io::Result<UlogTopic> {
        let places = self.formats.flatten(name, &mut NameBudget::default());
        let places =
            places.ok_or_else(|| invalid(format!("topic {name:?} has no usable format")))?;
        let number = u16::try_from(self.topics.len())
            .map_err(|_| invalid("more than 65536 topics".to_owned()))?;
        self.topics.push(places);
        let body = [&[instance][..], &number.to_le_bytes(), name.as_bytes()].concat();
        self.put(b'A', &body)?;
        Ok(UlogTopic(number))
    }

    /// Writes a message: a value for each number of the format, stamps left out.
    ///
    /// # Errors
    /// [`io::ErrorKind::InvalidInput`] for another number of values.
    pub fn message(&mut self, topic: UlogTopic, stamp_us: u64, values: &[f64]) -> io::Result<()> {
        let mut body = std::mem::take(&mut self.buffer);
        body.clear();
        let places = &self.topics[usize::from(topic.0)];
        if values.len() + 1 != places.places.len() {
            let expected = places.places.len() - 1;
            return Err(invalid(format!(
                "expected {expected} values, found {}",
                values.len()
            )));
        }
        body.extend(topic.0.to_le_bytes());
        body.resize(2 + places.shortest, 0);
        body[2..10].copy_from_slice(&stamp_us.to_le_bytes());
        for (&(scalar, at), &value) in places.places[1..].iter().zip(values) {
            scalar.write(&mut body[2 + at..], value);
        }
        let written = self.put(b'D', &body);
        self.buffer = body;
        written?;
        self.messages += 1;
        if self.messages.is_multiple_of(MARKED_EVERY) {
            self.put(b'S', &SYNC)?;
        }
        Ok(())
    }

    fn put(&mut self, kind: u8, body: &[u8]) -> io::Result<()> {
        let length = u16::try_from(body.len())
            .map_err(|_| invalid(format!("a record of {} bytes", body.len())))?;
        self.out.write_all(&length.to_le_bytes())?;
        self.out.write_all(&[kind])?;
        self.out.write_all(body)
    }

    /// Ends the log, and returns the output.
    ///
    /// # Errors
    /// Errors of the output.
    pub fn finish(mut self) -> io::Result<W> {
        self.out.flush()?;
        Ok(self.out)
    }
}
