//! Least squares on supports that are met again and again, and for equations that differ in their targets alone.

use std::collections::HashMap;
use std::sync::Arc;

use nalgebra::DVector;

use super::{Eigenspaces, LastEigenspaces, UnitLength, least_norm};
use crate::statistics::gram::Gram;
use crate::statistics::normal::solve_definite;

/// Least squares for one target, with what has been solved so far.
pub(crate) struct Refits<'g> {
    pub(crate) gram: &'g Gram,
    shared: Arc<LastEigenspaces>,
    solved: HashMap<Vec<bool>, DVector<f64>>,
    /// Of all terms, where these are dependent and have been solved for.
    whole: Option<Arc<Eigenspaces>>,
}

impl<'g> Refits<'g> {
    pub(crate) fn new(gram: &'g Gram, shared: Arc<LastEigenspaces>) -> Self {
        Self {
            gram,
            shared,
            solved: HashMap::new(),
            whole: None,
        }
    }

    /// The coefficients on a support, in the units of the data; zero elsewhere.
    pub(crate) fn on(&mut self, support: &[bool]) -> DVector<f64> {
        if let Some(solved) = self.solved.get(support) {
            return solved.clone();
        }
        let own = self.solve(support);
        self.solved.insert(support.to_vec(), own.clone());
        own
    }

    /// The eigenspaces of all terms with columns of unit length, where these are dependent and have been solved for.
    pub(crate) fn dependent(&self) -> Option<&Eigenspaces> {
        self.whole.as_deref()
    }

    /// By Cholesky's factor; where that is close to singular of least norm, and where there is a triangular factor by that.
    fn solve(&mut self, support: &[bool]) -> DVector<f64> {
        if let Some(triangle) = &self.gram.triangle {
            return triangle.least_squares(support);
        }
        let normal = UnitLength::new(self.gram, support);
        let solution = solve_definite(&normal.g, &normal.b).unwrap_or_else(|| {
            // Other equations ask for all terms too, and rarely for the same part of them.
            if support.iter().all(|s| *s) {
                let spaces = self.shared.of(normal.g.clone());
                let solution = spaces.least_norm(&normal.b);
                self.whole = Some(spaces);
                solution
            } else {
                least_norm(&normal.g, &normal.b)
            }
        });
        normal.spread(&solution)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;

    use super::*;
    use crate::statistics::regression::least_squares;

    /// Statistics of 80 terms on so many rows.
    fn gram(rows: usize) -> Gram {
        let theta = DMatrix::from_fn(rows, 80, |i, j| {
            (0.7 * ((i + 1) * (j + 3)) as f64).sin() + 0.01 * j as f64
        });
        let y = DVector::from_fn(rows, |i, _| (1.3 * i as f64).cos());
        Gram {
            xtx: theta.tr_mul(&theta),
            xty: theta.tr_mul(&y),
            yty: y.norm_squared(),
            sum_y: y.sum(),
            rows,
            ..Gram::zeros(80)
        }
    }

    #[test]
    fn analytic_refits_are_least_squares_of_each_target() {
        // Terms that the rows determine, and more terms than rows.
        // Rounding of two ways to solve systems times their conditions: 1e6, and 4e10 of the directions that count.
        for (rows, tolerance) in [(400, 1e-8), (50, 1e-5)] {
            let first = gram(rows);
            let second = Gram {
                xty: DVector::from_fn(80, |j, _| first.xtx[(j, 3)] - 2.0 * first.xtx[(j, 7)]),
                ..first.clone()
            };
            let shared = Arc::new(LastEigenspaces::default());
            for of in [&first, &second, &first] {
                let mut refits = Refits::new(of, shared.clone());
                for terms in [80, 79, 10] {
                    let support: Vec<bool> = (0..80).map(|j| j < terms).collect();
                    let expected = least_squares(of, &support);
                    for _ in 0..2 {
                        let found = refits.on(&support);
                        let error = (&found - &expected).amax() / expected.amax();
                        assert!(error < tolerance, "{rows} rows, {terms} terms: {error:e}");
                    }
                }
            }
        }
    }
}
