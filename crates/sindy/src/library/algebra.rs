//! Products and sums of libraries.

use std::collections::HashSet;

use sindy_expr::Expr;

use super::factored::{Alphabet, Factored};
use super::{Library, check_terms};
use crate::error::{SindyError, require};

/// Pairs of terms that a product may have before equal ones are merged.
pub(super) const MAX_PAIRS: usize = 200_000;

impl Library {
    /// Every term of `a` times every term of `b`: `a₁b₁, a₁b₂, …, a₂b₁, …`.
    ///
    /// Products are tidied (`1*x` is `x`, `x*x` is `x^2`) and equal ones are kept once, at the place of the
    /// first. Variables keep the order in which `a`, then `b` use them first.
    ///
    /// ```
    /// use sindy::Library;
    /// let poly = Library::polynomial(&["x", "y"], 1)?;
    /// let square = Library::product(&poly, &poly)?;
    /// assert_eq!(square.names(), ["1", "x", "y", "x^2", "x*y", "y^2"]);
    /// # Ok::<(), sindy::SindyError>(())
    /// ```
    ///
    /// # Errors
    /// More than [`super::MAX_TERMS`] products, or more than 200 000 before equal ones are merged.
    pub fn product(a: &Self, b: &Self) -> Result<Self, SindyError> {
        let variables = by_appearance(a.terms.iter().chain(&b.terms));
        Self::product_in(a, b, &variables)
    }

    /// The product with the variables in the given order.
    pub(super) fn product_in(a: &Self, b: &Self, variables: &[String]) -> Result<Self, SindyError> {
        let pairs = a.len().checked_mul(b.len());
        if pairs.is_none_or(|pairs| pairs > MAX_PAIRS) {
            let expected = format!("at most {MAX_PAIRS} products of a term with a term");
            let found = format!("{} times {} terms", a.len(), b.len());
            return Err(SindyError::setting("library", expected, found));
        }
        let terms: Vec<Expr> = a.terms.iter().chain(&b.terms).cloned().collect();
        let (alphabet, factored) = Alphabet::new(&terms, variables);
        let (left, right) = factored.split_at(a.len());
        let mut seen: HashSet<Factored> = HashSet::new();
        let mut products = Vec::new();
        for a in left {
            for b in right {
                let product = a.times(b);
                if seen.insert(product.clone()) {
                    products.push(alphabet.expr(&product));
                    check_terms(Some(products.len()))?;
                }
            }
        }
        Ok(Self::of(products))
    }

    /// The terms of all parts in order, equal ones once (at the place and under the name of the first).
    ///
    /// ```
    /// use sindy::Library;
    /// let poly = Library::polynomial(&["x", "y"], 1)?;
    /// let more = Library::parse(&["y*x", "x", "sin(y)"])?;
    /// assert_eq!(Library::sum(&[poly, more])?.names(), ["1", "x", "y", "y*x", "sin(y)"]);
    /// # Ok::<(), sindy::SindyError>(())
    /// ```
    ///
    /// # Errors
    /// No parts, or more than [`super::MAX_TERMS`] distinct terms.
    pub fn sum(parts: &[Self]) -> Result<Self, SindyError> {
        require(!parts.is_empty(), "library", "at least one part", "none")?;
        let terms: Vec<Expr> = parts.iter().flat_map(|p| p.terms.clone()).collect();
        let (_, factored) = Alphabet::new(&terms, &[]);
        let mut seen = HashSet::new();
        let mut sum = Self {
            names: Vec::new(),
            terms: Vec::new(),
        };
        let names = parts.iter().flat_map(|p| &p.names);
        for ((name, term), factored) in names.zip(terms).zip(factored) {
            if seen.insert(factored) {
                sum.names.push(name.clone());
                sum.terms.push(term);
            }
        }
        check_terms(Some(sum.len()))?;
        Ok(sum)
    }
}

/// All variables in the order in which the terms use them first; those of one term as its factors name them.
fn by_appearance<'a>(terms: impl Iterator<Item = &'a Expr>) -> Vec<String> {
    let mut seen = HashSet::new();
    let mut order = Vec::new();
    for term in terms {
        for factor in term.factors().1 {
            for name in factor.base.variables() {
                if seen.insert(name.to_string()) {
                    order.push(name.to_string());
                }
            }
        }
    }
    order
}
