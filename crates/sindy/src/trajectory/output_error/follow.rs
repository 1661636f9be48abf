//! A model followed through the data: simulation from node to node, and what is judged by it.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::colour::Whitener;
use super::record::Record;
use super::system::{Step, System, Work, multiply};

/// Steps of the integrator between samples, at most. Samples that need more are too coarse for any choice of terms; half of
/// it stops stiff systems short of [`INTEGRATION`].
const MOST_SUBSTEPS: usize = 32;
/// Error of the integrator from one node to the next that is accepted, in units of the noise: over a hundred nodes it adds
/// up to at most a third of the noise.
pub(super) const INTEGRATION: f64 = 0.003;
/// Nodes that the integrator's error is tried at, about: enough for a mean to a tenth, at a small part of a step's time.
const TRIED: usize = 200;

/// A state moves if its spread exceeds this multiple of its noise: that of noise over 25 rows is within 1.5.
const MOVES: f64 = 2.0;

/// How arcs are cut and simulated.
#[derive(Clone, Copy, Debug)]
pub(super) struct ArcSettings {
    /// An arc ends where a change of its start has grown by this factor.
    pub growth: f64,
    /// Nodes of an arc, at most.
    pub longest: usize,
    /// Steps of the integrator between samples.
    pub substeps: usize,
}

/// A model that is followed through the data.
#[derive(Clone, Copy)]
pub(super) struct Follow<'a> {
    pub system: &'a System,
    /// Of all candidates.
    pub coefficients: &'a [f64],
    /// Noise of each state.
    pub sigma: &'a [f64],
    /// How much of it each measured state remembers.
    pub colour: &'a [f64],
    pub cut: ArcSettings,
}

/// `M` and `d`: how a point of the trajectory moves with the arc's start and the coefficients.
pub(super) struct Sensitivity {
    /// n x (n + P).
    pub m: DMatrix<f64>,
    /// n: by closing the defects before it.
    pub d: DVector<f64>,
    /// Where a step writes the next of both.
    next: (DMatrix<f64>, DVector<f64>),
}

impl Sensitivity {
    /// At the start of an arc of n states under p coefficients.
    pub(super) fn start(n: usize, p: usize) -> Self {
        let mut m = DMatrix::zeros(n, n + p);
        (0..n).for_each(|i| m[(i, i)] = 1.0);
        let d = DVector::zeros(n);
        Self {
            next: (m.clone(), d.clone()),
            m,
            d,
        }
    }

    /// Over a step.
    pub(super) fn advance(&mut self, step: &Step) {
        let (m, d) = &mut self.next;
        multiply(&step.transition, &self.m, m);
        d.gemv(1.0, &step.transition, &self.d, 0.0);
        std::mem::swap(&mut self.m, m);
        std::mem::swap(&mut self.d, d);
        let mut of_coefficients = self.m.columns_mut(self.d.len(), step.forcing.ncols());
        of_coefficients += &step.forcing;
    }
}

impl Follow<'_> {
    /// Noise that a vector of residuals or defects is measured by.
    fn size(&self, i: usize, difference: f64) -> f64 {
        (difference / self.sigma[i]).powi(2)
    }

    /// What changes of a record's states are measured by: their noise, all as large beside their spread as the largest. Of a position
    /// without noise whose velocity is noisy any change is large beside its own. A state at rest has no spread but its noise.
    pub(super) fn scales(&self, record: &Record) -> Vec<f64> {
        let spread: Vec<f64> = record.spread.iter().map(|v| v.sqrt()).collect();
        let moving = self.sigma.iter().zip(&spread);
        let moving = moving.filter(|(sigma, spread)| **spread > MOVES * **sigma);
        let share = moving.map(|(sigma, spread)| sigma / spread);
        let largest = share.fold(0.0, f64::max);
        let all = self.sigma.iter().zip(&spread);
        all.map(|(sigma, spread)| sigma.max(largest * spread))
            .collect()
    }

    /// From sample `row` to the next, in `substeps`; the sensitivities along with it where they are given.
    pub(super) fn advance(
        &self,
        record: &Record,
        row: usize,
        substeps: usize,
        x: &mut [f64],
        (work, step): (&mut Work, &mut Step),
        mut along: Option<&mut Sensitivity>,
    ) {
        if self.system.stiff {
            self.advance_implicitly(record, row, x, (work, step), along);
            return;
        }
        let h = (record.time[row + 1] - record.time[row]) / substeps as f64;
        for k in 0..substeps {
            let at = |offset: f64| record.inputs_at(row, (k as f64 + offset) / substeps as f64);
            let (start, middle, end) = (at(0.0), at(0.5), at(1.0));
            let over = (h, [&start[..], &middle, &end]);
            self.system.step(x, over, along.is_some(), work, step);
            x.copy_from_slice(&step.state);
            if let Some(s) = &mut along {
                s.advance(step);
            }
        }
    }

    /// As [`Self::advance`], of the state alone and in the cut's steps.
    fn advance_state(
        &self,
        record: &Record,
        row: usize,
        x: &mut [f64],
        scratch: (&mut Work, &mut Step),
    ) {
        self.advance(record, row, self.cut.substeps, x, scratch, None);
    }

    /// Sum of squares of each measured state's residuals (0 of the others), and of the defects over the noise, over the given arcs,
    /// each with its record, first node and number of nodes: `(record, first, nodes)`.
    pub(super) fn judge(
        &self,
        records: &[Record],
        arcs: impl Iterator<Item = (usize, usize, usize)>,
    ) -> Option<(Vec<f64>, f64)> {
        let arcs: Vec<_> = arcs.collect();
        let parts: Vec<_> = arcs
            .into_par_iter()
            .map(|(index, first, nodes)| self.judge_arc(&records[index], first..first + nodes))
            .collect();
        let mut misfit = vec![0.0; self.system.n];
        let mut defects = 0.0;
        // In order, so that the number of threads changes no digit.
        for part in parts {
            let (own, own_defects) = part?;
            misfit.iter_mut().zip(own).for_each(|(sum, m)| *sum += m);
            defects += own_defects;
        }
        Some((misfit, defects))
    }

    fn judge_arc(&self, record: &Record, nodes: Range<usize>) -> Option<(Vec<f64>, f64)> {
        let mut misfit = vec![0.0; self.system.n];
        let mut defects = 0.0;
        let (mut work, mut step) = (self.system.work(self.coefficients), self.system.blank());
        let mut whitener = Whitener::new(self.colour);
        let mut compare = |x: &[f64], row: usize| {
            if record.root_weight(row) == 0.0 {
                return;
            }
            for (i, x) in x.iter().take(self.system.measured).enumerate() {
                let Some(sample) = record.sample(i, row) else {
                    continue;
                };
                let mut residual = [record.residual(i, row, *x)];
                whitener.apply(i, sample, &mut residual);
                misfit[i] += residual[0].powi(2);
            }
        };
        for node in nodes.clone() {
            let mut x = record.nodes[node].clone();
            let (from, to) = record.between(node);
            if node == nodes.start {
                compare(&x, from);
            }
            let goes_on = node + 1 < nodes.end;
            for row in from..to {
                self.advance_state(record, row, &mut x, (&mut work, &mut step));
                if row + 1 < to || goes_on || record.is_last(node) {
                    compare(&x, row + 1);
                }
            }
            if !x.iter().all(|v| v.is_finite()) {
                return None;
            }
            if goes_on {
                let next = &record.nodes[node + 1];
                defects += (0..x.len())
                    .map(|i| self.size(i, x[i] - next[i]))
                    .sum::<f64>();
            }
        }
        Some((misfit, defects))
    }

    /// Residuals of every record and measured state, by sample, as the nodes stand, in units of the data.
    pub(super) fn residuals(&self, records: &[Record]) -> Vec<Vec<Vec<f64>>> {
        let (mut work, mut step) = (self.system.work(self.coefficients), self.system.blank());
        let mut all = Vec::new();
        for record in records {
            let mut of = vec![Vec::with_capacity(record.time.len()); self.system.measured];
            for (node, x) in record.nodes.iter().enumerate() {
                let mut x = x.clone();
                let (from, to) = record.between(node);
                for row in from..to + usize::from(record.is_last(node)) {
                    for (i, of) in of.iter_mut().enumerate() {
                        if record.sample(i, row).is_some() {
                            of.push(record.residual(i, row, x[i]));
                        }
                    }
                    if row < to {
                        self.advance_state(record, row, &mut x, (&mut work, &mut step));
                    }
                }
            }
            all.push(of);
        }
        all
    }

    /// Root mean square, in units of the noise, of simulations over `cut.longest` nodes from where nodes are;
    /// infinite where one leaves the finite numbers.
    pub(super) fn free_run(&self, records: &[Record]) -> f64 {
        let (mut work, mut step) = (self.system.work(self.coefficients), self.system.blank());
        let (mut sum, mut count) = (0.0, 0usize);
        for record in records {
            for first in (0..record.rows.len()).step_by(self.cut.longest) {
                let mut x = record.nodes[first].clone();
                let end = record.rows.get(first + self.cut.longest).copied();
                for row in record.rows[first]..end.unwrap_or(record.time.len() - 1) {
                    self.advance_state(record, row, &mut x, (&mut work, &mut step));
                    if !x.iter().all(|v| v.is_finite()) {
                        return f64::INFINITY;
                    }
                    for (i, x) in x.iter().take(self.system.measured).enumerate() {
                        if record.sample(i, row + 1).is_some() {
                            sum += self.size(i, record.residual(i, row + 1, *x));
                            count += 1;
                        }
                    }
                }
            }
        }
        if sum.is_finite() {
            (sum / count.max(1) as f64).sqrt()
        } else {
            f64::INFINITY
        }
    }

    /// Steps of the integrator between samples, doubled from those of the cut until its error is small beside the noise.
    pub(super) fn fine_substeps(mut self, records: &[Record]) -> usize {
        // An implicit integrator has steps of its own, a map has none.
        if self.system.stiff || self.system.discrete {
            return self.cut.substeps;
        }
        while self.cut.substeps < MOST_SUBSTEPS && self.integration_error(records) > INTEGRATION {
            self.cut.substeps *= 2;
        }
        self.cut.substeps
    }

    /// Root mean square over nodes, largest over states: how far half the step takes the simulation from node
    /// to node elsewhere, in units of the noise.
    fn integration_error(&self, records: &[Record]) -> f64 {
        let (mut work, mut step) = (self.system.work(self.coefficients), self.system.blank());
        let mut squares = vec![0.0; self.system.n];
        let mut count = 0usize;
        let nodes: usize = records.iter().map(|r| r.rows.len()).sum();
        for record in records {
            for node in (0..record.rows.len()).step_by(nodes.div_ceil(TRIED).max(1)) {
                let (from, to) = record.between(node);
                let mut end = |substeps: usize| {
                    let mut x = record.nodes[node].clone();
                    for row in from..to {
                        self.advance(record, row, substeps, &mut x, (&mut work, &mut step), None);
                    }
                    x
                };
                let (coarse, fine) = (end(self.cut.substeps), end(2 * self.cut.substeps));
                for (i, square) in squares.iter_mut().enumerate() {
                    *square += self.size(i, coarse[i] - fine[i]);
                }
                count += 1;
            }
        }
        let worst = squares.into_iter().fold(0.0, f64::max);
        (worst / count.max(1) as f64).sqrt()
    }
}
