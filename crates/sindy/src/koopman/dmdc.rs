//! Dynamic mode decomposition with control.

use nalgebra::{Complex, DMatrix, DVector};
use sindy_expr::Expr;

use super::snapshots::{Lift, Snapshots};
use super::{
    Rank, Regression, check_inputs, check_period, check_row, continuous, eigenvalues, run,
};
use crate::data::samples::BlockSource;
use crate::error::SindyError;
use crate::model::Run;

/// Settings of DMDc, checked when built. With unscaled columns, as usual: bring states of very different
/// units to one size before a rank below the full one.
///
/// ```
/// use sindy::Samples;
/// use sindy::koopman::{Dmdc, Rank};
///
/// // x[k+1] = 0.9 x[k] + 0.5 u[k]
/// let u: Vec<f64> = (0..50).map(|k| (0.7 * f64::from(k)).sin()).collect();
/// let mut x = vec![1.0];
/// u.iter().for_each(|u| x.push(0.9 * x[x.len() - 1] + 0.5 * u));
/// x.pop();
/// let mut samples = Samples::new(&["x", "u"]);
/// samples.push_group(vec![x, u])?;
///
/// let model = Dmdc::new(Rank::Full, 0.0)?.fit(&samples, &["x"], &["u"], 0.1)?;
/// assert!((model.a()[(0, 0)] - 0.9).abs() < 1e-12 && (model.b()[(0, 0)] - 0.5).abs() < 1e-12);
/// # Ok::<(), sindy::SindyError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dmdc {
    regression: Regression,
}

/// A linear system `x[k+1] = A x[k] + B u[k]`.
#[derive(Clone, Debug, PartialEq)]
pub struct DmdcModel {
    period: f64,
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    singular_values: Vec<f64>,
    rank: usize,
    residual_rms: Vec<f64>,
    pairs: usize,
    skipped: usize,
}

impl Dmdc {
    /// DMDc of a rank, with a ridge α: each kept singular value σ is inverted as `σ / (σ² + α σ₁²)`, so
    /// that α (0 for none) is free of units and of the number of rows.
    ///
    /// # Errors
    /// A given rank of 0; α negative or not finite.
    pub fn new(rank: Rank, ridge: f64) -> Result<Self, SindyError> {
        let regression = Regression::new(rank, ridge)?;
        Ok(Self { regression })
    }

    /// Fits the columns `states` and `inputs` (none for plain DMD), sampled every `period`.
    ///
    /// # Errors
    /// No states, a name twice or without a column, a period that is not positive, no pair of successive
    /// usable rows, a given rank above the number of states and inputs.
    pub fn fit(
        &self,
        source: &dyn BlockSource,
        states: &[&str],
        inputs: &[&str],
        period: f64,
    ) -> Result<DmdcModel, SindyError> {
        check_period(period)?;
        check_names(states, inputs)?;
        let names: Vec<String> = states.iter().map(ToString::to_string).collect();
        let variables =
            |names: &[&str]| -> Vec<Expr> { names.iter().map(|n| Expr::variable(n)).collect() };
        let lift = Lift {
            states: &names,
            lifted: &variables(states),
            drives: &variables(inputs),
        };
        let snapshots = Snapshots::accumulate(&lift, source)?;
        let (r, rhs) = snapshots.step();
        let solved = self.regression.solve(r, &rhs, snapshots.pairs, false)?;
        let k = solved.coefficients.transpose();
        Ok(DmdcModel {
            period,
            a: k.columns(0, states.len()).into_owned(),
            b: k.columns(states.len(), inputs.len()).into_owned(),
            singular_values: solved.singular_values,
            rank: solved.rank,
            residual_rms: snapshots.residual_rms(&solved.coefficients),
            pairs: snapshots.pairs,
            skipped: snapshots.skipped,
        })
    }
}

/// At least one state, and no name twice.
pub(super) fn check_names(states: &[&str], inputs: &[&str]) -> Result<(), SindyError> {
    if states.is_empty() {
        return Err(SindyError::setting("states", "at least one name", "none"));
    }
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

impl DmdcModel {
    /// A, states x states.
    #[must_use]
    pub fn a(&self) -> &DMatrix<f64> {
        &self.a
    }

    /// B, states x inputs.
    #[must_use]
    pub fn b(&self) -> &DMatrix<f64> {
        &self.b
    }

    /// Singular values of the snapshots `[x; u]`, descending.
    #[must_use]
    pub fn singular_values(&self) -> &[f64] {
        &self.singular_values
    }

    /// How many of them were kept.
    #[must_use]
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// Root mean square of the one-step residual of each state, in its unit.
    #[must_use]
    pub fn residual_rms(&self) -> &[f64] {
        &self.residual_rms
    }

    /// Pairs of rows that were used.
    #[must_use]
    pub fn pairs(&self) -> usize {
        self.pairs
    }

    /// Rows that begin no pair because a state or an input is not usable.
    #[must_use]
    pub fn skipped(&self) -> usize {
        self.skipped
    }

    /// Eigenvalues λ of A, largest magnitude first.
    ///
    /// # Errors
    /// [`SindyError::Singular`] if their iteration does not converge.
    pub fn eigenvalues(&self) -> Result<Vec<Complex<f64>>, SindyError> {
        eigenvalues(&self.a)
    }

    /// Continuous-time eigenvalues `ln(λ) / period`, in the order of [`DmdcModel::eigenvalues`], per unit
    /// of time. Frequencies above half the sampling rate appear as lower ones; λ = 0 gives -∞.
    ///
    /// # Errors
    /// Those of [`DmdcModel::eigenvalues`].
    pub fn continuous_eigenvalues(&self) -> Result<Vec<Complex<f64>>, SindyError> {
        Ok(continuous(&self.eigenvalues()?, self.period))
    }

    /// The states one sample later.
    ///
    /// # Errors
    /// A wrong number of states or inputs, or values that are not finite (the prediction's included).
    pub fn predict(&self, x: &[f64], u: &[f64]) -> Result<Vec<f64>, SindyError> {
        check_row("states", x, self.a.nrows())?;
        check_row("inputs", u, self.b.ncols())?;
        let next = &self.a * DVector::from_row_slice(x) + &self.b * DVector::from_row_slice(u);
        check_row("predicted states", next.as_slice(), next.len())?;
        Ok(next.as_slice().to_vec())
    }

    /// Runs `steps` steps from `start` at time 0; `inputs[j][k]` is input j at step k. A run that grows
    /// beyond 10¹⁵⁰ ends as [`crate::model::RunOutcome::BlewUp`].
    ///
    /// # Errors
    /// A wrong number of states or inputs, inputs shorter than `steps`, or values that are not finite.
    pub fn simulate(
        &self,
        start: &[f64],
        steps: usize,
        inputs: &[&[f64]],
    ) -> Result<Run, SindyError> {
        check_row("states", start, self.a.nrows())?;
        check_inputs(inputs, self.b.ncols(), steps)?;
        let mut x = DVector::from_row_slice(start);
        Ok(run(start, steps, inputs, self.period, |u| {
            x = &self.a * &x + &self.b * DVector::from_row_slice(u);
            x.as_slice().to_vec()
        }))
    }
}
