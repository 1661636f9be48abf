//! Coefficients given their prior variances and the noise: normal, in closed form.
//!
//! With `D = diag(d_j)`, the prior variances of the coefficients, and the noise σ,
//!
//! ```text
//! β | y  ~  N(μ, Σ),   Σ = (G/σ² + D⁻¹)⁻¹ = D^½ B⁻¹ D^½,   μ = Σ b/σ²,   B = I + D^½ G D^½ / σ²
//! ln p(y) = -n ln σ - ½ ln det B - ½ (|y - Θ μ|²/σ² + μᵀ D⁻¹ μ) + a constant
//! ```
//!
//! Everything is computed through B, whose pivots are at least 1, so that neither a variance near zero nor dependent columns
//! are a danger. As a function of one variance alone, with the others as they are,
//!
//! ```text
//! ln p(y) = -½ ln(1 + d_j s_j) + ½ q_j² d_j/(1 + d_j s_j) + a constant
//! ```
//!
//! (s_j and q_j: precision of the data for `β_j`, and that times its estimate without a prior of its own). So each variance is
//! drawn without its coefficient at hand, which would tie it to where it was.
//!
//! Source of the last formula: M. E. Tipping, A. C. Faul, "Fast marginal likelihood maximisation for sparse Bayesian models",
//! AISTATS 2003.

use nalgebra::{DMatrix, DVector};

use crate::solve::sr3::Scaling;
use crate::statistics::gram::Gram;
use crate::statistics::regression::least_squares;

/// Statistics of one target, in the units of the prior.
pub(super) struct Statistics {
    /// `G = Θᵀ Θ`.
    pub(super) g: DMatrix<f64>,
    /// `b = Θᵀ y`.
    b: DVector<f64>,
    /// Least squares, and its residual sum.
    estimate: DVector<f64>,
    least: f64,
    pub(super) rows: f64,
    /// What a coefficient is multiplied by to be in the units of the data.
    pub(super) unit: DVector<f64>,
    /// The same of the noise.
    pub(super) noise_unit: f64,
    /// Root mean square of the target.
    pub(super) target_rms: f64,
}

impl Statistics {
    pub(super) fn new(gram: &Gram, scaling: Scaling) -> Self {
        let p = gram.xty.len();
        let (column, target) = match scaling {
            Scaling::None => (DVector::repeat(p, 1.0), 1.0),
            Scaling::UnitRms => (gram.column_rms(), gram.target_rms()),
        };
        let unit = column.map(|c| target / c);
        let estimate = least_squares(gram, &vec![true; p]);
        // Residual sums below this share are rounding of the sums. Without it the noise of data that fit exactly has no
        // posterior: its density has no bound near 0.
        let whole = if gram.yty > 0.0 { gram.yty } else { 1.0 };
        let floor = 16.0 * f64::EPSILON * (p + 1) as f64 * whole;
        Self {
            g: DMatrix::from_fn(p, p, |i, j| gram.xtx[(i, j)] / column[i] / column[j]),
            b: DVector::from_fn(p, |j, _| gram.xty[j] / column[j] / target),
            least: gram.residual_sum(&estimate).max(floor) / target.powi(2),
            estimate: estimate.component_div(&unit),
            rows: gram.rows as f64,
            noise_unit: target,
            target_rms: gram.target_rms() / target,
            unit,
        }
    }

    pub(super) fn terms(&self) -> usize {
        self.b.len()
    }

    /// `|y - Θ β|²`, without the cancellation of `yᵀy - 2 βᵀb + βᵀGβ`.
    fn residual(&self, beta: &DVector<f64>) -> f64 {
        let apart = beta - &self.estimate;
        self.least + apart.dot(&(&self.g * &apart)).max(0.0)
    }
}

/// The factor `B = L Lᵀ`, and what follows from it.
pub(super) struct Factor<'a> {
    statistics: &'a Statistics,
    noise_variance: f64,
    /// d.
    variance: Vec<f64>,
    /// √d.
    root: DVector<f64>,
    lower: DMatrix<f64>,
    /// μ.
    pub(super) mean: DVector<f64>,
    /// ln p(y) but for a constant.
    pub(super) log_density: f64,
}

impl<'a> Factor<'a> {
    pub(super) fn new(statistics: &'a Statistics, variance: Vec<f64>, sigma: f64) -> Self {
        let p = statistics.terms();
        let noise_variance = sigma * sigma;
        let root = DVector::from_iterator(p, variance.iter().map(|d| d.sqrt()));
        let scaled = &root / sigma;
        let mut lower = statistics.g.clone();
        for (j, mut column) in lower.column_iter_mut().enumerate() {
            column
                .iter_mut()
                .zip(&scaled)
                .for_each(|(v, s)| *v *= s * scaled[j]);
            column[j] += 1.0;
        }
        factorise(&mut lower);
        let mut standardised = statistics.b.component_mul(&scaled) / sigma;
        // The pivots are at least 1: no division fails.
        lower.solve_lower_triangular_mut(&mut standardised);
        lower.tr_solve_lower_triangular_mut(&mut standardised);
        let mean = standardised.component_mul(&root);
        let log_determinant: f64 = 2.0 * lower.diagonal().iter().map(|l| l.ln()).sum::<f64>();
        let misfit = statistics.residual(&mean) / noise_variance + standardised.norm_squared();
        Self {
            log_density: -statistics.rows * sigma.ln() - 0.5 * (log_determinant + misfit),
            statistics,
            noise_variance,
            variance,
            root,
            lower,
            mean,
        }
    }

    /// A draw of β: μ + D^½ L⁻ᵀ z, with standard normal numbers z.
    pub(super) fn draw(&self, mut standard: DVector<f64>) -> DVector<f64> {
        self.lower.tr_solve_lower_triangular_mut(&mut standard);
        &self.mean + standard.component_mul(&self.root)
    }

    /// The same factor, for variances that are replaced one by one from the first to the last.
    pub(super) fn one_by_one(self) -> OneByOne<'a> {
        OneByOne {
            order: (0..self.variance.len()).collect(),
            statistics: self.statistics,
            noise_variance: self.noise_variance,
            root: self.root,
            lower: self.lower,
        }
    }

    /// Σ_jj of each coefficient, and `κ_j = Σ_jj/d_j = 1/(1 + d_j s_j)`.
    pub(super) fn spreads(&self) -> (DVector<f64>, DVector<f64>) {
        let p = self.statistics.terms();
        let mut inverse = DMatrix::identity(p, p);
        self.lower.solve_lower_triangular_mut(&mut inverse);
        let shrinkage = DVector::from_iterator(p, inverse.column_iter().map(|c| c.norm_squared()));
        let variance = DVector::from_fn(p, |j, _| self.variance[j] * shrinkage[j]);
        (variance, shrinkage)
    }
}

/// The Cholesky factor in the lower triangle of a matrix `I + a positive semi-definite one`. Its pivots are at least 1 but for
/// rounding, and are kept there.
fn factorise(matrix: &mut DMatrix<f64>) {
    let p = matrix.nrows();
    let values = matrix.as_mut_slice();
    for k in 0..p {
        let (done, rest) = values.split_at_mut((k + 1) * p);
        let own = &mut done[k * p + k..];
        let root = own[0].max(1.0).sqrt();
        own.iter_mut().for_each(|v| *v /= root);
        own[0] = root;
        for (j, column) in rest.chunks_exact_mut(p).enumerate() {
            let factor = own[j + 1];
            let below = &mut column[k + 1 + j..];
            below
                .iter_mut()
                .zip(&own[j + 1..])
                .for_each(|(v, l)| *v -= factor * l);
        }
    }
}

/// What the data say of one coefficient, given the variances of the others.
pub(super) struct OneAlone {
    /// s: their precision for it.
    pub(super) precision: f64,
    /// q: s times its estimate without a prior of its own.
    pub(super) weighted: f64,
}

impl OneAlone {
    /// ln p(y) as a function of its prior variance, but for a constant.
    pub(super) fn log_density(&self, variance: f64) -> f64 {
        let total = 1.0 + variance * self.precision;
        0.5 * (self.weighted.powi(2) * variance / total - total.ln())
    }
}

/// The factor while variances are replaced one by one: the first column leaves it, and enters again as the last.
///
/// Its removal is a sequence of rotations, and its entry a forward substitution from the statistics. Neither lets errors grow,
/// unlike updates of Σ, whose errors are multiplied by `G/σ²` each time.
pub(super) struct OneByOne<'a> {
    statistics: &'a Statistics,
    noise_variance: f64,
    root: DVector<f64>,
    lower: DMatrix<f64>,
    /// The term of each of its columns.
    order: Vec<usize>,
}

impl OneByOne<'_> {
    /// Replaces the variance of the next term, in the order of the terms, by that which `draw` makes of what the data say of it.
    pub(super) fn next(&mut self, draw: impl FnOnce(&OneAlone) -> f64) {
        let others = self.order.len() - 1;
        let term = self.remove_first();
        let (g, b) = (&self.statistics.g, &self.statistics.b);
        let mut sides = DMatrix::from_fn(others, 2, |k, side| {
            let other = self.order[k];
            let product = if side == 0 {
                g[(other, term)]
            } else {
                b[other]
            };
            self.root[other] * product / self.noise_variance
        });
        self.lower
            .view((0, 0), (others, others))
            .solve_lower_triangular_mut(&mut sides);
        let (column, target) = (sides.column(0), sides.column(1));
        let alone = OneAlone {
            precision: (g[(term, term)] / self.noise_variance - column.norm_squared()).max(0.0),
            weighted: b[term] / self.noise_variance - column.dot(&target),
        };
        let variance = draw(&alone);
        self.root[term] = variance.sqrt();
        for (k, v) in column.iter().enumerate() {
            self.lower[(others, k)] = self.root[term] * v;
        }
        self.lower[(others, others)] = (1.0 + variance * alone.precision).sqrt();
    }

    /// Takes the first column out, moves it to the end of the order, and returns its term.
    fn remove_first(&mut self) -> usize {
        let p = self.order.len();
        let values = self.lower.as_mut_slice();
        // With l the first column of L below the diagonal and M the rest of L, the rest of B is M Mᵀ + l lᵀ.
        let mut first: Vec<f64> = values[1..p].to_vec();
        for k in 0..p - 1 {
            let (before, own) = values.split_at_mut((k + 1) * p);
            let to = &mut before[k * p + k..k * p + p - 1];
            let from = &own[k + 1..p];
            let length = from[0].hypot(first[k]);
            let (cosine, sine) = (from[0] / length, first[k] / length);
            for ((to, from), first) in to.iter_mut().zip(from).zip(&mut first[k..]) {
                *to = cosine * from + sine * *first;
                *first = cosine * *first - sine * from;
            }
        }
        self.order.rotate_left(1);
        self.order[p - 1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::normal::tests::{of_rows, random_rows, reference};

    fn variances() -> Vec<f64> {
        // From nothing to wide.
        vec![1e-18, 4.0, 1e-6, 0.01, 1e-30, 100.0]
    }

    #[test]
    fn analytic_the_density_is_that_of_the_normal_distribution_of_the_data() {
        // ln N(y; 0, σ² I + Θ D Θᵀ) by the rows themselves, for two rows more than terms.
        let (theta, y) = random_rows(1, 8, &[1.0; 6], 0.3, 0.4);
        let gram = of_rows(&theta, &y);
        let statistics = Statistics::new(&gram, Scaling::None);
        let of_rows = |d: &[f64], sigma: f64| {
            let d = DMatrix::from_diagonal(&DVector::from_column_slice(d));
            let c = &theta * d * theta.transpose() + DMatrix::identity(8, 8) * sigma * sigma;
            let factor = c.cholesky().unwrap();
            let log_determinant: f64 = factor.l().diagonal().iter().map(|l| 2.0 * l.ln()).sum();
            -0.5 * (log_determinant + y.dot(&factor.solve(&y)))
        };
        for (d, sigma) in [
            (variances(), 0.5),
            (vec![1.0; 6], 0.05),
            (vec![0.0; 6], 3.0),
        ] {
            let found = Factor::new(&statistics, d.clone(), sigma).log_density;
            let expected = of_rows(&d, sigma);
            // Values up to 1e3 from a covariance of condition 1e5.
            assert!((found - expected).abs() < 1e-8, "{found} {expected}");
        }
    }

    #[test]
    fn analytic_replaced_variances_give_the_factor_and_the_density_of_new_ones() {
        let statistics = Statistics::new(&reference(), Scaling::None);
        let sigma = 0.05;
        let mut d = variances();
        let factor = |d: &[f64]| Factor::new(&statistics, d.to_vec(), sigma);
        let mut running = factor(&d).one_by_one();
        for (j, next) in [2.0, 1e-8, 1e-30, 0.5, 1e-3, 9.0].into_iter().enumerate() {
            running.next(|alone| {
                let before = d[j];
                let was = factor(&d).log_density;
                d[j] = next;
                let change = factor(&d).log_density - was;
                // Densities of 1e5 lose ten digits of sixteen in their difference.
                let tolerance = 1e-9 * (1.0 + was.abs());
                let of_one = alone.log_density(next) - alone.log_density(before);
                assert!(
                    (of_one - change).abs() < tolerance,
                    "{j}: {of_one} {change}"
                );
                next
            });
        }
        // Every column has left and entered again: the order is as before.
        let new = factor(&d);
        for j in 0..6 {
            for i in j..6 {
                let scale = new.lower.row(i).norm();
                // Rounding of six removals, of rows of this length.
                assert!((running.lower[(i, j)] - new.lower[(i, j)]).abs() < 1e-12 * scale);
            }
        }
    }

    #[test]
    fn prop_replacing_again_and_again_lets_no_error_grow() {
        // The same column twice, and data that know their sum to a part in 1e6.
        let theta = DMatrix::from_fn(50, 3, |i, j| ((1 + j / 2) as f64 * i as f64).sin());
        let y = theta.column(0) * 2.0;
        let gram = of_rows(&theta, &y.into_owned());
        let statistics = Statistics::new(&gram, Scaling::UnitRms);
        let wide = [4.0, 3e-3, 1e-5];
        let mut running = Factor::new(&statistics, wide.to_vec(), 1e-6).one_by_one();
        let mut precisions = Vec::new();
        for round in 0..200 {
            for j in 0..3 {
                let next = wide[(round + j) % 3];
                running.next(|alone| {
                    precisions.push(alone.precision);
                    next
                });
            }
        }
        for (k, precision) in precisions.iter().enumerate().skip(18) {
            // The same variances every third round. A column whose copy is there has a precision of 1 over the copy's variance, a
            // difference of numbers of 5e13 that keep 16 digits.
            let other = precisions[k - 9];
            assert!(
                (precision - other).abs() < 0.1 + 1e-3 * other,
                "{k}: {precision} {other}"
            );
        }
    }

    #[test]
    fn prop_dependent_columns_have_finite_moments() {
        // The same column twice: B is singular but for the prior, and rounds to 2e14 times 1e-16.
        let theta = DMatrix::from_fn(50, 2, |i, _| (i as f64).sin());
        let y = theta.column(0) * 2.0;
        let gram = of_rows(&theta, &y.into_owned());
        let statistics = Statistics::new(&gram, Scaling::UnitRms);
        let factor = Factor::new(&statistics, vec![4.0, 4.0], 1e-6);
        let (variance, shrinkage) = factor.spreads();
        assert!(factor.log_density.is_finite());
        assert!(shrinkage.iter().all(|k| (0.0..=1.0 + 1e-12).contains(k)));
        // Each alone keeps half of its prior variance: only their sum is known.
        assert!((variance[0] / 2.0 - 1.0).abs() < 0.1, "{variance}");
        assert!((factor.mean.sum() - statistics.estimate.sum()).abs() < 1e-3);
    }
}
