//! What every fit hands over: a card, and what a report wants to say beside it.

use std::collections::BTreeMap;

use touchdown_model::card::{
    Card, Input, Provenance, SCHEMA, Score, Status, Term, Validity, Vehicle,
};
use touchdown_model::{Form, Kind};
use touchdown_trial::{Source, Trial};

use crate::score::Errors;

/// A fitted card and how the fit went.
#[derive(Clone, Debug)]
pub struct Made {
    /// The card.
    pub card: Card,
    /// Root mean square residual of the fit.
    pub rmse: f64,
    /// Its unit.
    pub rmse_unit: &'static str,
    /// Rows (or plateaus) that the fit used.
    pub rows_used: usize,
    /// The lag, where the form has one (s).
    pub lag_s: Option<f64>,
    /// What a user should know.
    pub warnings: Vec<String>,
}

/// What the fits of one data set have in common.
#[derive(Clone, Debug, Default)]
pub struct Origin {
    /// The vehicle.
    pub vehicle: Vehicle,
    /// Command, seed, settings, inputs.
    pub provenance: Provenance,
}

impl Origin {
    /// The origin of `trials`: their files by SHA-256, and the tool's own version.
    #[must_use]
    pub fn of(trials: &[Trial], vehicle: Vehicle) -> Self {
        let inputs = trials.iter().filter_map(|t| match &t.provenance().source {
            Source::File { path, sha256 } => Some(Input {
                name: path.rsplit(['/', '\\']).next().unwrap_or(path).to_string(),
                sha256: sha256.clone(),
            }),
            _ => None,
        });
        let provenance = Provenance {
            source: concat!("touchdown ", env!("CARGO_PKG_VERSION")).to_string(),
            inputs: inputs.collect(),
            ..Provenance::default()
        };
        Self {
            vehicle,
            provenance,
        }
    }

    /// An empty fitted card of this origin.
    #[must_use]
    pub fn card(&self, name: &str, kind: Kind, form: Form, equation: &str) -> Card {
        Card {
            schema: SCHEMA,
            name: name.to_string(),
            kind,
            form,
            status: Status::Fitted,
            equation: equation.to_string(),
            description: String::new(),
            warnings: Vec::new(),
            vehicle: self.vehicle.clone(),
            validity: Validity::default(),
            constants: BTreeMap::new(),
            definitions: BTreeMap::new(),
            provenance: self.provenance.clone(),
            terms: Vec::new(),
            scores: Vec::new(),
        }
    }
}

/// A term; a standard error that is not a number is left out.
pub(super) fn term(of: &str, expression: &str, value: f64, std_error: f64, unit: &str) -> Term {
    Term {
        of: of.to_string(),
        expression: expression.to_string(),
        value,
        std_error: std_error.is_finite().then_some(std_error),
        unit: unit.to_string(),
    }
}

/// A score.
pub(crate) fn score(trial: &str, seen: bool, kind: &str, errors: Errors, unit: &str) -> Score {
    Score {
        trial: trial.to_string(),
        seen,
        kind: kind.to_string(),
        mae: errors.mae,
        rmse: errors.rmse,
        worst: errors.worst,
        unit: unit.to_string(),
    }
}

/// Notes of a method, by name.
pub(super) fn method(notes: &[(&str, String)]) -> BTreeMap<String, String> {
    notes
        .iter()
        .map(|(k, v)| ((*k).to_string(), v.clone()))
        .collect()
}

/// The unit of a coefficient whose term has the given unit, in an equation of the unit `of`.
pub(super) fn unit_of_coefficient(of: &str, term: &str) -> String {
    if term == "1" {
        of.to_string()
    } else {
        format!("{of} per ({term})")
    }
}

/// Smallest and largest finite value; `None` where there is none.
pub(super) fn range(values: impl IntoIterator<Item = f64>) -> Option<[f64; 2]> {
    values
        .into_iter()
        .filter(|v| v.is_finite())
        .fold(None, |range, v| {
            Some(range.map_or([v, v], |[lo, hi]: [f64; 2]| [lo.min(v), hi.max(v)]))
        })
}
