//! The card's schema, version 1.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
pub use touchdown_flight::ground_effect::{Outside, VelocityInput};

pub use crate::catalogue::Form;

/// The schema version that this crate writes and reads.
pub const SCHEMA: u32 = 1;

/// One model.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Card {
    /// Schema version: [`SCHEMA`].
    pub schema: u32,
    /// A short name, fit for a file name.
    pub name: String,
    /// What is modelled.
    pub kind: Kind,
    /// In which form.
    pub form: Form,
    /// Fitted by us or taken from print.
    pub status: Status,
    /// The model's equation, in words and symbols.
    pub equation: String,
    /// Free text.
    #[serde(default)]
    pub description: String,
    /// What a user must know before relying on it.
    #[serde(default)]
    pub warnings: Vec<String>,
    /// Whether the model's free run leaves the data that it was fitted to. Such a card never flies.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub diverged: bool,
    /// Rotors whose thrust was measured together; absent: all rotors of the vehicle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub measured_rotors: Option<u32>,
    /// The vehicle.
    pub vehicle: Vehicle,
    /// Where it holds, and what happens outside.
    pub validity: Validity,
    /// Fixed numbers that are not fitted, by name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub constants: BTreeMap<String, f64>,
    /// Shorthands used in the terms, as expressions.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub definitions: BTreeMap<String, String>,
    /// What made it.
    pub provenance: Provenance,
    /// The terms.
    pub terms: Vec<Term>,
    /// How well it did.
    #[serde(default)]
    pub scores: Vec<Score>,
}

/// What a card models.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Throttle to thrust.
    Thrust,
    /// Ground-effect force.
    GroundEffect,
}

/// Where a model comes from.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// Fitted by this toolkit to the data named in the provenance.
    Fitted,
    /// Coefficients as printed in a publication.
    Published,
}

/// The vehicle that the model belongs to.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Vehicle {
    /// Its name.
    pub name: String,
    /// Mass (kg).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass_kg: Option<f64>,
    /// Rotor radius (m).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotor_radius_m: Option<f64>,
    /// Number of rotors.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotors: Option<u32>,
    /// Distance of the rotors' axes from the centre (m).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub arm_m: Option<f64>,
}

impl Vehicle {
    /// The first value out of range: its key, what it must be, and what was found.
    #[must_use]
    pub fn fault(&self) -> Option<(&'static str, &'static str, String)> {
        for (key, value) in [
            ("vehicle.mass_kg", self.mass_kg),
            ("vehicle.rotor_radius_m", self.rotor_radius_m),
            ("vehicle.arm_m", self.arm_m),
        ] {
            if let Some(v) = value.filter(|v| !(*v > 0.0 && v.is_finite())) {
                return Some((key, "a finite number above 0", v.to_string()));
            }
        }
        (self.rotors == Some(0)).then(|| ("vehicle.rotors", "at least 1", "0".to_string()))
    }
}

/// The box in which the model was trained or is known to hold.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Validity {
    /// Range of each input by its symbol, `[min, max]`.
    #[serde(default)]
    pub inputs: BTreeMap<String, [f64; 2]>,
    /// Range of the output, `[min, max]`, to which it is limited in flight.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub output: Option<[f64; 2]>,
    /// What a ground-effect model does above the box of heights; below it the least height is used. The other
    /// ranges are a record of the data, not a limit.
    #[serde(default)]
    pub outside: Outside,
    /// What a ground-effect model is given as the deck's velocity in flight.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocity_input: Option<VelocityInput>,
}

/// What made the model.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Provenance {
    /// Tool and version, or the publication.
    pub source: String,
    /// The command that redoes it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub command: Option<String>,
    /// Seed of the virtual rig.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// SHA-256 of the settings.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub settings_sha256: Option<String>,
    /// How it was solved: method, its settings, and why it stopped.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub method: BTreeMap<String, String>,
    /// The data.
    #[serde(default)]
    pub inputs: Vec<Input>,
}

/// One input file or trial.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Input {
    /// File or trial.
    pub name: String,
    /// SHA-256 of its bytes.
    pub sha256: String,
}

/// One term of the model: `value * expression`, in the part of the model that `of` names.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Term {
    /// The left-hand side or parameter that the term belongs to (`x'`, `h`, `k`, `tau`).
    pub of: String,
    /// The term, `1` for a constant.
    pub expression: String,
    /// Its coefficient.
    pub value: f64,
    /// Standard error of the coefficient.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub std_error: Option<f64>,
    /// 95 % confidence interval of the coefficient, `[low, high]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ci95: Option<[f64; 2]>,
    /// Unit of the coefficient (`1` for none).
    pub unit: String,
    /// Why the coefficient has no interval, where the data do not determine it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mark: Option<Mark>,
    /// 95 % upper bound of a coefficient that is marked [`Mark::UpperBound`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub upper_bound: Option<f64>,
}

/// Why a coefficient has no interval.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Mark {
    /// Sampling and excitation show no more than an upper bound; the value is the most likely one below it.
    UpperBound,
    /// At a bound of its search: the data do not identify it.
    AtBound,
    /// The fit ended before its minimum.
    NotConverged,
}

impl Mark {
    /// The mark in words.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::UpperBound => "upper bound",
            Self::AtBound => "at its bound",
            Self::NotConverged => "not converged",
        }
    }
}

/// One score.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Score {
    /// Trial or set of trials.
    pub trial: String,
    /// Whether the fit has seen it.
    pub seen: bool,
    /// What is measured (`free_run`, `one_step`, `static`).
    pub kind: String,
    /// Mean absolute error.
    pub mae: f64,
    /// Root mean square error.
    pub rmse: f64,
    /// Largest absolute error.
    pub worst: f64,
    /// Unit of the errors.
    pub unit: String,
}

impl Card {
    /// The coefficient of `expression` in the part `of`; zero where there is no such term.
    #[must_use]
    pub fn coefficient(&self, of: &str, expression: &str) -> f64 {
        self.terms
            .iter()
            .find(|t| t.of == of && t.expression == expression)
            .map_or(0.0, |t| t.value)
    }

    /// The terms of the part `of`.
    pub fn terms_of<'a>(&'a self, of: &'a str) -> impl Iterator<Item = &'a Term> {
        self.terms.iter().filter(move |t| t.of == of)
    }
}
