//! A rational right-hand side by its terms, and what it is to first order.

use sindy_expr::Expr;

use crate::error::SindyError;
use crate::identify::known::KnownPart;
use crate::library::{Library, parse};
use crate::model::Term;

/// The candidate terms of one equation.
#[derive(Clone, Debug)]
pub(super) struct Candidates {
    pub numerator: Library,
    /// The constant first.
    pub denominator: Library,
}

impl Candidates {
    /// How many coefficients they have.
    pub(super) fn len(&self) -> usize {
        self.numerator.len() + self.denominator.len()
    }
}

/// A candidate by its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    Numerator(usize),
    Denominator(usize),
}

/// `x' = N/D`.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Relation {
    /// Terms of N and their coefficients.
    pub numerator: Vec<(usize, f64)>,
    /// Terms of D and their coefficients; the first is held at 1.
    pub denominator: Vec<(usize, f64)>,
}

/// The relation with small changes of its coefficients:
///
/// ```text
/// x' = Σ ξ_j θ_j/D - Σ η_k φ_k N/D²  +  (D - φ_0) N/D²
/// ```
///
/// with D and N as they are. It is linear in ξ and η, and where the fit of it gives ξ and η as they are, the fit of N/D is found.
pub(super) struct Linear {
    pub library: Library,
    pub known: KnownPart,
    pub places: Vec<Place>,
    pub coefficients: Vec<f64>,
}

impl Relation {
    /// Coefficients that are estimated.
    pub(super) fn free(&self) -> usize {
        self.numerator.len() + self.denominator.len() - 1
    }

    /// Whether the right side is a plain sum of terms.
    pub(super) fn is_explicit(&self) -> bool {
        matches!(self.denominator.as_slice(), [(0, _)])
    }

    /// The terms of the denominator, in order.
    pub(super) fn denominators(&self) -> Vec<usize> {
        let mut below: Vec<usize> = self.denominator.iter().map(|t| t.0).collect();
        below.sort_unstable();
        below
    }

    /// Which terms there are, in order.
    pub(super) fn support(&self) -> Vec<Place> {
        let mut above: Vec<usize> = self.numerator.iter().map(|t| t.0).collect();
        above.sort_unstable();
        let above = above.into_iter().map(Place::Numerator);
        let below = self.denominators().into_iter().map(Place::Denominator);
        above.chain(below).collect()
    }

    /// Whether all terms of `other` are terms of this one.
    pub(super) fn contains(&self, other: &Self) -> bool {
        let own = self.support();
        other.support().iter().all(|p| own.contains(p))
    }

    /// The same with the term of place `first` in the denominator held at 1, if there is one with a coefficient.
    pub(super) fn held_at(&self, first: usize) -> Self {
        let place = self.denominator.iter().position(|t| t.0 == first);
        let Some(place) = place.filter(|p| self.denominator[*p].1 != 0.0) else {
            return self.clone();
        };
        let scale = self.denominator[place].1;
        let scaled = |t: &(usize, f64)| (t.0, t.1 / scale);
        let mut denominator: Vec<_> = self.denominator.iter().map(scaled).collect();
        denominator[..=place].rotate_right(1);
        denominator[0].1 = 1.0;
        denominator[1..].sort_by_key(|t| t.0);
        Self {
            numerator: self.numerator.iter().map(scaled).collect(),
            denominator,
        }
    }

    /// The same relation without a factor that all terms of N and D share, where the candidates hold what is left.
    pub(super) fn reduced(&self, of: &Candidates) -> Self {
        let mut at = self.clone();
        while let Some(next) = at.without_a_factor(of) {
            at = next;
        }
        at
    }

    fn without_a_factor(&self, of: &Candidates) -> Option<Self> {
        let above: Vec<Powers> = of.numerator.terms().iter().map(powers).collect();
        let below: Vec<Powers> = of.denominator.terms().iter().map(powers).collect();
        let first = &below[self.denominator[0].0];
        first.iter().find_map(|(base, _)| {
            let divided = |terms: &[(usize, f64)], library: &[Powers]| {
                let one = |&(j, c): &(usize, f64)| {
                    let mut rest = library[j].clone();
                    let factor = rest.iter_mut().find(|(b, n)| b == base && *n > 0)?;
                    factor.1 -= 1;
                    rest.retain(|(_, n)| *n != 0);
                    let same =
                        |l: &Powers| l.len() == rest.len() && rest.iter().all(|f| l.contains(f));
                    Some((library.iter().position(same)?, c))
                };
                terms.iter().map(one).collect::<Option<Vec<_>>>()
            };
            Some(Self {
                numerator: divided(&self.numerator, &above)?,
                denominator: divided(&self.denominator, &below)?,
            })
        })
    }

    /// N and D as expressions.
    pub(super) fn sides(&self, of: &Candidates) -> (Expr, Expr) {
        let sum = |terms: &[(usize, f64)], library: &Library| {
            Expr::sum(terms.iter().map(|&(j, c)| match c {
                1.0 => library.terms()[j].clone(),
                c => Expr::constant(c) * library.terms()[j].clone(),
            }))
        };
        (
            sum(&self.numerator, &of.numerator),
            sum(&self.denominator, &of.denominator),
        )
    }

    /// The relation to first order, over its own terms or all candidates.
    pub(super) fn linear(&self, of: &Candidates, all: bool) -> Result<Linear, SindyError> {
        let (above, below) = self.sides(of);
        let explicit = self.is_explicit();
        let one = Expr::constant(1.0);
        let over = |term: &Expr| match explicit {
            true => term.clone(),
            false if *term == one => term / &below,
            false => term.clone() / below.clone(),
        };
        // What a change of D does.
        let slope = match explicit {
            true => -&above,
            false => -(&above / &below.powi(2)),
        };
        let (numerator, denominator) = (&of.numerator, &of.denominator);
        let coefficient = |terms: &[(usize, f64)], j: usize| {
            let found = terms.iter().find(|t| t.0 == j);
            found.map(|t| t.1)
        };
        let (mut terms, mut places, mut coefficients) = (Vec::new(), Vec::new(), Vec::new());
        for j in 0..numerator.len() {
            let own = coefficient(&self.numerator, j);
            if all || own.is_some() {
                terms.push(readable(&over(&numerator.terms()[j]))?);
                places.push(Place::Numerator(j));
                coefficients.push(own.unwrap_or(0.0));
            }
        }
        let held = self.denominator[0].0;
        let moves = !self.numerator.is_empty();
        for k in (0..denominator.len()).filter(|k| *k != held && moves) {
            let own = coefficient(&self.denominator, k);
            if all || own.is_some() {
                terms.push(readable(&(&denominator.terms()[k] * &slope))?);
                places.push(Place::Denominator(k));
                coefficients.push(own.unwrap_or(0.0));
            }
        }
        let mut known = KnownPart::default();
        if !explicit && self.denominator.len() > 1 {
            let rest = Self {
                numerator: Vec::new(),
                denominator: self.denominator[1..].to_vec(),
            };
            let part = rest.sides(of).1 * -slope;
            known.terms.push(Term::new(readable(&part)?, 1.0));
        }
        Ok(Linear {
            library: Library::of(terms),
            known,
            places,
            coefficients,
        })
    }

    /// The relation with other coefficients in the places of a linear one; those that are 0 leave.
    pub(super) fn with(&self, places: &[Place], coefficients: &[f64]) -> Self {
        let mut out = Self {
            numerator: Vec::new(),
            denominator: vec![(self.denominator[0].0, 1.0)],
        };
        let above = |(place, c): (&Place, &f64)| matches!(place, Place::Numerator(_)) && *c != 0.0;
        if !places.iter().zip(coefficients).any(above) {
            // Nothing over anything is 0.
            out.denominator = vec![(0, 1.0)];
            return out;
        }
        for (place, &c) in places.iter().zip(coefficients).filter(|(_, c)| **c != 0.0) {
            match *place {
                Place::Numerator(j) => out.numerator.push((j, c)),
                Place::Denominator(k) => out.denominator.push((k, c)),
            }
        }
        out
    }

    /// The relation a part of the way to another one with the same terms.
    pub(super) fn towards(&self, other: &Self, part: f64) -> Self {
        let blend = |own: &[(usize, f64)], to: &[(usize, f64)]| {
            let before = |j: usize| own.iter().find(|t| t.0 == j).map_or(0.0, |t| t.1);
            let mixed = |&(j, c): &(usize, f64)| (j, before(j) + part * (c - before(j)));
            to.iter().map(mixed).collect()
        };
        Self {
            numerator: blend(&self.numerator, &other.numerator),
            denominator: blend(&self.denominator, &other.denominator),
        }
    }
}

/// The factors of a term, with their powers.
type Powers = Vec<(Expr, i64)>;

fn powers(term: &Expr) -> Powers {
    let (_, factors) = term.factors();
    let all = factors
        .into_iter()
        .map(|f| (f.base, i64::from(f.above) - i64::from(f.below)));
    all.filter(|(_, n)| *n != 0).collect()
}

/// The same expression in the form in which its text reads back.
pub(super) fn readable(expression: &Expr) -> Result<Expr, SindyError> {
    parse(&expression.to_string())
}

#[cfg(test)]
mod tests {
    use sindy_expr::{Program, Scratch};

    use super::*;

    fn candidates() -> Candidates {
        Candidates {
            numerator: Library::polynomial(&["x", "y"], 3).unwrap(),
            denominator: Library::polynomial(&["x", "y"], 2).unwrap(),
        }
    }

    fn value(expressions: &[Expr], x: f64, y: f64) -> Vec<f64> {
        let program = Program::compile(expressions, &["x", "y"]).unwrap();
        let mut out = vec![0.0; expressions.len()];
        program.eval_row(&[x, y], &mut out, &mut Scratch::new());
        out
    }

    #[test]
    fn analytic_a_relation_to_first_order_has_its_value_and_derivatives() {
        let of = candidates();
        // (0.4 x - 1.2 x y)/(1 + 0.7 x + 0.3 y^2)
        let relation = Relation {
            numerator: vec![(1, 0.4), (4, -1.2)],
            denominator: vec![(0, 1.0), (1, 0.7), (5, 0.3)],
        };
        let ratio = |relation: &Relation| {
            let (above, below) = relation.sides(&of);
            value(&[above / below], 0.8, 1.3)[0]
        };
        for held in [0, 5] {
            let at = relation.held_at(held);
            assert!((ratio(&at) - ratio(&relation)).abs() < 1e-15);
            let linear = at.linear(&of, true).unwrap();
            let terms = value(linear.library.terms(), 0.8, 1.3);
            let known = value(&[linear.known.terms[0].expression.clone()], 0.8, 1.3)[0];
            let pairs = terms.iter().zip(&linear.coefficients);
            let sum = known + pairs.map(|(t, c)| t * c).sum::<f64>();
            // Rounding of some ten terms of size 1.
            assert!((sum - ratio(&relation)).abs() < 1e-14, "{sum}");
            for (j, term) in terms.iter().enumerate() {
                let moved = |by: f64| {
                    let mut coefficients = linear.coefficients.clone();
                    coefficients[j] += by;
                    ratio(&at.with(&linear.places, &coefficients))
                };
                let slope = (moved(1e-5) - moved(-1e-5)) / 2e-5;
                // Central differences: 1e-10 from the third derivative, 1e-11 from rounding.
                assert!((slope - term).abs() < 1e-8, "{j}: {slope} {term}");
            }
        }
    }

    #[test]
    fn analytic_shared_factors_leave() {
        let of = candidates();
        // (0.6 x y - 3 x^2 y)/(x + 3 x^2) has the factor x, and y only above.
        let relation = Relation {
            numerator: vec![(4, 0.6), (7, -3.0)],
            denominator: vec![(1, 1.0), (3, 3.0)],
        };
        let simple = Relation {
            numerator: vec![(2, 0.6), (4, -3.0)],
            denominator: vec![(0, 1.0), (1, 3.0)],
        };
        assert_eq!(relation.reduced(&of), simple);
        assert_eq!(simple.reduced(&of), simple);
        assert!(!simple.is_explicit() && simple.free() == 3);
    }
}
