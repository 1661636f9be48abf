//! SR3 with other penalties: ℓ1 and ℓ0 with a weight for each term, and linear equality constraints.
//!
//! ```text
//! min over ξ, w   1/2 |y - Θ ξ|² + λ Σ ω_j r(w_j) + 1/(2ν) |ξ - w|²     subject to   C ξ = d
//! ```
//!
//! with `r(w) = |w|` (ℓ1) or `r(w) = 1 where w ≠ 0` (ℓ0). For given ξ the best w is a threshold: soft at
//! `λ ω_j ν`, or hard at `√(2 λ ω_j ν)`. For given signs `s` of w (its support, with ℓ0) ξ solves a linear system,
//!
//! ```text
//! (G + P_N/ν) ξ + Cᵀ μ = b - λ ω ∘ s   (ℓ1; without the last term for ℓ0),     C ξ = d
//! ```
//!
//! with `P_N` the terms outside the support, and so the fixed point is found support by support instead of
//! by thousands of steps. With ℓ1 the problem is convex, each step is Newton's with the step length halved
//! until the objective falls, and the result is the global optimum. With ℓ0 it is a fixed point of the
//! published iteration, as with [`Sr3`].
//!
//! The constraints hold exactly for `dense` and `refit`; `sparse` is thresholded and meets them
//! approximately. If the terms that are kept cannot meet them, the outcome is
//! [`Outcome::Infeasible`] and `refit` is as near to them as these terms allow.
//!
//! Scaling is as for [`Sr3`]: with [`Scaling::UnitRms`] λ, ν and ω act on scaled
//! coefficients; `C` and `d` are always in the units of the data.
//!
//! Sources: P. Zheng et al., IEEE Access 7 (2019); K. Champion et al., IEEE Access 8 (2020).

use nalgebra::{DMatrix, DVector};

use crate::error::SindyError;
use crate::fit::{Fit, Solver, check};
use crate::gram::Gram;
use crate::outcome::Outcome;
use crate::regression::pseudo_inverse;
use crate::sr3::{Scaling, Solution, Sr3};

/// What a coefficient costs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Penalty {
    /// Its being there.
    L0,
    /// Its size.
    L1,
}

/// SR3 with a penalty, weights and constraints.
#[derive(Clone, Debug, PartialEq)]
pub struct Relaxed {
    lambda: f64,
    nu: f64,
    penalty: Penalty,
    weights: Option<DVector<f64>>,
    constraints: Option<(DMatrix<f64>, DVector<f64>)>,
    scaling: Scaling,
    max_iterations: usize,
}

/// The affine set `C ξ = d` as a point and a basis of directions.
struct Affine {
    point: DVector<f64>,
    basis: DMatrix<f64>,
    /// Whether there is such a set, to rounding.
    feasible: bool,
}

impl Relaxed {
    /// Penalty λ, relaxation ν; scaled, equal weights, no constraints.
    ///
    /// # Errors
    /// As [`Sr3::new`].
    pub fn new(penalty: Penalty, lambda: f64, nu: f64) -> Result<Self, SindyError> {
        Sr3::new(lambda, nu)?;
        Ok(Self {
            lambda,
            nu,
            penalty,
            weights: None,
            constraints: None,
            scaling: Scaling::UnitRms,
            max_iterations: 200,
        })
    }

    /// The same with a weight for each term; a term of weight zero is never dropped for its size.
    ///
    /// # Errors
    /// A weight that is negative or not finite.
    pub fn weights(self, weights: &[f64]) -> Result<Self, SindyError> {
        for &w in weights {
            crate::fit::at_least_zero("weights", w)?;
        }
        Ok(Self {
            weights: Some(DVector::from_column_slice(weights)),
            ..self
        })
    }

    /// The same with the constraints `C ξ = d` (`C`: constraints x terms).
    ///
    /// # Errors
    /// Shapes that do not fit, entries that are not finite, or constraints that contradict each other.
    pub fn constraints(self, c: DMatrix<f64>, d: DVector<f64>) -> Result<Self, SindyError> {
        if c.nrows() != d.len() {
            return Err(SindyError::Shape {
                what: "right-hand sides of the constraints",
                expected: c.nrows(),
                found: d.len(),
            });
        }
        if let Some(index) =
            (0..d.len()).find(|&i| !d[i].is_finite() || c.row(i).iter().any(|v| !v.is_finite()))
        {
            return Err(SindyError::NotFinite {
                what: "constraints".to_string(),
                index,
            });
        }
        if c.ncols() > 0 && !affine(&c, &d).feasible {
            return Err(SindyError::setting(
                "constraints",
                "equations that can all hold at once",
                "equations that contradict each other",
            ));
        }
        Ok(Self {
            constraints: (!d.is_empty()).then_some((c, d)),
            ..self
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

    /// Solves for the coefficients of `gram`.
    ///
    /// # Errors
    /// Statistics that no solver can use ([`check`]); weights or constraints for another number of terms.
    pub fn solve(&self, gram: &Gram) -> Result<Solution, SindyError> {
        check(gram)?;
        let p = gram.xty.len();
        let expect = |what, found: usize| {
            if found == p {
                Ok(())
            } else {
                Err(SindyError::Shape {
                    what,
                    expected: p,
                    found,
                })
            }
        };
        if let Some(w) = &self.weights {
            expect("weights", w.len())?;
        }
        if let Some((c, _)) = &self.constraints {
            expect("columns of the constraints", c.ncols())?;
        }
        // Scaled coefficients are ξ' = scale ∘ ξ, and sums are multiplied by `factor`.
        let (scale, factor) = match self.scaling {
            Scaling::None => (DVector::from_element(p, 1.0), 1.0),
            Scaling::UnitRms => {
                let target = gram.target_rms();
                (
                    gram.column_rms() / target,
                    1.0 / (gram.rows as f64 * target * target),
                )
            }
        };
        let g = DMatrix::from_fn(p, p, |i, j| {
            gram.xtx[(i, j)] * factor / (scale[i] * scale[j])
        });
        let b = DVector::from_fn(p, |i, _| gram.xty[i] * factor / scale[i]);
        let set = match &self.constraints {
            None => affine(&DMatrix::zeros(0, p), &DVector::zeros(0)),
            Some((c, d)) => affine(
                &DMatrix::from_fn(c.nrows(), p, |i, j| c[(i, j)] / scale[j]),
                d,
            ),
        };
        let (dense, mut outcome, iterations) = self.iterate(&g, &b, &set);
        let sparse = self.threshold(&dense);
        let support: Vec<bool> = sparse.iter().map(|w| *w != 0.0).collect();
        let refit = self.refit(&g, &b, &scale, &support, &mut outcome);
        let objective = 0.5 * (gram.yty * factor) + self.objective(&g, &b, &dense);
        Ok(Solution {
            dense: dense.component_div(&scale),
            sparse: sparse.component_div(&scale),
            refit,
            support,
            outcome,
            iterations,
            objective,
        })
    }

    /// λ ω_j.
    fn cost(&self, j: usize) -> f64 {
        self.lambda * self.weights.as_ref().map_or(1.0, |w| w[j])
    }

    /// The best w for given ξ.
    fn threshold(&self, xi: &DVector<f64>) -> DVector<f64> {
        DVector::from_fn(xi.len(), |j, _| match self.penalty {
            Penalty::L0 if xi[j].abs() > (2.0 * self.cost(j) * self.nu).sqrt() => xi[j],
            Penalty::L0 => 0.0,
            Penalty::L1 => xi[j].signum() * (xi[j].abs() - self.cost(j) * self.nu).max(0.0),
        })
    }

    /// The objective without `yᵀ y / 2`, at the best w.
    fn objective(&self, g: &DMatrix<f64>, b: &DVector<f64>, xi: &DVector<f64>) -> f64 {
        let w = self.threshold(xi);
        let penalty: f64 = (0..w.len())
            .filter(|&j| w[j] != 0.0)
            .map(|j| match self.penalty {
                Penalty::L0 => self.cost(j),
                Penalty::L1 => self.cost(j) * w[j].abs(),
            })
            .sum();
        0.5 * xi.dot(&(g * xi)) - xi.dot(b) + penalty + (xi - w).norm_squared() / (2.0 * self.nu)
    }

    fn iterate(
        &self,
        g: &DMatrix<f64>,
        b: &DVector<f64>,
        set: &Affine,
    ) -> (DVector<f64>, Outcome, usize) {
        let p = b.len();
        // From least squares, as published.
        let mut xi = solve_on(g, b, set);
        let mut seen: Vec<Vec<i8>> = Vec::new();
        for k in 1..=self.max_iterations {
            let signs = self.signs(&xi);
            let mut a = g.clone();
            let mut rhs = b.clone();
            for j in 0..p {
                if signs[j] == 0 {
                    a[(j, j)] += 1.0 / self.nu;
                } else if self.penalty == Penalty::L1 {
                    rhs[j] -= self.cost(j) * f64::from(signs[j]);
                }
            }
            let mut next = solve_on(&a, &rhs, set);
            if self.signs(&next) == signs {
                return (next, Outcome::Converged, k);
            }
            match self.penalty {
                Penalty::L0 if seen.contains(&signs) => return (xi, Outcome::Cycled, k),
                Penalty::L0 => seen.push(signs),
                Penalty::L1 => {
                    let before = self.objective(g, b, &xi);
                    let mut halvings = 0;
                    while self.objective(g, b, &next) >= before && halvings < 50 {
                        next = 0.5 * (&next + &xi);
                        halvings += 1;
                    }
                    if halvings == 50 {
                        // A point on the edge between two pieces, to rounding: nothing improves on it.
                        return (xi, Outcome::Converged, k);
                    }
                }
            }
            xi = next;
        }
        (xi, Outcome::IterationLimit, self.max_iterations)
    }

    fn signs(&self, xi: &DVector<f64>) -> Vec<i8> {
        let sign = |w: &f64| i8::from(*w > 0.0) - i8::from(*w < 0.0);
        let w = self.threshold(xi);
        match self.penalty {
            Penalty::L1 => w.iter().map(sign).collect(),
            Penalty::L0 => w.iter().map(|w| sign(w).abs()).collect(),
        }
    }

    /// Least squares on the support, with the constraints, in the units of the data.
    fn refit(
        &self,
        g: &DMatrix<f64>,
        b: &DVector<f64>,
        scale: &DVector<f64>,
        support: &[bool],
        outcome: &mut Outcome,
    ) -> DVector<f64> {
        let index: Vec<usize> = (0..support.len()).filter(|&j| support[j]).collect();
        let k = index.len();
        let (c, d) = match &self.constraints {
            None => (DMatrix::zeros(0, k), DVector::zeros(0)),
            Some((c, d)) => (
                DMatrix::from_fn(c.nrows(), k, |i, a| c[(i, index[a])] / scale[index[a]]),
                d.clone(),
            ),
        };
        let set = affine(&c, &d);
        if !set.feasible {
            *outcome = Outcome::Infeasible;
        }
        let mut out = DVector::zeros(support.len());
        let part = g.select_rows(&index).select_columns(&index);
        let xi = solve_on(&part, &b.select_rows(&index), &set);
        for (a, &j) in index.iter().enumerate() {
            out[j] = xi[a] / scale[j];
        }
        out
    }
}

impl Solver for Relaxed {
    /// The refitted solution.
    fn fit(&self, gram: &Gram) -> Result<Fit, SindyError> {
        let s = self.solve(gram)?;
        Ok(Fit::new(gram, s.refit, s.support, s.outcome, s.iterations))
    }
}

/// `C ξ = d` as its point of least norm and an orthonormal basis of the null space of `C`, whose rows are made
/// unit length first.
fn affine(c: &DMatrix<f64>, d: &DVector<f64>) -> Affine {
    let p = c.ncols();
    let length: Vec<f64> = (0..c.nrows())
        .map(|i| c.row(i).norm())
        .map(|l| if l > 0.0 { l } else { 1.0 })
        .collect();
    let c = DMatrix::from_fn(c.nrows(), p, |i, j| c[(i, j)] / length[i]);
    let d = DVector::from_fn(d.len(), |i, _| d[i] / length[i]);
    if c.is_empty() {
        return Affine {
            point: DVector::zeros(p),
            basis: DMatrix::identity(p, p),
            feasible: d.iter().all(|v| *v == 0.0),
        };
    }
    // Eigenvectors of CᵀC with rows of unit length: those of eigenvalue zero span the null space.
    let eigen = (c.transpose() * &c).symmetric_eigen();
    let point = pseudo_inverse(&(c.transpose() * &c)) * c.transpose() * &d;
    let largest = eigen.eigenvalues.max();
    let null: Vec<usize> = (0..p)
        .filter(|&j| eigen.eigenvalues[j] <= 1e-13 * largest)
        .collect();
    let missed = (&c * &point - &d).amax();
    Affine {
        feasible: missed <= 1e-9 * (d.amax() + point.amax()),
        basis: eigen.eigenvectors.select_columns(&null),
        point,
    }
}

/// The minimum of `1/2 ξᵀ A ξ - ξᵀ r` on the set; least norm where it is not unique.
fn solve_on(a: &DMatrix<f64>, r: &DVector<f64>, set: &Affine) -> DVector<f64> {
    if set.basis.ncols() == 0 {
        return set.point.clone();
    }
    // Columns of unit length, which keeps a badly scaled library from looking dependent.
    let h = set.basis.transpose() * a * &set.basis;
    let s = h.diagonal().map(|v| if v > 0.0 { v.sqrt() } else { 1.0 });
    let h = DMatrix::from_fn(s.len(), s.len(), |i, j| h[(i, j)] / s[i] / s[j]);
    let rhs = (set.basis.transpose() * (r - a * &set.point)).component_div(&s);
    &set.point + &set.basis * (pseudo_inverse(&h) * rhs).component_div(&s)
}

#[cfg(test)]
mod tests;
