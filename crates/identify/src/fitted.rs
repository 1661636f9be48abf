//! What every fit returns: a card, and what a report shows beside it.

use std::collections::BTreeMap;

use rayon::prelude::*;
use sindy::trajectory::shooting::Refined;
use touchdown_model::card::{
    Card, Input, Mark, Provenance, SCHEMA, Score, Status, Term, Validity, Vehicle,
};
use touchdown_model::{Form, Kind};
use touchdown_trial::{Source, Trial};

use super::front::Front;
use crate::error::{Error, Result};
use crate::forms::FormScore;
use crate::scores::Errors;

use crate::warning::{Warning, sentences};

/// A free run beyond this multiple of the greatest measured value has left its data.
/// A fit that errs by a few tenths stays far below it, a divergent one passes it within seconds.
const DIVERGED: f64 = 5.0;

/// A fitted card and how the fit went.
#[derive(Clone, Debug)]
pub struct FittedCard {
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
    /// The forms that were tried and their errors on held-out parts; empty where the form was given.
    pub forms: Vec<FormScore>,
    /// The best subset of every size beside the fit's own, where it is a sparse one.
    pub front: Option<Front>,
    /// What a user should know.
    pub warnings: Vec<Warning>,
}

impl FittedCard {
    /// A card with the root mean square residual of its fit and the rows that were used; without lag, front and warnings.
    pub(super) fn new(
        card: Card,
        (rmse, rmse_unit): (f64, &'static str),
        rows_used: usize,
    ) -> Self {
        Self {
            card,
            rmse,
            rmse_unit,
            rows_used,
            lag_s: None,
            forms: Vec::new(),
            front: None,
            warnings: Vec::new(),
        }
    }

    /// The same with more that a user should know, in the card as well.
    #[must_use]
    pub fn with_warnings(mut self, more: Vec<Warning>) -> Self {
        self.warnings.extend(more);
        self.card.warnings = sentences(&self.warnings);
        self
    }

    /// Marks a card whose free run reaches `most` where the data reach `largest`, if that has left them: it has not
    /// converged, its coefficients have no intervals, and it never flies.
    pub(super) fn judge_divergence(&mut self, most: f64, largest: f64, unit: &'static str) {
        self.card.diverged = most > DIVERGED * largest;
        if !self.card.diverged {
            return;
        }
        self.warnings.push(Warning::Diverged { most, unit });
        self.card.terms.iter_mut().for_each(unconverged);
        for note in self.card.provenance.method.values_mut() {
            *note = note.replace("Converged", "Diverged");
        }
    }

    /// Refuses data that give no finite coefficients.
    pub(super) fn check_finite(&self) -> Result<()> {
        match self.card.terms.iter().find(|t| !t.value.is_finite()) {
            None => Ok(()),
            Some(term) => Err(Error::data(
                &self.card.name,
                "data that a finite fit follows from (time in seconds, forces in newtons)",
                format!(
                    "a coefficient `{}:{}` of {}",
                    term.of, term.expression, term.value
                ),
            )),
        }
    }
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
    /// The origin of `trials`: the tool's own version, and every trial by SHA-256.
    #[must_use]
    pub fn of(trials: &[Trial], vehicle: Vehicle) -> Self {
        let provenance = Provenance {
            source: concat!("touchdown ", env!("CARGO_PKG_VERSION")).to_string(),
            ..Provenance::default()
        };
        Self {
            vehicle,
            provenance,
        }
        .with_inputs(trials)
    }

    /// The same origin with other data: files by their own SHA-256, trials of the virtual rig by that of the CSV
    /// that they are written as.
    #[must_use]
    pub fn with_inputs(&self, trials: &[Trial]) -> Self {
        let mut origin = self.clone();
        origin.provenance.inputs = trials.par_iter().filter_map(input).collect();
        origin
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
            diverged: false,
            measured_rotors: None,
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

fn input(trial: &Trial) -> Option<Input> {
    match &trial.provenance().source {
        Source::File { path, sha256 } => Some(Input {
            name: path.rsplit(['/', '\\']).next().unwrap_or(path).to_string(),
            sha256: sha256.clone(),
        }),
        Source::VirtualRig { .. } => Some(Input {
            name: format!("{}.csv", trial.name()),
            sha256: touchdown_log::sha256(&touchdown_log::to_csv(trial)),
        }),
        _ => None,
    }
}

/// A score.
pub fn score(trial: &str, seen: bool, kind: &str, errors: Errors, unit: &str) -> Score {
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

/// How a search by shooting ended.
pub(super) fn outcome(refined: &Refined) -> String {
    format!("{:?} after {} steps", refined.outcome, refined.iterations)
}

/// Notes of a method, by name.
pub(super) fn method(notes: &[(&str, String)]) -> BTreeMap<String, String> {
    notes
        .iter()
        .map(|(k, v)| ((*k).to_string(), v.clone()))
        .collect()
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

/// Takes the interval from a term of a fit that did not converge.
pub(super) fn unconverged(term: &mut Term) {
    term.std_error = None;
    term.ci95 = None;
    term.upper_bound = None;
    term.mark = Some(Mark::NotConverged);
}
