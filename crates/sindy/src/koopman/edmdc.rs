//! Extended dynamic mode decomposition with control.

use nalgebra::{DMatrix, DVector};
use sindy_expr::{Expr, Program, Scratch};

use super::snapshots::{Lift, Snapshots};
use super::{LinearSystem, Rank, Regression};
use super::{check_inputs, check_names, check_row, run};
use crate::data::samples::BlockSource;
use crate::error::{SindyError, above_zero, require};
use crate::library::{Library, compile};
use crate::model::Run;

/// Settings of EDMDc, checked when built.
///
/// Terms of the library over states alone are the observables ψ(x), which the model predicts; terms in
/// which an input occurs are regressors φ(x, u) only (`u` for the linear form of Korda & Mezić, `x*u` for a
/// bilinear one). Columns are brought to unit length before the decomposition, so that rank and ridge do
/// not depend on the units of the terms.
///
/// ```
/// use sindy::koopman::{Edmdc, Lifting, Rank};
/// use sindy::{Library, Samples};
///
/// // x[k+1] = 0.9 x[k], y[k+1] = 0.5 y[k] + x[k]^2: linear once x^2 is an observable.
/// let (mut x, mut y) = (vec![1.0], vec![0.0]);
/// for k in 0..40 {
///     x.push(0.9 * x[k]);
///     y.push(0.5 * y[k] + x[k] * x[k]);
/// }
/// let mut samples = Samples::new(&["x", "y"]);
/// samples.push_group(vec![x, y])?;
///
/// let library = Library::parse(&["x", "y", "x^2"])?;
/// let model = Edmdc::new(library, Rank::Full, 0.0)?.fit(&samples, &["x", "y"], &[], 1.0)?;
/// let run = model.simulate(&[2.0, 1.0], 2, &[], Lifting::Once)?;
/// assert!((run.states[1][2] - (0.5 * 4.5 + 1.8 * 1.8)).abs() < 1e-9);
/// # Ok::<(), sindy::SindyError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Edmdc {
    library: Library,
    regression: Regression,
}

/// Where a run of an [`EdmdcModel`] lifts its states.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lifting {
    /// At the start only: a linear system from then on (what linear control uses). Regressors in which
    /// states and inputs meet take the states `C z`.
    Once,
    /// Before every step, from the projected states `x = C z`: a nonlinear map, mostly more accurate.
    EveryStep,
}

/// A linear system `z[k+1] = A z[k] + B v[k]` of the observables, with `x ≈ C z`.
#[derive(Clone, Debug)]
pub struct EdmdcModel {
    /// A, B and the quality of their fit.
    pub system: LinearSystem,
    c: DMatrix<f64>,
    inputs: usize,
    lifted: Program,
    drives: Program,
}

impl Edmdc {
    /// EDMDc with a library of observables and regressors, a rank and a ridge (as in
    /// [`super::Dmdc::new`]).
    ///
    /// # Errors
    /// A given rank of 0 or above the number of terms; a ridge that is negative or not finite.
    pub fn new(library: Library, rank: Rank, ridge: f64) -> Result<Self, SindyError> {
        let regression = Regression::new(rank, ridge)?;
        match rank {
            Rank::Given(rank) if rank > library.len() => {
                let expected = format!("at most the {} terms", library.len());
                Err(SindyError::setting("rank", expected, rank))
            }
            _ => Ok(Self {
                library,
                regression,
            }),
        }
    }

    /// Fits the columns `states` and `inputs`, sampled every `period`. C takes a state from the observable
    /// that is that state; a state that is not itself an observable is projected by least squares.
    ///
    /// # Errors
    /// No states, a name twice or without a column, a term with other names, no term over states alone, a
    /// period that is not positive, no pair of successive rows in which all terms are usable.
    pub fn fit(
        &self,
        source: &dyn BlockSource,
        states: &[&str],
        inputs: &[&str],
        period: f64,
    ) -> Result<EdmdcModel, SindyError> {
        above_zero("period", period)?;
        check_names(states, inputs)?;
        let (drives, lifted): (Vec<Expr>, Vec<Expr>) = self
            .library
            .terms()
            .iter()
            .cloned()
            .partition(|term| term.variables().iter().any(|v| inputs.contains(v)));
        require(
            !lifted.is_empty(),
            "library",
            "at least one term over states alone",
            "none",
        )?;
        let row: Vec<&str> = states.iter().chain(inputs).copied().collect();
        let lifted_program = compile(&lifted, states)?;
        let drives_program = compile(&drives, &row)?;

        let names: Vec<String> = states.iter().map(ToString::to_string).collect();
        let lift = Lift {
            states: &names,
            lifted: &lifted,
            drives: &drives,
        };
        let snapshots = Snapshots::accumulate(&lift, source)?;
        let system = LinearSystem::fit(self.regression, &snapshots, period, true)?;
        let (r, rhs) = snapshots.projection();
        let full = Regression::new(Rank::Full, 0.0)?;
        let mut c = full
            .solve(r, &rhs, snapshots.pairs, true)?
            .coefficients
            .transpose();
        for (i, state) in states.iter().enumerate() {
            let itself = Expr::variable(state);
            if let Some(j) = lifted.iter().position(|term| *term == itself) {
                c.row_mut(i).fill(0.0);
                c[(i, j)] = 1.0;
            }
        }
        Ok(EdmdcModel {
            system,
            c,
            inputs: inputs.len(),
            lifted: lifted_program,
            drives: drives_program,
        })
    }
}

impl EdmdcModel {
    /// C, states x observables.
    #[must_use]
    pub fn c(&self) -> &DMatrix<f64> {
        &self.c
    }

    /// The states one sample later: `C (A ψ(x) + B φ(x, u))`.
    ///
    /// # Errors
    /// A wrong number of states or inputs, values that are not finite, or states outside the domain of a
    /// term.
    pub fn predict(&self, x: &[f64], u: &[f64]) -> Result<Vec<f64>, SindyError> {
        check_row("states", x, self.c.nrows())?;
        check_row("inputs", u, self.inputs)?;
        let mut scratch = Scratch::default();
        let z = self.lift(x, &mut scratch);
        let next = &self.c * self.step(&z, x, u, &mut scratch);
        check_row("predicted states", next.as_slice(), next.len())?;
        Ok(next.as_slice().to_vec())
    }

    /// Runs `steps` steps from `start` at time 0; `inputs[j][k]` is input j at step k. A run that grows
    /// beyond 10¹⁵⁰ or leaves the domain of a term ends as [`crate::model::RunOutcome::BlewUp`].
    ///
    /// # Errors
    /// A wrong number of states or inputs, inputs shorter than `steps`, or values that are not finite.
    pub fn simulate(
        &self,
        start: &[f64],
        steps: usize,
        inputs: &[&[f64]],
        lifting: Lifting,
    ) -> Result<Run, SindyError> {
        check_row("states", start, self.c.nrows())?;
        check_inputs(inputs, self.inputs, steps)?;
        let mut scratch = Scratch::default();
        let mut x = start.to_vec();
        let mut z = self.lift(&x, &mut scratch);
        Ok(run(start, steps, inputs, self.system.period, |u| {
            z = self.step(&z, &x, u, &mut scratch);
            x = (&self.c * &z).as_slice().to_vec();
            if lifting == Lifting::EveryStep {
                z = self.lift(&x, &mut scratch);
            }
            x.clone()
        }))
    }

    fn lift(&self, x: &[f64], scratch: &mut Scratch) -> DVector<f64> {
        let mut z = DVector::zeros(self.system.a.nrows());
        self.lifted.eval_row(x, z.as_mut_slice(), scratch);
        z
    }

    fn step(&self, z: &DVector<f64>, x: &[f64], u: &[f64], scratch: &mut Scratch) -> DVector<f64> {
        let mut v = DVector::zeros(self.system.b.ncols());
        let row: Vec<f64> = x.iter().chain(u).copied().collect();
        self.drives.eval_row(&row, v.as_mut_slice(), scratch);
        &self.system.a * z + &self.system.b * v
    }
}
