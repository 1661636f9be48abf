//! Linear relations between coefficients, of one equation or of several.
//!
//! | text | meaning |
//! | --- | --- |
//! | `[x': y] = -[y': x]` | the coefficient of `y` in the equation of x is minus that of `x` in the equation of y |
//! | `[x': x] + [y': y] + [z': z] = 0` | a sum |
//! | `2*[x': x*y] = [y': x^2]` | a ratio |
//! | `[x': y] = 0` | the term is left out |
//!
//! A relation is a row of factors with `Σ_k r_k ξ_k = 0` over the candidates of all equations. A constant is not allowed: a
//! coefficient that is known is a known part of its equation.

use nalgebra::DMatrix;
use sindy_expr::Expr;

use crate::error::SindyError;
use crate::identify::known::{equation, expression, left_sides, same_factors};
use crate::identify::signs::listed;
use crate::library::{Library, parse};

/// What the setting is called in messages.
pub(super) const KEY: &str = "constraints";
/// The coefficients of a relation while its text is read; no text can hold such a name, because brackets are not allowed in it.
const COEFFICIENT: &str = "coefficient_";

/// A relation as it was given.
#[derive(Clone, Debug)]
pub(crate) struct Relation {
    pub text: String,
    /// Candidates, numbered equation by equation, with their factors.
    pub factors: Vec<(usize, f64)>,
}

pub(super) fn refused(expected: &str, found: &str) -> SindyError {
    SindyError::setting(KEY, expected, format!("`{found}`"))
}

/// The relations that texts give.
pub(super) fn of(
    texts: &[String],
    states: &[String],
    libraries: &[Library],
) -> Result<Vec<Relation>, SindyError> {
    let one = |text: &String| relation(text.trim(), states, libraries);
    texts.iter().map(one).collect()
}

fn relation(text: &str, states: &[String], libraries: &[Library]) -> Result<Relation, SindyError> {
    let shape = || refused("a relation such as [x': y] = -[y': x]", text);
    let (plain, brackets) = without_brackets(text).ok_or_else(shape)?;
    let (left, right) = plain.split_once('=').ok_or_else(shape)?;
    if brackets.is_empty() || right.contains('=') {
        return Err(shape());
    }
    let all = parse(left).and_then(|left| Ok(left - parse(right)?));
    let all = all.map_err(|_| shape())?;
    let name = |c: usize| format!("{COEFFICIENT}{c}");
    let names: Vec<String> = (0..brackets.len()).map(name).collect();
    if let Some(other) = all
        .variables()
        .iter()
        .find(|v| !names.iter().any(|n| n == *v))
    {
        let expected = "coefficients in brackets, such as [x': y], and numbers";
        return Err(refused(expected, &format!("{other}` in `{text}")));
    }
    let mut factors: Vec<(usize, f64)> = Vec::new();
    for (name, bracket) in names.iter().zip(&brackets) {
        let factor = all.derivative(name).simplify().as_constant();
        let factor = factor.filter(|f| f.is_finite());
        let factor =
            factor.ok_or_else(|| refused("a sum of coefficients, each times a number", text))?;
        let candidate = candidate(bracket, states, libraries, text)?;
        match factors.iter_mut().find(|(k, _)| *k == candidate) {
            Some((_, before)) => *before += factor,
            None => factors.push((candidate, factor)),
        }
    }
    let zero = Expr::constant(0.0);
    let rest = names.iter().fold(all, |all, n| all.substitute(n, &zero));
    if rest.simplify().as_constant() != Some(0.0) {
        let expected =
            "a relation without a constant (a coefficient that is known stands in `known`)";
        return Err(refused(expected, text));
    }
    factors.retain(|(_, factor)| *factor != 0.0);
    match factors.is_empty() {
        true => Err(refused(
            "a relation that does not hold for all coefficients",
            text,
        )),
        false => Ok(Relation {
            text: text.to_owned(),
            factors,
        }),
    }
}

/// A text with names in place of its brackets, and what the brackets hold; `None` where they do not match.
fn without_brackets(text: &str) -> Option<(String, Vec<&str>)> {
    let (mut plain, mut brackets) = (String::new(), Vec::new());
    let mut rest = text;
    while let Some(from) = rest.find(['[', ']']) {
        let (before, inner) = rest.split_at(from);
        let inner = inner.strip_prefix('[')?;
        let to = closing(inner)?;
        plain += &format!("{before}({COEFFICIENT}{})", brackets.len());
        brackets.push(&inner[..to]);
        rest = &inner[to + 1..];
    }
    plain.push_str(rest);
    Some((plain, brackets))
}

/// Where the bracket that is open before this text is closed.
fn closing(text: &str) -> Option<usize> {
    let mut depth = 0_usize;
    text.char_indices().find_map(|(at, c)| match (c, depth) {
        (']', 0) => Some(at),
        (']', _) => {
            depth -= 1;
            None
        }
        ('[', _) => {
            depth += 1;
            None
        }
        _ => None,
    })
}

/// The candidate that `x': y` names, counted over all equations.
fn candidate(
    bracket: &str,
    states: &[String],
    libraries: &[Library],
    text: &str,
) -> Result<usize, SindyError> {
    let shape = || {
        refused(
            "an equation, `:` and a term in each bracket, such as [x': y]",
            text,
        )
    };
    let (left, term) = bracket.split_once(':').ok_or_else(shape)?;
    let (left, term) = (left.trim(), term.trim());
    if term.is_empty() {
        return Err(shape());
    }
    let of = equation(left, states, false)
        .ok_or_else(|| refused(&left_sides(states, false, ":"), left))?;
    let term = expression(KEY, term)?;
    if term.factors().0 != 1.0 {
        return Err(refused("a term without a factor in each bracket", text));
    }
    let library = &libraries[of];
    if library.is_empty() {
        let expected = format!("an equation that is not known (that of {} is)", states[of]);
        return Err(refused(&expected, text));
    }
    let at = library.terms().iter().position(|t| same_factors(t, &term));
    let at = at.ok_or_else(|| {
        let expected = format!(
            "a candidate term of {left}, without those that are known: {}",
            listed(library)
        );
        refused(&expected, text)
    })?;
    Ok(libraries[..of].iter().map(Library::len).sum::<usize>() + at)
}

/// The relations as rows over all candidates, the largest factor of each 1.
pub(super) fn rows(relations: &[Relation], candidates: usize) -> DMatrix<f64> {
    let mut out = DMatrix::zeros(relations.len(), candidates);
    for (r, relation) in relations.iter().enumerate() {
        let all = relation.factors.iter();
        let largest = all.clone().map(|(_, f)| f.abs()).fold(0.0, f64::max);
        all.for_each(|&(k, factor)| out[(r, k)] = factor / largest);
    }
    out
}

impl Relation {
    /// By how much coefficients break it, as a share of its largest part.
    pub(super) fn broken_by(&self, coefficients: &[f64]) -> f64 {
        let parts = || self.factors.iter().map(|&(k, f)| f * coefficients[k]);
        let largest = parts().map(f64::abs).fold(f64::MIN_POSITIVE, f64::max);
        parts().sum::<f64>().abs() / largest
    }
}
