//! Message formats of ULog: text such as `esc_status:uint64_t timestamp;esc_report[8] esc;`.

use crate::limits::NameBudget;
use crate::topics::fields::make_unique;
use crate::topics::sink::Scalar;
use std::collections::HashMap;

/// Deepest nesting of messages in messages.
const DEEPEST: usize = 16;
/// Most fields and nested messages of one topic; a message has at most 65 535 bytes.
const MOST_FIELDS: usize = 1 << 16;

/// Most bytes of formats of one log.
const MOST_BYTES: usize = 2 << 20;

/// Formats by name, as text.
#[derive(Debug, Default)]
pub(super) struct Formats {
    known: HashMap<String, Vec<Field>>,
    bytes: usize,
}

#[derive(Debug)]
struct Field {
    name: String,
    kind: String,
    /// `None` for a single value.
    length: Option<usize>,
}

/// Places of the numbers of a message, counted from the first byte after the message's number.
#[derive(Debug, Default)]
pub(super) struct Places {
    pub(super) names: Vec<String>,
    pub(super) places: Vec<(Scalar, usize)>,
    /// Bytes of a message, with and without the optional padding at its end.
    pub(super) longest: usize,
    pub(super) shortest: usize,
    /// Where the stamp is.
    pub(super) stamp: Option<usize>,
}

impl Formats {
    /// Adds a definition, or returns its error.
    pub(super) fn define(&mut self, text: &[u8]) -> Result<(), &'static str> {
        let text = std::str::from_utf8(text).map_err(|_| "a format that is no text")?;
        let (name, fields) = text.split_once(':').ok_or("a format without a name")?;
        if name.is_empty() || name.bytes().any(|b| b.is_ascii_control()) {
            return Err("a format without a name");
        }
        let fields = fields.split(';').filter(|field| !field.is_empty());
        let fields: Option<Vec<Field>> = fields.map(parse_field).collect();
        let fields = fields.ok_or("a format whose fields cannot be read")?;
        let bytes = self.bytes + text.len();
        if bytes > MOST_BYTES {
            return Err("one format too many");
        }
        self.bytes = bytes;
        self.known.insert(name.to_owned(), fields);
        Ok(())
    }

    /// The places of all numbers of a message; `None` for unknown, circular or oversize formats,
    /// and for those beyond the limits of names.
    pub(super) fn flatten(&self, name: &str, budget: &mut NameBudget) -> Option<Places> {
        let mut places = Places::default();
        let mut left = MOST_FIELDS;
        let fields = self.known.get(name)?;
        for (index, field) in fields.iter().enumerate() {
            let last = index + 1 == fields.len();
            if last && field.name.starts_with("_padding") {
                let size = scalar(&field.kind)?.size();
                places.longest += size * field.length.unwrap_or(1);
            } else {
                self.push(&mut places, "", field, DEEPEST, (&mut left, budget))?;
                places.shortest = places.longest;
            }
        }
        let stamp = places.names.iter().position(|name| name == "timestamp");
        places.stamp = stamp
            .map(|at| places.places[at])
            .filter(|(kind, _)| *kind == Scalar::U64)
            .map(|(_, offset)| offset);
        make_unique(&mut places.names);
        (places.longest <= usize::from(u16::MAX) - 2).then_some(places)
    }

    fn push(
        &self,
        places: &mut Places,
        prefix: &str,
        field: &Field,
        depth: usize,
        (left, budget): (&mut usize, &mut NameBudget),
    ) -> Option<()> {
        for index in 0..field.length.unwrap_or(1) {
            *left = left.checked_sub(1)?;
            budget.node()?;
            let name = match field.length {
                Some(_) => format!("{prefix}{}[{index}]", field.name),
                None => format!("{prefix}{}", field.name),
            };
            if let Some(scalar) = scalar(&field.kind) {
                if !field.name.starts_with("_padding") {
                    budget.name(&name)?;
                    places.names.push(name);
                    places.places.push((scalar, places.longest));
                }
                places.longest += scalar.size();
                continue;
            }
            let depth = depth.checked_sub(1)?;
            let prefix = format!("{name}.");
            for inner in self.known.get(&field.kind)? {
                self.push(places, &prefix, inner, depth, (left, budget))?;
            }
        }
        Some(())
    }
}

fn parse_field(text: &str) -> Option<Field> {
    let (kind, name) = text.split_once(' ')?;
    let (kind, length) = match kind.split_once('[') {
        None => (kind, None),
        Some((kind, length)) => {
            let length: usize = length.strip_suffix(']')?.parse().ok()?;
            (kind, Some((length <= MOST_FIELDS).then_some(length)?))
        }
    };
    let good =
        |text: &str| !text.is_empty() && !text.contains(|c: char| c == ' ' || c.is_control());
    (good(kind) && good(name)).then(|| Field {
        name: name.to_owned(),
        kind: kind.to_owned(),
        length,
    })
}

/// A character is the number of its byte.
fn scalar(kind: &str) -> Option<Scalar> {
    Some(match kind {
        "int8_t" => Scalar::I8,
        "uint8_t" | "char" => Scalar::U8,
        "int16_t" => Scalar::I16,
        "uint16_t" => Scalar::U16,
        "int32_t" => Scalar::I32,
        "uint32_t" => Scalar::U32,
        "int64_t" => Scalar::I64,
        "uint64_t" => Scalar::U64,
        "float" => Scalar::F32,
        "double" => Scalar::F64,
        "bool" => Scalar::Bool,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn formats(texts: &[&str]) -> Formats {
        let mut formats = Formats::default();
        for text in texts {
            formats.define(text.as_bytes()).unwrap();
        }
        formats
    }

    #[test]
    fn analytic_places_of_a_nested_message() {
        let formats = formats(&[
            "esc:uint64_t timestamp;int16_t rpm;uint8_t[2] _padding0;",
            "all:uint64_t timestamp;esc[2] esc;bool ok;uint8_t[3] _padding0;",
        ]);
        let places = formats.flatten("all", &mut NameBudget::default()).unwrap();
        assert_eq!(
            places.names,
            [
                "timestamp",
                "esc[0].timestamp",
                "esc[0].rpm",
                "esc[1].timestamp",
                "esc[1].rpm",
                "ok"
            ]
        );
        // Padding inside of a message is there, that at its end need not be.
        let offsets: Vec<usize> = places.places.iter().map(|&(_, at)| at).collect();
        assert_eq!(offsets, [0, 8, 16, 20, 28, 32]);
        assert_eq!((places.shortest, places.longest), (33, 36));
        assert_eq!(places.stamp, Some(0));
    }

    #[test]
    fn prop_formats_without_end_are_refused() {
        let mut formats = Formats::default();
        let rest = "int8_t x;".repeat(7000);
        let kept = (0..300)
            .take_while(|i| formats.define(format!("f{i}:{rest}").as_bytes()).is_ok())
            .count();
        // So many of 63 kB are 2 MiB.
        assert_eq!(kept, 33);
        // What was told before is known still.
        assert!(formats.flatten("f0", &mut NameBudget::default()).is_some());
    }

    #[test]
    fn prop_circular_and_oversize_formats_are_refused() {
        let circular = formats(&["a:b[2] x;", "b:a y;"]);
        assert!(circular.flatten("a", &mut NameBudget::default()).is_none());
        let empty = formats(&["a:b[60000] x;", "b:c[60000] x;", "c:d[60000] x;", "d:"]);
        assert!(empty.flatten("a", &mut NameBudget::default()).is_none());
        assert!(
            formats(&["a:uint64_t[9000] x;"])
                .flatten("a", &mut NameBudget::default())
                .is_none()
        );
        assert!(
            formats(&["a:unknown x;"])
                .flatten("a", &mut NameBudget::default())
                .is_none()
        );
        let long = formats(&[&format!("a:int8_t {};", "n".repeat(600))]);
        assert!(long.flatten("a", &mut NameBudget::default()).is_none());
        for text in [
            "a",
            ":int8_t x;",
            "a:int8_t;",
            "a:int8_t[x] x;",
            "a:int8_t[-1] x;",
        ] {
            assert!(
                Formats::default().define(text.as_bytes()).is_err(),
                "{text}"
            );
        }
    }
}
