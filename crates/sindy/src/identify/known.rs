//! Parts of equations that are known beforehand.
//!
//! | text | meaning |
//! | --- | --- |
//! | `x' = v` | the whole equation of x is known |
//! | `v' = -9.81 + ...` | this part is known, the rest is looked for |
//! | `x'' = -9.81 + ...` | the same for a state of second order, whose velocity is not measured |
//! | `x[k+1] = y` | in discrete time |
//!
//! Known terms act in simulations and in regressions (they are taken from the slopes), have no standard error, and leave
//! the library of their equation.

use sindy_expr::{Expr, Factor};

use super::second_order::velocity;
use crate::data::dataset::Dataset;
use crate::error::SindyError;
use crate::library::{Library, parse};
use crate::model::Term;
use crate::statistics::gram::Gram;

/// The known part of one equation.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct KnownPart {
    pub terms: Vec<Term>,
    /// The whole equation is known.
    pub whole: bool,
}

/// What the setting is called in messages.
const KEY: &str = "known";
/// Text in place of the unknown part.
const REST: [&str; 2] = ["...", "…"];

fn refused(expected: &str, found: &str) -> SindyError {
    SindyError::setting(KEY, expected, format!("`{found}`"))
}

/// The known part of each state's equation, velocities of second order included.
pub(super) fn of(
    texts: &[String],
    data: &Dataset,
    second_order: &[String],
    discrete: bool,
) -> Result<Vec<KnownPart>, SindyError> {
    let states = data.states();
    let mut out = vec![KnownPart::default(); states.len()];
    for name in second_order {
        if let Some(i) = states.iter().position(|s| s == name) {
            out[i] = KnownPart {
                terms: vec![Term::new(Expr::variable(&velocity(name)), 1.0)],
                whole: true,
            };
        }
    }
    for text in texts {
        let (left, right) = text
            .split_once('=')
            .ok_or_else(|| refused("an equation, such as x' = v or v' = -9.81 + ...", text))?;
        let i = equation(left.trim(), states, discrete)
            .ok_or_else(|| refused(&left_sides(states, discrete, "="), left.trim()))?;
        let part = right_side(right.trim(), &data.names())?;
        if second_order.contains(&states[i]) {
            if out[i] == part {
                continue;
            }
            let (own, velocity) = (left_side(&states[i], discrete), velocity(&states[i]));
            let expected = format!("{own} = {velocity}, as the setting `second_order` says");
            return Err(refused(&expected, text));
        }
        if out[i] != KnownPart::default() {
            return Err(refused("each equation once", left.trim()));
        }
        out[i] = part;
    }
    if out.iter().all(|k| k.whole) {
        let expected = "an equation of which a part is not known";
        return Err(SindyError::setting(KEY, expected, "none"));
    }
    Ok(out)
}

/// The state whose equation has this left side.
pub(super) fn equation(left: &str, states: &[String], discrete: bool) -> Option<usize> {
    let name = match discrete {
        true => unquoted(left.strip_suffix("[k+1]")?),
        false => match left.strip_suffix("''") {
            Some(position) => velocity(&unquoted(position)),
            None => unquoted(left.strip_suffix('\'')?),
        },
    };
    states.iter().position(|s| *s == name)
}

/// A name as it is, or in the quotes that names with blanks and units have in expressions.
fn unquoted(name: &str) -> String {
    let name = name.trim();
    let inner = name.strip_prefix('"').and_then(|n| n.strip_suffix('"'));
    inner.map_or_else(|| name.to_owned(), |n| n.replace("\"\"", "\""))
}

/// An expression in a setting, whose fault names the setting.
pub(super) fn expression(key: &'static str, text: &str) -> Result<Expr, SindyError> {
    parse(text).map_err(|error| match error {
        SindyError::Expression { text, reason } => {
            // The lines below show the text with a mark.
            let reason = reason.lines().next().unwrap_or_default();
            let expected = format!("an expression ({reason})");
            SindyError::setting(key, expected, format!("`{text}`"))
        }
        other => other,
    })
}

/// The left side of a state's equation.
pub(super) fn left_side(state: &str, discrete: bool) -> String {
    match discrete {
        true => format!("{state}[k+1]"),
        false => format!("{state}'"),
    }
}

/// What may stand before `mark`, for messages.
pub(super) fn left_sides(states: &[String], discrete: bool, mark: &str) -> String {
    let all: Vec<String> = states.iter().map(|s| left_side(s, discrete)).collect();
    format!("one of {} before `{mark}`", all.join(", "))
}

fn right_side(text: &str, names: &[String]) -> Result<KnownPart, SindyError> {
    let rest = REST.iter().find_map(|rest| text.strip_suffix(rest));
    let known = match rest {
        Some(known) => match known.trim_end().strip_suffix('+') {
            Some(known) => known.trim(),
            None => return Err(refused("a known part, `+` and `...`", text)),
        },
        None => text,
    };
    let mut terms: Vec<Term> = Vec::new();
    for part in summands(known) {
        let expression = expression(KEY, part)?;
        let unknown = |v: &&str| !names.iter().any(|n| n == v);
        if let Some(name) = expression.variables().into_iter().find(unknown) {
            let expected = format!("terms of {}", names.join(", "));
            return Err(refused(&expected, name));
        }
        let (coefficient, factors) = expression.factors();
        if !coefficient.is_finite() || coefficient == 0.0 {
            return Err(refused("finite coefficients that are not 0", part));
        }
        let expression = Expr::product(factors.iter().map(factor));
        match terms.iter_mut().find(|t| t.expression == expression) {
            Some(same) => same.coefficient += coefficient,
            None => terms.push(Term::new(expression, coefficient)),
        }
    }
    terms.retain(|t| t.coefficient != 0.0);
    if terms.is_empty() {
        return Err(refused("a sum that is not 0", text));
    }
    Ok(KnownPart {
        terms,
        whole: rest.is_none(),
    })
}

fn factor(f: &Factor) -> Expr {
    let power = |n: u32| match n {
        1 => f.base.clone(),
        n => f.base.powi(i32::try_from(n).unwrap_or(i32::MAX)),
    };
    match (f.above, f.below) {
        (above, 0) => power(above),
        (0, below) => Expr::constant(1.0) / power(below),
        (above, below) => power(above) / power(below),
    }
}

/// A sum cut before each `+` and `-` that joins its terms.
fn summands(text: &str) -> Vec<&str> {
    let bytes = text.as_bytes();
    let (mut depth, mut from) = (0, 0);
    let mut out = Vec::new();
    for at in 0..bytes.len() {
        match bytes[at] {
            b'(' => depth += 1,
            b')' => depth -= 1,
            b'+' | b'-' if depth == 0 => {
                let before = text[from..at].trim_end();
                // A sign, or the exponent of a number, joins nothing.
                let sign =
                    before.is_empty() || before.ends_with(['*', '/', '^', '+', '-', '<', '>']);
                let digits = before.trim_end_matches(['e', 'E']);
                let exponent = digits.len() + 1 == before.len()
                    && before.len() == text[from..at].len()
                    && digits.ends_with(|c: char| c.is_ascii_digit() || c == '.');
                if !sign && !exponent {
                    out.push(&text[from..at]);
                    from = at + usize::from(bytes[at] == b'+');
                }
            }
            _ => {}
        }
    }
    out.push(&text[from..]);
    out
}

/// Whether two terms are the same but for a number.
pub(super) fn same_factors(a: &Expr, b: &Expr) -> bool {
    let (a, b) = (a.factors(), b.factors());
    a.1.len() == b.1.len() && a.1.iter().all(|f| b.1.contains(f))
}

impl KnownPart {
    /// The candidate terms of the unknown part: the library without the known terms; empty if the whole equation is known.
    pub(super) fn remaining(&self, library: &Library) -> Library {
        let known = |term: &Expr| self.terms.iter().any(|k| same_factors(&k.expression, term));
        let left_out: Vec<usize> = (0..library.len())
            .filter(|&j| self.whole || known(&library.terms()[j]))
            .collect();
        library.without(&left_out)
    }

    /// Intervals of all terms of an equation: none of those that are known, which come first.
    pub(super) fn before(&self, others: Vec<Option<[f64; 2]>>) -> Vec<Option<[f64; 2]>> {
        let mut all = vec![None; self.terms.len()];
        all.extend(others);
        all
    }

    /// A library with the sum of the known terms behind its own, for statistics; [`Self::less`] takes it away again.
    pub(super) fn with(&self, library: &Library) -> Library {
        let parts = self.terms.iter();
        let parts = parts.map(|t| Expr::constant(t.coefficient) * t.expression.clone());
        let known = (!self.terms.is_empty()).then(|| Expr::sum(parts));
        Library::of(library.terms().iter().cloned().chain(known).collect())
    }

    /// Statistics over [`Self::with`] as those of the target less what is known, over the other terms. They have no
    /// triangular factor.
    pub(super) fn less(&self, gram: Gram) -> Gram {
        if self.terms.is_empty() {
            return gram;
        }
        let k = gram.xty.len() - 1;
        let own = gram.xtx.view((0, 0), (k, k)).into_owned();
        let of_known = gram.xtx.view((0, k), (k, 1)).column(0).into_owned();
        Gram {
            xty: gram.xty.rows(0, k) - of_known,
            yty: (gram.yty - 2.0 * gram.xty[k] + gram.xtx[(k, k)]).max(0.0),
            xtx: own,
            triangle: None,
            ..gram
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(text: &str) -> Result<KnownPart, SindyError> {
        right_side(text, &["x", "y", "e"].map(String::from))
    }

    fn written(part: &KnownPart) -> Vec<String> {
        let terms = part.terms.iter();
        terms
            .map(|t| format!("{} {}", t.coefficient, t.expression))
            .collect()
    }

    #[test]
    fn prop_sums_are_cut_into_terms() {
        let one = part("-9.81*sin(x - y) + 1e-3*y^2 - x/2 + 2 - 2*e - 3*e").unwrap();
        let terms = ["-9.81 sin(x - y)", "0.001 y^2", "-0.5 x", "2 1", "-5 e"];
        assert_eq!(written(&one), terms);
        assert!(one.whole);
        let some = part("-y*x^-1 + ...").unwrap();
        assert!(!some.whole && some.terms.len() == 1, "{some:?}");
        assert!(part("0*x").is_err() && part("x ...").is_err() && part("z").is_err());
        assert!(part("").is_err());
    }

    #[test]
    fn prop_faults_name_the_setting() {
        for (text, expected) in [("x*", "an expression"), ("2*z", "terms of x, y, e")] {
            let error = part(text).unwrap_err().to_string();
            assert!(error.contains("`known`: expected"), "{error}");
            assert!(error.contains(expected), "{error}");
            assert_eq!(error.lines().count(), 1, "{error}");
        }
    }

    #[test]
    fn prop_known_terms_leave_the_library() {
        let library = Library::polynomial(&["x", "y"], 2).unwrap();
        let known = part("3*y*x - 2 + ...").unwrap();
        assert_eq!(known.remaining(&library).names(), ["x", "y", "x^2", "y^2"]);
        assert!(part("y").unwrap().remaining(&library).is_empty());
    }
}
