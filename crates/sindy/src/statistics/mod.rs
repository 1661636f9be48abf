//! Statistics of a library and a target: what every regression reads in place of the data.
//!
//! | module | what it holds |
//! | --- | --- |
//! | [`gram`] | sufficient statistics: accumulate, merge, downdate |
//! | [`tsqr`] | a mergeable triangular factor, for libraries too ill-conditioned for the Gram matrix |
//! | [`regression`] | least squares and its standard errors |
//! | [`residual`] | residuals of a fit, row by row |
//! | [`criteria`] | AIC, AICc, BIC and Bayesian evidence |

pub mod criteria;
pub mod gram;
pub(crate) mod lanes;
pub(crate) mod normal;
pub mod regression;
pub mod residual;
pub mod tsqr;

pub use criteria::Criterion;
pub use gram::Gram;
