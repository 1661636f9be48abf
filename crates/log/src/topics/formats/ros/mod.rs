//! Messages of ROS, decoded by the definitions in their files.

mod definition;

use crate::limits::NameBudget;
use crate::topics::formats::cursor::Cursor;
use crate::topics::sink::Scalar;
use definition::{Definition, Node, NodeContent};

/// Encoding of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Ros1,
    Cdr,
}

/// Decodes messages of one type.
#[derive(Debug)]
pub(super) struct Message {
    definition: Definition,
    encoding: Encoding,
}

/// Alignment and byte order.
#[derive(Clone, Copy)]
struct Wire {
    /// Most bytes that a number is aligned to; 1 for packed.
    align: usize,
    big: bool,
    encoding: Encoding,
}

impl Message {
    /// Reads the text of a definition; `None` if it cannot be used.
    pub(super) fn new(
        kind: &str,
        text: &str,
        encoding: Encoding,
        budget: &mut NameBudget,
    ) -> Option<Self> {
        let definition = definition::parse(kind, text, encoding == Encoding::Ros1, budget)?;
        Some(Self {
            definition,
            encoding,
        })
    }

    pub(super) fn names(&self) -> &[String] {
        &self.definition.names
    }

    pub(super) fn texts(&self) -> &[String] {
        &self.definition.texts
    }

    /// The numbers of a message, NaN for elements that it lacks; `None` for a message that is truncated
    /// or does not match its definition.
    pub(super) fn decode(&self, bytes: &[u8], values: &mut Vec<f64>) -> Option<()> {
        let mut wire = Wire {
            align: 1,
            big: false,
            encoding: self.encoding,
        };
        let mut body = bytes;
        if self.encoding == Encoding::Cdr {
            let (head, rest) = bytes.split_at_checked(4)?;
            body = rest;
            (wire.align, wire.big) = match head[1] {
                0 => (8, true),
                1 => (8, false),
                // XCDR2 without headers.
                6 => (4, true),
                7 => (4, false),
                _ => return None,
            };
        }
        values.clear();
        values.resize(self.definition.root.width, f64::NAN);
        decode(
            &self.definition.root,
            &mut Cursor::new(body),
            wire,
            Some(values),
        )
    }
}

fn number(scalar: Scalar, cursor: &mut Cursor<'_>, wire: Wire) -> Option<f64> {
    align(cursor, scalar.size(), wire)?;
    let bytes = cursor.take(scalar.size())?;
    if !wire.big {
        return Some(scalar.read(bytes, 0));
    }
    let mut turned = [0; 8];
    let turned = &mut turned[..bytes.len()];
    turned.copy_from_slice(bytes);
    turned.reverse();
    Some(scalar.read(turned, 0))
}

fn align(cursor: &mut Cursor<'_>, size: usize, wire: Wire) -> Option<()> {
    let to = size.min(wire.align).max(1);
    cursor.take((to - cursor.at() % to) % to).map(|_| ())
}

fn decode(node: &Node, cursor: &mut Cursor<'_>, wire: Wire, out: Option<&mut [f64]>) -> Option<()> {
    match &node.kind {
        NodeContent::Scalar(scalar) => {
            let value = number(*scalar, cursor, wire)?;
            if let Some([place, ..]) = out {
                *place = value;
            }
        }
        NodeContent::Text => {
            let length = number(Scalar::U32, cursor, wire)?;
            cursor.take(length as usize)?;
        }
        NodeContent::Message(nodes) => {
            let mut out = out;
            for node in nodes {
                let part = match out.take() {
                    None => None,
                    Some(values) => {
                        let (part, rest) = values.split_at_mut_checked(node.width)?;
                        out = Some(rest);
                        Some(part)
                    }
                };
                decode(node, cursor, wire, part)?;
            }
            if nodes.is_empty() && wire.encoding == Encoding::Cdr {
                cursor.take(1)?;
            }
        }
        NodeContent::Array {
            element,
            length,
            told,
        } => {
            let mut out = out;
            let count = match length {
                Some(length) => *length,
                None => {
                    let length = number(Scalar::U32, cursor, wire)?;
                    // Of any number of elements, each has a byte at least.
                    let left = cursor.rest().len();
                    let length = (length as usize <= left).then_some(length)?;
                    if let Some([.., place]) = out.as_deref_mut() {
                        *place = length;
                    }
                    length as usize
                }
            };
            for k in 0..count {
                if let (true, NodeContent::Scalar(scalar)) = (k >= *told, &element.kind) {
                    align(cursor, scalar.size(), wire)?;
                    return cursor
                        .take((count - k).checked_mul(scalar.size())?)
                        .map(|_| ());
                }
                let part = match &mut out {
                    Some(values) if k < *told => {
                        values.get_mut(k * element.width..(k + 1) * element.width)
                    }
                    _ => None,
                };
                decode(element, cursor, wire, part)?;
            }
        }
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_cdr_is_aligned_and_ros1_is_packed() {
        let text = "uint8 a\nfloat64 b\nstring s\nint16[] c\nuint32 d";
        let mut values = Vec::new();
        // By the rules of CDR 1: numbers are aligned to their size after the head of 4 bytes.
        let mut cdr = vec![0, 1, 0, 0, 7, 0, 0, 0, 0, 0, 0, 0];
        cdr.extend(2.5_f64.to_le_bytes());
        cdr.extend([3, 0, 0, 0, b'h', b'i', 0, 0]);
        cdr.extend([2, 0, 0, 0, 255, 255, 5, 0, 9, 0, 0, 0]);
        let budget = &mut NameBudget::default();
        let message = Message::new("p/M", text, Encoding::Cdr, budget).unwrap();
        message.decode(&cdr, &mut values).unwrap();
        assert_eq!(message.texts(), ["s"]);
        let at = |name: &str| message.names().iter().position(|n| n == name).unwrap();
        assert_eq!(
            (values[at("a")], values[at("b")], values[at("d")]),
            (7.0, 2.5, 9.0)
        );
        assert_eq!(
            (
                values[at("c[0]")],
                values[at("c[1]")],
                values[at("c.length")]
            ),
            (-1.0, 5.0, 2.0)
        );
        assert!(values[at("c[2]")].is_nan());
        for cut in 0..cdr.len() {
            assert!(message.decode(&cdr[..cut], &mut values).is_none(), "{cut}");
        }
        let mut packed = vec![7];
        packed.extend(2.5_f64.to_le_bytes());
        packed.extend([
            2, 0, 0, 0, b'h', b'i', 2, 0, 0, 0, 255, 255, 5, 0, 9, 0, 0, 0,
        ]);
        let message = Message::new("p/M", text, Encoding::Ros1, budget).unwrap();
        message.decode(&packed, &mut values).unwrap();
        assert_eq!(
            (values[at("b")], values[at("c[1]")], values[at("d")]),
            (2.5, 5.0, 9.0)
        );
    }

    #[test]
    fn analytic_big_endian_and_arrays_longer_than_told() {
        let text = "uint16[] x\nint32 y";
        let budget = &mut NameBudget::default();
        let message = Message::new("p/M", text, Encoding::Cdr, budget).unwrap();
        let mut bytes = vec![0, 0, 0, 0, 0, 0, 0, 30];
        for k in 0..30_u16 {
            bytes.extend(k.to_be_bytes());
        }
        bytes.extend((-4_i32).to_be_bytes());
        let mut values = Vec::new();
        message.decode(&bytes, &mut values).unwrap();
        assert_eq!(
            values[..16],
            std::array::from_fn::<f64, 16, _>(|k| k as f64)
        );
        assert_eq!(values[16..], [30.0, -4.0]);
        // A length that the message cannot have.
        bytes[4] = 0xff;
        assert!(message.decode(&bytes, &mut values).is_none());
    }
}
