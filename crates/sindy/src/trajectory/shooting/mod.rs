//! Refinement by multiple shooting: coefficients judged by prediction over time.
//!
//! A model with states `x`, inputs `u`, parameters `θ` and one measured output
//!
//! ```text
//! x' = f(x, u, θ),    y = g(x, u, θ)
//! ```
//!
//! is simulated over many short windows of the data, and
//!
//! ```text
//! Σ_windows Σ_k  w² ( y(t_k; θ, x₀) - y_k )²  +  prior on x₀  +  prior on θ
//! ```
//!
//! is minimised over θ and over every window's own start `x₀` by the Gauss–Newton method with
//! Levenberg's damping. Sensitivities are exact: they are integrated beside the states from the
//! expressions' derivatives. The starts are eliminated window by window (Schur complement), so the cost
//! is linear in the data.
//!
//! Unlike regression on derivatives, noise in the measured state does not bias the coefficients.
//!
//! Source: H. G. Bock, "Recent advances in parameter identification techniques for ODE" (1983).

mod model;
mod normal;
mod propagate;
mod settings;
mod solve;

pub use model::OdeModel;
pub use settings::{Parameter, Shooting};
pub use solve::{Outcome, Refined};

/// One trajectory of data, on one time grid.
#[derive(Clone, Debug)]
pub struct Record<'a> {
    /// Times, increasing.
    pub time: &'a [f64],
    /// One column per input of the model.
    pub inputs: Vec<&'a [f64]>,
    /// The measured output; a sample that is not finite is left out.
    pub measured: &'a [f64],
    /// For each state, a first guess at every sample; a window starts from the value at its first one.
    pub start: Vec<&'a [f64]>,
    /// The group for standard errors: records of one group may be correlated.
    pub group: usize,
}

#[cfg(test)]
mod tests;
