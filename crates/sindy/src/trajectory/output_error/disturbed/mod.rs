//! Systems that are disturbed: terms judged by what each row adds to the rows before it.
//!
//! A disturbance stays in the state, so that no trajectory of the model follows the data for long. Here the state is estimated
//! from row to row by an extended Kalman filter,
//!
//! ```text
//! dx = Θ(x, u) ξ dt + dw,   cov(dw) = diag(q) dt,        y_k = x(t_k) + e_k,   cov(e_k) = diag(r)
//! ```
//!
//! and the model is judged by the filter's innovations `ν_k = y_k - x(t_k | y_0 … y_{k-1})`, whose covariance `S_k` it predicts:
//!
//! ```text
//! min over ξ, q, r    Σ_k ( ln det S_k + ν_kᵀ S_k⁻¹ ν_k )   +   penalty x (terms of ξ)
//! ```
//!
//! which is maximum likelihood up to the filter's linearisation (prediction-error method). Steps of the coefficients are those of the
//! output error: the innovations are linear in the coefficients of all candidates around the present filter, and each step chooses
//! among them all. The filter's gain is held within a step; the innovations' products with their derivatives have mean zero
//! for any gain, so that the estimate is consistent. q and r follow between the steps, by golden sections of the likelihood over rows
//! linearised around the filter.
//!
//! With r = 0 rows are states, and `q` is the diffusion of a stochastic differential equation. Where it may depend on the state
//! ([`diffusion`]), its terms are chosen as those of the drift are, but from squared innovations ([`squares`], [`choice`]).
//! The choices of drift and diffusion take turns until neither changes.
//!
//! Sources: L. Ljung, "Asymptotic behavior of the extended Kalman filter as a parameter estimator for linear systems", IEEE
//! Transactions on Automatic Control 24 (1979); N. R. Kristensen, H. Madsen, S. B. Jørgensen, "Parameter estimation in stochastic grey-box
//! models", Automatica 40 (2004).

mod choice;
mod diffusion;
mod filter;
mod squares;
#[cfg(test)]
mod tests;
mod variances;

use std::ops::ControlFlow;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::choice::{Chosen, Linearised};
use super::colour;
use super::follow::{ArcSettings, Follow};
use super::noise::Trace;
use super::record::Record;
use super::search::{DONE, SETTLED, SHORTEST, WORSE, correlation};
use super::{OutputErrorFit, Piece, Settings, Start, Step, System};
use crate::solve::outcome::Outcome;
pub use diffusion::Diffusion;
pub(crate) use diffusion::DiffusionCandidates;
use filter::{Filter, Pass};

/// Distance of two estimates of the variances that are the same ([`variances::distance`]): it changes the filter's gain by a few
/// percent.
const SAME_VARIANCE: f64 = 0.1;
/// Twice the logarithm of the likelihood by which estimates of the variances are the same, however far apart: odds of e^½ = 1.6. A
/// variance that is zero has no logarithm to settle at.
const SAME_LIKELIHOOD: f64 = 1.0;

/// What acts on a disturbed system and its measurement, as variances.
#[derive(Clone, Debug, PartialEq)]
pub struct Disturbance {
    /// Of the disturbance of each state, in its unit squared per unit of time; the mean over rows where it depends on the state.
    pub process: Vec<f64>,
    /// Of the noise of each measured state, in its unit squared.
    pub measurement: Vec<f64>,
    /// What of it is estimated.
    pub sources: Sources,
    /// How the disturbances depend on the state, where they may.
    pub diffusion: Option<Diffusion>,
}

/// What may be estimated of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sources {
    /// Disturbances alone: rows are states.
    Process,
    /// Both.
    Both,
}

/// A model and its filter over all records.
struct Disturbed<'a> {
    system: &'a System,
    records: Vec<Record>,
    xi: DVector<f64>,
    noise: Disturbance,
    substeps: usize,
}

/// The sums over all records.
struct Total {
    xtx: DMatrix<f64>,
    xty: DVector<f64>,
    yty: f64,
    log_determinant: f64,
    values: usize,
    passes: Vec<Pass>,
}

/// Runs the search; `None` where the filter leaves the finite numbers, or where `progress` ends it.
pub(crate) fn search(
    system: &System,
    pieces: &[Piece<'_>],
    (start, sources): (&Start, Sources),
    settings: &Settings,
    progress: &mut dyn FnMut(Step<'_>) -> ControlFlow<()>,
) -> Option<OutputErrorFit> {
    let records: Vec<Record> = pieces.iter().map(Record::new).collect();
    let mut state = Disturbed {
        system,
        noise: variances::first(&records, system.measured, start, sources),
        records,
        xi: DVector::from_column_slice(&start.coefficients),
        substeps: 1,
    };
    state.substeps = state.follow(&start.sigma).fine_substeps(&state.records);
    let mut total = state.total()?;
    state.noise = state.estimate(&total, variances::WIDE);
    total = state.total()?;
    let mut outcome = Outcome::IterationLimit;
    let mut anew = true;
    let mut settled_noise = false;
    let mut iterations = 0;
    let mut last = None;
    while iterations < settings.iterations {
        iterations += 1;
        let linearised = Linearised {
            xtx: &total.xtx,
            xty: &total.xty,
            yty: total.yty,
            values: total.values,
            free: 0.0,
        };
        let chosen = linearised.choose(&state.xi, &system.groups, (settings, start), anew);
        let (moved, part) = state.move_by(&chosen.change, &total)?;
        total = moved;
        if part == 1.0 {
            chosen.clear(&mut state.xi);
        }
        let step = Step {
            step: iterations,
            terms: state.xi.iter().filter(|c| **c != 0.0).count(),
            sigma: &start.sigma,
            settled: None,
        };
        if progress(step).is_break() {
            return None;
        }
        let settled = chosen.same && chosen.moved < SETTLED && part == 1.0;
        let done = settled && chosen.moved < DONE && settled_noise;
        last = Some(chosen);
        if done {
            outcome = Outcome::Converged;
            break;
        }
        anew = settled && !settled_noise;
        if settled && !settled_noise {
            let next = state.next_noise(&total, settings);
            settled_noise = choice::is_same(&state.noise, &next)
                && (variances::distance(&next, &state.noise, &state.records) < SAME_VARIANCE
                    || state.gain(&total, &next) < SAME_LIKELIHOOD);
            state.noise = next;
            total = state.total()?;
        } else if !settled {
            settled_noise = false;
        }
    }
    Some(state.report(&last?, &total, start, (iterations, outcome)))
}

/// What the innovations of a fit tell of it.
pub(crate) struct Innovations {
    /// Whether neighbours are not correlated.
    pub white: bool,
    /// State and inputs that a row was predicted from, and its innovations in standard deviations.
    pub points: Vec<Vec<f64>>,
    pub errors: Vec<Vec<f64>>,
}

/// The innovations of a fit with disturbances; `None` of another.
pub(crate) fn innovations(
    system: &System,
    pieces: &[Piece<'_>],
    fit: &OutputErrorFit,
) -> Option<Innovations> {
    let state = Disturbed {
        system,
        records: pieces.iter().map(Record::new).collect(),
        xi: DVector::from_column_slice(&fit.coefficients),
        noise: fit.disturbance.clone()?,
        substeps: fit.trace.substeps,
    };
    let passes = state.total()?.passes;
    let white = colour::is_white(&series(&passes));
    let mut out = Innovations {
        white,
        points: Vec::new(),
        errors: Vec::new(),
    };
    for pass in passes {
        out.errors.extend(pass.errors);
        out.points.extend(pass.points);
    }
    Some(out)
}

/// The normal equations of all candidates, around coefficients and noise of a fit.
pub(super) fn normal(
    system: &System,
    pieces: &[Piece<'_>],
    coefficients: &[f64],
    (noise, substeps): (&Disturbance, usize),
) -> Option<(DMatrix<f64>, DVector<f64>)> {
    let state = Disturbed {
        system,
        records: pieces.iter().map(Record::new).collect(),
        xi: DVector::from_column_slice(coefficients),
        noise: noise.clone(),
        substeps,
    };
    let total = state.total()?;
    Some((total.xtx, total.xty))
}

/// Innovations by record, state and row.
fn series(passes: &[Pass]) -> Vec<Vec<Vec<f64>>> {
    passes.iter().map(|p| p.innovations.clone()).collect()
}

impl Disturbed<'_> {
    fn follow<'s>(&'s self, sigma: &'s [f64]) -> Follow<'s> {
        Follow {
            system: self.system,
            coefficients: self.xi.as_slice(),
            sigma,
            colour: &[],
            cut: ArcSettings {
                growth: f64::INFINITY,
                longest: usize::MAX,
                substeps: self.substeps,
            },
        }
    }

    /// The filter over all records.
    fn total(&self) -> Option<Total> {
        let filter = Filter {
            follow: self.follow(&[]),
            noise: &self.noise,
        };
        let runs = self.records.par_iter().map(|record| filter.run(record));
        let passes: Vec<Pass> = runs.collect::<Option<_>>()?;
        let p = self.system.size();
        let mut sums = DMatrix::zeros(p + 1, p + 1);
        for pass in &passes {
            sums += &pass.sums.total;
        }
        let total = Total {
            xtx: sums.view((0, 0), (p, p)).into_owned(),
            xty: sums.view((0, p), (p, 1)).column(0).into_owned(),
            yty: sums[(p, p)],
            log_determinant: passes.iter().map(|pass| pass.log_determinant).sum(),
            values: passes
                .iter()
                .flat_map(|pass| &pass.innovations)
                .map(Vec::len)
                .sum(),
            passes,
        };
        let finite = sums.iter().all(|v| v.is_finite());
        (finite && total.values > 0).then_some(total)
    }

    /// What other variances gain: twice the logarithm of the likelihood.
    fn gain(&self, total: &Total, next: &Disturbance) -> f64 {
        let passes: Vec<_> = self.records.iter().zip(&total.passes).collect();
        let cost = |noise| variances::cost(&passes, noise, variances::ROWS);
        cost(&self.noise) - cost(next)
    }

    fn estimate(&self, total: &Total, range: variances::Range) -> Disturbance {
        let passes: Vec<_> = self.records.iter().zip(&total.passes).collect();
        variances::estimate(&passes, &self.noise, range)
    }

    /// The most likely variances from an estimate on: with the diffusion's terms where they are looked for, and constant where no sum
    /// of them is positive.
    fn next_noise(&self, total: &Total, settings: &Settings) -> Disturbance {
        let passes: Vec<_> = self.records.iter().zip(&total.passes).collect();
        let candidates = self.system.diffusion.as_ref();
        let depends =
            candidates.and_then(|all| choice::estimate(&passes, &self.noise, all, settings));
        depends.unwrap_or_else(|| {
            let constant = Disturbance {
                diffusion: None,
                ..self.noise.clone()
            };
            variances::estimate(&passes, &constant, variances::NARROW)
        })
    }

    /// Moves coefficients by the step, halved until the innovations are not much larger; the sums there, and the share that was made.
    fn move_by(&mut self, change: &DVector<f64>, before: &Total) -> Option<(Total, f64)> {
        let xi = self.xi.clone();
        let mut part = 1.0;
        loop {
            self.xi = &xi + change * part;
            let after = self.total();
            let most = WORSE * before.yty.max(before.values as f64);
            if part < SHORTEST || after.as_ref().is_some_and(|after| after.yty < most) {
                return after.map(|after| (after, part));
            }
            part *= 0.5;
        }
    }

    fn report(
        &self,
        chosen: &Chosen,
        total: &Total,
        start: &Start,
        (iterations, outcome): (usize, Outcome),
    ) -> OutputErrorFit {
        let diffusion = self.noise.diffusion.iter().flat_map(|d| &d.coefficients);
        let all = self.xi.iter().chain(diffusion.flatten());
        let terms = all.filter(|c| **c != 0.0).count() as f64;
        let mut sigma = start.sigma.clone();
        for (sigma, variance) in sigma.iter_mut().zip(&self.noise.measurement) {
            *sigma = variance.sqrt();
        }
        OutputErrorFit {
            coefficients: self.xi.iter().copied().collect(),
            std_errors: chosen.std_errors(&self.xi),
            covariance: chosen.covariance(&self.xi),
            evidence: chosen.evidence(),
            penalty: chosen.penalty(),
            fronts: chosen.fronts(&self.system.groups),
            exchanges: chosen.exchanges(&self.system.groups),
            multiples: Vec::new(),
            correlation: correlation(&series(&total.passes)),
            score: total.log_determinant + total.yty - total.values as f64
                + terms * chosen.penalty(),
            sigma,
            colour: Vec::new(),
            disturbance: Some(self.noise.clone()),
            arcs: self.records.len(),
            values: total.values,
            iterations,
            outcome,
            trace: Trace {
                nodes: self.records.iter().map(|r| r.nodes.clone()).collect(),
                substeps: self.substeps,
            },
        }
    }
}
