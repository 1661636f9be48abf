//! Formats of records, which are records themselves.

use crate::topics::fields::make_unique;
use crate::topics::sink::{Scalar, Wanted};

/// Type of a field's bytes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum FieldType {
    Number(Scalar),
    /// A whole number, and its factor to the unit.
    Parts(Scalar, f64),
    /// A floating-point number of 16 bits.
    Half,
    Text(usize),
    /// 32 whole numbers of 16 bits.
    Array,
}

impl FieldType {
    fn of(letter: u8) -> Option<Self> {
        use Scalar::{F32, F64, I8, I16, I32, I64, U8, U16, U32, U64};
        Some(match letter {
            b'b' => Self::Number(I8),
            b'B' | b'M' => Self::Number(U8),
            b'h' => Self::Number(I16),
            b'H' => Self::Number(U16),
            b'i' => Self::Number(I32),
            b'I' => Self::Number(U32),
            b'q' => Self::Number(I64),
            b'Q' => Self::Number(U64),
            b'f' => Self::Number(F32),
            b'd' => Self::Number(F64),
            b'g' => Self::Half,
            b'c' => Self::Parts(I16, 100.0),
            b'C' => Self::Parts(U16, 100.0),
            b'e' => Self::Parts(I32, 100.0),
            b'E' => Self::Parts(U32, 100.0),
            b'L' => Self::Parts(I32, 1e7),
            b'n' => Self::Text(4),
            b'N' => Self::Text(16),
            b'Z' => Self::Text(64),
            b'a' => Self::Array,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::Number(scalar) | Self::Parts(scalar, _) => scalar.size(),
            Self::Half => 2,
            Self::Text(size) => size,
            Self::Array => 64,
        }
    }

    pub(super) fn read(self, bytes: &[u8], at: usize) -> f64 {
        match self {
            Self::Number(scalar) => scalar.read(bytes, at),
            Self::Parts(scalar, to_one) => scalar.read(bytes, at) / to_one,
            Self::Half => half(Scalar::U16.read(bytes, at) as u16),
            Self::Text(_) => f64::NAN,
            Self::Array => Scalar::I16.read(bytes, at),
        }
    }
}

/// The value of a binary16.
fn half(bits: u16) -> f64 {
    let sign = if bits >> 15 == 1 { -1.0 } else { 1.0 };
    let exponent = i32::from(bits >> 10 & 0x1f);
    let fraction = f64::from(bits & 0x3ff);
    sign * match exponent {
        0 => fraction * 2_f64.powi(-24),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        _ => (1.0 + fraction / 1024.0) * 2_f64.powi(exponent - 15),
    }
}

#[derive(Debug)]
pub(super) struct Format {
    pub(super) name: String,
    /// With the head.
    pub(super) length: usize,
    pub(super) names: Vec<String>,
    /// From the first byte after the head.
    pub(super) places: Vec<(FieldType, usize)>,
    pub(super) texts: Vec<String>,
    /// Where the stamp is, and ns to its unit.
    pub(super) stamp: Option<(Scalar, usize, i64)>,
    /// Name, kind and place of each field, also those of text.
    pub(super) fields: Vec<(String, FieldType, usize)>,
    /// A letter of unknown type. The places of this field and of later ones are then unknown.
    pub(super) unknown: Option<char>,
    /// Where the number of the instance is.
    pub(super) instance: Option<usize>,
    pub(super) topics: Vec<(u32, usize, Wanted)>,
}

impl Format {
    /// Reads a format from the bytes after a head; `None` for an impossible format. The format states
    /// the length of its records separately, so unknown letters do not affect other records.
    pub(super) fn parse(body: &[u8]) -> Option<(u8, Self)> {
        let (kind, length) = (*body.first()?, usize::from(*body.get(1)?));
        let (name, letters) = (text(body.get(2..6)?), text(body.get(6..22)?));
        let labels = text(body.get(22..86)?);
        let mut labels = labels.split(',').map(str::trim);
        let mut format = Self {
            name,
            length,
            names: Vec::new(),
            places: Vec::new(),
            texts: Vec::new(),
            stamp: None,
            fields: Vec::new(),
            unknown: None,
            instance: None,
            topics: Vec::new(),
        };
        let mut at = 0;
        for (index, letter) in letters.bytes().enumerate() {
            let Some(field) = FieldType::of(letter) else {
                format.unknown = Some(letter.into());
                break;
            };
            let label = labels.next().filter(|label| !label.is_empty());
            let label = label.map_or_else(|| format!("field_{index}"), str::to_owned);
            format.fields.push((label.clone(), field, at));
            match (label.as_str(), field) {
                ("TimeUS", FieldType::Number(scalar)) => {
                    format.stamp.get_or_insert((scalar, at, 1000));
                }
                // Older firmware: `TimeMS` of a receiver is that of its week, and `T` the vehicle's.
                ("T", FieldType::Number(scalar))
                    if format.name.starts_with("GPS")
                        && format.stamp.is_some_and(|(.., to_ns)| to_ns == 1_000_000) =>
                {
                    format.stamp = Some((scalar, at, 1_000_000));
                }
                ("TimeMS", FieldType::Number(scalar)) => {
                    format.stamp.get_or_insert((scalar, at, 1_000_000));
                }
                _ => {}
            }
            match field {
                FieldType::Text(_) => format.texts.push(label),
                FieldType::Array => {
                    for k in 0..32 {
                        format.names.push(format!("{label}[{k}]"));
                        format.places.push((field, at + 2 * k));
                    }
                }
                _ => {
                    format.names.push(label);
                    format.places.push((field, at));
                }
            }
            at += field.size();
        }
        make_unique(&mut format.names);
        make_unique(&mut format.texts);
        let named = !format.name.is_empty();
        let fits = match format.unknown {
            Some(_) => format.length > at + 3,
            None => format.length == at + 3,
        };
        (named && fits).then_some((kind, format))
    }

    /// Type and place of a field.
    pub(super) fn field(&self, name: &str) -> Option<(FieldType, usize)> {
        let mut fields = self.fields.iter();
        fields.find_map(|&(ref known, kind, at)| (known == name).then_some((kind, at)))
    }

    /// The bytes of a field of text.
    pub(super) fn bytes<'a>(&self, name: &str, body: &'a [u8]) -> Option<&'a [u8]> {
        match self.field(name)? {
            (FieldType::Text(size), at) => body.get(at..at + size),
            _ => None,
        }
    }
}

/// Text up to the first NUL.
pub(super) fn text(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|&b| b == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(&bytes[..end]).trim().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_half_precision() {
        for (bits, value) in [
            (0x3c00, 1.0),
            (0xc000, -2.0),
            (0x7bff, 65504.0),
            (0x0001, 2_f64.powi(-24)),
            (0x3555, 0.333_251_953_125),
            (0x7c00, f64::INFINITY),
        ] {
            assert_eq!(half(bits), value, "{bits:x}");
        }
        assert!(half(0x7e00).is_nan());
    }

    #[test]
    fn prop_a_format_must_agree_with_its_length() {
        let mut body = [0; 86];
        body[..2].copy_from_slice(&[9, 3 + 8 + 2]);
        body[2..5].copy_from_slice(b"ABC");
        body[6..8].copy_from_slice(b"Qc");
        body[22..31].copy_from_slice(b"TimeUS,Tm");
        let (kind, format) = Format::parse(&body).unwrap();
        assert_eq!((kind, format.name.as_str(), format.length), (9, "ABC", 13));
        assert_eq!(format.names, ["TimeUS", "Tm"]);
        body[1] = 2;
        assert!(Format::parse(&body).is_none(), "shorter than its head");
        body[1] = 14;
        assert!(Format::parse(&body).is_none());
        // A letter that is not known costs its field and those behind.
        body[7] = b'?';
        let (_, format) = Format::parse(&body).unwrap();
        assert_eq!((format.length, format.unknown), (14, Some('?')));
        assert_eq!(format.names, ["TimeUS"]);
        assert_eq!(format.stamp, Some((Scalar::U64, 0, 1000)));
        body[1] = 3 + 8;
        assert!(Format::parse(&body).is_none(), "no room for the field");
    }
}
