//! Proof that every trajectory of a model stays bounded, for equations of degree 1 or 2 in the states.
//!
//! With `x' = c(u) + L x + Q(x, x)` and a quadratic part that keeps the energy, `x · Q(x, x) = 0`, the distance from any m obeys
//!
//! ```text
//! d/dt |x - m|²/2 = (x - m)ᵀ A_S(m) (x - m) + d · (x - m),     d = x'(m),     A_S the symmetric part of the Jacobian at m
//! ```
//!
//! If `A_S(m)` is negative definite with largest eigenvalue -r, the distance falls wherever it is above `|d| / r`.
//!
//! Sources: M. Schlegel, B. R. Noack, "On long-term boundedness of Galerkin models", J. Fluid Mech. 765 (2015); A. A. Kaptanoglu et al.,
//! "Promoting global stability in data-driven models of quadratic nonlinear dynamics", Phys. Rev. Fluids 6 (2021).

pub(crate) mod centre;
pub(crate) mod form;
#[cfg(test)]
mod tests;

use std::fmt;

use nalgebra::DVector;
use serde::Serialize;

use super::{Model, Time};
use crate::error::{SindyError, finite, same_size};
use centre::centre;
use form::{QuadraticForm, TermForm};

/// A ball that every trajectory enters and does not leave.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TrappingRegion {
    /// Its centre m.
    pub centre: Vec<f64>,
    /// Its radius, for the inputs that were given; trajectories reach every larger ball in a finite time.
    pub radius: f64,
    /// The rate at which distances from the centre decay far away, `-λ_max(A_S(m))`, above 0.
    pub rate: f64,
}

/// Why every trajectory stays bounded.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum StabilityCertificate {
    /// Linear in the states, and all eigenvalues decay.
    Linear {
        /// The largest real part of the eigenvalues, below 0.
        largest_real_part: f64,
    },
    /// Of degree 2 in the states, with a trapping region.
    Trapping(TrappingRegion),
}

impl fmt::Display for StabilityCertificate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Linear { largest_real_part } => {
                write!(
                    f,
                    "all eigenvalues decay: the largest real part is {largest_real_part:.5}"
                )
            }
            Self::Trapping(region) => {
                let centre: Vec<String> = region.centre.iter().map(|m| format!("{m:.5}")).collect();
                write!(
                    f,
                    "every trajectory ends in the ball of radius {:.5} about ({}); distances decay at the rate {:.5}",
                    region.radius,
                    centre.join(", "),
                    region.rate
                )
            }
        }
    }
}

/// Why there is no certificate. That a trajectory leaves all bounds does not follow, except for linear equations.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum NoCertificate {
    /// Discrete time.
    Discrete,
    /// This term is not of degree 2 or less in the states, or it has states and inputs together.
    Term(String),
    /// An eigenvalue of the linear equations does not decay: the largest real part.
    Growing(f64),
    /// The quadratic part changes the energy by this share of its largest coefficient.
    Energy(f64),
    /// No `A_S(m)` is negative definite: the least of the largest eigenvalues.
    NotDefinite(f64),
}

impl fmt::Display for NoCertificate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Discrete => write!(f, "expected continuous time, found discrete time"),
            Self::Term(term) => write!(
                f,
                "expected terms of degree 1 or 2 in the states, or of inputs alone, found `{term}`"
            ),
            Self::Growing(part) => write!(
                f,
                "expected eigenvalues with negative real parts, found one with {part:.5}"
            ),
            Self::Energy(share) => write!(
                f,
                "expected quadratic terms that keep the energy |x|²/2, found terms that change it by {share:.2e} of the largest \
                 coefficient"
            ),
            Self::NotDefinite(value) => write!(
                f,
                "expected a centre about which the energy decays, found none: the least eigenvalue is {value:.5}"
            ),
        }
    }
}

impl Model {
    /// Why every trajectory stays bounded, or why that is not known. `near` is where the search for a centre starts, such as the mean of
    /// the data; the result depends on it where several centres are equally good. `inputs` holds rows of input values for
    /// which the radius holds; inputs are zero if it is empty.
    ///
    /// ```
    /// use sindy::model::StabilityCertificate;
    ///
    /// let lorenz = sindy::problems::lorenz().model()?;
    /// let found = lorenz.stability_certificate(&[0.0, 0.0, 25.0], &[])?;
    /// let Ok(StabilityCertificate::Trapping(region)) = found else { panic!() };
    /// assert!((region.rate - 1.0).abs() < 1e-4); // 1 is the rate of y
    /// assert!((region.centre[2] - 38.0).abs() < 0.1); // σ + ρ
    /// # Ok::<(), sindy::SindyError>(())
    /// ```
    ///
    /// # Errors
    /// Not one finite value for each state or input.
    pub fn stability_certificate(
        &self,
        near: &[f64],
        inputs: &[Vec<f64>],
    ) -> Result<Result<StabilityCertificate, NoCertificate>, SindyError> {
        same_size(
            "values of `near` (one per state)",
            self.states.len(),
            near.len(),
        )?;
        finite("near", near)?;
        for row in inputs {
            same_size("input values", self.inputs.len(), row.len())?;
            finite("inputs", row)?;
        }
        Ok(self.certificate(near, inputs))
    }

    fn certificate(
        &self,
        near: &[f64],
        inputs: &[Vec<f64>],
    ) -> Result<StabilityCertificate, NoCertificate> {
        if self.time != Time::Continuous {
            return Err(NoCertificate::Discrete);
        }
        let mut form = QuadraticForm::zeros(self.states.len());
        for (i, equation) in self.equations.iter().enumerate() {
            for term in equation {
                let own = TermForm::of(&term.expression, &self.states);
                let own = own.ok_or_else(|| NoCertificate::Term(term.expression.to_string()))?;
                form.add(i, &own, term.coefficient);
            }
        }
        if !form.is_quadratic() {
            let largest_real_part = form.growth();
            return match largest_real_part < 0.0 {
                true => Ok(StabilityCertificate::Linear { largest_real_part }),
                false => Err(NoCertificate::Growing(largest_real_part)),
            };
        }
        if !form.keeps_energy() {
            return Err(NoCertificate::Energy(form.energy_change()));
        }
        let (centre, value) = centre(&form, &DVector::from_column_slice(near));
        if value >= 0.0 {
            return Err(NoCertificate::NotDefinite(value));
        }
        let rate = -value;
        Ok(StabilityCertificate::Trapping(TrappingRegion {
            radius: self.largest_slope(&centre, inputs) / rate,
            centre: centre.iter().copied().collect(),
            rate,
        }))
    }

    /// The largest `|x'|` at a state over rows of inputs.
    fn largest_slope(&self, state: &DVector<f64>, inputs: &[Vec<f64>]) -> f64 {
        let zero = [vec![0.0; self.inputs.len()]];
        let rows = match inputs.is_empty() {
            true => &zero,
            false => inputs,
        };
        let mut slopes = vec![0.0; self.states.len()];
        let mut workspace = self.compiled.workspace();
        let norm = |row: &Vec<f64>| {
            let row = [state.as_slice(), row].concat();
            self.compiled.row(&row, &mut slopes, &mut workspace);
            slopes.iter().map(|v| v * v).sum::<f64>().sqrt()
        };
        rows.iter().map(norm).fold(0.0, f64::max)
    }
}
