//! The linear system that both comparators fit.

use nalgebra::linalg::Schur;
use nalgebra::{Complex, DMatrix};

use super::snapshots::Snapshots;
use super::{ITERATIONS, Regression};
use crate::error::SindyError;

/// A linear system `z[k+1] = A z[k] + B v[k]` and the quality of its fit.
///
/// For DMDc z are the states and v the inputs. For EDMDc z are the observables and v the terms with inputs, both in the
/// order of the library.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearSystem {
    /// Sampling period.
    pub period: f64,
    /// A, z x z.
    pub a: DMatrix<f64>,
    /// B, z x v.
    pub b: DMatrix<f64>,
    /// Singular values of the snapshots `[z; v]`, descending; EDMDc brings their rows to unit length first.
    pub singular_values: Vec<f64>,
    /// How many of them were kept.
    pub rank: usize,
    /// Root mean square of the one-step residual of each z, in its unit.
    pub residual_rms: Vec<f64>,
    /// Pairs of rows that were used.
    pub pairs: usize,
    /// Rows that begin no pair because one of their values is not usable.
    pub skipped: usize,
}

impl LinearSystem {
    /// The regression of `z[k+1]` on `z[k]` and `v[k]`; with `scaled`, over columns of unit length.
    pub(super) fn fit(
        regression: Regression,
        snapshots: &Snapshots,
        period: f64,
        scaled: bool,
    ) -> Result<Self, SindyError> {
        let (r, rhs) = snapshots.step();
        let solved = regression.solve(r, &rhs, snapshots.pairs, scaled)?;
        let k = solved.coefficients.transpose();
        let observables = k.nrows();
        Ok(Self {
            period,
            a: k.columns(0, observables).into_owned(),
            b: k.columns(observables, k.ncols() - observables).into_owned(),
            singular_values: solved.singular_values,
            rank: solved.rank,
            residual_rms: snapshots.residual_rms(&solved.coefficients),
            pairs: snapshots.pairs,
            skipped: snapshots.skipped,
        })
    }

    /// Eigenvalues λ of A, largest magnitude first; of a conjugate pair, the one above the real axis first. For EDMDc they
    /// are the Koopman eigenvalues.
    ///
    /// # Errors
    /// [`SindyError::Singular`] if their iteration does not converge.
    pub fn eigenvalues(&self) -> Result<Vec<Complex<f64>>, SindyError> {
        let what = "eigenvalues";
        let schur = Schur::try_new(self.a.clone(), f64::EPSILON, ITERATIONS)
            .ok_or(SindyError::Singular { what })?;
        let mut values: Vec<_> = schur.complex_eigenvalues().iter().copied().collect();
        values.sort_by(|p, q| {
            let size = q.norm_sqr().total_cmp(&p.norm_sqr());
            size.then(q.im.total_cmp(&p.im))
        });
        Ok(values)
    }

    /// Continuous-time eigenvalues `ln(λ) / period`, in the order of [`Self::eigenvalues`], per unit of time.
    /// Frequencies above half the sampling rate appear as lower ones; λ = 0 gives -∞.
    ///
    /// # Errors
    /// Those of [`Self::eigenvalues`].
    pub fn continuous_eigenvalues(&self) -> Result<Vec<Complex<f64>>, SindyError> {
        let log = |v: &Complex<f64>| Complex::new(v.norm().ln(), v.im.atan2(v.re)) / self.period;
        Ok(self.eigenvalues()?.iter().map(log).collect())
    }
}
