//! Partial differential equations from fields on a grid.
//!
//! `u_t = Σ_j ξ_j ∂^α_j (u^a v^b ...)` times a test function `φ` that vanishes at the edge of a box of time and space,
//! integrated by parts, is a linear system for `ξ` in which no derivative of the data occurs:
//!
//! ```text
//! -∫ φ_t u = Σ_j ξ_j (-1)^|α_j| ∫ (∂^α_j φ) u^a v^b ...,     φ = Π_axes (1 - ξ²)^8
//! ```
//!
//! One row for each box. **Windows**: along each axis the half-width at which the test function leaves a tenth of the
//! amplitude at the frequency beyond which the spectrum is noise (the rule of the [weak form](crate::weak)), a quarter of it apart.
//!
//! **Noise.** Its level comes from differences ([`noise_level`](crate::derivative::noise_level)). Differences along one axis also tell
//! how much of the noise samples share that are neighbours along another, and by how much outliers raise its variance. Products are
//! formed without bias (`u² - σ²`, `u³ - 3 σ² u`), and the covariance of the noise in terms and left side is taken from the normal
//! equations, so that coefficients of the true terms have no bias by noise that is white along one axis at least. Standard errors
//! follow from the noise in every sample and grow with the misfit. Where the residual is larger than the noise explains, they are at
//! least those that the scatter of scores between distant parts of the grid gives, which holds for noise of other kinds too.
//!
//! **Terms.** The best subset by the Bayesian criterion over independent windows; then terms that are more likely absent
//! than not leave one by one, each time with a new fit. Terms below the noise cannot be found: warnings tell which of them
//! could contribute more than a tenth, which models are about as likely, and where a wave that travels without a change of
//! shape is all that there is. Single missing samples are filled from their neighbours.
//!
//! **Valid** for grids with even steps, noise that is alike everywhere and white along one axis at least, coefficients that do not
//! depend on place or time. Terms are derivatives of products: `u u_x` is `0.5 (u^2)_x`. Those that are no such derivative, as
//! `u u_xx`, cannot be integrated by parts and are not among the candidates.
//!
//! ```
//! use sindy::pde::{Axis, FieldData, FieldLibrary, IdentifyField};
//!
//! // u_t = 0.1 u_xx: two modes that decay.
//! let (t, x) = (Axis::even("t", 0.05, 60)?, Axis::even("x", 0.1, 80)?);
//! let u = (0..60 * 80).map(|i| {
//!     let (t, x) = (0.05 * f64::from(i / 80), 0.1 * f64::from(i % 80));
//!     (-0.1 * t).exp() * x.sin() + (-0.4 * t).exp() * (2.0 * x).cos()
//! }).collect();
//! let data = FieldData::new(vec![t, x], vec![("u".to_owned(), u)])?;
//! let library = FieldLibrary::polynomial(&["u"], 2, &["x"], 3)?;
//! let found = IdentifyField::new(library).run(&[data])?;
//! assert_eq!(format!("{:.3}", found.equations[0]), "u_t = 0.100*u_xx");
//! # Ok::<(), sindy::SindyError>(())
//! ```
//!
//! Sources: D. A. Messenger, D. M. Bortz, "Weak SINDy for partial differential equations", Journal of Computational Physics
//! 443 (2021); S. H. Rudy, S. L. Brunton, J. L. Proctor, J. N. Kutz, "Data-driven discovery of partial differential equations",
//! Science Advances 3 (2017); W. A. Fuller, "Measurement Error Models" (1987), for the correction.

mod alternatives;
mod blocks;
mod bridge;
mod colour;
mod data;
mod doubts;
mod fit;
mod identify;
mod model;
mod moments;
mod system;
mod term;
#[cfg(test)]
mod tests;
mod window;

pub use data::{Axis, FieldData};
pub use identify::{FieldIdentification, FieldQuality, IdentifyField};
pub use model::{FieldEquation, FoundTerm};
pub use term::{FieldLibrary, FieldTerm};
