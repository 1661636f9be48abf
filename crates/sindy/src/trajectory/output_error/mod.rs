//! Sparse identification by output error: terms and coefficients judged by the trajectory, not by its slope.
//!
//! Regression on slopes suffers twice from noise in the states: the slope is rough, and the terms
//! themselves are wrong. Here neither occurs. The model's own trajectory `x(t)` is compared with the
//! measured states,
//!
//! ```text
//! min over ξ, trajectories    Σ_i Σ_t ( y_i(t) - x_i(t) )² / σ_i²   +   penalty x (terms of ξ),      x' = Θ(x, u) ξ
//! ```
//!
//! which is maximum likelihood for independent noise. It is solved by Gauss–Newton steps with a sparse
//! inner problem: around the present trajectory the residuals are linear in the coefficients of *all*
//! candidate terms, so each step chooses among them all (add, drop, exchange), by the extended Bayesian
//! information criterion
//!
//! ```text
//! a term stays if it lowers  Σ r²/σ²  by more than  s² (ln N + 2 ln P),     N values, P candidates,
//! ```
//!
//! with `s²` the mean square of the fit's residual. Where noise remembers from row to row, residuals are compared by what is new
//! in them ([`Start::colour`]). Trajectories run through nodes ten samples apart, whose
//! defects the steps close (multiple shooting), and start afresh where chaos has amplified a change of the
//! start a thousandfold, or after a given length.
//!
//! Works for uneven times and discrete time alike. Inputs are taken as exact; their interpolation between
//! samples comes with the data ([`Piece::between`]).
//!
//! Sources: H. G. Bock, "Recent advances in parameter identification techniques for ODE" (1983);
//! J. Chen, Z. Chen, "Extended Bayesian information criteria for model selection with large model
//! spaces", Biometrika 95 (2008).

mod absent;
mod adaptive;
mod arcs;
mod choice;
mod colour;
pub(crate) mod disturbed;
pub(crate) mod exchange;
mod follow;
mod multiples;
mod noise;
mod record;
mod search;
mod select;
mod system;
#[cfg(test)]
mod tests;

pub(crate) use absent::gains;
pub use disturbed::{Diffusion, Disturbance, Sources};
pub use exchange::Exchange;
use follow::{ArcSettings, Follow};
pub(crate) use multiples::Multiple;
pub(crate) use noise::{Trace, colour_of, independence, is_white};
use record::Record;
pub(crate) use search::irrelevant;
pub use search::search;
pub use system::System;

use std::ops::ControlFlow;

use nalgebra::DMatrix;

use crate::model::Interpolation;
use crate::solve::outcome::Outcome;
use crate::solve::sign::Sign;

/// Nodes of the short simulations that models are ranked by: long enough for a wrong term to show above the noise, short
/// enough that chaos does not decide.
const FREE_NODES: usize = 8;
/// Nodes of the first arcs: short enough that a regression's model follows them, long enough to distinguish terms.
pub(crate) const FIRST_ARC: usize = 4;

/// A stretch of data with a first guess of its trajectory.
#[derive(Clone)]
pub struct Piece<'a> {
    /// Times, increasing.
    pub time: &'a [f64],
    /// States, those that are measured first. Values of others are not compared with.
    pub states: Vec<&'a [f64]>,
    /// Inputs.
    pub inputs: Vec<&'a [f64]>,
    /// What each input is between its samples.
    pub between: Vec<Interpolation>,
    /// A weight for each row.
    pub weights: Option<&'a [f64]>,
    /// The rows in which each state is measured; none where all are in all rows. States are compared there alone.
    pub seen: Vec<&'a [bool]>,
    /// Smoothed states.
    pub smooth: Vec<Vec<f64>>,
}

/// Where the search starts.
#[derive(Clone, Debug)]
pub struct Start {
    /// Coefficients of all candidates; those that are not zero are the first support.
    pub coefficients: Vec<f64>,
    /// Noise of each state.
    pub sigma: Vec<f64>,
    /// The least noise of each state that is believed.
    pub floor: Vec<f64>,
    /// Root mean square of each candidate's term over the data.
    pub term_rms: Vec<f64>,
    /// Candidates that these were chosen from, by whatever means: P of the penalty. At least as many as there are here.
    pub chosen_from: usize,
    /// Signs of all candidates' coefficients, or none. The search ends with coefficients that keep them if it starts from such.
    pub signs: Vec<Sign>,
    /// How much the noise of each measured state remembers from row to row: φ of an autoregression of first order, at least 0
    /// and below 1, 0 for white noise and for states beyond the last. `sigma` is then the noise that is new in each row.
    pub colour: Vec<f64>,
}

/// A step that was made.
pub struct Step<'a> {
    /// Its number, from 1.
    pub step: usize,
    /// Terms that are kept.
    pub terms: usize,
    /// Root mean square of the residual of each state.
    pub sigma: &'a [f64],
    /// Where the steps over arcs of one length ended, if they did.
    pub settled: Option<Settled>,
}

/// Goes on after every step, and says nothing.
pub fn silent(_: Step<'_>) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// Where the steps over arcs of one length ended.
#[derive(Clone, Debug)]
pub struct Settled {
    /// Nodes of an arc, at most.
    pub longest: usize,
    /// Coefficients of all candidates.
    pub coefficients: Vec<f64>,
    /// Their standard errors, 0 outside the support.
    pub std_errors: Vec<f64>,
}

impl Settled {
    /// Whether a search that settled there goes on as one that settled here: from the same terms, and from coefficients that differ
    /// by less than another step would move them.
    #[must_use]
    pub fn meets(&self, other: &Self) -> bool {
        let all = self.coefficients.iter().zip(&other.coefficients);
        self.longest == other.longest
            && all.zip(&self.std_errors).all(|((own, other), error)| {
                (*own != 0.0) == (*other != 0.0) && (own - other).abs() <= search::SETTLED * error
            })
    }
}

/// The best terms of one number for one equation, the others held.
#[derive(Clone, Debug, PartialEq)]
pub struct Alternative {
    /// Candidates that are kept.
    pub support: Vec<usize>,
    /// Root mean square residual in units of the noise, by the linearisation around the solution.
    pub error: f64,
    /// Whether no other terms of this number are better in that linearisation, by proof.
    pub proven: bool,
}

/// Settings of the search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// An arc ends where a change of its start has grown by this factor.
    pub growth: f64,
    /// Steps, at most.
    pub iterations: usize,
    /// The weight of the penalty: 1 is the criterion above.
    pub penalty: f64,
    /// Nodes of an arc, at most.
    pub longest: usize,
    /// Nodes of the first arcs: few where a start may be far away.
    pub first_arc: usize,
    /// A term that contributes less than this share of its equation's largest term is left out, however
    /// significant: in data without noise even the rounding of the simulation that made them is.
    pub relevance: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            growth: 1e3,
            iterations: 60,
            penalty: 1.0,
            longest: usize::MAX,
            first_arc: FIRST_ARC,
            relevance: 1e-4,
        }
    }
}

/// The fit that the search found.
#[derive(Clone, Debug)]
pub struct OutputErrorFit {
    /// Coefficients of all candidates.
    pub coefficients: Vec<f64>,
    /// Their standard errors, 0 outside the support.
    pub std_errors: Vec<f64>,
    /// Their covariance: a row for each coefficient that is not zero.
    pub(crate) covariance: DMatrix<f64>,
    /// Twice the fall of the log-likelihood that dropping a term of the support costs, or adding one
    /// gains, less the penalty for it: evidence for the term, were the residuals independent.
    pub evidence: Vec<f64>,
    /// The penalty in it: `ln N + 2 ln P`.
    pub penalty: f64,
    /// Root mean square of the residual of each measured state, of what is new in it from row to row if its noise remembers; of
    /// other states, what they started from.
    pub sigma: Vec<f64>,
    /// The `colour` of [`Start`].
    pub colour: Vec<f64>,
    /// What acts on the system, where the fit is that of a disturbed one: `sigma` is then the noise of the
    /// measurement, and `correlation` that of the innovations.
    pub disturbance: Option<Disturbance>,
    /// For each equation, the best terms of every number up to some more than were kept.
    pub fronts: Vec<Vec<Alternative>>,
    /// For each term that is kept, and for two of an equation, the candidates of the equation that are nearest in place of them.
    pub exchanges: Vec<Exchange>,
    /// What may be added to equations of a stiff system unseen; none of others.
    pub(crate) multiples: Vec<Multiple>,
    /// `1 + 2 Σ ρ_k` of the residuals, the largest over states; 1 for independent ones.
    pub correlation: f64,
    /// What candidates are compared by, smaller is better: `Σ_i N ln σ_i²`, and the penalties of terms and
    /// of the arcs' starts.
    pub score: f64,
    /// Arcs into which the data were cut.
    pub arcs: usize,
    /// Values compared.
    pub values: usize,
    /// Gauss–Newton steps.
    pub iterations: usize,
    /// Converged, or not.
    pub outcome: Outcome,
    /// Where the trajectories run.
    pub(crate) trace: Trace,
}

impl OutputErrorFit {
    /// Root mean square of the residual of each state, with what its noise remembers.
    #[must_use]
    pub fn residual(&self) -> Vec<f64> {
        let of = |(i, sigma): (usize, &f64)| {
            let phi = self.colour.get(i).copied().unwrap_or(0.0);
            sigma / (1.0 - phi * phi).sqrt()
        };
        self.sigma.iter().enumerate().map(of).collect()
    }
}

/// Root mean square of short simulations from smoothed states against the measured ones, in units of the noise,
/// all states alike; infinite where a simulation leaves the finite numbers.
#[must_use]
pub fn free_run(system: &System, pieces: &[Piece<'_>], coefficients: &[f64], sigma: &[f64]) -> f64 {
    let records: Vec<Record> = pieces.iter().map(Record::new).collect();
    let follow = Follow {
        system,
        coefficients,
        sigma,
        colour: &[],
        cut: ArcSettings {
            growth: f64::INFINITY,
            longest: FREE_NODES,
            substeps: 1,
        },
    };
    follow.free_run(&records)
}
