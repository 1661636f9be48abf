//! Monomials up to a degree.

use sindy_expr::Expr;

use super::{Library, check_terms, check_variables};
use crate::error::SindyError;

/// Which products of different variables a polynomial library has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interaction {
    /// All of them: `x, y, x^2, x*y, y^2`.
    #[default]
    All,
    /// None, only powers: `x, y, x^2, y^2`.
    None,
    /// Nothing else, each variable at most once: `x, y, x*y`.
    Only,
}

/// A polynomial library with its options.
///
/// ```
/// use sindy::library::{Interaction, Polynomial};
/// let powers = Polynomial::new(2).bias(false).interaction(Interaction::None);
/// assert_eq!(powers.library(&["x", "y"])?.names(), ["x", "y", "x^2", "y^2"]);
/// # Ok::<(), sindy::SindyError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Polynomial {
    degree: u32,
    bias: bool,
    interaction: Interaction,
}

impl Polynomial {
    /// All monomials up to a total degree, the constant `1` among them.
    #[must_use]
    pub fn new(degree: u32) -> Self {
        Self {
            degree,
            bias: true,
            interaction: Interaction::All,
        }
    }

    /// With the constant `1` (the default) or without.
    #[must_use]
    pub fn bias(self, bias: bool) -> Self {
        Self { bias, ..self }
    }

    /// With the given products of different variables ([`Interaction::All`] by default).
    #[must_use]
    pub fn interaction(self, interaction: Interaction) -> Self {
        Self {
            interaction,
            ..self
        }
    }

    /// The library over `variables`, by rising degree, then in the variables' order.
    ///
    /// # Errors
    /// No variables, a name that is empty or occurs twice, no terms (degree 0 without the constant), or more
    /// than [`super::MAX_TERMS`] terms.
    pub fn library<S: AsRef<str>>(self, variables: &[S]) -> Result<Library, SindyError> {
        check_variables(variables)?;
        if self.degree == 0 && !self.bias {
            let expected = "at least 1 for a library without the constant";
            return Err(SindyError::setting("degree", expected, 0));
        }
        check_terms(self.count(variables.len()))?;
        let mut terms = Vec::new();
        if self.bias {
            terms.push(Expr::constant(1.0));
        }
        // Monomials of one degree, as ascending places of variables; those of the next prolong them.
        let mut last: Vec<Vec<usize>> = vec![vec![]];
        for _ in 0..self.degree {
            let mut next = Vec::new();
            for places in &last {
                let from = match (self.interaction, places.last()) {
                    (_, None) => 0..variables.len(),
                    (Interaction::All, Some(&p)) => p..variables.len(),
                    (Interaction::None, Some(&p)) => p..p + 1,
                    (Interaction::Only, Some(&p)) => p + 1..variables.len(),
                };
                next.extend(from.map(|place| [&places[..], &[place]].concat()));
            }
            if next.is_empty() {
                break;
            }
            terms.extend(next.iter().map(|places| monomial(variables, places)));
            last = next;
        }
        Ok(Library::of(terms))
    }

    /// The number of terms over `n` variables, if it is a number that a library may have.
    fn count(self, n: usize) -> Option<usize> {
        let mut of_degree = 1_usize;
        let mut count = usize::from(self.bias);
        for d in 1..=self.degree as usize {
            of_degree = match self.interaction {
                Interaction::All => of_degree.checked_mul(n + d - 1)? / d,
                Interaction::None => n,
                Interaction::Only if d > n => return Some(count),
                Interaction::Only => of_degree.checked_mul(n + 1 - d)? / d,
            };
            count = count.checked_add(of_degree)?;
            if count > 100 * super::MAX_TERMS {
                return None;
            }
        }
        Some(count)
    }
}

fn monomial<S: AsRef<str>>(variables: &[S], places: &[usize]) -> Expr {
    let runs = places.chunk_by(|a, b| a == b);
    let powers = runs.map(|run| (variables[run[0]].as_ref(), run.len() as u32));
    Expr::monomial(&powers.collect::<Vec<_>>())
}

impl Library {
    /// All monomials of `variables` up to the total degree `degree`, by rising degree:
    /// `1, x, y, x^2, x*y, y^2, …`. [`Polynomial`] has options.
    ///
    /// # Errors
    /// As [`Polynomial::library`].
    pub fn polynomial<S: AsRef<str>>(variables: &[S], degree: u32) -> Result<Self, SindyError> {
        Polynomial::new(degree).library(variables)
    }
}
