//! SR3 with other penalties: ℓ1 and ℓ0 with a weight for each term, and linear constraints.
//!
//! ```text
//! min over ξ, w   1/2 |y - Θ ξ|² + λ Σ ω_j r(w_j) + 1/(2ν) |ξ - w|²     subject to   C ξ = d,  A ξ <= b
//! ```
//!
//! with `r(w) = |w|` (ℓ1) or `r(w) = 1 where w ≠ 0` (ℓ0). For given ξ the best w is a threshold: soft at
//! `λ ω_j ν`, or hard at `√(2 λ ω_j ν)`. For given signs `s` of w (its support, with ℓ0) ξ solves a linear system,
//!
//! ```text
//! (G + P_N/ν) ξ + Cᵀ μ = b - λ ω ∘ s   (ℓ1; without the last term for ℓ0),     C ξ = d
//! ```
//!
//! (under inequalities: a convex quadratic programme, solved by the dual active-set method of Goldfarb and
//! Idnani) with `P_N` the terms outside the support, and so the fixed point is found support by support instead of
//! by thousands of steps. With ℓ1 the problem is convex, each step is Newton's with the step length halved
//! until the objective falls, and the result is the global optimum. With ℓ0 it is a fixed point of the
//! published iteration, as with [`Sr3`].
//!
//! The constraints hold to rounding for `dense` and `refit`; `sparse` is thresholded and meets them
//! approximately. If the terms that are kept cannot meet them, the outcome is
//! [`Outcome::Infeasible`] and `refit` leaves the inequalities aside and is as near to the equations as these
//! terms allow.
//!
//! [`Relaxed::trace`] gives the objective above at each step, at the best w: it never rises. [`Trimming`]
//! leaves out the rows that fit worst.
//!
//! Scaling is as for [`Sr3`]: with [`Scaling::UnitRms`] λ, ν and ω act on scaled
//! coefficients; `C`, `d`, `A` and `b` are always in the units of the data.
//!
//! Sources: P. Zheng et al., IEEE Access 7 (2019); K. Champion et al., IEEE Access 8 (2020).

mod set;
mod trim;

pub use trim::{Trimmed, Trimming};

use nalgebra::{DMatrix, DVector};

use crate::error::{SindyError, same_size};
use crate::solve::fit::{Fit, Solver};
use crate::solve::outcome::Outcome;
use crate::solve::sr3::{FixedPoint, Path, Problem, Scaling, Solution, Sr3, fixed_support};
use crate::statistics::gram::{Gram, check};
use set::Set;

/// Iteration limit by default: supports and signs change a handful of times, and only settings that cycle come near it.
const MAX_ITERATIONS: usize = 200;

/// Halvings of a step before it counts as none: 2⁻⁵⁰ of it is rounding.
const HALVINGS: usize = 50;

/// The penalty of a coefficient.
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
    sr3: Sr3,
    penalty: Penalty,
    weights: Option<DVector<f64>>,
    equations: (DMatrix<f64>, DVector<f64>),
    inequalities: (DMatrix<f64>, DVector<f64>),
}

impl Relaxed {
    /// Penalty λ, relaxation ν; scaled, equal weights, no constraints.
    ///
    /// # Errors
    /// As [`Sr3::new`].
    pub fn new(penalty: Penalty, lambda: f64, nu: f64) -> Result<Self, SindyError> {
        Ok(Self {
            sr3: Sr3::new(lambda, nu)?.path(Path::Direct, MAX_ITERATIONS),
            penalty,
            weights: None,
            equations: (DMatrix::zeros(0, 0), DVector::zeros(0)),
            inequalities: (DMatrix::zeros(0, 0), DVector::zeros(0)),
        })
    }

    /// The same with a weight for each term; a term of weight zero is never dropped for its size.
    ///
    /// # Errors
    /// A weight that is negative or not finite.
    pub fn weights(self, weights: &[f64]) -> Result<Self, SindyError> {
        for &w in weights {
            crate::error::at_least_zero("weights", w)?;
        }
        Ok(Self {
            weights: Some(DVector::from_column_slice(weights)),
            ..self
        })
    }

    /// The same with the constraints `C ξ = d` (`C`: constraints x terms).
    ///
    /// # Errors
    /// Shapes that do not fit, entries that are not finite, or constraints (with the inequalities, if they are
    /// known by then) that cannot all hold.
    pub fn constraints(self, c: DMatrix<f64>, d: DVector<f64>) -> Result<Self, SindyError> {
        Self {
            equations: checked(c, d)?,
            ..self
        }
        .consistent()
    }

    /// The same with the constraints `A ξ <= b` (`A`: constraints x terms), such as signs and bounds of
    /// coefficients.
    ///
    /// # Errors
    /// As [`Relaxed::constraints`].
    pub fn inequalities(self, a: DMatrix<f64>, b: DVector<f64>) -> Result<Self, SindyError> {
        Self {
            inequalities: checked(a, b)?,
            ..self
        }
        .consistent()
    }

    fn consistent(self) -> Result<Self, SindyError> {
        let (c, a) = (&self.equations.0, &self.inequalities.0);
        let p = c.ncols().max(a.ncols());
        for (what, found) in [
            ("columns of the constraints", c),
            ("columns of the inequalities", a),
        ] {
            if found.nrows() > 0 && found.ncols() != p {
                return Err(SindyError::shape(what, p, found.ncols()));
            }
        }
        if p > 0
            && !self
                .set(&vec![1.0; p], &(0..p).collect::<Vec<_>>())
                .feasible()
        {
            return Err(SindyError::setting(
                "constraints",
                "equations and inequalities that can all hold at once",
                "such as contradict each other",
            ));
        }
        Ok(self)
    }

    /// The constraints on the terms of `index` alone, in scaled coefficients.
    fn set(&self, scale: &[f64], index: &[usize]) -> Set {
        let part = |m: &DMatrix<f64>| {
            DMatrix::from_fn(m.nrows(), index.len(), |i, k| {
                m[(i, index[k])] / scale[index[k]]
            })
        };
        let ((c, d), (a, b)) = (&self.equations, &self.inequalities);
        Set::new((&part(c), d), (&part(a), b))
    }

    /// The same with another scaling.
    #[must_use]
    pub fn scaling(self, scaling: Scaling) -> Self {
        let sr3 = self.sr3.scaling(scaling);
        Self { sr3, ..self }
    }

    /// The same with another iteration limit, at least 1.
    #[must_use]
    pub fn max_iterations(self, limit: usize) -> Self {
        let sr3 = self.sr3.path(Path::Direct, limit.max(1));
        Self { sr3, ..self }
    }

    /// Solves for the coefficients of `gram`.
    ///
    /// # Errors
    /// Statistics that no solver can use ([`check`]); weights or constraints for another number of terms.
    pub fn solve(&self, gram: &Gram) -> Result<Solution, SindyError> {
        Ok(self.trace(gram)?.0)
    }

    /// The same, with the objective at each step: first at the start (least squares under the constraints),
    /// last at the solution. It is the objective above to the letter, in the chosen scaling, with the best w
    /// for each ξ, and never rises but by rounding.
    ///
    /// # Errors
    /// As [`Relaxed::solve`].
    pub fn trace(&self, gram: &Gram) -> Result<(Solution, Vec<f64>), SindyError> {
        check(gram)?;
        let p = gram.xty.len();
        let mut expected = vec![("weights", self.weights.as_ref().map_or(p, DVector::len))];
        if self.equations.0.nrows() > 0 {
            expected.push(("columns of the constraints", self.equations.0.ncols()));
        }
        if self.inequalities.0.nrows() > 0 {
            expected.push(("columns of the inequalities", self.inequalities.0.ncols()));
        }
        if let Some(&(what, found)) = expected.iter().find(|(_, found)| *found != p) {
            return Err(SindyError::shape(what, p, found));
        }
        let problem = Problem::new(gram, self.sr3.scaling);
        let set = self.set(problem.scale.as_slice(), &(0..p).collect::<Vec<_>>());
        let mut trace = Vec::new();
        let mut found = match self.penalty {
            Penalty::L0 => self.hard(&problem, &set, &mut trace),
            Penalty::L1 => self.soft(&problem, &set, &mut trace),
        };
        let square = 0.5 * (gram.yty * problem.weight);
        trace.iter_mut().for_each(|v| *v += square);
        let sparse = match self.penalty {
            Penalty::L0 => found.on_support(),
            Penalty::L1 => self.threshold(&found.dense),
        };
        let refit = self.refit(&problem, &mut found);
        let objective = square + self.objective(&problem, &found.dense);
        Ok((problem.solution(found, &sparse, refit, objective), trace))
    }

    /// λ ω_j.
    fn cost(&self, j: usize) -> f64 {
        self.sr3.lambda * self.weights.as_ref().map_or(1.0, |w| w[j])
    }

    /// The best w for given ξ.
    fn threshold(&self, xi: &DVector<f64>) -> DVector<f64> {
        DVector::from_fn(xi.len(), |j, _| match self.penalty {
            Penalty::L0 if xi[j].abs() > (2.0 * self.cost(j) * self.sr3.nu).sqrt() => xi[j],
            Penalty::L0 => 0.0,
            Penalty::L1 => xi[j].signum() * (xi[j].abs() - self.cost(j) * self.sr3.nu).max(0.0),
        })
    }

    /// The objective without `yᵀ y / 2`, at the best w.
    fn objective(&self, Problem { g, b, .. }: &Problem<'_>, xi: &DVector<f64>) -> f64 {
        let w = self.threshold(xi);
        let penalty: f64 = (0..w.len())
            .filter(|&j| w[j] != 0.0)
            .map(|j| match self.penalty {
                Penalty::L0 => self.cost(j),
                Penalty::L1 => self.cost(j) * w[j].abs(),
            })
            .sum();
        0.5 * xi.dot(&(g * xi)) - xi.dot(b)
            + penalty
            + (xi - w).norm_squared() / (2.0 * self.sr3.nu)
    }

    /// Support by support, as [`Sr3`].
    fn hard(&self, problem: &Problem<'_>, set: &Set, trace: &mut Vec<f64>) -> FixedPoint {
        fixed_support(
            vec![true; problem.b.len()],
            self.sr3.max_iterations,
            |support| {
                let signs: Vec<i8> = support.iter().map(|kept| i8::from(*kept)).collect();
                let xi = self.minimum(problem, set, &signs)?;
                trace.push(self.objective(problem, &xi));
                Ok(xi)
            },
            |xi| self.threshold(xi).iter().map(|w| *w != 0.0).collect(),
        )
    }

    /// Newton's steps from the signs of w to the next, halved until the objective falls; from least squares.
    fn soft(&self, problem: &Problem<'_>, set: &Set, trace: &mut Vec<f64>) -> FixedPoint {
        let p = problem.b.len();
        let of = |xi: &DVector<f64>| self.objective(problem, xi);
        let end = |xi: DVector<f64>, outcome, iterations| {
            let support = self.threshold(&xi).iter().map(|w| *w != 0.0).collect();
            FixedPoint::new(xi, support, outcome, iterations)
        };
        let mut xi = match set.minimum(&problem.g, &problem.b) {
            Ok(xi) => xi,
            Err(outcome) => return end(DVector::zeros(p), outcome, 0),
        };
        trace.push(of(&xi));
        for k in 1..=self.sr3.max_iterations {
            let signs = self.signs(&xi);
            let mut next = match self.minimum(problem, set, &signs) {
                Ok(next) => next,
                Err(outcome) => return end(xi, outcome, k),
            };
            if self.signs(&next) == signs {
                trace.push(of(&next));
                return end(next, Outcome::Converged, k);
            }
            let before = of(&xi);
            let mut halvings = 0;
            while of(&next) >= before && halvings < HALVINGS {
                next = 0.5 * (&next + &xi);
                halvings += 1;
            }
            if halvings == HALVINGS {
                // A point on the edge between two pieces, to rounding: nothing improves on it.
                return end(xi, Outcome::Converged, k);
            }
            xi = next;
            trace.push(of(&xi));
        }
        end(xi, Outcome::IterationLimit, self.sr3.max_iterations)
    }

    /// The best ξ under the constraints for given signs of w: terms of sign 0 have the ridge 1/ν, and with ℓ1 the others
    /// pay for their size.
    fn minimum(
        &self,
        Problem { g, b, .. }: &Problem<'_>,
        set: &Set,
        signs: &[i8],
    ) -> Result<DVector<f64>, Outcome> {
        let (mut a, mut rhs) = (g.clone(), b.clone());
        for (j, &sign) in signs.iter().enumerate() {
            if sign == 0 {
                a[(j, j)] += 1.0 / self.sr3.nu;
            } else if self.penalty == Penalty::L1 {
                rhs[j] -= self.cost(j) * f64::from(sign);
            }
        }
        set.minimum(&a, &rhs)
    }

    fn signs(&self, xi: &DVector<f64>) -> Vec<i8> {
        let sign = |w: &f64| i8::from(*w > 0.0) - i8::from(*w < 0.0);
        self.threshold(xi).iter().map(sign).collect()
    }

    /// Least squares on the support, with the constraints, in the units of the data.
    fn refit(&self, problem: &Problem<'_>, found: &mut FixedPoint) -> DVector<f64> {
        let Problem { g, b, scale, .. } = problem;
        let support = &found.support;
        let index: Vec<usize> = (0..support.len()).filter(|&j| support[j]).collect();
        let part = g.select_rows(&index).select_columns(&index);
        let rhs = b.select_rows(&index);
        let set = self.set(scale.as_slice(), &index);
        let mut out = DVector::zeros(support.len());
        let xi = set.minimum(&part, &rhs);
        if !set.consistent() || xi.is_err() {
            found.outcome = Outcome::Infeasible;
        }
        let xi = xi.unwrap_or_else(|_| set.equations_only(&part, &rhs));
        for (a, &j) in index.iter().enumerate() {
            out[j] = xi[a] / scale[j];
        }
        out
    }
}

/// Refuses constraints whose shapes do not fit or that are not finite.
fn checked(a: DMatrix<f64>, b: DVector<f64>) -> Result<(DMatrix<f64>, DVector<f64>), SindyError> {
    same_size("right-hand sides of the constraints", a.nrows(), b.len())?;
    let bad = |&i: &usize| !b[i].is_finite() || a.row(i).iter().any(|v| !v.is_finite());
    match (0..b.len()).find(bad) {
        Some(index) => Err(SindyError::NotFinite {
            what: "constraints".to_string(),
            index,
        }),
        None => Ok((a, b)),
    }
}

impl Solver for Relaxed {
    /// The refitted solution.
    fn fit(&self, gram: &Gram) -> Result<Fit, SindyError> {
        let s = self.solve(gram)?;
        Ok(Fit::new(gram, s.refit, s.support, s.outcome, s.iterations))
    }
}

#[cfg(test)]
mod tests;
