//! A card as source code for a flight computer: C99 without dependencies, or a Rust constant.
//!
//! The C code holds the operations of `touchdown-flight` one by one, with the elementary
//! functions that it uses, so that compilers that do not contract products and sums
//! (`-ffp-contract=off`) give the same bits. Recorded vectors and a `make test` beside it show
//! that. It has no recursion, no heap and no unbounded loop, and in single precision no
//! double.

mod c;
mod flying;
mod rust;
mod vectors;

use touchdown_flight::Real;

use crate::card::Card;
use crate::error::CardError;
use flying::FlyingModel;

/// The language of an export.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Language {
    /// C99.
    C,
    /// Rust, `no_std`, for `touchdown-flight`.
    Rust,
}

/// The precision of an export.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// `float` and `f32`.
    Single,
    /// `double` and `f64`.
    Double,
}

/// A file of an export.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExportedFile {
    /// Its name.
    pub name: String,
    /// Its text.
    pub text: String,
}

/// The files of a card's export.
///
/// # Errors
/// A card that does not fly ([`Card::thrust_model`], [`Card::ground_effect`]).
pub fn export(
    card: &Card,
    language: Language,
    precision: Precision,
) -> Result<Vec<ExportedFile>, CardError> {
    match precision {
        Precision::Single => files::<f32>(card, language),
        Precision::Double => files::<f64>(card, language),
    }
}

fn files<R: Number>(card: &Card, language: Language) -> Result<Vec<ExportedFile>, CardError> {
    let model = FlyingModel::<R>::of(card)?;
    let name = identifier(&card.name);
    Ok(match language {
        Language::C => c::files(card, &model, &name),
        Language::Rust => vec![rust::file(card, &model, &name)],
    })
}

/// A scalar as source code.
trait Number: Real {
    /// The type in C and in Rust.
    const TYPES: [&'static str; 2];
    /// The ending of functions of C's mathematical library.
    const ENDING: &'static str;
    /// Bits of the number.
    fn bits(self) -> u64;
    /// The shortest text that reads back to the same bits, in Rust's syntax.
    fn text(self) -> String;
    /// The number as a literal of C.
    fn literal(self) -> String {
        format!("{}{}", self.text(), Self::ENDING)
    }
}

impl Number for f32 {
    const TYPES: [&'static str; 2] = ["float", "f32"];
    const ENDING: &'static str = "f";

    fn bits(self) -> u64 {
        u64::from(self.to_bits())
    }

    fn text(self) -> String {
        format!("{self:?}")
    }
}

impl Number for f64 {
    const TYPES: [&'static str; 2] = ["double", "f64"];
    const ENDING: &'static str = "";

    fn bits(self) -> u64 {
        self.to_bits()
    }

    fn text(self) -> String {
        format!("{self:?}")
    }
}

/// A card's text for a comment: on one line, and nothing in it ends a comment.
fn in_comment(text: &str) -> String {
    let one_line: String = text
        .chars()
        .map(|c| {
            if c.is_control() || matches!(c, '\u{2028}' | '\u{2029}') {
                ' '
            } else {
                c
            }
        })
        .collect();
    one_line.replace("*/", "* /").replace("/*", "/ *")
}

/// A name as an identifier of C and Rust and as a file name.
fn identifier(name: &str) -> String {
    let plain: String = name
        .chars()
        .map(|c| {
            if c.is_ascii_alphanumeric() {
                c.to_ascii_lowercase()
            } else {
                '_'
            }
        })
        .collect();
    sindy_expr::code_identifier(&plain)
}

#[cfg(test)]
mod tests;
