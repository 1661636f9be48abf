//! What qualifies the equation of a field.

use super::fit::{FieldFit, MOST, Preferred, SMALL};
use super::model::FieldEquation;

/// A term that could contribute more than this share of the left side matters.
const HIDES: f64 = 0.1;
/// Hidden terms that are named, at most.
const NAMED: usize = 3;

/// Warnings of an equation.
pub(super) fn doubts(equation: &FieldEquation, fit: &FieldFit, names: &[String]) -> Vec<String> {
    let (left, estimate) = (&equation.left, &fit.estimate);
    let mut out = Vec::new();
    if equation.terms.is_empty() {
        out.push(nothing(equation, fit, names));
        return out;
    }
    if !estimate.corrected {
        out.push(format!(
            "equation of {left}: the noise is too large for its bias to be taken away; coefficients are too small, by more \
             than their intervals"
        ));
    }
    let hidden: Vec<String> = fit
        .hidden
        .iter()
        .filter(|hidden| hidden.share > HIDES)
        .map(|hidden| {
            format!(
                "{} up to {:.0} %",
                names[hidden.term],
                100.0 * hidden.share.min(1.0)
            )
        })
        .collect();
    if !hidden.is_empty() {
        let more = hidden.len().saturating_sub(NAMED);
        let rest = match more {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        out.push(format!(
            "equation of {left}: these data cannot exclude terms that are not in it, which could contribute {} of {left}{rest}",
            hidden[..hidden.len().min(NAMED)].join(", ")
        ));
    }
    if !fit.rivals.is_empty() {
        let named = fit.rivals.iter().take(NAMED).map(|terms| {
            let names: Vec<&str> = terms.iter().map(|&j| names[j].as_str()).collect();
            format!("those of {}", names.join(", "))
        });
        out.push(format!(
            "equation of {left}: other terms are about as likely: {}",
            named.collect::<Vec<_>>().join("; ")
        ));
    }
    if equation
        .terms
        .iter()
        .all(|t| t.of.degree() == 1 && t.of.order() == 1)
    {
        out.push(format!(
            "equation of {left}: waves that travel without a change of shape explain all: every equation that has such waves fits, \
             and these data cannot tell which is true"
        ));
    }
    if estimate.misses && estimate.unexplained > SMALL {
        out.push(format!(
            "equation of {left}: the residual is {:.1} times that of white noise, {:.1} % of {left}: a term is not in the library, \
             or the noise is not white",
            estimate.misfit,
            100.0 * estimate.unexplained
        ));
    }
    out
}

/// What to say where no term is left.
fn nothing(equation: &FieldEquation, fit: &FieldFit, names: &[String]) -> String {
    let left = &equation.left;
    let Preferred { terms, explained } = &fit.preferred;
    if *explained > MOST {
        let terms: Vec<&str> = terms.iter().map(|&j| names[j].as_str()).collect();
        return format!(
            "equation of {left}: {} explain {:.0} % of it, but none of them is certain beside the residual: a term is not in the \
             library, or the noise is not white",
            terms.join(", "),
            100.0 * explained
        );
    }
    format!(
        "equation of {left}: no candidate explains it; what moves {} is not in the library, or is below the noise",
        equation.field
    )
}
