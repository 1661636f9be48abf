//! Signs that coefficients must have.
//!
//! | text | meaning |
//! | --- | --- |
//! | `v': v < 0` | the coefficient of `v` in the equation of v is below 0, or the term is left out |
//! | `v': v*abs(v) < 0` | the same for another candidate |
//! | `x'': x_dot < 0` | for a state of second order, whose velocity is not measured |
//! | `x[k+1]: x > 0` | in discrete time |
//!
//! `<=` and `>=` have the same meanings: a coefficient of 0 is a term that is left out.

use sindy_expr::Expr;

use super::follow::FollowedModel;
use super::known::{KnownPart, equation, expression, left_side, left_sides, same_factors};
use super::model::count;
use super::regress::{NODES, Statistics, signed_subsets};
use super::run::IdentificationRun;
use crate::data::dataset::Dataset;
use crate::error::SindyError;
use crate::library::Library;
use crate::model::print::Number;
use crate::solve::sign::{Sign, broken, is_constrained};
use crate::statistics::criteria::{Criterion, TWENTY_TO_ONE};
use crate::statistics::gram::Gram;

/// What the setting is called in messages.
const KEY: &str = "signs";
/// Candidates that an error lists, at most.
const LISTED: usize = 12;

/// A sign as it was given.
#[derive(Clone, Debug)]
pub(super) struct GivenSign {
    equation: usize,
    term: Expr,
    sign: Sign,
    text: String,
}

fn refused(expected: &str, found: &str) -> SindyError {
    SindyError::setting(KEY, expected, format!("`{found}`"))
}

/// The signs that texts give to candidates of `libraries`, one library for each equation.
pub(super) fn of(
    texts: &[String],
    data: &Dataset,
    libraries: &[(Library, KnownPart)],
    discrete: bool,
) -> Result<Vec<GivenSign>, SindyError> {
    let states = data.states();
    let mut given: Vec<GivenSign> = Vec::new();
    for text in texts {
        let (left, condition) = text
            .split_once(':')
            .ok_or_else(|| refused("an equation, `:` and a sign, such as v': v < 0", text))?;
        let left = left.trim();
        let equation = equation(left, states, discrete)
            .ok_or_else(|| refused(&left_sides(states, discrete, ":"), left))?;
        let (term, sign) = condition_of(condition, text)?;
        let (library, known) = &libraries[equation];
        let term = library.terms().iter().find(|t| same_factors(t, &term));
        let term = term.ok_or_else(|| {
            let expected = match known.whole {
                true => format!(
                    "an equation that is not known (that of {} is)",
                    states[equation]
                ),
                false => format!("a candidate term of {left}: {}", listed(library)),
            };
            refused(&expected, text)
        })?;
        let same = |g: &&GivenSign| g.equation == equation && g.term == *term;
        if let Some(before) = given.iter().find(same) {
            if before.sign != sign {
                return Err(refused(&format!("nothing against `{}`", before.text), text));
            }
            continue;
        }
        given.push(GivenSign {
            equation,
            term: term.clone(),
            sign,
            text: text.trim().to_owned(),
        });
    }
    Ok(given)
}

/// The term of a condition such as `v < 0`, and its sign.
fn condition_of(condition: &str, text: &str) -> Result<(Expr, Sign), SindyError> {
    let shape = || refused("a term and `< 0` or `> 0` behind the `:`", text);
    let left = condition.trim().strip_suffix('0').ok_or_else(shape)?;
    let left = left.trim_end();
    let left = left.strip_suffix('=').unwrap_or(left);
    let (term, below) = match (left.strip_suffix('<'), left.strip_suffix('>')) {
        (Some(term), _) => (term, true),
        (_, Some(term)) => (term, false),
        _ => return Err(shape()),
    };
    if term.trim().is_empty() {
        return Err(shape());
    }
    let term = expression(KEY, term.trim())?;
    let (factor, _) = term.factors();
    if !factor.is_finite() || factor == 0.0 {
        return Err(shape());
    }
    let sign = match below == (factor > 0.0) {
        true => Sign::Negative,
        false => Sign::Positive,
    };
    Ok((term, sign))
}

/// The names of candidates, for messages.
pub(super) fn listed(library: &Library) -> String {
    let names = library.names();
    let first = names.iter().take(LISTED).cloned().collect::<Vec<_>>();
    let more = names.len().saturating_sub(LISTED);
    match (names.len(), more) {
        (0, _) => "there is none".to_owned(),
        (_, 0) => first.join(", "),
        (_, more) => format!("{} and {}", first.join(", "), count(more, "other")),
    }
}

/// One sign for each candidate of each equation, or none where none is given. A sign whose term has left its library, because
/// it is a multiple of another one, is warned of.
pub(super) fn by_candidate(
    given: &[GivenSign],
    libraries: &[Library],
    warnings: &mut Vec<String>,
) -> Vec<Vec<Sign>> {
    if given.is_empty() {
        return vec![Vec::new(); libraries.len()];
    }
    let mut signs: Vec<Vec<Sign>> = libraries.iter().map(|l| vec![Sign::Any; l.len()]).collect();
    for one in given {
        let terms = libraries[one.equation].terms();
        match terms.iter().position(|t| *t == one.term) {
            Some(j) => signs[one.equation][j] = one.sign,
            None => warnings.push(format!(
                "the sign `{}` has no effect: its term is left out as a multiple of a simpler one, which may take any sign",
                one.text
            )),
        }
    }
    signs
}

impl IdentificationRun<'_> {
    /// A warning for each sign that a model by output error without signs breaks, if that is more likely by odds of 20 to 1.
    pub(super) fn contradicted_by_trajectories(&self, followed: &FollowedModel) -> Vec<String> {
        let Some(free) = &followed.without_signs else {
            return Vec::new();
        };
        let (mut first, mut out) = (0, Vec::new());
        for i in 0..self.libraries.len() {
            let own = first..first + self.libraries[i].0.len();
            first = own.end;
            out.extend(self.contradicted(i, &free[own]));
        }
        out
    }

    /// The same for best subsets of a regression.
    pub(super) fn contradicted_by_regression(
        &self,
        from: &Statistics,
    ) -> Result<Vec<String>, SindyError> {
        let mut out = Vec::new();
        for (i, (parts, signs)) in from.grams.iter().zip(&self.signs).enumerate() {
            if !is_constrained(signs) {
                continue;
            }
            let total = Gram::total(parts);
            let rows = (total.rows as f64 * from.independent).max(2.0 * signs.len() as f64);
            let best = |signs: &[Sign]| {
                let found = signed_subsets(&total, signs, NODES)?;
                let fit = &found.choose(&total, Criterion::Bic, Some(rows))?.fit;
                let score = Criterion::Bic.score(&total, &fit.support, Some(rows))?;
                Ok::<_, SindyError>((fit.coefficients.clone(), score))
            };
            let ((_, signed), (coefficients, free)) = (best(signs)?, best(&[])?);
            if signed - free > TWENTY_TO_ONE {
                out.extend(self.contradicted(i, coefficients.as_slice()));
            }
        }
        Ok(out)
    }

    /// A warning for each sign of equation `i` that these coefficients break.
    fn contradicted(&self, i: usize, coefficients: &[f64]) -> Vec<String> {
        let left = left_side(&self.data.states()[i], self.settings.discrete);
        let warning = |j: usize| {
            format!(
                "the data contradict the sign of {} in {left}: without signs its coefficient is {}, and that model is more \
                 than 20 times as likely. Check the sign, the data, and what the library lacks",
                self.libraries[i].0.names()[j],
                Number::new(coefficients[j], Some(4)).text()
            )
        };
        broken(&self.signs[i], coefficients).map(warning).collect()
    }
}
