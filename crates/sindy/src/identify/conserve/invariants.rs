//! Invariants as they are given, and the points at which fields are compared with them.

use nalgebra::DMatrix;
use sindy_expr::{Expr, Scratch};

use crate::data::dataset::{Dataset, Stretch};
use crate::error::SindyError;
use crate::identify::known::expression;
use crate::library::{Library, compile};
use crate::numerics::prime;

/// What the setting is called in messages.
pub(super) const KEY: &str = "conserve";
/// Points for each candidate: with one the rank is full with probability one, and a second makes its least value larger.
const POINTS: usize = 2;
/// Points that are tried for each that is needed: the rest lie where a term has no finite value.
const TRIED: usize = 8;
/// A column that moves by less than this share of its size counts as constant: its range is widened to its size, because an
/// invariant is to hold for other values as well.
const CONSTANT: f64 = 1e-6;

/// An invariant.
#[derive(Clone, Debug)]
pub(crate) struct Invariant {
    /// As it was given.
    pub text: String,
    pub expression: Expr,
    /// Its derivative by each state.
    pub gradient: Vec<Expr>,
}

pub(super) fn refused(expected: &str, found: &str) -> SindyError {
    SindyError::setting(KEY, expected, found)
}

/// The invariants that texts give.
pub(super) fn of(texts: &[String], states: &[String]) -> Result<Vec<Invariant>, SindyError> {
    texts
        .iter()
        .map(|text| {
            let given = expression(KEY, text)?;
            let unknown = |v: &&str| !states.iter().any(|s| s == v);
            let quoted = format!("`{}`", text.trim());
            if let Some(name) = given.variables().into_iter().find(unknown) {
                let expected = format!("an expression of the states {}", states.join(", "));
                return Err(refused(&expected, &format!("`{name}` in {quoted}")));
            }
            let gradient: Vec<Expr> = states
                .iter()
                .map(|s| given.derivative(s).simplify())
                .collect();
            if gradient.iter().all(|g| g.as_constant() == Some(0.0)) {
                return Err(refused("an expression that depends on a state", &quoted));
            }
            Ok(Invariant {
                text: text.trim().to_owned(),
                expression: given,
                gradient,
            })
        })
        .collect()
}

/// The range of each column of the data, states first.
pub(super) fn ranges(stretches: &[Stretch<'_>], columns: usize) -> Vec<[f64; 2]> {
    (0..columns)
        .map(|c| {
            let values = stretches.iter().flat_map(|s| s.columns[c]).copied();
            let finite = values.filter(|v| v.is_finite());
            let [low, high] = finite.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| {
                [low.min(v), high.max(v)]
            });
            let size = low.abs().max(high.abs());
            match high - low > CONSTANT * size {
                true => [low, high],
                false if size > 0.0 && size.is_finite() => [low - size, high + size],
                false => [-1.0, 1.0],
            }
        })
        .collect()
}

/// Changes of the invariants by each candidate, `∂E/∂x_i θ_k`, in rows for points and invariants. Points are spread evenly over
/// the ranges: multiples of roots of primes.
pub(super) fn changes(
    invariants: &[Invariant],
    libraries: &[Library],
    data: &Dataset,
    ranges: &[[f64; 2]],
) -> Result<DMatrix<f64>, SindyError> {
    let names = data.names();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let gradients = invariants.iter().flat_map(|e| e.gradient.iter().cloned());
    let terms = libraries.iter().flat_map(|l| l.terms().iter().cloned());
    // Invariants themselves only have to be finite.
    let values = invariants.iter().map(|e| e.expression.clone());
    let all: Vec<Expr> = gradients.chain(terms).chain(values).collect();
    let program = compile(&all, &names)?;
    let states = data.states().len();
    let slopes = invariants.len() * states;
    let candidates: usize = libraries.iter().map(Library::len).sum();
    let needed = POINTS * candidates;
    let equations: Vec<usize> = (0..states)
        .flat_map(|i| std::iter::repeat_n(i, libraries[i].len()))
        .collect();
    let roots: Vec<f64> = (0..names.len()).map(|c| (prime(c) as f64).sqrt()).collect();
    let (mut values, mut scratch) = (vec![0.0; all.len()], Scratch::new());
    let mut rows: Vec<Vec<f64>> = Vec::new();
    for point in 1..=TRIED * needed {
        if rows.len() == needed * invariants.len() {
            break;
        }
        let along = roots.iter().zip(ranges);
        let x: Vec<f64> = along
            .map(|(root, [low, high])| low + (high - low) * (point as f64 * root).fract())
            .collect();
        program.eval_row(&x, &mut values, &mut scratch);
        if values.iter().any(|v| !v.is_finite()) {
            continue;
        }
        let (slopes, terms) = values[..slopes + candidates].split_at(slopes);
        for slopes in slopes.chunks(states) {
            let change = |(term, &i): (&f64, &usize)| slopes[i] * term;
            rows.push(terms.iter().zip(&equations).map(change).collect());
        }
    }
    if rows.len() < needed * invariants.len() {
        return Err(refused(
            "an invariant and terms that are finite in the range of the data",
            "points where they are not",
        ));
    }
    let matrix = DMatrix::from_fn(rows.len(), candidates, |r, c| rows[r][c]);
    Ok(balanced(matrix, invariants.len()))
}

/// Each invariant's rows divided by their size.
fn balanced(mut matrix: DMatrix<f64>, invariants: usize) -> DMatrix<f64> {
    for q in 0..invariants {
        let rows = || (q..matrix.nrows()).step_by(invariants);
        let size = rows().map(|r| matrix.row(r).amax()).fold(0.0, f64::max);
        if size > 0.0 {
            for r in (q..matrix.nrows()).step_by(invariants) {
                matrix.row_mut(r).scale_mut(1.0 / size);
            }
        }
    }
    matrix
}
