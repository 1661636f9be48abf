//! The normal equations: the contribution of each window, reduced by eliminating its start.

use nalgebra::{DMatrix, DVector};

use super::Record;
use super::settings::Parameter;
use crate::statistics::regression::pseudo_inverse;

/// A window: a stretch of a record.
pub(super) struct Stretch<'a> {
    pub(super) record: &'a Record<'a>,
    pub(super) first: usize,
    pub(super) len: usize,
}

impl Stretch<'_> {
    /// The record's guess of the states at the window's start.
    pub(super) fn guess(&self) -> DVector<f64> {
        let start = self.record.start.iter().map(|c| c[self.first]);
        DVector::from_iterator(self.record.start.len(), start)
    }
}

/// What one window contributes.
pub(super) struct WindowEquations {
    pub(super) h: DMatrix<f64>,
    pub(super) h0: DMatrix<f64>,
    pub(super) h0p: DMatrix<f64>,
    pub(super) g: DVector<f64>,
    pub(super) g0: DVector<f64>,
    pub(super) squares: f64,
    pub(super) count: usize,
}

impl WindowEquations {
    pub(super) fn zeros(n: usize, p: usize) -> Self {
        Self {
            h: DMatrix::zeros(p, p),
            h0: DMatrix::zeros(n, n),
            h0p: DMatrix::zeros(n, p),
            g: DVector::zeros(p),
            g0: DVector::zeros(n),
            squares: 0.0,
            count: 0,
        }
    }

    pub(super) fn add(&mut self, r: f64, row: &[f64], p: usize) {
        let (jp, j0) = row.split_at(p);
        for (b, &vb) in jp.iter().enumerate() {
            for (a, &va) in jp.iter().enumerate() {
                self.h[(a, b)] += va * vb;
            }
            for (a, &va) in j0.iter().enumerate() {
                self.h0p[(a, b)] += va * vb;
            }
            self.g[b] += vb * r;
        }
        for (b, &vb) in j0.iter().enumerate() {
            for (a, &va) in j0.iter().enumerate() {
                self.h0[(a, b)] += va * vb;
            }
            self.g0[b] += vb * r;
        }
        self.squares += r * r;
        self.count += 1;
    }
}

pub(super) struct Back {
    pub(super) offset: DVector<f64>,
    pub(super) gain: DMatrix<f64>,
}

impl Back {
    pub(super) fn start_step(&self, step: &DVector<f64>) -> DVector<f64> {
        &self.offset + &self.gain * step
    }
}

pub(super) struct Reduced {
    pub(super) h: DMatrix<f64>,
    pub(super) g: DVector<f64>,
    pub(super) back: Vec<Back>,
    pub(super) scores: Vec<DVector<f64>>,
}

impl Reduced {
    /// The damped step; parameters that sit at a bound and would leave it stay.
    pub(super) fn step(
        &self,
        damping: f64,
        parameters: &[Parameter],
        theta: &DVector<f64>,
    ) -> DVector<f64> {
        let free: Vec<usize> = (0..theta.len())
            .filter(|&j| {
                let (at, push) = (theta[j], -self.g[j]);
                !(at <= parameters[j].min && push < 0.0 || at >= parameters[j].max && push > 0.0)
            })
            .collect();
        let k = free.len();
        let mut h = DMatrix::from_fn(k, k, |a, b| self.h[(free[a], free[b])]);
        (0..k).for_each(|a| h[(a, a)] += damping * h[(a, a)]);
        let g = DVector::from_fn(k, |a, _| -self.g[free[a]]);
        let scale = h.diagonal().map(|d| if d > 0.0 { d.sqrt() } else { 1.0 });
        let scaled = DMatrix::from_fn(k, k, |a, b| h[(a, b)] / (scale[a] * scale[b]));
        let step = pseudo_inverse(&scaled) * g.component_div(&scale);
        let mut out = DVector::zeros(theta.len());
        for (a, &j) in free.iter().enumerate() {
            out[j] = step[a] / scale[a];
        }
        out
    }

    pub(super) fn errors(
        &self,
        stretches: &[Stretch<'_>],
        parameters: &[Parameter],
        theta: &DVector<f64>,
    ) -> (Vec<f64>, DMatrix<f64>) {
        let p = theta.len();
        // A parameter held by its bound is known there, not estimated.
        // One on which no residual depends is where its prior has it: the data do not estimate it.
        let seen = |j: usize| self.scores.iter().any(|score| score[j] != 0.0);
        let free: Vec<usize> = (0..p)
            .filter(|&j| theta[j] > parameters[j].min && theta[j] < parameters[j].max && seen(j))
            .collect();
        let k = free.len();
        let h = DMatrix::from_fn(k, k, |a, b| self.h[(free[a], free[b])]);
        let scale = h.diagonal().map(|d| if d > 0.0 { d.sqrt() } else { 1.0 });
        let inverse = pseudo_inverse(&DMatrix::from_fn(k, k, |a, b| {
            h[(a, b)] / (scale[a] * scale[b])
        }));
        let bread = DMatrix::from_fn(k, k, |a, b| inverse[(a, b)] / (scale[a] * scale[b]));
        let mut correlation = DMatrix::identity(p, p);
        for (a, &i) in free.iter().enumerate() {
            for (b, &j) in free.iter().enumerate() {
                correlation[(i, j)] = bread[(a, b)] / (bread[(a, a)] * bread[(b, b)]).sqrt();
            }
        }
        let groups = stretches.iter().map(|s| s.record.group).max().unwrap_or(0) + 1;
        let mut sums = vec![DVector::zeros(k); groups];
        for (stretch, score) in stretches.iter().zip(&self.scores) {
            sums[stretch.record.group] += DVector::from_fn(k, |a, _| score[free[a]]);
        }
        let used = sums.iter().filter(|s| s.iter().any(|v| *v != 0.0)).count();
        let mut meat = DMatrix::zeros(k, k);
        sums.iter().for_each(|s| meat += s * s.transpose());
        let c = used as f64;
        let cov = &bread * meat * &bread * (c / (c - 1.0));
        let mut errors = vec![f64::NAN; p];
        // Fewer groups than parameters leave the middle factor singular, and its errors far too small.
        if used > k.max(1) {
            for (a, &j) in free.iter().enumerate() {
                errors[j] = cov[(a, a)].max(0.0).sqrt();
            }
        }
        (errors, correlation)
    }
}
