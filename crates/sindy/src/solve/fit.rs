//! The fit of a sparse solver, and the trait of all solvers.

use nalgebra::DVector;

use crate::error::SindyError;
use crate::solve::outcome::Outcome;
use crate::statistics::gram::Gram;
use crate::statistics::regression::least_squares;

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
