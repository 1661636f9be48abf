//! Sequentially thresholded least squares (STLSQ).
//!
//! Ridge regression on the terms that are left,
//!
//! ```text
//! min over ξ_S   |y - Θ_S ξ_S|² + α |ξ_S|²
//! ```
//!
//! then every term with `|ξ_j| < η` is dropped, until none is. Least squares on the remaining terms gives the
//! coefficients (unless [`Stlsq::refit`] is turned off).
//!
//! With [`Scaling::None`], η is in the coefficients' own units and α in those of the Gram matrix (sums over
//! rows). With [`Scaling::UnitRms`], columns and target are divided by their root mean square and the
//! sums by the number of rows, so that η and α mean the same for any units and any amount of data: a
//! scaled coefficient of 1 explains the whole target alone.
//!
//! Source: S. L. Brunton, J. L. Proctor, J. N. Kutz, PNAS 113 (2016); with the ridge: S. H. Rudy et al.,
//! Science Advances 3 (2017).

use nalgebra::DVector;

use crate::error::{SindyError, at_least_zero};
use crate::solve::fit::{Fit, Solver};
use crate::solve::outcome::Outcome;
use crate::solve::sr3::Scaling;
use crate::statistics::gram::Gram;
use crate::statistics::normal::Normal;

/// Settings of STLSQ, checked when built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stlsq {
    threshold: f64,
    ridge: f64,
    scaling: Scaling,
    max_iterations: usize,
    refit: bool,
}

impl Stlsq {
    /// STLSQ with threshold η and ridge α, scaled, refitted, at most 100 iterations.
    ///
    /// # Errors
    /// `threshold` or `ridge` negative or not finite.
    pub fn new(threshold: f64, ridge: f64) -> Result<Self, SindyError> {
        Ok(Self {
            threshold: at_least_zero("threshold", threshold)?,
            ridge: at_least_zero("ridge", ridge)?,
            scaling: Scaling::UnitRms,
            max_iterations: 100,
            refit: true,
        })
    }

    /// The same with another scaling.
    #[must_use]
    pub fn scaling(self, scaling: Scaling) -> Self {
        Self { scaling, ..self }
    }

    /// The same with another iteration limit, at least 1.
    #[must_use]
    pub fn max_iterations(self, limit: usize) -> Self {
        Self {
            max_iterations: limit.max(1),
            ..self
        }
    }

    /// The same with or without least squares on the final support.
    #[must_use]
    pub fn refit(self, refit: bool) -> Self {
        Self { refit, ..self }
    }
}

impl Solver for Stlsq {
    fn fit(&self, gram: &Gram) -> Result<Fit, SindyError> {
        let normal = Normal::new(gram)?;
        // What thresholds compare: scaled coefficients ξ' of the normal equations (columns and target of
        // unit length) or ξ = ξ' / scale; and the ridge that α becomes there.
        let (unit, ridge): (Vec<f64>, Vec<f64>) = (0..normal.terms.len())
            .map(|j| match self.scaling {
                Scaling::UnitRms => (1.0, self.ridge),
                Scaling::None => {
                    let length = gram.xtx[(normal.terms[j], normal.terms[j])];
                    (normal.scale[j], self.ridge / length)
                }
            })
            .unzip();
        let mut index: Vec<usize> = (0..normal.terms.len()).collect();
        let mut scaled = DVector::zeros(normal.terms.len());
        let mut outcome = Outcome::IterationLimit;
        let mut iterations = 0;
        while iterations < self.max_iterations && !index.is_empty() {
            iterations += 1;
            let xi = normal.solve(&index, |j| ridge[j]);
            scaled.fill(0.0);
            let before = index.len();
            let keep: Vec<(usize, f64)> = index
                .iter()
                .zip(xi.iter())
                .filter(|(j, v)| v.abs() >= self.threshold * unit[**j])
                .map(|(j, v)| (*j, *v))
                .collect();
            keep.iter().for_each(|&(j, v)| scaled[j] = v);
            index = keep.into_iter().map(|(j, _)| j).collect();
            if index.len() == before {
                outcome = Outcome::Converged;
                break;
            }
        }
        if index.is_empty() {
            outcome = Outcome::Empty;
        }
        let support = normal.support(index.iter().copied());
        if self.refit {
            return Ok(Fit::on_support(gram, support, outcome, iterations));
        }
        let mut coefficients = DVector::zeros(normal.p);
        for &j in &index {
            coefficients[normal.terms[j]] = scaled[j] / normal.scale[j];
        }
        Ok(Fit::new(gram, coefficients, support, outcome, iterations))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::normal::tests::{of_rows, random_rows, reference};

    #[test]
    fn xval_coefficients_of_pysindy() {
        // PySINDy 2.1.0, `STLSQ(threshold, alpha, unbias).fit(X, y)` on the same rows.
        let gram = reference();
        let cases: [(f64, f64, bool, usize, [f64; 6]); 5] = [
            (
                0.1,
                0.05,
                true,
                100,
                [
                    0.14589163657879137,
                    0.9489468290135741,
                    0.0,
                    0.0,
                    0.0,
                    3.287710753553758,
                ],
            ),
            (
                0.1,
                0.05,
                false,
                100,
                [
                    0.14393545361138219,
                    0.9480970305484309,
                    0.0,
                    0.0,
                    0.0,
                    2.8097495191754596,
                ],
            ),
            (
                0.07,
                2.0,
                false,
                100,
                [
                    0.1309475317804781,
                    0.8957483447566519,
                    0.0,
                    0.0,
                    0.0,
                    0.4218101791684589,
                ],
            ),
            (
                0.1,
                0.05,
                false,
                1,
                [
                    0.49833317447928643,
                    1.1970468188397276,
                    0.0,
                    0.0,
                    0.0,
                    2.641854448176171,
                ],
            ),
            (100.0, 0.05, true, 100, [0.0; 6]),
        ];
        for (threshold, ridge, refit, limit, expected) in cases {
            let fit = Stlsq::new(threshold, ridge)
                .unwrap()
                .scaling(Scaling::None)
                .max_iterations(limit)
                .refit(refit)
                .fit(&gram)
                .unwrap();
            for j in 0..6 {
                // Gram matrix of condition about 1e3 against a factorisation of the rows.
                assert!((fit.coefficients[j] - expected[j]).abs() < 1e-12, "{fit:?}");
                assert_eq!(fit.support[j], expected[j] != 0.0);
            }
            assert_eq!(
                fit.outcome,
                match (threshold, limit) {
                    (100.0, _) => Outcome::Empty,
                    (_, 1) => Outcome::IterationLimit,
                    _ => Outcome::Converged,
                }
            );
        }
    }

    #[test]
    fn xval_scaled_coefficients_of_pysindy() {
        // PySINDy 2.1.0 with `normalize_columns=True`: columns of unit length, so its threshold is ours
        // times the length of the target, and alpha is the same.
        let gram = reference();
        let length = gram.yty.sqrt();
        let cases: [(f64, f64, bool, [f64; 6]); 2] = [
            (
                0.5,
                0.05,
                false,
                [
                    0.33126650224268467,
                    1.0391535875214413,
                    0.0,
                    0.0,
                    -0.0460321375159344,
                    2.9967870754975956,
                ],
            ),
            (
                1.5,
                0.3,
                true,
                [0.0, 0.9557951060065139, 0.0, 0.0, 0.0, 0.0],
            ),
        ];
        for (threshold, ridge, refit, expected) in cases {
            let fit = Stlsq::new(threshold / length, ridge)
                .unwrap()
                .refit(refit)
                .fit(&gram)
                .unwrap();
            for j in 0..6 {
                // As above.
                assert!((fit.coefficients[j] - expected[j]).abs() < 1e-12, "{fit:?}");
            }
        }
    }

    #[test]
    fn prop_scaled_support_does_not_depend_on_units() {
        let (theta, y) = random_rows(2, 100, &[1.0, 0.0, 0.4, 0.0], 0.5, 0.2);
        let scales = [1e8, 1e-8, 1.0, 1e3];
        let other = nalgebra::DMatrix::from_fn(100, 4, |i, j| theta[(i, j)] * scales[j]);
        let stlsq = Stlsq::new(0.1, 1e-3).unwrap();
        let a = stlsq.fit(&of_rows(&theta, &y)).unwrap();
        let b = stlsq.fit(&of_rows(&other, &(&y * 1e5))).unwrap();
        assert_eq!(a.support, [true, false, true, false]);
        assert_eq!(a.support, b.support);
        for j in 0..4 {
            // Relative rounding of the Gram entries.
            assert!((b.coefficients[j] * scales[j] / 1e5 - a.coefficients[j]).abs() < 1e-12);
        }
    }

    #[test]
    fn prop_degenerate_statistics_give_a_fit_or_a_clear_error() {
        assert!(Stlsq::new(-1.0, 0.0).is_err() && Stlsq::new(0.1, f64::NAN).is_err());
        let stlsq = Stlsq::new(0.01, 0.0).unwrap();
        assert!(stlsq.fit(&Gram::zeros(3)).is_err());
        // Two equal columns and one that is zero: the coefficient is shared (least norm).
        let x = random_rows(3, 20, &[1.0], 0.0, 0.0).0;
        let wide = nalgebra::DMatrix::from_fn(20, 3, |i, j| if j < 2 { x[(i, 0)] } else { 0.0 });
        let fit = stlsq.fit(&of_rows(&wide, &(x.column(0) * 2.0))).unwrap();
        assert_eq!(fit.support, [true, true, false]);
        assert!(
            (fit.coefficients[0] - 1.0).abs() < 1e-9 && (fit.coefficients[1] - 1.0).abs() < 1e-9
        );
        // A target that is zero throughout leaves nothing.
        let fit = stlsq.fit(&of_rows(&x, &DVector::zeros(20))).unwrap();
        assert_eq!((fit.terms(), fit.outcome), (0, Outcome::Empty));
    }
}
