//! Dynamic mode decomposition with control.

use nalgebra::DVector;
use sindy_expr::Expr;

use super::snapshots::{Lift, Snapshots};
use super::{LinearSystem, Rank, Regression};
use super::{check_inputs, check_names, check_row, run};
use crate::data::samples::BlockSource;
use crate::error::{SindyError, above_zero};
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
/// assert!((model.system.a[(0, 0)] - 0.9).abs() < 1e-12 && (model.system.b[(0, 0)] - 0.5).abs() < 1e-12);
/// # Ok::<(), sindy::SindyError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dmdc {
    regression: Regression,
}

/// A linear system `x[k+1] = A x[k] + B u[k]` of the states.
#[derive(Clone, Debug, PartialEq)]
pub struct DmdcModel {
    /// A, B and the quality of their fit.
    pub system: LinearSystem,
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
        above_zero("period", period)?;
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
        let system = LinearSystem::fit(self.regression, &snapshots, period, false)?;
        Ok(DmdcModel { system })
    }
}

impl DmdcModel {
    /// The states one sample later.
    ///
    /// # Errors
    /// A wrong number of states or inputs, or values that are not finite (the prediction's included).
    pub fn predict(&self, x: &[f64], u: &[f64]) -> Result<Vec<f64>, SindyError> {
        check_row("states", x, self.system.a.nrows())?;
        check_row("inputs", u, self.system.b.ncols())?;
        let next = &self.system.a * DVector::from_row_slice(x)
            + &self.system.b * DVector::from_row_slice(u);
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
        check_row("states", start, self.system.a.nrows())?;
        check_inputs(inputs, self.system.b.ncols(), steps)?;
        let mut x = DVector::from_row_slice(start);
        Ok(run(start, steps, inputs, self.system.period, |u| {
            x = &self.system.a * &x + &self.system.b * DVector::from_row_slice(u);
            x.as_slice().to_vec()
        }))
    }
}
