//! Relations that can write another one with a factor that their N and D share.
//!
//! ```text
//! x - x²/2 = (x - x³/4)/(1 + x/2)
//! ```
//!
//! The right side has one coefficient more, follows every trajectory as well, and is no other model.

use nalgebra::DMatrix;
use sindy_expr::Scratch;

use super::relation::{Candidates, Relation};
use crate::error::SindyError;
use crate::library::Library;

/// A singular value below this share of the largest is rounding: an identity leaves 1e-15 or so, and polynomials of up to
/// fifth degree that are none leave 1e-6 in the box that is looked at.
const ROUNDING: f64 = 1e-10;
/// Points for each coefficient, at least.
const PER_COEFFICIENT: usize = 3;

/// Whether some coefficients of the terms of `other`, N' over D', give the right side N/D of `relation`: whether
/// `N' D - N D' = 0` at all `points`, of columns `names`, has a solution that is not 0.
pub(super) fn writes(
    other: &Relation,
    relation: &Relation,
    of: &Candidates,
    (names, points): (&[String], &[Vec<f64>]),
) -> Result<bool, SindyError> {
    let (above, below) = relation.sides(of);
    let over = other.numerator.iter();
    let over = over.map(|(j, _)| of.numerator.terms()[*j].clone() * below.clone());
    let under = other.denominator.iter();
    let under = under.map(|(k, _)| of.denominator.terms()[*k].clone() * above.clone());
    let terms: Vec<_> = over.chain(under).collect();
    let p = terms.len();
    let program = Library::of(terms).compile(names)?;
    let mut scratch = Scratch::new();
    let mut row = vec![0.0; p];
    let mut rows = Vec::new();
    for point in points {
        program.eval_row(point, &mut row, &mut scratch);
        if row.iter().all(|v| v.is_finite()) {
            rows.push(row.clone());
        }
    }
    if rows.len() < PER_COEFFICIENT * p {
        return Ok(false);
    }
    let mut matrix = DMatrix::from_fn(rows.len(), p, |i, j| rows[i][j]);
    for mut column in matrix.column_iter_mut() {
        let length = column.norm();
        if length > 0.0 {
            column /= length;
        }
    }
    let values = matrix.singular_values();
    Ok(values.min() <= ROUNDING * values.max())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_a_shared_factor_is_seen_and_other_terms_are_not_taken_for_one() {
        let of = Candidates {
            numerator: Library::polynomial(&["x", "y"], 3).unwrap(),
            denominator: Library::polynomial(&["x", "y"], 2).unwrap(),
        };
        let names = ["x", "y"].map(String::from);
        let points: Vec<Vec<f64>> = (1..60)
            .map(|k| vec![0.05 * f64::from(k), (0.7 * f64::from(k)).sin()])
            .collect();
        let place =
            |library: &Library, term: &str| library.names().iter().position(|n| n == term).unwrap();
        let relation = |above: &[(&str, f64)], below: &[(&str, f64)]| Relation {
            numerator: above
                .iter()
                .map(|(t, c)| (place(&of.numerator, t), *c))
                .collect(),
            denominator: below
                .iter()
                .map(|(t, c)| (place(&of.denominator, t), *c))
                .collect(),
        };
        let holds = |a: &Relation, b: &Relation| writes(a, b, &of, (&names, &points)).unwrap();
        // Logistic growth with the factor 1 + x/2, an enzyme with 1 + 5 x, satiation with 1 + 0.7 x. The coefficients of the
        // larger ones play no part: estimates of them are only near.
        let logistic = relation(&[("x", 1.0), ("x^2", -0.5)], &[("1", 1.0)]);
        let larger = relation(&[("x", 0.97), ("x^3", -0.24)], &[("1", 1.0), ("x", 0.4)]);
        assert!(holds(&larger, &logistic) && !holds(&logistic, &larger));
        let enzyme = relation(&[("1", 0.6), ("x", -3.0)], &[("1", 1.0), ("x", 10.0 / 3.0)]);
        let larger = relation(
            &[("1", 0.6), ("x^2", -15.0)],
            &[("1", 1.0), ("x", 8.4), ("x^2", 17.0)],
        );
        assert!(holds(&larger, &enzyme));
        let satiated = relation(&[("y", -0.4), ("x*y", 0.28)], &[("1", 1.0), ("x", 0.8)]);
        let larger = relation(
            &[("y", -0.4), ("x^2*y", 0.2)],
            &[("1", 1.0), ("x", 1.5), ("x^2", 0.6)],
        );
        assert!(holds(&larger, &satiated));
        // Terms that cannot: another numerator, another variable.
        let other = relation(&[("1", 0.6), ("x^3", -3.0)], &[("1", 1.0), ("x", 3.0)]);
        assert!(!holds(&other, &enzyme) && !holds(&other, &logistic));
        let other = relation(&[("y", -0.4), ("x*y^2", 0.2)], &[("1", 1.0), ("y", 1.5)]);
        assert!(!holds(&other, &satiated));
    }
}
