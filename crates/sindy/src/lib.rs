#![doc = include_str!("../README.md")]
//!
//! # Modules
//!
//! | module | what it holds |
//! | --- | --- |
//! | [`identify`] | the automatic call: from data to a model, with its reason, fronts and certificates |
//! | [`data`] | trajectories, samples and streams of rows; gaps |
//! | [`derivative`] | derivatives of sampled signals, noise level, the smoothing chosen |
//! | [`weak`] | the weak form: regression without derivatives |
//! | [`library`] | candidate terms |
//! | [`statistics`] | Gram matrices and triangular factors of the library; least squares, residuals, information criteria |
//! | [`solve`] | sparse solvers: SR3, STLSQ, stepwise search, best subsets with proof |
//! | [`choose`] | cross-validation and selection among fits |
//! | [`trajectory`] | delays, past states, multiple shooting, terms judged by trajectories |
//! | [`model`] | models: predict, simulate, Jacobian, equilibria, print, JSON |
//! | [`uncertainty`] | bootstrap, ensembles, sparse Bayesian regression, bands, identifiability |
//! | [`implicit`] | rational equations, `D(x) x' = N(x)` |
//! | [`pde`] | partial differential equations from fields on a grid |
//! | [`koopman`] | linear comparators: DMDc and EDMDc |
//! | [`numerics`] | golden section, quantiles |
//! | [`problems`] | problems with known answers |
//! | [`tour`] | an example for each part |
//! | [`from_pysindy`] | PySINDy's names and what replaces them here |

pub mod choose;
pub mod data;
pub mod derivative;
mod error;
pub mod from_pysindy;
pub mod identify;
pub mod koopman;
pub mod library;
pub mod model;
pub mod numerics;
pub mod pde;
pub mod problems;
pub mod solve;
pub mod statistics;
pub mod tour;
pub mod trajectory;
pub mod uncertainty;
pub mod weak;

pub use choose::{Choice, Grid};
pub use data::{Block, BlockSource, Dataset, OwnedBlock, Samples, Stream};
pub use derivative::{Differentiator, SavitzkyGolay};
pub use error::SindyError;
pub use identify::implicit;
pub use identify::{Identification, Identify};
pub use koopman::{Dmdc, Edmdc};
pub use library::{Libraries, Library};
pub use model::Model;
pub use solve::{BestSubset, Fit, Outcome, Solver, Sr3, Stepwise, Stlsq};
pub use statistics::{Criterion, Gram};
pub use trajectory::OdeModel;
pub use uncertainty::{Ensemble, Horseshoe};
pub use weak::WeakForm;
