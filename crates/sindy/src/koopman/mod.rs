//! Linear comparators: dynamic mode decomposition with control (DMDc) and its extended form (EDMDc).
//!
//! Both fit a discrete-time linear system to pairs of successive samples, `x` being n states and `u` m
//! inputs:
//!
//! ```text
//! Dmdc    x[k+1] = A x[k] + B u[k]                                A n x n,  B n x m
//! Edmdc   z[k+1] = A z[k] + B v[k],   z = ψ(x),  v = φ(x, u),  x ≈ C z
//! ```
//!
//! They are the baselines that a sparse nonlinear model should beat on unseen data. A, B
//! and C are in the units of the data; the sampling period is the caller's statement, the same for all
//! trajectories, and serves only continuous-time eigenvalues and the time of a run.
//!
//! Pairs are never made across groups (trajectories) nor across a row with a value that is not finite (or
//! beyond 10¹⁵⁰, whose square overflows); a group handed over in several blocks is one trajectory as
//! long as no block of another group comes between. The data are read once, block by block: all that is
//! kept is the triangular factor R of a QR decomposition of the snapshots, updated with each block. Unlike
//! their Gram matrix it has their singular values in full precision.
//!
//! The least squares problem is solved by a singular value decomposition of R, cut off at a [`Rank`].
//! Where the data do not determine all coefficients (fewer pairs than regressors, collinear or zero
//! columns) the solution is that of least norm and `rank` is smaller than the number of regressors.
//!
//! Sources: J. L. Proctor, S. L. Brunton, J. N. Kutz, SIAM J. Appl. Dyn. Syst. 15 (2016) (DMDc); M. O.
//! Williams, I. G. Kevrekidis, C. W. Rowley, J. Nonlinear Sci. 25 (2015) (EDMD); M. Korda, I. Mezić,
//! Automatica 93 (2018) (EDMD with control); M. Gavish, D. L. Donoho, IEEE Trans. Inf. Theory 60 (2014)
//! (optimal hard threshold).

mod dmdc;
mod edmdc;
mod snapshots;
mod system;
#[cfg(test)]
mod tests;

use nalgebra::linalg::SVD;
use nalgebra::{DMatrix, DVector};

pub use dmdc::{Dmdc, DmdcModel};
pub use edmdc::{Edmdc, EdmdcModel, Lifting};
pub use system::LinearSystem;

use crate::error::{SindyError, finite, require, same_size};
use crate::model::{Run, RunOutcome};

/// A run whose state exceeds this has blown up.
const BLOW_UP: f64 = 1e150;

/// Limit of the iterations of nalgebra's decompositions, which need a few per row.
const ITERATIONS: usize = 100_000;

/// How many singular values of the regressors' snapshots are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rank {
    /// All above rounding: `σ > ε max(rows, columns) σ₁`.
    Full,
    /// This number of the largest ones (fewer if fewer exceed the rounding), at least 1.
    Given(usize),
    /// Those above the optimal hard threshold for unknown noise, `σ > ω(β) median(σ)` with β the
    /// snapshots' aspect ratio and `ω(β) ≈ 0.56 β³ - 0.95 β² + 1.82 β + 1.43`; at least one. Meant for
    /// many measured columns of few true directions: with few columns it keeps very little.
    OptimalThreshold,
}

/// Rank and regularisation, checked.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Regression {
    rank: Rank,
    ridge: f64,
}

/// The result of the regression: `targets ≈ regressors · coefficients`.
struct RegressionSolution {
    /// Regressors x targets.
    coefficients: DMatrix<f64>,
    singular_values: Vec<f64>,
    rank: usize,
}

impl Regression {
    fn new(rank: Rank, ridge: f64) -> Result<Self, SindyError> {
        require(rank != Rank::Given(0), "rank", "at least 1", 0)?;
        require(
            ridge >= 0.0 && ridge.is_finite(),
            "ridge",
            "finite, not negative",
            ridge,
        )?;
        Ok(Self { rank, ridge })
    }

    /// Solves for the right-hand sides `rhs` (p x q) with the triangular factor `r` (p x p) of `rows`
    /// rows; with `scaled`, the columns of `r` are brought to unit length first.
    fn solve(
        &self,
        mut r: DMatrix<f64>,
        rhs: &DMatrix<f64>,
        rows: usize,
        scaled: bool,
    ) -> Result<RegressionSolution, SindyError> {
        let p = r.ncols();
        if let Rank::Given(rank) = self.rank
            && rank > p
        {
            let expected = format!("at most the {p} regressors");
            return Err(SindyError::setting("rank", expected, rank));
        }
        let scale = DVector::from_iterator(
            p,
            r.column_iter().map(|c| match c.norm() {
                norm if scaled && norm > 0.0 => norm,
                _ => 1.0,
            }),
        );
        for (mut column, s) in r.column_iter_mut().zip(&scale) {
            column /= *s;
        }
        let what = "singular values of the snapshots";
        let svd = SVD::try_new(r, true, true, f64::EPSILON, ITERATIONS)
            .ok_or(SindyError::Singular { what })?;
        let (Some(u), Some(v_t)) = (&svd.u, &svd.v_t) else {
            return Err(SindyError::Singular { what });
        };
        let count = p.min(rows);
        let sigma = &svd.singular_values.as_slice()[..count];
        let rank = self.keep(sigma, p, rows);
        let mut inner = u.columns(0, rank).transpose() * rhs;
        for (mut row, s) in inner.row_iter_mut().zip(sigma) {
            row *= s / (s * s + self.ridge * sigma[0] * sigma[0]);
        }
        let mut coefficients = v_t.rows(0, rank).transpose() * inner;
        for (mut row, s) in coefficients.row_iter_mut().zip(&scale) {
            row /= *s;
        }
        Ok(RegressionSolution {
            coefficients,
            singular_values: sigma.to_vec(),
            rank,
        })
    }

    /// How many of the descending `sigma` are kept.
    fn keep(&self, sigma: &[f64], columns: usize, rows: usize) -> usize {
        let largest = sigma.first().copied().unwrap_or(0.0);
        let rounding = f64::EPSILON * columns.max(rows) as f64 * largest;
        let full = sigma.iter().filter(|s| **s > rounding).count();
        match self.rank {
            Rank::Full => full,
            Rank::Given(rank) => rank.min(full),
            Rank::OptimalThreshold => {
                let beta = columns.min(rows) as f64 / columns.max(rows) as f64;
                let omega = ((0.56 * beta - 0.95) * beta + 1.82) * beta + 1.43;
                let threshold = omega * median(sigma);
                let above = sigma.iter().filter(|s| **s > threshold).count();
                above.max(1).min(full)
            }
        }
    }
}

/// The median of descending numbers.
fn median(sorted: &[f64]) -> f64 {
    let half = sorted.len() / 2;
    if sorted.len() % 2 == 1 {
        sorted[half]
    } else {
        0.5 * (sorted[half - 1] + sorted[half])
    }
}

/// At least one state, and no name twice.
fn check_names(states: &[&str], inputs: &[&str]) -> Result<(), SindyError> {
    require(!states.is_empty(), "states", "at least one name", "none")?;
    let all: Vec<&str> = states.iter().chain(inputs).copied().collect();
    match all.iter().enumerate().find(|(i, n)| all[..*i].contains(n)) {
        Some((_, name)) => Err(SindyError::setting(
            "states and inputs",
            "each name once",
            name,
        )),
        None => Ok(()),
    }
}

/// As many finite values as there should be.
fn check_row(what: &'static str, values: &[f64], expected: usize) -> Result<(), SindyError> {
    same_size(what, expected, values.len())?;
    finite(what, values)
}

/// One column of at least `steps` finite values for each input.
fn check_inputs(inputs: &[&[f64]], expected: usize, steps: usize) -> Result<(), SindyError> {
    same_size("inputs", expected, inputs.len())?;
    for column in inputs {
        let Some(used) = column.get(..steps) else {
            return Err(SindyError::too_short(steps, column.len()));
        };
        check_row("values of an input", used, steps)?;
    }
    Ok(())
}

/// Runs `steps` steps; `next` takes the row `u[k]` and gives the states at k + 1.
fn run(
    start: &[f64],
    steps: usize,
    inputs: &[&[f64]],
    period: f64,
    mut next: impl FnMut(&[f64]) -> Vec<f64>,
) -> Run {
    let mut run = Run {
        time: vec![0.0],
        states: start.iter().map(|x| vec![*x]).collect(),
        outcome: RunOutcome::Finished,
        evaluations: 0,
        steps: 0,
    };
    for k in 0..steps {
        let row: Vec<f64> = inputs.iter().map(|c| c[k]).collect();
        let x = next(&row);
        run.evaluations += 1;
        run.steps += 1;
        let time = (k + 1) as f64 * period;
        // Written so that NaN counts as too large.
        if !x.iter().all(|x| x.abs() <= BLOW_UP) {
            run.outcome = RunOutcome::BlewUp { time };
            return run;
        }
        run.time.push(time);
        for (column, x) in run.states.iter_mut().zip(x) {
            column.push(x);
        }
    }
    run
}
