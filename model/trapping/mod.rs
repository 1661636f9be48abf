//! A ball that all trajectories of a quadratic model enter.
//!
//! Of `x' = d(u) + L x + Q(x, x)` let the quadratic part keep the energy `|x|²/2`: `x·Q(x, x) = 0` for all x. Then of the distance
//! `y = x - m` from a point m
//!
//! ```text
//! d/dt |y|²/2 = y·f(m, u) + yᵀ A_S(m) y,      A_S(m) = symmetric part of the Jacobian at m = L_S - (m·Q)_S
//! ```
//!
//! If all eigenvalues of `A_S(m)` are negative, `|y|` falls wherever it is large, so every trajectory ends in a ball about m. The
//! largest eigenvalue is a convex function of m ([`centre`]), and the least ball follows from the equation above ([`radius`]).
//!
//! Source: M. Schlegel, B. R. Noack, "On long-term boundedness of Galerkin models", J. Fluid Mech. 765 (2015).

pub(crate) mod centre;
pub(crate) mod form;
mod radius;

use nalgebra::{DMatrix, DVector};
use thiserror::Error;

use super::{Model, Time};
use crate::error::{SindyError, finite, same_size};
use centre::{AffineMatrix, largest_eigenvalue};
use form::QuadraticTerm;

/// A change of the energy by the quadratic part below this share of its terms is rounding: some hundred sums of 1e-16.
const KEPT: f64 = 1e-10;
/// A decay below this share of the linear part is none: eigenvalues of the minimum are right to 1e-9.
const NONE: f64 = 1e-8;

/// A ball that all trajectories enter and do not leave again.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct TrappingRegion {
    /// Its centre m, one value for each state.
    pub centre: Vec<f64>,
    /// Least rate at which a large distance from the centre decays: less the largest eigenvalue of `A_S(m)`.
    pub rate: f64,
    /// Its radius: outside it the distance from the centre falls.
    pub radius: f64,
}

/// Why a model has no trapping region that can be shown.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum NoTrappingRegion {
    /// The model gives the next sample.
    #[error("expected a model in continuous time, found one in discrete time")]
    Discrete,
    /// A term of another kind.
    #[error(
        "expected terms of degree 2 at most in the states, and functions of inputs alone; found `{term}` in the equation of {state}"
    )]
    Term {
        /// The state.
        state: String,
        /// The term.
        term: String,
    },
    /// The quadratic terms change the energy.
    #[error(
        "expected quadratic terms that keep the sum of squares of the states; they change it by {:.2} % of what they exchange", 100.0 * share
    )]
    Energy {
        /// The change as a share of what the terms exchange.
        share: f64,
    },
    /// No centre makes all eigenvalues negative.
    #[error(
        "expected a centre about which every distance decays; about the best one, a distance grows at the rate {rate:.3e}"
    )]
    Growth {
        /// The least largest eigenvalue of `A_S(m)`.
        rate: f64,
    },
    /// Inputs that do not fit the model.
    #[error(transparent)]
    Inputs(#[from] SindyError),
}

impl Model {
    /// The ball about the centre of fastest decay that all trajectories enter, for inputs among these rows (one column for each input).
    ///
    /// Of centres with the same rate the one nearest to the origin is taken. Other centres may have a smaller ball.
    ///
    /// ```
    /// let lorenz = sindy::problems::lorenz().model()?;
    /// let region = lorenz.trapping_region(&[])?;
    /// assert!((region.centre[2] - 38.0).abs() < 1e-3); // σ + ρ
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// Why there is none, or none that can be shown.
    pub fn trapping_region(&self, inputs: &[&[f64]]) -> Result<TrappingRegion, NoTrappingRegion> {
        self.trapping_region_from(inputs, &vec![0.0; self.states.len()])
    }

    /// The same, with the centre nearest to `start`.
    ///
    /// # Errors
    /// As [`Self::trapping_region`]; not one value for each state.
    pub fn trapping_region_from(
        &self,
        inputs: &[&[f64]],
        start: &[f64],
    ) -> Result<TrappingRegion, NoTrappingRegion> {
        let n = self.states.len();
        same_size("values of the start (one per state)", n, start.len())?;
        finite("start", start)?;
        same_size("columns of inputs", self.inputs.len(), inputs.len())?;
        for column in inputs {
            same_size("rows of an input", inputs[0].len(), column.len())?;
            finite("input", column)?;
        }
        let matrix = self.symmetric_part()?;
        let start = DVector::from_column_slice(start);
        let m = centre::of_fastest_decay(&matrix, &start);
        let at = matrix.at(&m);
        let rate = -largest_eigenvalue(&at);
        if !(rate > NONE * matrix.size()) {
            return Err(NoTrappingRegion::Growth { rate: -rate });
        }
        let slopes = self.slopes_at(&m, inputs);
        let radius = radius::least(&at, &slopes);
        let centre = m.as_slice().to_vec();
        Ok(TrappingRegion {
            centre,
            rate,
            radius,
        })
    }

    /// `A_S(m)`, if the quadratic part keeps the energy.
    fn symmetric_part(&self) -> Result<AffineMatrix, NoTrappingRegion> {
        if self.time != Time::Continuous {
            return Err(NoTrappingRegion::Discrete);
        }
        let n = self.states.len();
        let mut linear = DMatrix::zeros(n, n);
        let mut quadratic = vec![DMatrix::zeros(n, n); n];
        for (i, terms) in self.equations.iter().enumerate() {
            for term in terms {
                let form = QuadraticTerm::of(&term.expression, &self.states).ok_or_else(|| {
                    NoTrappingRegion::Term {
                        state: self.states[i].clone(),
                        term: term.expression.to_string(),
                    }
                })?;
                form.add_to(i, term.coefficient, &mut linear, &mut quadratic);
            }
        }
        let share = form::change_of_energy(&quadratic);
        match share > KEPT {
            true => Err(NoTrappingRegion::Energy { share }),
            false => Ok(AffineMatrix::new(&linear, &quadratic)),
        }
    }

    /// `f(m, u)` for every row of the inputs.
    fn slopes_at(&self, m: &DVector<f64>, inputs: &[&[f64]]) -> Vec<DVector<f64>> {
        let rows = inputs.first().map_or(1, |column| column.len());
        let mut work = self.compiled.workspace();
        let mut row = |r: usize| {
            let mut values = DVector::zeros(m.len());
            let own = inputs.iter().map(|column| column[r]);
            let row: Vec<f64> = m.iter().copied().chain(own).collect();
            self.compiled.row(&row, values.as_mut_slice(), &mut work);
            values
        };
        (0..rows).map(&mut row).collect()
    }
}
