//! The normal equations with columns and target of unit length, and their Cholesky factor.

use nalgebra::{DMatrix, DVector};

use crate::error::SindyError;
use crate::statistics::gram::Gram;
use crate::statistics::gram::check;
use crate::statistics::regression::pseudo_inverse;
use crate::statistics::tsqr;

/// A pivot below this share of its (unit) column counts as dependent: the Gram matrix squares the
/// condition, so beyond a condition of `Θ` of 3e6 nothing is left of f64's digits.
pub(crate) const PIVOT: f64 = 1e-13;

/// `G`, `b` and `c` after division by the lengths of the columns and of the target: `G` has a unit
/// diagonal, `b` holds cosines, and residual sums are shares of `yᵀ y`.
pub(crate) struct Normal {
    /// `Θᵀ Θ` over the columns that are not zero throughout, scaled.
    pub(crate) g: DMatrix<f64>,
    /// `Θᵀ y` over the same columns, scaled.
    pub(crate) b: DVector<f64>,
    /// The library's index of each of them.
    pub(crate) terms: Vec<usize>,
    /// Length of each of them over the length of the target: scaled = unscaled x this.
    pub(crate) scale: DVector<f64>,
    /// `yᵀ y`, the unit of residual sums.
    pub(crate) unit: f64,
    /// One over the number of rows, or over the sum of their weights.
    pub(crate) weight: f64,
    /// Residual shares below this are rounding of the statistics.
    pub(crate) floor: f64,
    /// Terms of the library.
    pub(crate) p: usize,
    /// The triangular factor of the same columns and the target, scaled, if there is one.
    root: Option<(DMatrix<f64>, DVector<f64>)>,
}

impl Normal {
    pub(crate) fn new(gram: &Gram) -> Result<Self, SindyError> {
        check(gram)?;
        let p = gram.xty.len();
        let terms: Vec<usize> = (0..p).filter(|&j| gram.xtx[(j, j)] > 0.0).collect();
        let length: Vec<f64> = terms.iter().map(|&j| gram.xtx[(j, j)].sqrt()).collect();
        let k = terms.len();
        let target = if gram.yty > 0.0 { gram.yty.sqrt() } else { 1.0 };
        Ok(Self {
            g: DMatrix::from_fn(k, k, |i, j| {
                gram.xtx[(terms[i], terms[j])] / length[i] / length[j]
            }),
            b: DVector::from_fn(k, |i, _| gram.xty[terms[i]] / length[i] / target),
            scale: DVector::from_fn(k, |i, _| length[i] / target),
            root: gram.triangle.as_ref().map(|triangle| {
                let r = triangle.matrix();
                (
                    DMatrix::from_fn(p + 1, k, |i, j| r[(i, terms[j])] / length[j]),
                    r.column(p) / target,
                )
            }),
            terms,
            unit: if gram.yty > 0.0 { gram.yty } else { 1.0 },
            weight: 1.0 / gram.weight(),
            floor: 16.0 * f64::EPSILON * (p + 1) as f64,
            p,
        })
    }

    /// Adds the smallest ridge that makes every principal part safely positive definite, and returns
    /// it: zero while the condition of the scaled `Θ` is below about 3e6. By interlacing, no part is
    /// worse than the whole.
    pub(crate) fn regularise(&mut self) -> f64 {
        if self.terms.is_empty() {
            return 0.0;
        }
        let eigen = self.g.symmetric_eigenvalues();
        let smallest = eigen.min();
        if smallest > 2.0 * PIVOT {
            return 0.0;
        }
        let ridge = 2.0 * PIVOT - smallest.min(0.0);
        (0..self.terms.len()).for_each(|j| self.g[(j, j)] += ridge);
        ridge
    }

    /// Solves `(G_S + diag(ridge)) ξ = b_S` on the subset `index`, in scaled units; least norm where it
    /// is dependent.
    pub(crate) fn solve(&self, index: &[usize], ridge: impl Fn(usize) -> f64) -> DVector<f64> {
        if let Some((root, target)) = &self.root {
            let columns = root.select_columns(index);
            return solve_with_ridge(&columns, target, |a| ridge(index[a]));
        }
        let entry = |a: usize, c: usize| {
            self.g[(index[a], index[c])] + if a == c { ridge(index[a]) } else { 0.0 }
        };
        let mut factor = Factor::new(index.len());
        for (a, &j) in index.iter().enumerate() {
            if !factor.push(|c| entry(a, c), self.b[j]) {
                let k = index.len();
                let b = DVector::from_fn(k, |i, _| self.b[index[i]]);
                return pseudo_inverse(&DMatrix::from_fn(k, k, entry)) * b;
            }
        }
        DVector::from_vec(factor.solve())
    }

    /// The support over the whole library of a subset of the columns.
    pub(crate) fn support(&self, index: impl IntoIterator<Item = usize>) -> Vec<bool> {
        let mut support = vec![false; self.p];
        for j in index {
            support[self.terms[j]] = true;
        }
        support
    }
}

/// `min |b - R x|² + Σ ridge_j x_j²` through the rows of R.
pub(crate) fn solve_with_ridge(
    r: &DMatrix<f64>,
    b: &DVector<f64>,
    ridge: impl Fn(usize) -> f64,
) -> DVector<f64> {
    let (n, k) = r.shape();
    let rows = DMatrix::from_fn(n + k, k, |i, j| match i.checked_sub(n) {
        None => r[(i, j)],
        Some(i) if i == j => ridge(j).sqrt(),
        Some(_) => 0.0,
    });
    tsqr::solve(&rows, &b.clone().resize_vertically(n + k, 0.0))
}

/// `G_S = L Lᵀ` grown row by row, with `z = L⁻¹ b_S`.
pub(crate) struct Factor {
    l: Vec<f64>,
    stride: usize,
    z: Vec<f64>,
}

impl Factor {
    pub(crate) fn new(capacity: usize) -> Self {
        Self {
            l: vec![0.0; capacity * capacity],
            stride: capacity,
            z: Vec::with_capacity(capacity),
        }
    }

    fn row(&self, i: usize) -> &[f64] {
        &self.l[i * self.stride..i * self.stride + i + 1]
    }

    /// Appends a column with products `g(0..=k)` (the last with itself) and `b`; false, and nothing
    /// appended, if it depends on those before.
    pub(crate) fn push(&mut self, g: impl Fn(usize) -> f64, b: f64) -> bool {
        let k = self.z.len();
        for c in 0..k {
            let dot: f64 = (0..c)
                .map(|i| self.l[k * self.stride + i] * self.l[c * self.stride + i])
                .sum();
            self.l[k * self.stride + c] = (g(c) - dot) / self.l[c * self.stride + c];
        }
        let row = &self.l[k * self.stride..k * self.stride + k];
        let diagonal = g(k);
        let pivot = diagonal - row.iter().map(|v| v * v).sum::<f64>();
        if !(pivot > PIVOT * diagonal) {
            return false;
        }
        let root = pivot.sqrt();
        let z = (b - row.iter().zip(&self.z).map(|(a, c)| a * c).sum::<f64>()) / root;
        self.l[k * self.stride + k] = root;
        self.z.push(z);
        true
    }

    /// By how much a further column, with products `g` as in [`Factor::push`], would lower the residual;
    /// `None` if it depends on those before.
    pub(crate) fn gain(&mut self, g: impl Fn(usize) -> f64, b: f64) -> Option<f64> {
        if !self.push(g, b) {
            return None;
        }
        self.z.pop().map(|z| z * z)
    }

    /// The part of the target's square that the columns explain.
    pub(crate) fn explained(&self) -> f64 {
        self.z.iter().map(|z| z * z).sum()
    }

    /// The coefficients, `L⁻ᵀ z`.
    pub(crate) fn solve(&self) -> Vec<f64> {
        let mut x = self.z.clone();
        for i in (0..x.len()).rev() {
            let row = self.row(i);
            x[i] /= row[i];
            for c in 0..i {
                x[c] -= row[c] * x[i];
            }
        }
        x
    }

    /// By how much the residual grows when each column is dropped alone: `ξ_j² / (G⁻¹)_jj`.
    pub(crate) fn drop_costs(&self) -> Vec<f64> {
        let k = self.z.len();
        let mut column = vec![0.0; k];
        (0..k)
            .map(|j| {
                // Column j of L⁻¹ by forward substitution.
                let (mut norm, mut x) = (0.0, 0.0);
                for i in j..k {
                    let row = self.row(i);
                    let dot: f64 = (j..i).map(|c| row[c] * column[c]).sum();
                    column[i] = (f64::from(u8::from(i == j)) - dot) / row[i];
                    norm += column[i] * column[i];
                    x += column[i] * self.z[i];
                }
                x * x / norm
            })
            .collect()
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    /// Statistics of `n` random rows whose columns are mixed by `mix` (0: independent), with the
    /// coefficients `truth` and uniform noise.
    pub(crate) fn random_gram(seed: u64, n: usize, truth: &[f64], mix: f64, noise: f64) -> Gram {
        let (theta, y) = random_rows(seed, n, truth, mix, noise);
        of_rows(&theta, &y)
    }

    pub(crate) fn random_rows(
        seed: u64,
        n: usize,
        truth: &[f64],
        mix: f64,
        noise: f64,
    ) -> (DMatrix<f64>, DVector<f64>) {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(seed);
        let p = truth.len();
        let mut theta = DMatrix::from_fn(n, p, |_, _| rng.random_range(-1.0..1.0));
        for i in 0..n {
            for j in 1..p {
                theta[(i, j)] += mix * theta[(i, j - 1)];
            }
        }
        let y = &theta * DVector::from_column_slice(truth)
            + DVector::from_fn(n, |_, _| noise * rng.random_range(-1.0..1.0));
        (theta, y)
    }

    /// 60 rows of six columns and a target without random numbers, for values from other tools.
    pub(crate) fn reference() -> Gram {
        let column = |i: usize, j: usize| {
            let t = 0.1 * i as f64;
            match j {
                0 => 1.0,
                1 => t.sin(),
                2 => (2.0 * t).cos(),
                3 => t.sin() * (2.0 * t).cos(),
                4 => 10.0 * (0.7 * t).sin().powi(2),
                _ => 0.1 * (3.0 * t).cos(),
            }
        };
        let theta = DMatrix::from_fn(60, 6, column);
        let y = DVector::from_fn(60, |i, _| {
            let r = i as f64;
            0.5 + 1.2 * theta[(i, 1)] - 0.08 * theta[(i, 4)]
                + 3.0 * theta[(i, 5)]
                + 0.06 * theta[(i, 2)]
                + 0.02 * (17.0 * r).sin()
                + 0.05 * (5.3 * r * r).cos()
        });
        of_rows(&theta, &y)
    }

    pub(crate) fn of_rows(theta: &DMatrix<f64>, y: &DVector<f64>) -> Gram {
        Gram {
            xtx: theta.transpose() * theta,
            xty: theta.transpose() * y,
            yty: y.norm_squared(),
            sum_y: y.sum(),
            rows: theta.nrows(),
            ..Gram::zeros(theta.ncols())
        }
    }

    #[test]
    fn analytic_gains_and_drop_costs_are_differences_of_residuals() {
        let gram = random_gram(1, 60, &[1.0, 0.0, -2.0, 0.5, 0.1], 0.9, 0.3);
        let normal = Normal::new(&gram).unwrap();
        let explained = |index: &[usize]| {
            let mut f = Factor::new(6);
            for &j in index {
                assert!(f.push(|c| normal.g[(j, *index.get(c).unwrap())], normal.b[j]));
            }
            f
        };
        let all = [0, 1, 2, 3, 4];
        let costs = explained(&all).drop_costs();
        for j in all {
            let rest: Vec<usize> = all.into_iter().filter(|&i| i != j).collect();
            let mut f = explained(&rest);
            let before = f.explained();
            let at = |c: usize| normal.g[(j, *rest.get(c).unwrap_or(&j))];
            let gain = f.gain(at, normal.b[j]).unwrap();
            // Shares of yᵀy, well conditioned: rounding only.
            assert!((gain - costs[j]).abs() < 1e-13);
            assert!((explained(&all).explained() - before - gain).abs() < 1e-13);
            // The same column twice is refused.
            let twice = all;
            let mut f = explained(&twice);
            assert!(!f.push(|c| normal.g[(j, *twice.get(c).unwrap_or(&j))], normal.b[j]));
        }
    }
}
