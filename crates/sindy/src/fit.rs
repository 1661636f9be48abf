//! What every sparse solver returns, and what a solver is.

use nalgebra::DVector;

use crate::error::SindyError;
use crate::gram::Gram;
use crate::outcome::Outcome;
use crate::regression::least_squares;

/// A sparse fit of one target, in the units of the data.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// Coefficients ξ of all p terms, zero outside the support.
    pub coefficients: DVector<f64>,
    /// Which terms are kept, p.
    pub support: Vec<bool>,
    /// Residual sum of squares `|y - Θ ξ|²`, in the target's unit squared.
    pub residual_sum: f64,
    /// Why the solver stopped.
    pub outcome: Outcome,
    /// Supports that were solved, or steps that were made.
    pub iterations: usize,
}

impl Fit {
    /// Least squares on the terms of `support`.
    #[must_use]
    pub fn on_support(
        gram: &Gram,
        support: Vec<bool>,
        outcome: Outcome,
        iterations: usize,
    ) -> Self {
        let coefficients = least_squares(gram, &support);
        Self::new(gram, coefficients, support, outcome, iterations)
    }

    /// A fit with given coefficients; its residual is taken from `gram`.
    pub(crate) fn new(
        gram: &Gram,
        coefficients: DVector<f64>,
        support: Vec<bool>,
        outcome: Outcome,
        iterations: usize,
    ) -> Self {
        Self {
            residual_sum: gram.residual_sum(&coefficients),
            coefficients,
            support,
            outcome,
            iterations,
        }
    }

    /// The number of terms that are kept.
    #[must_use]
    pub fn terms(&self) -> usize {
        self.support.iter().filter(|s| **s).count()
    }
}

/// A sparse solver: anything that turns the statistics of one target into a [`Fit`].
///
/// A closure will do as well.
pub trait Solver: Sync {
    /// Fits the target of `gram`.
    ///
    /// # Errors
    /// Statistics that are empty, not finite, or of shapes that do not fit.
    fn fit(&self, gram: &Gram) -> Result<Fit, SindyError>;
}

impl<F> Solver for F
where
    F: Fn(&Gram) -> Result<Fit, SindyError> + Sync,
{
    fn fit(&self, gram: &Gram) -> Result<Fit, SindyError> {
        self(gram)
    }
}

/// Refuses statistics that no solver can use.
///
/// # Errors
/// No terms, no rows, shapes that do not fit, or an entry that is not finite.
pub fn check(gram: &Gram) -> Result<(), SindyError> {
    let p = gram.xty.len();
    if p == 0 {
        return Err(SindyError::Shape {
            what: "terms of the library",
            expected: 1,
            found: 0,
        });
    }
    for (what, found) in [
        ("rows of the Gram matrix", gram.xtx.nrows()),
        ("columns of the Gram matrix", gram.xtx.ncols()),
    ] {
        if found != p {
            return Err(SindyError::Shape {
                what,
                expected: p,
                found,
            });
        }
    }
    if gram.rows == 0 {
        return Err(SindyError::TooShort {
            needed: 1,
            found: 0,
        });
    }
    let not_finite = |what: &str, index| SindyError::NotFinite {
        what: what.to_string(),
        index,
    };
    if let Some(j) = (0..p).find(|&j| gram.xtx.column(j).iter().any(|v| !v.is_finite())) {
        return Err(not_finite("Gram matrix, column", j));
    }
    if let Some(j) = (0..p).find(|&j| !gram.xty[j].is_finite()) {
        return Err(not_finite("products of terms and target", j));
    }
    if !gram.yty.is_finite() || gram.yty < 0.0 {
        return Err(not_finite("sum of squares of the target", 0));
    }
    Ok(())
}

/// Refuses a setting outside its range.
pub(crate) fn at_least_zero(key: &'static str, value: f64) -> Result<f64, SindyError> {
    if value.is_finite() && value >= 0.0 {
        Ok(value)
    } else {
        Err(SindyError::setting(
            key,
            "a finite number, at least 0",
            value,
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_unusable_statistics_are_refused_by_name() {
        assert!(check(&Gram::zeros(0)).is_err());
        assert_eq!(
            check(&Gram::zeros(2)),
            Err(SindyError::TooShort {
                needed: 1,
                found: 0
            })
        );
        let mut gram = Gram::zeros(2);
        gram.rows = 3;
        assert_eq!(check(&gram), Ok(()));
        gram.xtx[(0, 1)] = f64::NAN;
        assert!(check(&gram).unwrap_err().to_string().contains("Gram"));
        gram.xtx = nalgebra::DMatrix::zeros(3, 2);
        assert!(check(&gram).unwrap_err().to_string().contains("rows of"));
        let mut gram = Gram::zeros(2);
        gram.rows = 3;
        gram.yty = f64::INFINITY;
        assert!(check(&gram).is_err());
    }
}
