//! Models by regression, ranked by free run.

use super::regress::Regression;
use crate::trajectory::output_error::{Piece, System, free_run};

/// Approximate number of rows on which models are ranked. Their free-run error scatters by about 1/√20 000 = 0.7 %. Twice
/// as many rows take twice the time for 0.5 %.
pub(super) const RANKED: usize = 10_000;

/// Free-run errors that round to the same multiple of 1/50 of the noise count as alike, and fewer terms come first: a
/// step of 2 % is three times the scatter. Steps half as wide would rank by scatter; steps twice as wide let a term of
/// 4 % of the error go.
const STEPS: f64 = 50.0;

/// A free-run error below this share of another is better: the same 2 %.
pub(super) const BETTER: f64 = 0.98;

/// A model by regression, with what it is ranked by.
#[derive(Clone)]
pub(super) struct RankedModel {
    pub regression: Regression,
    pub coefficients: Vec<f64>,
    pub free_run: f64,
}

impl RankedModel {
    pub(super) fn new(
        regression: Regression,
        system: &System,
        yardstick: &[Piece<'_>],
        sigma: &[f64],
    ) -> Self {
        let fits = regression.fits.iter();
        let coefficients: Vec<f64> = fits.flat_map(|f| f.coefficients.iter().copied()).collect();
        Self {
            free_run: free_run(system, yardstick, &coefficients, sigma),
            coefficients,
            regression,
        }
    }

    /// Terms in all equations.
    pub(super) fn terms(&self) -> usize {
        self.coefficients.iter().filter(|c| **c != 0.0).count()
    }
}

/// Sorts by the free-run error; the fewest terms come first among models that predict alike.
pub(super) fn by_free_run(ranked: &mut [RankedModel]) {
    let rounded = |r: &RankedModel| (r.free_run * STEPS).round();
    ranked.sort_by(|a, b| {
        let alike = rounded(a).total_cmp(&rounded(b));
        alike.then(a.terms().cmp(&b.terms()))
    });
}
