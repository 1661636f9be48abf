//! The weak form: regression without derivatives.
//!
//! `dx/dt = Σ_j ξ_j θ_j(x, u)` times a test function `φ_k` that vanishes at both ends of its support,
//! integrated by parts, is a linear system for `ξ` in which no derivative of the data occurs:
//!
//! ```text
//! -∫ φ_k' x dt = Σ_j ξ_j ∫ φ_k θ_j(x, u) dt,      φ_k(t) = (1 - ((t - c_k)/H)²)^p  for |t - c_k| < H
//! ```
//!
//! Noise is averaged instead of differentiated. [`WeakForm`] turns samples (time, states, inputs, in groups) into [`Gram`](crate::Gram) statistics of that system, one row for
//! each window `k`, for every solver of this crate. Inputs and time itself may occur in the terms.
//!
//! **Integrals** are sums over the samples on any increasing grid, with weights that are the trapezoid's
//! where the grid is uniform (there the error falls with the power `p` of the test function) and of order
//! 4 elsewhere. Windows lie inside stretches without gaps (NaN in a column that is used, or a step above 3
//! median periods) and have centres on samples.
//!
//! **Covariance.** Noise `σ` that is independent from sample to sample gives the left sides the covariance
//! `σ² C`, `C_kl = Σ_i w_i² φ_k'(t_i) φ_l'(t_i)`, banded since only windows that overlap share samples.
//! Ordinary least squares (the default) divides each row by `∫ φ_k dt`: rows in the unit of the *slope*,
//! correlated. Generalised least squares multiplies the rows of each stretch by the inverse Cholesky factor
//! of `C` instead, with 10⁻⁴ of the diagonal added to it: rows nearly independent, in the *state's* unit,
//! so that criteria that count rows hold. Which is better depends on the noise that passes through the terms,
//! which is not in `C`: whitening gives weight back to high frequencies, where that noise biases the
//! coefficients. With 5 % of noise and the true terms, generalised least squares has a third less error than
//! ordinary for Lotka–Volterra, and three to five times more for Van der Pol and Lorenz. Terms of degree
//! 2 and more keep a bias of about `σ²` over the square of the signal in both, as in every regression on
//! noisy terms.
//!
//! Error of the coefficients of the true terms, relative 2-norm, median of 5 seeds, with the defaults here
//! and with [`choose_savgol`](crate::derivative::choose_savgol) and regression of the slopes:
//!
//! | problem | noise | weak form | Savitzky–Golay |
//! | --- | --- | --- | --- |
//! | Lorenz | 1 % | 7.0e-4 | 2.0e-3 |
//! | Lorenz | 5 % | 2.9e-3 | 9.4e-3 |
//! | Van der Pol | 1 % | 7.0e-4 | 8.5e-4 |
//! | Van der Pol | 5 % | 4.6e-3 | 3.7e-3 |
//!
//! The best subsets of the right sizes are the true terms in all these runs. Van der Pol at 5 % shows the bias
//! of noise in a cubic term, which smoothing before the terms are formed takes away.
//!
//! **Half-width.** Wider windows average more noise, but windows wider than the signal's fastest parts make
//! terms confounded. If it is not set, [`choose_half_width`] takes, per state and stretch, the frequency
//! `ω_c` at which cutting off the spectrum gives the least estimated error of the slope (Mallows's
//! criterion: energy `ω² (|X|² - N)` that is cut off against noise `ω² N` that passes, `N` from
//! [`noise_level`](crate::derivative::noise_level)), and the `H` at which averaging with `φ` leaves a tenth of
//! the amplitude at `ω_c`; at least 20 steps, at most a quarter of the stretch. The median over states and
//! stretches is used, one `H` for the whole system.
//!
//! ```
//! use sindy::{Library, Samples, Solver, Stlsq, WeakForm};
//!
//! // x' = u - 2 x with u = sin 3t, noise of alternating sign on x.
//! let time: Vec<f64> = (0..800).map(|i| 0.01 * f64::from(i)).collect();
//! let u = time.iter().map(|t| (3.0 * t).sin()).collect();
//! let x = time.iter().enumerate().map(|(i, t)| {
//!     (2.0 * (3.0 * t).sin() - 3.0 * (3.0 * t).cos()) / 13.0 + (-2.0 * t).exp() + [0.01, -0.01][i % 2]
//! }).collect();
//! let mut samples = Samples::new(&["t", "x", "u"]);
//! samples.push_group(vec![time, x, u])?;
//!
//! let library = Library::parse(&["1", "x", "u", "x^2", "x*u"])?;
//! let weak = WeakForm::default().system(&library, "t", &["x"], &samples)?;
//! let fit = Stlsq::new(0.1, 0.0)?.fit(&weak.total(0))?;
//! assert_eq!(fit.support, [false, true, true, false, false]);
//! assert!((fit.coefficients[1] + 2.0).abs() < 0.01 && (fit.coefficients[2] - 1.0).abs() < 0.01);
//! # Ok::<(), sindy::SindyError>(())
//! ```
//!
//! Sources: D. A. Messenger, D. M. Bortz, "Weak SINDy: Galerkin-based data-driven model selection",
//! Multiscale Modeling & Simulation 19 (2021); H. Schaeffer, S. G. McCalla, "Sparse model selection via
//! integral terms", Physical Review E 96 (2017); C. L. Mallows, "Some comments on C_p", Technometrics 15
//! (1973).

mod system;
#[cfg(test)]
mod tests;
mod whiten;
mod width;
mod window;

pub use system::WeakSystem;
pub use width::choose_half_width;
pub(crate) use width::half_width_of;
pub(crate) use window::place;

use crate::data::samples::Samples;
use crate::error::{SindyError, require};
use crate::library::Library;

/// Settings of the weak form, checked when built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WeakForm {
    half_width: Option<f64>,
    spacing: f64,
    power: u32,
    generalised: bool,
}

impl Default for WeakForm {
    /// Half-width from the data, centres an eighth of it apart, power 8, ordinary least squares.
    fn default() -> Self {
        Self {
            half_width: None,
            spacing: 0.125,
            power: 8,
            generalised: false,
        }
    }
}

impl WeakForm {
    /// The same with windows of a given half-width `H`, in the unit of time of the data.
    ///
    /// # Errors
    /// A half-width that is not positive and finite.
    pub fn half_width(self, half_width: f64) -> Result<Self, SindyError> {
        require(
            half_width > 0.0 && half_width.is_finite(),
            "half_width",
            "positive and finite",
            half_width,
        )?;
        Ok(Self {
            half_width: Some(half_width),
            ..self
        })
    }

    /// The same with window centres at least `spacing` half-widths apart (and never closer than samples).
    ///
    /// # Errors
    /// A spacing outside 0.02 to 2 (windows that only touch).
    pub fn spacing(self, spacing: f64) -> Result<Self, SindyError> {
        if !(0.02..=2.0).contains(&spacing) {
            return Err(SindyError::setting(
                "spacing",
                "0.02 to 2 half-widths",
                spacing,
            ));
        }
        Ok(Self { spacing, ..self })
    }

    /// The same with the power `p` of the test functions.
    ///
    /// # Errors
    /// A power outside 2 to 32.
    pub fn power(self, power: u32) -> Result<Self, SindyError> {
        if !(2..=32).contains(&power) {
            return Err(SindyError::setting("power", "2 to 32", power));
        }
        Ok(Self { power, ..self })
    }

    /// The same with generalised (`true`) or ordinary least squares.
    #[must_use]
    pub fn generalised(self, generalised: bool) -> Self {
        Self {
            generalised,
            ..self
        }
    }

    /// The weak system of `library` for each of `states`, with `time` the name of the time column.
    ///
    /// One pass over the samples evaluates the terms, 256 rows at a time; what is kept are the sums of the
    /// windows, p + states numbers each.
    ///
    /// # Errors
    /// No states, names without a column, times that do not increase or columns in use with infinite values,
    /// and [`SindyError::TooShort`] if no stretch holds a window.
    pub fn system(
        &self,
        library: &Library,
        time: &str,
        states: &[&str],
        samples: &Samples,
    ) -> Result<WeakSystem, SindyError> {
        system::build(self, library, time, states, samples)
    }
}
