//! The regularised horseshoe prior.

use crate::error::{SindyError, above_zero};

/// The regularised horseshoe prior of coefficients β_j and of the noise σ:
///
/// ```text
/// β_j ~ N(0, τ² l_j²),   l_j² = c² λ_j²/(c² + τ² λ_j²),   λ_j ~ C⁺(0, 1),   τ ~ C⁺(0, τ₀)
/// c² ~ InverseGamma(ν/2, ν s²/2),   σ ~ Exponential(rate)
/// ```
///
/// Small coefficients are drawn to zero by τ, which all share; the heavy tails of λ_j let single ones escape. Those that do have
/// Student's t distribution with ν degrees of freedom and scale s, the slab. With p₀ of p terms expected in the equation,
/// n rows and columns of unit root mean square, a τ₀ near `p₀/(p - p₀) σ/√n` expects as many.
///
/// | setting | default | meaning |
/// | --- | --- | --- |
/// | `global_scale` | 0.1 | τ₀, the median of τ |
/// | `slab_degrees` | 4 | ν |
/// | `slab_scale` | 2 | s, in the unit of a coefficient |
/// | `noise_rate` | 1 | rate of σ, whose mean is 1/rate, in the unit of the target |
///
/// The defaults are those of PySINDy's `SBR`.
///
/// Sources: J. Piironen, A. Vehtari, "Sparsity information and regularization in the horseshoe and other shrinkage priors",
/// Electronic Journal of Statistics 11 (2017); S. M. Hirsh, D. A. Barajas-Solano, J. N. Kutz, "Sparsifying priors for Bayesian
/// uncertainty quantification in model discovery", Royal Society Open Science 9 (2022).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prior {
    global_scale: f64,
    slab_degrees: f64,
    slab_scale: f64,
    noise_rate: f64,
}

impl Default for Prior {
    fn default() -> Self {
        Self {
            global_scale: 0.1,
            slab_degrees: 4.0,
            slab_scale: 2.0,
            noise_rate: 1.0,
        }
    }
}

impl Prior {
    /// A prior with τ₀, ν, s and the rate of σ.
    ///
    /// # Errors
    /// One of them not finite and above 0.
    pub fn new(
        global_scale: f64,
        slab_degrees: f64,
        slab_scale: f64,
        noise_rate: f64,
    ) -> Result<Self, SindyError> {
        Ok(Self {
            global_scale: above_zero("global_scale", global_scale)?,
            slab_degrees: above_zero("slab_degrees", slab_degrees)?,
            slab_scale: above_zero("slab_scale", slab_scale)?,
            noise_rate: above_zero("noise_rate", noise_rate)?,
        })
    }

    /// τ₀.
    pub(super) fn global_scale(&self) -> f64 {
        self.global_scale
    }

    /// Shape ν/2 and rate ν s²/2 of 1/c², which has a gamma distribution.
    pub(super) fn slab_shape_and_rate(&self) -> (f64, f64) {
        let shape = 0.5 * self.slab_degrees;
        (shape, shape * self.slab_scale.powi(2))
    }

    /// The rate of σ.
    pub(super) fn noise_rate(&self) -> f64 {
        self.noise_rate
    }
}
