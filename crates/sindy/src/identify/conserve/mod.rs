//! Invariants that the equations keep exactly, and linear relations between coefficients.
//!
//! Both are linear in the coefficients ([`fields`], [`relations`]), so models that keep them are combinations of fields, each of
//! terms in several equations with fixed ratios. Fields take the place of candidate terms: statistics of all equations are
//! joined ([`joined`]), searches choose among fields, and the model that they find is written in terms again ([`terms`]).

pub(super) mod fields;
mod invariants;
mod joined;
mod relations;
mod report;
mod terms;
#[cfg(test)]
mod tests;

use nalgebra::{DMatrix, DVector};

use fields::{Field, NoFields};
use invariants::{Invariant, refused};
use relations::Relation;

use super::known::left_side;
use super::settings::Settings;
use crate::data::dataset::{Dataset, Stretch};
use crate::error::SindyError;
use crate::library::Library;
use crate::trajectory::output_error::System;

/// Candidate terms of all equations, at most: the time grows as the cube of their number.
const MOST_CANDIDATES: usize = 400;

/// What an identification under invariants and relations looks for.
#[derive(Clone, Debug)]
pub(super) struct Conserved {
    pub invariants: Vec<Invariant>,
    /// Neither invariants nor relations where the quadratic part keeps the energy.
    pub relations: Vec<Relation>,
    /// The fields whose combinations keep all of them.
    pub fields: Vec<Field>,
    /// Candidate terms of all equations.
    pub candidates: usize,
    /// How candidates change the invariants, in rows for points in the range of the data and invariants.
    changes: DMatrix<f64>,
    /// The system of single candidates, which keeps nothing.
    pub free: System,
}

/// Refuses settings that do not go together with invariants or relations.
pub(super) fn check(settings: &Settings) -> Result<(), SindyError> {
    let beside = |key, own: &[String], others: &[(&str, &[String])]| {
        let given = others.iter().find(|(_, texts)| !texts.is_empty());
        match (own.is_empty(), settings.discrete, given) {
            (true, ..) | (_, false, None) => Ok(()),
            (_, true, _) => {
                let expected = "none in discrete time";
                Err(SindyError::setting(key, expected, own.join(", ")))
            }
            (.., Some((name, _))) => {
                let expected = format!("none beside `{name}`");
                Err(SindyError::setting(key, expected, own.join(", ")))
            }
        }
    };
    let signs = ("signs", settings.signs.as_slice());
    let others = [
        ("second_order", settings.second_order.as_slice()),
        ("known", &settings.known),
        signs,
    ];
    beside(invariants::KEY, &settings.conserve, &others)?;
    beside(relations::KEY, &settings.constraints, &[signs])
}

/// What is looked for among the candidates of `libraries` under the invariants and relations that the settings give, and the system of
/// its fields; `None` where they give none, and the system of single candidates as it is.
pub(super) fn of(
    settings: &Settings,
    data: &Dataset,
    libraries: &[Library],
    stretches: &[Stretch<'_>],
    free: System,
) -> Result<(System, Option<Conserved>), SindyError> {
    if settings.conserve.is_empty() && settings.constraints.is_empty() {
        return Ok((free, None));
    }
    let states = data.states();
    let invariants = invariants::of(&settings.conserve, states)?;
    let relations = relations::of(&settings.constraints, states, libraries)?;
    let key = match invariants.is_empty() {
        true => relations::KEY,
        false => invariants::KEY,
    };
    let candidates: usize = libraries.iter().map(Library::len).sum();
    few_enough(key, candidates)?;
    let ranges = invariants::ranges(stretches, data.names().len());
    let changes = match invariants.is_empty() {
        true => DMatrix::zeros(0, candidates),
        false => invariants::changes(&invariants, libraries, data, &ranges)?,
    };
    let rows = relations::rows(&relations, candidates);
    let fields = fields::conserving(&changes, &rows, &equations(libraries));
    let fields = fields.map_err(|fault| match fault {
        NoFields::Empty if invariants.is_empty() => SindyError::setting(
            relations::KEY,
            "a model that keeps all of them",
            "none but zero",
        ),
        NoFields::Empty => refused(&combination(&invariants, states), "none but zero"),
        NoFields::Unclear => SindyError::setting(
            key,
            "candidate terms that differ by more than rounding in the range of the data",
            "terms that depend on each other: use fewer terms, or data nearer to zero",
        ),
    })?;
    let conserved = Conserved {
        invariants,
        relations,
        fields,
        candidates,
        changes,
        free,
    };
    Ok((conserved.free.joined(&conserved.fields), Some(conserved)))
}

/// Refuses more candidates of all equations than can be joined.
fn few_enough(key: &'static str, candidates: usize) -> Result<(), SindyError> {
    let expected = format!("at most {MOST_CANDIDATES} candidate terms of all equations");
    match candidates > MOST_CANDIDATES {
        true => Err(SindyError::setting(key, expected, candidates.to_string())),
        false => Ok(()),
    }
}

/// What is looked for among models whose quadratic part keeps the energy `|x|²/2`, and the system of its fields. `changes` holds how each
/// candidate changes the energy.
pub(super) fn of_energy(
    changes: DMatrix<f64>,
    libraries: &[Library],
    free: System,
) -> Result<(System, Option<Conserved>), SindyError> {
    let candidates = changes.ncols();
    few_enough("stable", candidates)?;
    let none = DMatrix::zeros(0, candidates);
    let fields = fields::conserving(&changes, &none, &equations(libraries)).map_err(|_| {
        SindyError::setting(
            "stable",
            "candidate terms that differ by more than rounding",
            "terms that depend on each other",
        )
    })?;
    let conserved = Conserved {
        invariants: Vec::new(),
        relations: Vec::new(),
        fields,
        candidates,
        changes,
        free,
    };
    Ok((conserved.free.joined(&conserved.fields), Some(conserved)))
}

impl Conserved {
    /// The system of some of the fields.
    pub(super) fn system_of(&self, fields: &[usize]) -> System {
        let own: Vec<Field> = fields.iter().map(|&j| self.fields[j].clone()).collect();
        self.free.joined(&own)
    }
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

/// What candidates must have where no field keeps the invariants: those that a field of two equations is made of, `∂E/∂y` in x' for each
/// other state y.
fn combination(invariants: &[Invariant], states: &[String]) -> String {
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
    let combination = "candidate terms of which a combination keeps it";
    match all.is_empty() {
        true => combination.to_owned(),
        false => format!(
            "{combination}. Terms of {} are needed, or these times one factor for all equations",
            all.join(" and ")
        ),
    }
}
