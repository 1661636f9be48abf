//! A card as source code for a flight computer: C99 without dependencies, a Rust constant, or a
//! constant for the settings of `touchdown-ffi`.
//!
//! The C code holds the operations of `touchdown-flight` one by one, with the elementary
//! functions that it uses, so that compilers that do not contract products and sums
//! (`-ffp-contract=off`) give the same bits. Recorded vectors and a `make test` beside it show
//! that. It has no recursion, no heap and no unbounded loop, and in single precision no
//! double. [`export_vertical`] writes the vertical controller in the same way, beside its models.

mod c;
mod comment;
mod flying;
mod rust;
mod settings;
mod vectors;
mod vertical;

use touchdown_flight::Real;

use crate::card::Card;
use crate::error::CardError;
use flying::FlyingModel;

pub use vertical::{VERTICAL_NAME, export_vertical};

/// The language of an export.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Language {
    /// C99.
    C,
    /// Rust, `no_std`, for `touchdown-flight`.
    Rust,
    /// A constant for the settings of `touchdown-ffi`, which is in single precision.
    CSettings,
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
/// A card that does not fly ([`Card::thrust_model`], [`Card::ground_effect`]), or settings in double
/// precision.
pub fn export(
    card: &Card,
    language: Language,
    precision: Precision,
) -> Result<Vec<ExportedFile>, CardError> {
    match (language, precision) {
        (Language::CSettings, Precision::Single) => {
            let model = FlyingModel::of(card)?;
            let name = identifier(&card.name);
            Ok(vec![settings::file(card, &model, &name)])
        }
        (Language::CSettings, Precision::Double) => Err(CardError::NotForFlight {
            card: card.name.clone(),
            reason: "touchdown-ffi flies in single precision; export its settings in f32".into(),
        }),
        (Language::C, Precision::Single) => c_files::<f32>(card),
        (Language::C, Precision::Double) => c_files::<f64>(card),
        (Language::Rust, Precision::Single) => rust_file::<f32>(card),
        (Language::Rust, Precision::Double) => rust_file::<f64>(card),
    }
}

/// Whether [`export`] takes a card: whether a model of it flies.
///
/// # Errors
/// A card that does not fly, with the reason.
pub fn check(card: &Card) -> Result<(), CardError> {
    FlyingModel::<f64>::of(card).map(|_| ())
}

fn c_files<R: Number>(card: &Card) -> Result<Vec<ExportedFile>, CardError> {
    let model = FlyingModel::<R>::of(card)?;
    Ok(c::files(card, &model, &identifier(&card.name)))
}

fn rust_file<R: Number>(card: &Card) -> Result<Vec<ExportedFile>, CardError> {
    let model = FlyingModel::<R>::of(card)?;
    Ok(vec![rust::file(card, &model, &identifier(&card.name))])
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
    one_line
        .replace("*/", "* /")
        .replace("/*", "/ *")
        .replace("??", "? ?")
}

/// Names that would be those of functions of the exported code, or whose header would hide another: those of C99, of
/// `touchdown-ffi` and of the vertical controller.
const TAKEN: &str = "
    air deck family library main near touchdown vertical
    assert complex ctype errno features fenv float inttypes iso646 limits locale math memory setjmp signal stdalign stdarg
    stdatomic stdbool stddef stdint stdio stdlib stdnoreturn string strings tgmath threads time uchar wchar wctype";

/// A name as an identifier of C and Rust and as a file name. One that is taken gets `_model` behind it.
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
    // A run of `_` is reserved in C++.
    let parts: Vec<&str> = plain.split('_').filter(|part| !part.is_empty()).collect();
    let name = sindy_expr::code_identifier(&parts.join("_"));
    let taken = TAKEN.split_ascii_whitespace().any(|word| word == name);
    if taken || name.ends_with("_t") || name.starts_with("td_") {
        name + "_model"
    } else {
        name
    }
}

#[cfg(test)]
mod tests;
