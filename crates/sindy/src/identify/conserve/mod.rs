//! Invariants that the equations keep exactly.
//!
//! An invariant E(x) is linear in the coefficients ([`fields`]), so models that keep it are combinations of fields, each of
//! terms in several equations with fixed ratios. Fields take the place of candidate terms: statistics of all equations are
//! joined ([`joined`]), searches choose among fields, and the model that they find is written in terms again ([`terms`]).

pub(super) mod fields;
mod invariants;
mod joined;
mod report;
mod terms;
#[cfg(test)]
mod tests;

use nalgebra::{DMatrix, DVector};

use fields::{Field, NoFields};
use invariants::{Invariant, refused};

use super::known::left_side;
use super::settings::Settings;
use crate::data::dataset::{Dataset, Stretch};
use crate::error::SindyError;
use crate::library::Library;
use crate::trajectory::output_error::System;

/// Candidate terms of all equations, at most: the time grows as the cube of their number.
const MOST_CANDIDATES: usize = 400;

/// What an identification under invariants looks for.
#[derive(Clone, Debug)]
pub(super) struct Conserved {
    /// None where the quadratic part keeps the energy alone.
    pub invariants: Vec<Invariant>,
    /// The fields whose combinations keep all invariants.
    pub fields: Vec<Field>,
    /// Candidate terms of all equations.
    pub candidates: usize,
    /// How candidates change the invariants, in rows for points in the range of the data and invariants.
    changes: DMatrix<f64>,
    /// The system of single candidates, which keeps nothing.
    pub free: System,
}

/// Refuses settings that do not go together with invariants.
pub(super) fn check(settings: &Settings) -> Result<(), SindyError> {
    if settings.conserve.is_empty() {
        return Ok(());
    }
    let with = |expected: &str, found: &str| Err(refused(expected, found));
    if settings.discrete {
        return with("none in discrete time", &settings.conserve.join(", "));
    }
    for (name, given) in [
        ("second_order", &settings.second_order),
        ("known", &settings.known),
        ("signs", &settings.signs),
    ] {
        if !given.is_empty() {
            let expected = format!("none beside `{name}`");
            return with(&expected, &settings.conserve.join(", "));
        }
    }
    Ok(())
}

/// What is looked for among the candidates of `libraries` under the invariants that the settings give, and the system of its fields;
/// `None` where they give none, and the system of single candidates as it is.
pub(super) fn of(
    settings: &Settings,
    data: &Dataset,
    libraries: &[Library],
    stretches: &[Stretch<'_>],
    free: System,
) -> Result<(System, Option<Conserved>), SindyError> {
    if settings.conserve.is_empty() {
        return Ok((free, None));
    }
    let states = data.states();
    let invariants = invariants::of(&settings.conserve, states)?;
    let candidates: usize = libraries.iter().map(Library::len).sum();
    if candidates > MOST_CANDIDATES {
        let expected = format!("at most {MOST_CANDIDATES} candidate terms of all equations");
        return Err(refused(&expected, &candidates.to_string()));
    }
    let ranges = invariants::ranges(stretches, data.names().len());
    let changes = invariants::changes(&invariants, libraries, data, &ranges)?;
    let fields = fields::conserving(&changes, &equations(libraries)).map_err(|fault| match fault {
        NoFields::Empty => refused(
            &format!(
                "candidate terms of which a combination keeps it. Terms of {} are needed, or these times one factor for all \
                 equations",
                needed(&invariants, states)
            ),
            "none but zero",
        ),
        NoFields::Unclear => refused(
            "candidate terms that differ by more than rounding in the range of the data",
            "terms that depend on each other: use fewer terms, or data nearer to zero",
        ),
    })?;
    let conserved = Conserved {
        invariants,
        fields,
        candidates,
        changes,
        free,
    };
    Ok((conserved.free.joined(&conserved.fields), Some(conserved)))
}

/// What is looked for among models whose quadratic part keeps the energy `|x|²/2`, and the system of its fields. `changes` holds how each
/// candidate changes the energy.
pub(super) fn of_energy(
    changes: DMatrix<f64>,
    libraries: &[Library],
    free: System,
) -> Result<(System, Option<Conserved>), SindyError> {
    let candidates = changes.ncols();
    if candidates > MOST_CANDIDATES {
        let expected = format!("at most {MOST_CANDIDATES} candidate terms of all equations");
        let found = candidates.to_string();
        return Err(SindyError::setting("stable", &expected, &found));
    }
    let fields = fields::conserving(&changes, &equations(libraries)).map_err(|_| {
        SindyError::setting(
            "stable",
            "candidate terms that differ by more than rounding",
            "terms that depend on each other",
        )
    })?;
    let conserved = Conserved {
        invariants: Vec::new(),
        fields,
        candidates,
        changes,
        free,
    };
    Ok((conserved.free.joined(&conserved.fields), Some(conserved)))
}

/// The candidates of each equation among those of all.
fn equations(libraries: &[Library]) -> Vec<Vec<usize>> {
    let mut first = 0;
    let own = libraries.iter().map(|library| {
        first += library.len();
        (first - library.len()..first).collect()
    });
    own.collect()
}

/// The terms that a field of two equations is made of: `∂E/∂y` in x' for each other state y.
fn needed(invariants: &[Invariant], states: &[String]) -> String {
    let of = |i: usize| {
        let others = invariants.iter().flat_map(|e| {
            let slopes = e.gradient.iter().enumerate();
            slopes.filter_map(move |(j, g)| (j != i && g.as_constant() != Some(0.0)).then_some(g))
        });
        let mut texts: Vec<String> = others.map(|g| format!("`{g}`")).collect();
        texts.dedup();
        (!texts.is_empty())
            .then(|| format!("{} in {}", texts.join(", "), left_side(&states[i], false)))
    };
    let all: Vec<String> = (0..states.len()).filter_map(of).collect();
    all.join(" and ")
}
