//! Arguments of `touchdown export`.

use std::path::PathBuf;

use clap::builder::PossibleValuesParser;
use clap::{Args, ValueEnum};
use touchdown_flight::Method;
use touchdown_model::export::{Language, Precision};

#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct ExportArgs {
    /// Model cards
    #[arg(required = true, value_name = "CARD")]
    pub(crate) cards: Vec<PathBuf>,
    /// Language: C99 without dependencies, Rust for `touchdown-flight`, or C for `touchdown-ffi`
    #[arg(long, value_enum)]
    pub(crate) to: To,
    /// Precision: f32 for a microcontroller without double precision
    #[arg(long, value_enum, default_value = "f32")]
    pub(crate) precision: Scalar,
    /// Also write the vertical controller of this method, in C99, into the folder `vertical`: from one thrust card with
    /// `vehicle.mass_kg`, and one ground-effect card where the method feeds a model forward
    #[arg(long, value_name = "NAME",
          value_parser = PossibleValuesParser::new(Method::VERTICAL.map(Method::name)))]
    pub(crate) method: Option<String>,
    /// Folder for the code: one folder in it for each card
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
}

/// Language of the code.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum To {
    /// A `.c`, its `.h`, recorded vectors and a Makefile that compares with them
    C,
    /// A `.rs` with one constant
    Rust,
    /// A `.h` with one constant for the settings in `touchdown.h`; f32 only
    CSettings,
}

/// Precision of the code.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum Scalar {
    /// `float`
    F32,
    /// `double`
    F64,
}

impl From<To> for Language {
    fn from(to: To) -> Self {
        match to {
            To::C => Self::C,
            To::Rust => Self::Rust,
            To::CSettings => Self::CSettings,
        }
    }
}

impl From<Scalar> for Precision {
    fn from(scalar: Scalar) -> Self {
        match scalar {
            Scalar::F32 => Self::Single,
            Scalar::F64 => Self::Double,
        }
    }
}

const EXAMPLES: &str = "\
Examples (cards of `touchdown identify`; a folder has the name in its card, here `ground-effect-lag`):
  touchdown export thrust.toml models/lag.toml --to c --out firmware
  make -C firmware/ground_effect_lag test
  touchdown export thrust.toml models/lag.toml --to c --method dynamic --out firmware
  make -C firmware/vertical test
  touchdown export thrust.toml models/lag.toml --to c-settings --out firmware
  touchdown export thrust.toml --to rust --precision f64 --out src";
