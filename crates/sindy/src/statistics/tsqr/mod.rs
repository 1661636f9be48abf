//! Least squares through a triangular factor of `[Θ | y]`, for libraries that the Gram matrix loses.
//!
//! ```text
//! [Θ | y] = Q R,   R upper triangular, (p+1) x (p+1), with a diagonal of at least 0
//! ```
//!
//! The Gram matrix `ΘᵀΘ = RᵀR` has the square of the condition κ of `Θ`: with κ above about 10⁷ the small
//! directions are below its rounding, and the coefficients along them are lost. `R` has the condition of
//! `Θ` itself: coefficients keep a relative error of about `10⁻¹⁶ κ` (where the residual is small) up to
//! a κ of 10¹⁴, at four to ten times the work.
//!
//! `R` is accumulated in blocks by Householder's reflections, and the factors of two parts are merged by
//! factorising one on top of the other, so that `Θ` is never stored and every way of splitting the data gives
//! the same `R` up to rounding.
//!
//! [`by_condition`] takes the Gram matrix and decides by its condition (columns of unit length) whether it
//! resolves the library; if not, it passes over the data again for `R`. Statistics that carry a
//! [`Triangle`] use it wherever it matters: [`least_squares`](crate::statistics::regression::least_squares), and so the
//! coefficients of every solver's final support, [`Gram::residual_sum`], the steps of
//! [`Stlsq`](crate::Stlsq) and of the direct path of [`Sr3`](crate::Sr3). The *search* of
//! [`BestSubset`](crate::BestSubset), [`Stepwise`](crate::Stepwise) and [`relaxed`](crate::solve::relaxed) reads the Gram matrix
//! alone, with its digits.
//!
//! ```
//! use sindy::statistics::tsqr::{Route, by_condition};
//! use sindy::{Gram, Library, Samples, statistics::gram::Accumulate, statistics::regression::least_squares};
//!
//! // Powers of a number between 1 and 1.01: nearly the same column four times.
//! let x: Vec<f64> = (0..1000).map(|i| 1.0 + 1e-5 * f64::from(i)).collect();
//! let y = x.iter().map(|x| 1.0 - 2.0 * x + 3.0 * x * x - x.powi(3)).collect();
//! let mut samples = Samples::new(&["x", "y"]);
//! samples.push_group(vec![x, y])?;
//! let library = Library::parse(&["1", "x", "x^2", "x^3"])?;
//!
//! let statistics = by_condition(&Accumulate::new(&library, "y"), &samples)?;
//! assert_eq!(statistics.route, Route::Triangle);
//! let xi = least_squares(&Gram::total(&statistics.grams), &[true; 4]);
//! assert!((xi[1] + 2.0).abs() < 1e-4);
//! # Ok::<(), sindy::SindyError>(())
//! ```
//!
//! Sources: G. H. Golub, Numerische Mathematik 7 (1965); J. Demmel, L. Grigori, M. Hoemmen, J. Langou,
//! "Communication-optimal parallel and sequential QR and LU factorizations", SIAM Journal on Scientific
//! Computing 34 (2012); N. J. Higham, "Accuracy and Stability of Numerical Algorithms" (2002), chapters 19 and 20.

use nalgebra::{DMatrix, DVector};
use pulp::{Arch, Simd, WithSimd};

use crate::data::samples::BlockSource;
use crate::error::{SindyError, same_size};
use crate::statistics::gram::{Accumulate, Gram};
use crate::statistics::lanes::dot;

/// Condition of `Θ` (columns of unit length) above which the Gram matrix is not trusted: there its relative
/// error of about 10⁻¹⁵ costs coefficients up to 10⁻³ of their size, and soon after all of it.
pub const CONDITION_LIMIT: f64 = 1e6;

/// A column (of unit length) whose distance from the span of those before it is below this counts as
/// dependent: rounding of the rows.
const DEPENDENT: f64 = 1e-14;

/// Squares outside this range are taken of scaled numbers: theirs would lose digits, or overflow.
const SAFE: std::ops::Range<f64> = 1e-280..1e280;

/// The length of a vector, of any numbers whose length is one.
fn length(v: &[f64]) -> f64 {
    let square = dot(v, v);
    if SAFE.contains(&square) {
        return square.sqrt();
    }
    let largest = v.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    match largest > 0.0 {
        true => largest * v.iter().map(|x| (x / largest).powi(2)).sum::<f64>().sqrt(),
        false => 0.0,
    }
}

/// Which statistics resolve a library.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Route {
    /// The Gram matrix will do.
    Gram,
    /// The triangular factor is needed.
    Triangle,
}

impl Route {
    /// The route that a library of this condition needs: [`Route::Gram`] up to [`CONDITION_LIMIT`].
    #[must_use]
    pub fn of(condition: f64) -> Self {
        if condition <= CONDITION_LIMIT {
            Self::Gram
        } else {
            Self::Triangle
        }
    }
}

/// Statistics, and the route that they were taken by.
#[derive(Clone, Debug, PartialEq)]
pub struct ByCondition {
    /// One for each group; with triangular factors if the route is [`Route::Triangle`].
    pub grams: Vec<Gram>,
    /// Condition of `Θ` over all groups, columns of unit length.
    pub condition: f64,
    /// The route that was taken.
    pub route: Route,
}

/// Accumulates by the Gram matrix, and if the condition of all groups together asks for it, once more with
/// the triangular factor. Where `settings` asks for the factor, there is only the one pass.
///
/// A source that can be passed over only once ([`Stream`](crate::Stream)) fails at the second pass: for such
/// take the factor at once, or ask [`Route::of`] with [`Gram::condition`] and open it again.
///
/// # Errors
/// As [`Accumulate::over`].
pub fn by_condition(
    settings: &Accumulate<'_>,
    source: &dyn BlockSource,
) -> Result<ByCondition, SindyError> {
    let mut grams = settings.over(source)?;
    let mut total = Gram::total(&grams);
    let route = match &total.triangle {
        Some(_) => Route::Triangle,
        None => Route::of(total.condition()),
    };
    if route == Route::Triangle && total.triangle.is_none() {
        grams = settings.triangle(true).over(source)?;
        total = Gram::total(&grams);
    }
    Ok(ByCondition {
        condition: total.condition(),
        grams,
        route,
    })
}

/// The triangular factor `R` of `[Θ | y]`, (p+1) x (p+1).
#[derive(Clone, Debug, PartialEq)]
pub struct Triangle {
    r: DMatrix<f64>,
}

impl Triangle {
    /// That of no rows, for `p` terms.
    #[must_use]
    pub fn new(p: usize) -> Self {
        Self {
            r: DMatrix::zeros(p + 1, p + 1),
        }
    }

    /// That of rows in memory: `theta` n x p, `y` n.
    ///
    /// # Errors
    /// `y` of another length; entries that are not finite.
    pub fn of_rows(theta: &DMatrix<f64>, y: &DVector<f64>) -> Result<Self, SindyError> {
        let (n, p) = theta.shape();
        same_size("rows of the target", n, y.len())?;
        let mut rows: Vec<f64> = theta.iter().chain(y.iter()).copied().collect();
        if let Some(i) = rows.iter().position(|v| !v.is_finite()) {
            return Err(SindyError::NotFinite {
                what: format!("column {} of [theta | y]", i / n),
                index: i % n,
            });
        }
        let mut out = Self::new(p);
        out.fold(&mut rows, n);
        Ok(out)
    }

    /// The factor of a square matrix that [`Triangle::matrix`] gave.
    pub(crate) fn of_matrix(r: DMatrix<f64>) -> Self {
        Self { r }
    }

    /// The factor itself: the terms in order, then the target.
    #[must_use]
    pub fn matrix(&self) -> &DMatrix<f64> {
        &self.r
    }

    /// Adds rows, given column after column (the target last), all finite. They are overwritten.
    pub(crate) fn fold(&mut self, columns: &mut [f64], rows: usize) {
        fold(&mut self.r, columns, rows);
    }

    /// Adds the rows of another part of the data.
    ///
    /// # Panics
    /// If it has another number of terms.
    pub fn merge(&mut self, other: &Self) {
        self.merge_scaled(other, 1.0);
    }

    /// Adds the rows of another part, each multiplied by `scale`.
    pub(crate) fn merge_scaled(&mut self, other: &Self, scale: f64) {
        assert_eq!(self.r.shape(), other.r.shape(), "the same terms");
        let mut rows = &other.r * scale;
        if self.r.iter().all(|v| *v == 0.0) {
            self.r = rows;
        } else {
            let m = rows.nrows();
            self.fold(rows.as_mut_slice(), m);
        }
    }

    /// The statistics of the factored rows, with the factor among them. `rows` is how many there were and `sum_y` the sum
    /// of the target, which it does not know.
    #[must_use]
    pub fn to_gram(&self, rows: usize, sum_y: f64) -> Gram {
        let p = self.r.ncols() - 1;
        let all = self.r.tr_mul(&self.r);
        Gram {
            xtx: all.view((0, 0), (p, p)).into_owned(),
            xty: all.view((0, p), (p, 1)).column(0).into_owned(),
            yty: all[(p, p)],
            sum_y,
            rows,
            triangle: Some(self.clone()),
            ..Gram::zeros(p)
        }
    }

    /// Least squares on the terms of `support`, zero elsewhere; the least norm over columns of unit length where
    /// they are dependent.
    ///
    /// # Panics
    /// If `support` does not have one entry for each term.
    #[must_use]
    pub fn least_squares(&self, support: &[bool]) -> DVector<f64> {
        let p = self.r.ncols() - 1;
        assert_eq!(support.len(), p, "one entry for each term");
        let index: Vec<usize> = (0..p).filter(|&j| support[j]).collect();
        let a = self.r.select_columns(&index);
        let xi = solve(&a, &self.r.column(p).into_owned());
        let mut out = DVector::zeros(p);
        for (xi, &j) in xi.iter().zip(&index) {
            out[j] = *xi;
        }
        out
    }

    /// Residual sum of squares `|y - Θ ξ|²`, without the cancellation of the Gram matrix's.
    ///
    /// # Panics
    /// If there is not one coefficient for each term.
    #[must_use]
    pub fn residual_sum(&self, coefficients: &DVector<f64>) -> f64 {
        let p = self.r.ncols() - 1;
        (self.r.columns(0, p) * coefficients - self.r.column(p)).norm_squared()
    }

    /// Condition of `Θ` with columns of unit length, over the terms that are not zero throughout.
    #[must_use]
    pub fn condition(&self) -> f64 {
        let p = self.r.ncols() - 1;
        let live: Vec<DVector<f64>> = (0..p)
            .map(|j| self.r.column(j).rows(0, p).into_owned())
            .filter_map(|column| {
                let length = length(column.as_slice());
                (length > 0.0).then(|| column / length)
            })
            .collect();
        if live.is_empty() {
            return 1.0;
        }
        let values = DMatrix::from_columns(&live).singular_values();
        let (largest, smallest) = (values.max(), values.min());
        if smallest > 0.0 {
            largest / smallest
        } else {
            f64::INFINITY
        }
    }
}

/// Least squares `min |b - A x|²` of a small system, by reflections; the least norm over columns of unit length
/// where they are dependent.
pub(crate) fn solve(a: &DMatrix<f64>, b: &DVector<f64>) -> DVector<f64> {
    let (n, k) = a.shape();
    let length: Vec<f64> = a
        .column_iter()
        .map(|c| length(&c.iter().copied().collect::<Vec<_>>()))
        .map(|l| if l > 0.0 { l } else { 1.0 })
        .collect();
    let mut rows: Vec<f64> = Vec::with_capacity(n * (k + 1));
    for (column, length) in a.column_iter().zip(&length) {
        rows.extend(column.iter().map(|v| v / length));
    }
    rows.extend(b.iter());
    let mut r = DMatrix::zeros(k + 1, k + 1);
    fold(&mut r, &mut rows, n);
    let triangle = r.view((0, 0), (k, k));
    let b = r.view((0, k), (k, 1)).column(0).into_owned();
    let independent = (0..k).all(|j| r[(j, j)] > DEPENDENT * (k as f64).sqrt());
    let x = if independent {
        triangle.solve_upper_triangular(&b)
    } else {
        // The tolerance is relative to columns of unit length.
        let svd = triangle.into_owned().svd(true, true);
        svd.solve(&b, DEPENDENT * k as f64).ok()
    };
    let x = x.unwrap_or_else(|| DVector::zeros(k));
    DVector::from_fn(k, |j, _| x[j] / length[j])
}

/// Reflects the rows in `columns` (m columns of `rows` each) into the upper triangle `r`, m x m.
fn fold(r: &mut DMatrix<f64>, columns: &mut [f64], rows: usize) {
    if rows == 0 {
        return;
    }
    Arch::new().dispatch(Fold { r, columns, rows });
}

struct Fold<'a> {
    r: &'a mut DMatrix<f64>,
    columns: &'a mut [f64],
    rows: usize,
}

impl WithSimd for Fold<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { r, columns, rows } = self;
        for k in 0..r.ncols() {
            let (left, right) = columns.split_at_mut((k + 1) * rows);
            let v = &mut left[k * rows..];
            let mut square = dot(v, v);
            let mut old = r[(k, k)];
            let mut unit = 1.0;
            if !(SAFE.contains(&square) && old < 1e140) {
                // In units of the largest: the reflection knows no unit.
                unit = v.iter().fold(old, |m, x| m.max(x.abs()));
                if unit == 0.0 {
                    continue;
                }
                v.iter_mut().for_each(|x| *x /= unit);
                old /= unit;
                square = dot(v, v);
            }
            if square == 0.0 {
                continue;
            }
            // The reflection that takes (r_kk, v) to (norm, 0); Parlett's form, which does not cancel.
            let norm = (old * old + square).sqrt();
            let first = -square / (old + norm);
            let factor = 2.0 / (first * first + square);
            let v = &*v;
            r[(k, k)] = norm * unit;
            for (j, column) in right.chunks_exact_mut(rows).enumerate() {
                let entry = &mut r[(k, k + 1 + j)];
                let step = factor * (first * *entry + dot(v, column));
                *entry -= step * first;
                for (c, v) in column.iter_mut().zip(v) {
                    *c -= step * v;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
