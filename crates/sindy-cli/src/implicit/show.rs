//! Rational equations as text for people.

use std::fmt::Write as _;

use sindy::implicit::ComparedRelation;

use super::object::ImplicitObject;
use crate::fit::object::TermObject;
use crate::fit::show::{COEFFICIENTS, coefficient_rows, table, words, wrapped};
use crate::named::Named;
use crate::numbers::significant;

/// Relations of an equation that are shown.
const SHOWN: usize = 5;

/// Equations, coefficients with intervals, and what they were compared with.
pub(super) fn text(object: &ImplicitObject) -> String {
    let mut out = format!("{}\n\n", object.text.join("\n"));
    out.push_str(&coefficients(object));
    for (state, equation) in object.equations.iter() {
        if equation.compared.len() > 1 {
            let _ = writeln!(
                out,
                "\nrelations of {state} (against: twice the logarithm of the odds against it)"
            );
            let rows: Vec<Vec<String>> =
                equation.compared.iter().take(SHOWN).map(compared).collect();
            out.push_str(&table(
                &["coefficients", "against", "relation"],
                &rows,
                &[2],
            ));
        }
    }
    for (state, equation) in object.equations.iter() {
        if let Some(residual) = equation.residual {
            let (left, noise) = (significant(residual, 3), significant(equation.noise, 3));
            let _ = write!(
                out,
                "\nfit       {state}: the model leaves {left}, noise {noise}"
            );
        }
    }
    let _ = write!(out, "\nchoice    {}", wrapped(&object.reason));
    let _ = write!(out, "\noutcome   {}", words(object.outcome));
    let _ = write!(out, "\ndata      {}", wrapped(&object.data.summary()));
    out
}

/// The table of all coefficients, those of numerators and denominators under names of their own.
fn coefficients(object: &ImplicitObject) -> String {
    let rows = object.equations.iter().flat_map(|(state, equation)| {
        let named = |name: String, terms: &[TermObject]| {
            let terms: Vec<TermObject> = terms.to_vec();
            coefficient_rows(&Named::new(&[name], [terms]))
        };
        let mut rows = named(format!("{state}, above"), &equation.numerator);
        let explicit = equation.denominator.len() == 1 && equation.denominator[0].term == "1";
        if explicit {
            rows.iter_mut().for_each(|row| row[0] = state.to_owned());
        } else {
            rows.extend(named(format!("{state}, below"), &equation.denominator));
        }
        rows
    });
    table(&COEFFICIENTS, &rows.collect::<Vec<_>>(), &[0, 1])
}

fn compared(relation: &ComparedRelation) -> Vec<String> {
    vec![
        relation.coefficients.to_string(),
        match relation.against.is_finite() {
            true => format!("{:.1}", relation.against),
            false => "-".to_owned(),
        },
        relation.equation.clone(),
    ]
}
