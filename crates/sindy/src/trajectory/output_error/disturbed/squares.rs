//! Innovations and their squares, linearised by what makes their covariance: coefficients of the diffusion, and variances of the
//! measurement.
//!
//! With parameters c, and the derivatives `S_a` of the innovations' covariance and `ν_a` of the innovations, a step of Fisher's scoring
//! towards maximum likelihood is the least-squares problem
//!
//! ```text
//! min over δ    Σ_k ( ½ | z zᵀ - I - Σ_a δ_a D_a |²  +  | z + Σ_a δ_a w_a |² ),
//!               z = L⁻¹ ν,   D_a = L⁻¹ S_a L⁻ᵀ,   w_a = L⁻¹ ν_a,   S = L Lᵀ
//! ```
//!
//! a regression of squared innovations with weights 1/S². Its sum of squares falls by as much as twice the log-likelihood rises, to
//! second order. Covariance and mean of the state pass their derivatives from row to row,
//!
//! ```text
//! P⁺_a = (I - KC) P_a (I - KC)ᵀ + K R_a Kᵀ,      x⁺_a = (I - KC) x_a + ((I - KC) P_a Cᵀ - K R_a) S⁻¹ ν
//! ```
//!
//! Innovations depend on the covariance through the gain K. Where the measurement's variance is small, their squares alone cannot tell it from
//! a constant disturbance.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::diffusion::DiffusionCandidates;
use super::filter::{Belief, ENDS, Linear, MIDDLE, Pass, Update};
use super::{Disturbance, Sources};
use crate::trajectory::output_error::arcs::Sums;
use crate::trajectory::output_error::record::Record;

/// The parameters of the covariance: for each state the coefficients of all candidates, then what is estimated of the measurement.
#[derive(Clone, Copy)]
pub(super) struct Parameters {
    pub states: usize,
    pub terms: usize,
    /// Variances of the measurement that are estimated: of all measured states, or of none.
    pub measured: usize,
}

impl Parameters {
    pub(super) fn new(candidates: &DiffusionCandidates, noise: &Disturbance) -> Self {
        Self {
            states: noise.process.len(),
            terms: candidates.len(),
            measured: match noise.sources {
                Sources::Process => 0,
                Sources::Both => noise.measurement.len(),
            },
        }
    }

    pub(super) fn len(&self) -> usize {
        self.states * self.terms + self.measured
    }

    /// The parameters of state `i`'s diffusion.
    pub(super) fn of(&self, i: usize) -> std::ops::Range<usize> {
        i * self.terms..(i + 1) * self.terms
    }

    /// The first variance of the measurement.
    pub(super) fn measurement(&self) -> usize {
        self.states * self.terms
    }
}

/// Normal equations of a step.
pub(super) struct Squares {
    /// `[D | zzᵀ - I]ᵀ [D | zzᵀ - I]`, and the same of `[w | -z]`.
    pub total: DMatrix<f64>,
    /// Distinct entries of all `zzᵀ`, and of all `z` where they depend on parameters.
    pub values: usize,
}

/// The sums over all records, in their order; `None` where the filter fails.
pub(super) fn linearise(
    passes: &[(&Record, &Pass)],
    noise: &Disturbance,
    parameters: Parameters,
) -> Option<Squares> {
    let of = |(record, pass): &(&Record, &Pass)| along(record, &pass.steps, noise, parameters);
    let parts: Vec<Squares> = passes.par_iter().map(of).collect::<Option<_>>()?;
    let size = parameters.len() + 1;
    let mut all = Squares {
        total: DMatrix::zeros(size, size),
        values: 0,
    };
    for part in parts {
        all.total += part.total;
        all.values += part.values;
    }
    all.total.iter().all(|v| v.is_finite()).then_some(all)
}

/// Derivatives of the state's covariance and mean by the parameters.
struct Slopes {
    by: Vec<DMatrix<f64>>,
    mean: Vec<DVector<f64>>,
    parameters: Parameters,
    /// Whether all states are measured almost exactly: a row leaves nothing of what came before.
    forgets: bool,
    /// Whether all are zero.
    blank: bool,
}

fn along(
    record: &Record,
    steps: &[Linear],
    noise: &Disturbance,
    parameters: Parameters,
) -> Option<Squares> {
    let (n, measured) = (parameters.states, noise.measurement.len());
    let mut sums = Sums::new(parameters.len());
    let mut values = 0;
    let mut belief = Belief::first(record, noise);
    let exact = noise.sources == Sources::Process;
    let mut slopes = Slopes::first(parameters, n == measured && exact);
    for (k, step) in steps.iter().enumerate() {
        let mean = &step.to + &step.transition * (&belief.mean - &step.from);
        belief.predict(mean, step, noise);
        slopes.predict(step);
        if !record.is_compared(k + 1) {
            continue;
        }
        let weight = record.root_weight(k + 1).powi(2);
        let update = belief.update(record, k + 1, noise)?;
        let whitened = slopes.whitened(&update, weight)?;
        let z = &update.innovation;
        for a in 0..z.len() {
            for b in 0..=a {
                // Entries beside the diagonal stand in the matrix twice.
                let scale = if a == b { 0.5_f64.sqrt() } else { 1.0 };
                let expected = f64::from(u8::from(a == b));
                let row = whitened.iter().map(|d| scale * d[(a, b)]);
                sums.push(row, scale * (z[a] * z[b] - expected));
                values += 1;
            }
        }
        if !slopes.forgets {
            for (k, moved) in slopes.moved(&update)?.row_iter().enumerate() {
                sums.push(moved.iter().copied(), -z[k]);
                values += 1;
            }
        }
        slopes.update(&update, measured, weight)?;
    }
    sums.flush();
    Some(Squares {
        total: sums.total,
        values,
    })
}

impl Slopes {
    /// At a record's first row, where measured states are as they are measured.
    fn first(parameters: Parameters, forgets: bool) -> Self {
        let n = parameters.states;
        let mut by = vec![DMatrix::zeros(n, n); parameters.len()];
        for i in 0..parameters.measured {
            by[parameters.measurement() + i][(i, i)] = 1.0;
        }
        Self {
            by,
            mean: vec![DVector::zeros(n); parameters.len()],
            parameters,
            forgets,
            blank: parameters.measured == 0,
        }
    }

    /// Over a step, as [`Belief::predict`].
    fn predict(&mut self, step: &Linear) {
        let (ends, middle) = (ENDS * step.period, MIDDLE * step.period);
        let [from, to] = &step.terms;
        let (f, half) = (&step.transition, step.second_half());
        if !self.blank {
            let turned = f.transpose();
            self.by.iter_mut().for_each(|by| *by = f * &*by * &turned);
            self.mean.iter_mut().for_each(|mean| *mean = f * &*mean);
        }
        for i in 0..self.parameters.states {
            let outer = f.column(i) * f.column(i).transpose() * ends;
            let between = half.column(i) * half.column(i).transpose() * (0.5 * middle);
            for (by, (from, to)) in self.by[self.parameters.of(i)]
                .iter_mut()
                .zip(from.iter().zip(to))
            {
                by.zip_apply(&outer, |by, o| *by += from * o);
                by.zip_apply(&between, |by, o| *by += (from + to) * o);
                by[(i, i)] += ends * to;
            }
        }
        self.blank = false;
    }

    /// Those of the innovations' covariance, mapped as this is to unit covariance.
    fn whitened(&self, update: &Update, weight: f64) -> Option<Vec<DMatrix<f64>>> {
        let first = self.parameters.measurement();
        let all = self.by.iter().enumerate();
        all.map(|(a, by)| {
            let states = &update.states;
            let mut s = by.select_rows(states).select_columns(states);
            let own = states.iter().position(|i| a.checked_sub(first) == Some(*i));
            if let Some(k) = own {
                s[(k, k)] += 1.0 / weight;
            }
            let half = update.root.solve_lower_triangular(&s)?.transpose();
            update.root.solve_lower_triangular(&half)
        })
        .collect()
    }

    /// Those of the innovations, mapped as these are to unit covariance: a column for each parameter.
    fn moved(&self, update: &Update) -> Option<DMatrix<f64>> {
        let of = |a: usize, k: usize| -self.mean[a][update.states[k]];
        let all = DMatrix::from_fn(update.states.len(), self.mean.len(), |k, a| of(a, k));
        update.root.solve_lower_triangular(&all)
    }

    /// By a row; `None` where its covariance is singular.
    fn update(&mut self, update: &Update, measured: usize, weight: f64) -> Option<()> {
        if self.forgets && update.states.len() == measured {
            self.by.iter_mut().for_each(|by| by.fill(0.0));
            self.blank = true;
            return Some(());
        }
        let n = self.parameters.states;
        let mut kept = DMatrix::identity(n, n);
        for (k, &i) in update.states.iter().enumerate() {
            let mut column = kept.column_mut(i);
            column -= update.gain.column(k);
        }
        let pull = update.root.tr_solve_lower_triangular(&update.innovation)?;
        for (by, mean) in self.by.iter().zip(&mut self.mean) {
            *mean = &kept * (&*mean + by.select_columns(&update.states) * &pull);
        }
        let turned = kept.transpose();
        for by in &mut self.by {
            *by = &kept * &*by * &turned;
        }
        let estimated = self.parameters.measured;
        for (k, &i) in update
            .states
            .iter()
            .enumerate()
            .filter(|s| *s.1 < estimated)
        {
            let gain = update.gain.column(k);
            let a = self.parameters.measurement() + i;
            self.by[a] += gain * gain.transpose() / weight;
            self.mean[a] -= gain * (pull[k] / weight);
        }
        Some(())
    }
}
