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
//! with `s²` the mean square of what the fit leaves. Trajectories run through nodes ten samples apart, whose
//! defects the steps close (multiple shooting), and start afresh where chaos has amplified a change of the
//! start a thousandfold, or after a given length.
//!
//! Works for uneven times and discrete time alike. Inputs are taken as exact and linear between samples.
//!
//! Sources: H. G. Bock, "Recent advances in parameter identification techniques for ODE" (1983);
//! J. Chen, Z. Chen, "Extended Bayesian information criteria for model selection with large model
//! spaces", Biometrika 95 (2008).

mod arcs;
mod select;
mod system;

use nalgebra::DVector;

use arcs::{Cut, Record, integration_error, judge, linearise};
use select::Search;
pub use system::System;

use crate::outcome::Outcome;

/// Steps of the integrator between samples, at most.
const MOST_SUBSTEPS: usize = 32;
/// Error of the integrator from one node to the next that is accepted, in units of the noise.
const INTEGRATION: f64 = 0.003;

/// A stretch of data with a first guess of its trajectory.
pub struct Piece<'a> {
    /// Times, increasing.
    pub time: &'a [f64],
    /// Measured states.
    pub states: Vec<&'a [f64]>,
    /// Inputs.
    pub inputs: Vec<&'a [f64]>,
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
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            growth: 1e3,
            iterations: 60,
            penalty: 1.0,
        }
    }
}

/// What the search found.
#[derive(Clone, Debug)]
pub struct Found {
    /// Coefficients of all candidates.
    pub coefficients: Vec<f64>,
    /// Their standard errors, 0 outside the support.
    pub std_errors: Vec<f64>,
    /// Twice the fall of the log-likelihood that dropping a term of the support costs, or adding one
    /// gains, less the penalty for it: evidence for the term.
    pub evidence: Vec<f64>,
    /// Root mean square of what is left of each state.
    pub sigma: Vec<f64>,
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
}

/// Runs the search; `None` where no trajectory could be followed.
pub fn search(
    system: &System,
    pieces: &[Piece<'_>],
    start: &Start,
    settings: &Settings,
) -> Option<Found> {
    let mut records: Vec<Record> = pieces
        .iter()
        .map(|p| Record::new(p.time, &p.states, &p.inputs, &p.smooth))
        .collect();
    let (n, p) = (system.n, system.size());
    let mut xi = DVector::from_column_slice(&start.coefficients);
    let mut support: Vec<bool> = xi.iter().map(|c| *c != 0.0).collect();
    let mut sigma = start.sigma.clone();
    let mut cut = Cut {
        growth: settings.growth,
        longest: 4,
        substeps: 1,
    };
    let nodes = records.iter().map(|r| r.rows.len()).max()?;
    let mut equations = vec![Vec::new(); n];
    for (candidate, &(equation, _)) in system.candidates.iter().enumerate() {
        equations[equation].push(candidate);
    }
    let debug = std::env::var("OE_DEBUG").is_ok();
    let mut outcome = Outcome::IterationLimit;
    let mut iterations = 0;
    let mut at_length = 0;
    let mut breaks = None;
    let mut last = None;
    while iterations < settings.iterations {
        iterations += 1;
        at_length += 1;
        let normal = linearise(system, &records, xi.as_slice(), &sigma, cut, &mut breaks)?;
        let values = (normal.rows * n) as f64;
        let mut search = Search::new(&normal.xtx, &normal.xty, normal.yty, &xi);
        let unit = values.ln() + 2.0 * (p as f64).ln();
        let free = (normal.arcs * n) as f64;
        let mut variance = 0.0;
        for _ in 0..4 {
            let terms = search.support.iter().filter(|s| **s).count() as f64;
            variance = search.residual() / (values - free - terms).max(1.0);
            search.descend(settings.penalty * unit * variance);
        }
        if at_length == 1 || search.support != support {
            search.exact(&equations, settings.penalty * unit * variance, normal.rows * n);
        }
        let new = search.coefficients();
        let change = &new - &xi;
        let same = search.support == support;
        let moved = (0..p)
            .filter(|&j| search.support[j])
            .map(|j| change[j].abs() / (search.variance(j) * variance).sqrt())
            .fold(0.0, f64::max);
        // The step, shortened until the merit falls.
        let merit = |misfit: &[f64], defects: f64| {
            misfit.iter().zip(&sigma).map(|(m, s)| m / s / s).sum::<f64>() + 10.0 * defects
        };
        let before = merit(&normal.misfit, normal.defects);
        let saved: Vec<Vec<Vec<f64>>> = records.iter().map(|r| r.nodes.clone()).collect();
        let mut part = 1.0;
        let mut after;
        loop {
            normal.move_nodes(&mut records, &change, part);
            let trial = &xi + &change * part;
            after = judge(system, &records, trial.as_slice(), &sigma, cut, &normal);
            if after
                .as_ref()
                .is_some_and(|(m, d)| merit(m, *d) < 1.5 * before.max(values))
                || part < 0.02
            {
                break;
            }
            records
                .iter_mut()
                .zip(&saved)
                .for_each(|(r, s)| r.nodes.clone_from(s));
            part *= 0.5;
        }
        let (misfit, defects) = after?;
        if debug {
            eprintln!(
                "it {iterations} longest {} arcs {} terms {} same {same} moved {moved:.2e} part {part} merit {before:.4e} -> {:.4e} (defects {:.2e}->{defects:.2e}) s2 {variance:.3} sigma {sigma:?}",
                cut.longest, normal.arcs, search.support.iter().filter(|s| **s).count(), merit(&misfit, defects), normal.defects
            );
        }
        xi += &change * part;
        support.clone_from(&search.support);
        if part == 1.0 {
            for ((s, m), floor) in sigma.iter_mut().zip(&misfit).zip(&start.floor) {
                *s = (m / normal.rows as f64).sqrt().max(*floor);
            }
        } else {
            for (j, c) in xi.iter_mut().enumerate() {
                if !support[j] && part < 1.0 {
                    // A shortened step leaves what is being dropped in the model.
                    support[j] = *c != 0.0;
                }
            }
        }
        let settled = same && moved < 0.1 && part == 1.0;
        let (arcs, values) = (normal.arcs, normal.rows * n);
        last = Some((search, variance, unit, arcs, values));
        if settled && cut.longest >= nodes {
            if moved < 0.01 {
                outcome = Outcome::Converged;
                break;
            }
        } else if cut.longest < nodes && (settled || at_length >= 6) {
            while cut.substeps < MOST_SUBSTEPS
                && integration_error(system, &records, xi.as_slice(), &sigma, cut.substeps) > INTEGRATION
            {
                cut.substeps *= 2;
            }
            cut.longest = (cut.longest * 4).min(nodes);
            at_length = 0;
            breaks = None;
        }
    }
    let (search, variance, unit, arcs, values) = last?;
    Some(Found {
        coefficients: xi.iter().copied().collect(),
        std_errors: (0..p)
            .map(|j| match search.support[j] {
                true => (search.variance(j) * variance).sqrt(),
                false => 0.0,
            })
            .collect(),
        evidence: (0..p)
            .map(|j| search.change(j) / variance - unit)
            .collect(),
        score: {
            let rows = values as f64 / n as f64;
            let terms = search.support.iter().filter(|s| **s).count() as f64;
            rows * sigma.iter().map(|s| 2.0 * s.ln()).sum::<f64>()
                + terms * unit
                + (arcs * n) as f64 * (values as f64).ln()
        },
        sigma,
        arcs,
        values,
        iterations,
        outcome,
    })
}
