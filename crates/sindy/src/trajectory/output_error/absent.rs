//! What terms that are not in the model would gain, all others fitted again: a score test.
//!
//! Around a fit the residuals are linear in the coefficients of further terms as in those of its own. With `G` and `b` the normal
//! equations of both, K the fit's terms and j a further one,
//!
//! ```text
//! gain_j = (b_j - G_jK G_KK⁻¹ b_K)² / (G_jj - G_jK G_KK⁻¹ G_Kj)
//! ```
//!
//! is twice the growth of the log-likelihood with j, up to the linearisation; chi-squared with one degree of freedom where j is not
//! a term of the truth. Trajectories, noise and gains of the filter are those of the fit.
//!
//! Source: C. R. Rao, Proceedings of the Cambridge Philosophical Society 44 (1948).

use nalgebra::{DMatrix, DVector};

use super::arcs::linearise;
use super::noise::{at, followed};
use super::{OutputErrorFit, Piece, System, disturbed};

/// A term of which the others leave less than this share of its square depends on them: normal equations square the condition,
/// and half of the digits are left.
const DEPENDENT: f64 = 1e-6;

/// The gain of every candidate of `system` that has no coefficient, in arcs of at most `longest` nodes or by the filter of `fit`; 0 where
/// it depends on those that have one. `coefficients` are those of the fit over these candidates. `None` where the model cannot be
/// followed.
pub(crate) fn gains(
    system: &System,
    pieces: &[Piece<'_>],
    (fit, longest): (&OutputErrorFit, usize),
    coefficients: &[f64],
) -> Option<Vec<f64>> {
    let (xtx, xty) = match &fit.disturbance {
        Some(noise) => {
            disturbed::normal(system, pieces, coefficients, (noise, fit.trace.substeps))?
        }
        None => {
            let mut follow = followed(system, fit, longest);
            follow.coefficients = coefficients;
            let normal = linearise(&follow, &at(pieces, fit), &mut None)?;
            (normal.xtx, normal.xty)
        }
    };
    // Correlated residuals hold the information of fewer independent ones.
    let all = of_normal(&xtx, &xty, coefficients)?;
    Some(all.into_iter().map(|g| g / fit.correlation).collect())
}

/// The same of normal equations in units of the noise.
fn of_normal(xtx: &DMatrix<f64>, xty: &DVector<f64>, coefficients: &[f64]) -> Option<Vec<f64>> {
    let (kept, others): (Vec<usize>, Vec<usize>) =
        (0..coefficients.len()).partition(|&j| coefficients[j] != 0.0);
    let own = xtx.select_rows(&kept);
    let with_others = own.select_columns(&others);
    let factor = own.select_columns(&kept).cholesky()?;
    let by = factor.solve(&with_others);
    let at_best = factor.solve(&xty.select_rows(&kept));
    let mut out = vec![0.0; coefficients.len()];
    for (k, &j) in others.iter().enumerate() {
        let left = xtx[(j, j)] - with_others.column(k).dot(&by.column(k));
        if left > DEPENDENT * xtx[(j, j)] {
            out[j] = (xty[j] - with_others.column(k).dot(&at_best)).powi(2) / left;
        }
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};

    use super::*;

    #[test]
    fn analytic_gain_is_the_fall_of_the_residual() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(4);
        let theta = DMatrix::from_fn(60, 4, |_, _| rng.random_range(-1.0..1.0));
        let y = DVector::from_fn(60, |_, _| rng.random_range(-1.0..1.0));
        let residual = |columns: &[usize]| {
            let own = theta.select_columns(columns);
            let fit = own.clone().svd(true, true).solve(&y, 1e-14).unwrap();
            (&y - own * fit).norm_squared()
        };
        let found = of_normal(
            &theta.tr_mul(&theta),
            &theta.tr_mul(&y),
            &[1.0, 0.0, 2.0, 0.0],
        )
        .unwrap();
        assert_eq!((found[0], found[2]), (0.0, 0.0));
        for j in [1, 3] {
            let fall = residual(&[0, 2]) - residual(&[0, 2, j]);
            // Rounding of well-conditioned systems.
            assert!((found[j] - fall).abs() < 1e-12, "{j}: {} {fall}", found[j]);
        }
        // Of no terms at all: what one column explains.
        let none = of_normal(&theta.tr_mul(&theta), &theta.tr_mul(&y), &[0.0; 4]).unwrap();
        let fall = y.norm_squared() - residual(&[2]);
        assert!((none[2] - fall).abs() < 1e-12, "{} {fall}", none[2]);
    }
}
