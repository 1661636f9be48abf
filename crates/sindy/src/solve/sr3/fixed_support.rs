//! The search for a support that its own solution confirms.

use nalgebra::DVector;

use crate::solve::outcome::Outcome;

/// Where a search ended, in scaled coefficients.
pub(crate) struct FixedPoint {
    pub(crate) dense: DVector<f64>,
    pub(crate) support: Vec<bool>,
    pub(crate) outcome: Outcome,
    /// Supports that were solved, or steps of the relaxation.
    pub(crate) iterations: usize,
}

impl FixedPoint {
    pub(crate) fn new(
        dense: DVector<f64>,
        support: Vec<bool>,
        outcome: Outcome,
        iterations: usize,
    ) -> Self {
        Self {
            dense,
            support,
            outcome,
            iterations,
        }
    }

    /// The dense vector on the support, zero elsewhere.
    pub(crate) fn on_support(&self) -> DVector<f64> {
        DVector::from_fn(self.dense.len(), |j, _| {
            if self.support[j] { self.dense[j] } else { 0.0 }
        })
    }
}

/// Solves for the coefficients of a support, keeps the terms above the threshold, and repeats until these are the
/// support that was solved. A support that cannot be solved ends the search at the one before.
pub(crate) fn fixed_support(
    start: Vec<bool>,
    max_iterations: usize,
    mut solve: impl FnMut(&[bool]) -> Result<DVector<f64>, Outcome>,
    above: impl Fn(&DVector<f64>) -> Vec<bool>,
) -> FixedPoint {
    let mut seen: Vec<Vec<bool>> = Vec::new();
    let mut support = start;
    let mut before: Option<DVector<f64>> = None;
    loop {
        let iterations = seen.len() + 1;
        let xi = match solve(&support) {
            Ok(xi) => xi,
            Err(outcome) => {
                let support = seen.pop().unwrap_or_else(|| vec![false; support.len()]);
                let xi = before.unwrap_or_else(|| DVector::zeros(support.len()));
                return FixedPoint::new(xi, support, outcome, iterations - 1);
            }
        };
        let next = above(&xi);
        let outcome = if next == support {
            Some(Outcome::Converged)
        } else if seen.contains(&next) {
            Some(Outcome::Cycled)
        } else if iterations >= max_iterations {
            Some(Outcome::IterationLimit)
        } else {
            None
        };
        if let Some(outcome) = outcome {
            return FixedPoint::new(xi, support, outcome, iterations);
        }
        seen.push(std::mem::replace(&mut support, next));
        before = Some(xi);
    }
}
