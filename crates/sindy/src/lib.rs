//! Sparse identification of nonlinear dynamics.
//!
//! Given samples of a system, find a differential equation `dx/dt = Θ(x, u) ξ` with few terms: build a
//! [`Library`] of candidate terms from text, [`SavitzkyGolay`] derivatives, accumulate the
//! [`Gram`] statistics block by block (`Θ` is never stored), and solve with [`Sr3`]. Before
//! trusting a fit, ask [`identifiability`] what the data can carry; after it, let [`shooting`] refine the
//! coefficients for what the model is for: prediction over time.
//!
//! ```
//! use sindy::{Gram, Library, Samples, SavitzkyGolay, Sr3};
//!
//! // dx/dt = -2 x, sampled at 100 Hz.
//! let time: Vec<f64> = (0..200).map(|i| 0.01 * f64::from(i)).collect();
//! let x: Vec<f64> = time.iter().map(|t| (-2.0 * t).exp()).collect();
//! let smooth = SavitzkyGolay::new(11, 3)?.apply(&time, &x)?;
//!
//! let mut samples = Samples::new(&["x", "x_dot"]);
//! samples.push_group(vec![smooth.value, smooth.derivative])?;
//! let library = Library::parse(&["1", "x", "x^2", "x^3"])?;
//! let gram = Gram::total(&Gram::accumulate(&library, "x_dot", &samples)?);
//!
//! let solution = Sr3::new(1e-4, 1.0)?.solve(&gram);
//! assert_eq!(solution.support, [false, true, false, false]);
//! assert!((solution.refit[1] + 2.0).abs() < 1e-4);
//! # Ok::<(), sindy::SindyError>(())
//! ```
//!
//! | module | what it is |
//! | --- | --- |
//! | [`dataset`] | trajectories of states and inputs, split at gaps, counted |
//! | [`samples`] | named columns in groups, handed on in blocks |
//! | [`stream`] | samples from an iterator of blocks, in one pass |
//! | [`library`] | candidate terms: polynomials, Fourier, products, sums, texts |
//! | [`shift`] | past states as columns, and the next sample for discrete time |
//! | [`savgol`] | Savitzky–Golay smoothing and derivative |
//! | [`gram`] | sufficient statistics: accumulate, merge, downdate |
//! | [`tsqr`] | a mergeable triangular factor for libraries that the Gram matrix loses |
//! | [`regression`] | least squares and its standard errors |
//! | [`residual`] | residuals of a fit, row by row |
//! | [`sr3`] | SR3 with ℓ0, solved at its fixed point |
//! | [`outcome`] | why a solver stopped, one type for all |
//! | [`fit`] | what every sparse solver takes and returns |
//! | [`criteria`] | AIC, AICc, BIC and Bayesian evidence |
//! | [`stlsq`] | sequentially thresholded least squares |
//! | [`stepwise`] | one term more or less at a time, by a criterion |
//! | [`exact`] | the best subset of every size, proven |
//! | [`ensemble`] | bagging of data and library, inclusion and intervals |
//! | [`uncertainty`] | block-bootstrap intervals, bands of predictions and simulations |
//! | [`relaxed`] | SR3 with ℓ1, weights, linear constraints; trimming |
//! | [`choose`] | λ and ν by cross-validation over groups |
//! | [`select`] | one fit of a family, by left-out error or a criterion; folds |
//! | [`identifiability`] | what the data can and cannot tell apart |
//! | [`derivative`] | derivatives: differences, splines, Kalman, spectral; noise level, gaps, the smoothing chosen |
//! | [`weak`] | the weak form: regression without derivatives, generalised least squares |
//! | [`delay`] | the delay between two channels |
//! | [`shooting`] | refinement by multiple shooting |
//! | [`koopman`] | linear comparators: DMDc and EDMDc |
//! | [`model`] | models: predict, simulate, Jacobian, equilibria, print, JSON |
//! | [`problems`] | problems with known answers |

pub mod choose;
pub mod criteria;
pub mod dataset;
pub mod delay;
pub mod derivative;
pub mod ensemble;
mod error;
pub mod exact;
pub mod fit;
pub mod gram;
pub mod identifiability;
pub mod identify;
pub mod koopman;
pub mod library;
pub mod model;
mod normal;
pub mod outcome;
pub mod output_error;
pub mod problems;
pub mod regression;
pub mod relaxed;
pub mod residual;
pub mod samples;
pub mod savgol;
pub mod select;
pub mod shift;
pub mod shooting;
pub mod sr3;
pub mod stepwise;
pub mod stlsq;
pub mod stream;
pub mod tsqr;
pub mod uncertainty;
pub mod weak;

pub use choose::{Choice, Grid};
pub use criteria::Criterion;
pub use dataset::Dataset;
pub use derivative::Differentiator;
pub use ensemble::Ensemble;
pub use error::SindyError;
pub use exact::BestSubset;
pub use fit::{Fit, Solver};
pub use gram::Gram;
pub use identify::{Identification, Identify};
pub use koopman::{Dmdc, Edmdc};
pub use library::{Libraries, Library};
pub use model::Model;
pub use outcome::Outcome;
pub use samples::{Block, BlockSource, Samples};
pub use savgol::SavitzkyGolay;
pub use shooting::OdeModel;
pub use sr3::Sr3;
pub use stepwise::Stepwise;
pub use stlsq::Stlsq;
pub use stream::{OwnedBlock, Stream};
pub use weak::WeakForm;
