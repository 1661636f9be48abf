//! Models whose trajectories all stay bounded.
//!
//! Candidates linear in the states: all eigenvalues decay. Candidates of degree 2: the quadratic part keeps the energy `|x|²/2`, and the
//! energy decays about a centre ([`stability`](crate::model::StabilityCertificate)). The first is linear in the coefficients: fields
//! that keep the energy take the place of candidates, as under invariants ([`super::conserve`]). The second is an inequality: a
//! fit that breaks it moves to the nearest coefficients that satisfy it ([`nearest`]).

mod nearest;
mod report;
#[cfg(test)]
mod tests;

use nalgebra::{DMatrix, DVector};

pub use report::Stability;

use super::settings::Settings;
use crate::data::dataset::{Stretch, is_constant};
use crate::error::SindyError;
use crate::library::Library;
use crate::model::stability::form::{QuadraticForm, TermForm};

const KEY: &str = "stable";

/// What an identification of a stable model knows of its candidates.
#[derive(Clone, Debug)]
pub(super) struct StableCandidates {
    /// The equation and the polynomial of each candidate.
    pub forms: Vec<(usize, TermForm)>,
    /// The candidate `x` in the equation of each state x.
    pub diagonal: Vec<usize>,
    /// The mean of each state over the data, and its root mean square.
    pub mean: DVector<f64>,
    pub rms: f64,
    /// One turn, or one decay, over the longest trajectory.
    pub slowest: f64,
}

fn refused(expected: &str, found: &str) -> SindyError {
    SindyError::setting(KEY, expected, found)
}

/// Refuses settings that do not go together with stability.
pub(super) fn check(settings: &Settings) -> Result<(), SindyError> {
    if !settings.stable {
        return Ok(());
    }
    if settings.discrete {
        return Err(refused("false in discrete time", "true"));
    }
    for (name, given) in [
        ("conserve", &settings.conserve),
        ("constraints", &settings.constraints),
        ("second_order", &settings.second_order),
        ("known", &settings.known),
        ("signs", &settings.signs),
    ] {
        if !given.is_empty() {
            let expected = format!("false beside `{name}`");
            return Err(refused(&expected, "true"));
        }
    }
    Ok(())
}

impl StableCandidates {
    /// Of libraries, one for each state; `None` where no stable model is asked for.
    pub(super) fn of(
        settings: &Settings,
        states: &[String],
        libraries: &[Library],
        stretches: &[Stretch<'_>],
    ) -> Result<Option<Self>, SindyError> {
        if !settings.stable {
            return Ok(None);
        }
        let mut forms = Vec::new();
        let mut diagonal = Vec::new();
        for (i, library) in libraries.iter().enumerate() {
            let mut unit = DVector::zeros(states.len());
            unit[i] = 1.0;
            let mut own = None;
            for term in library.terms() {
                let form = TermForm::of(term, states).ok_or_else(|| {
                    let is_state = |v: &&str| states.iter().any(|s| s == v);
                    let suited = match term.variables().iter().all(is_state) {
                        true => "poly(2)".to_owned(),
                        false => format!("poly(2, {}), and terms of the inputs", states.join(", ")),
                    };
                    let expected = format!(
                        "candidate terms of degree 1 or 2 in the states, or of inputs alone, such as {suited}"
                    );
                    refused(&expected, &format!("`{term}` in the equation of {}", states[i]))
                })?;
                if !form.is_quadratic() && form.linear == unit {
                    own = Some(forms.len());
                }
                forms.push((i, form));
            }
            let expected = format!("the candidate `{0}` in the equation of {0}", states[i]);
            diagonal.push(own.ok_or_else(|| match is_constant(stretches, i) {
                true => refused(
                    "states that change",
                    &format!(
                        "one value of {} in all rows: make it an input, or leave it out",
                        states[i]
                    ),
                ),
                false => refused(&expected, "none"),
            })?);
        }
        let column = |i: usize| stretches.iter().flat_map(move |s| s.columns[i]).copied();
        let average = |i: usize, f: fn(f64) -> f64| {
            let finite = column(i).filter(|v| v.is_finite()).map(f);
            let (sum, count) = finite.fold((0.0, 0.0), |(s, n), v| (s + v, n + 1.0));
            if count > 0.0 { sum / count } else { 0.0 }
        };
        let n = states.len();
        let lengths = stretches
            .iter()
            .map(|s| s.time[s.time.len() - 1] - s.time[0]);
        let longest = lengths.fold(0.0, f64::max);
        let square: f64 = (0..n).map(|i| average(i, |v| v * v)).sum();
        Ok(Some(Self {
            forms,
            diagonal,
            mean: DVector::from_fn(n, |i, _| average(i, |v| v)),
            rms: if square > 0.0 { square.sqrt() } else { 1.0 },
            slowest: 1.0 / longest,
        }))
    }

    /// Whether fields that keep the energy take the place of candidates.
    pub(super) fn is_quadratic(&self) -> bool {
        self.forms.iter().any(|(_, form)| form.is_quadratic())
    }

    /// How candidates change the energy: rows for the monomials of degree 3, a column for each candidate, and as many rows as columns
    /// at least, so that the null space is complete.
    pub(super) fn energy_changes(&self) -> DMatrix<f64> {
        let n = self.diagonal.len();
        let mut monomials = Vec::new();
        for i in 0..n {
            for j in 0..=i {
                monomials.extend((0..=j).map(|k| [i, j, k]));
            }
        }
        let rows = monomials.len().max(self.forms.len());
        let mut out = DMatrix::zeros(rows, self.forms.len());
        for (column, (equation, form)) in self.forms.iter().enumerate() {
            for j in 0..n {
                for k in 0..n {
                    let mut monomial = [*equation, j, k];
                    monomial.sort_unstable_by(|a, b| b.cmp(a));
                    let row = monomials.iter().position(|m| *m == monomial);
                    if let Some(row) = row {
                        out[(row, column)] += form.quadratic[(j, k)];
                    }
                }
            }
        }
        out
    }

    /// The equations of one field, a sum of candidates.
    fn form_of(&self, field: &[(usize, f64)]) -> QuadraticForm {
        let mut out = QuadraticForm::zeros(self.diagonal.len());
        for &(candidate, factor) in field {
            let (equation, form) = &self.forms[candidate];
            out.add(*equation, form, factor);
        }
        out
    }
}
