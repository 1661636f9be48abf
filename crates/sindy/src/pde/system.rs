//! The weak system of a measured field, and what noise does to it.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::moments::NoisyFields;
use super::term::FieldTerm;
use super::window::{AxisWindows, convolved};
use crate::statistics::gram::Gram;

/// What stands on a side of the equation: derivatives in time and space of a product of the fields.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Quantity {
    powers: Vec<u8>,
    /// Orders by all axes, time first.
    orders: Vec<u8>,
}

impl Quantity {
    /// A candidate term.
    pub(super) fn of_term(term: &FieldTerm) -> Self {
        Self {
            powers: term.powers.clone(),
            orders: [&[0], term.orders.as_slice()].concat(),
        }
    }

    /// The derivative in time of a field.
    pub(super) fn of_field(field: usize, fields: usize, time_order: u8, axes: usize) -> Self {
        let mut powers = vec![0; fields];
        powers[field] = 1;
        let mut orders = vec![0; axes];
        orders[0] = time_order;
        Self { powers, orders }
    }
}

/// A measured field under windows: one row for each window, in the unit of the quantity.
pub(super) struct WeakField<'a> {
    fields: NoisyFields<'a>,
    pub(super) windows: Vec<AxisWindows>,
    quantities: Vec<Quantity>,
    /// By quantity, the value in each window; NaN where a sample is missing.
    pub(super) columns: Vec<Vec<f64>>,
    /// Windows in which no sample is missing.
    pub(super) rows: usize,
}

impl<'a> WeakField<'a> {
    pub(super) fn new(
        fields: NoisyFields<'a>,
        windows: Vec<AxisWindows>,
        quantities: Vec<Quantity>,
    ) -> Self {
        let mut columns = vec![Vec::new(); quantities.len()];
        let mut done = vec![false; quantities.len()];
        for j in 0..quantities.len() {
            if done[j] {
                continue;
            }
            let product = fields.product(&quantities[j].powers);
            let same: Vec<usize> = (j..quantities.len())
                .filter(|&k| quantities[k].powers == quantities[j].powers)
                .collect();
            sums(&windows, &quantities, &product, 0, &same, &mut columns);
            same.iter().for_each(|&k| done[k] = true);
        }
        let windows_in_all = columns.first().map_or(0, Vec::len);
        let mut missing = vec![false; windows_in_all];
        for column in &columns {
            let not = column.iter().map(|v| !v.is_finite());
            missing.iter_mut().zip(not).for_each(|(m, n)| *m |= n);
        }
        for column in &mut columns {
            let cells = column.iter_mut().zip(&missing);
            cells.filter(|(_, m)| **m).for_each(|(v, _)| *v = f64::NAN);
        }
        Self {
            fields,
            windows,
            quantities,
            columns,
            rows: missing.iter().filter(|m| !**m).count(),
        }
    }

    /// Rows that are independent.
    pub(super) fn independent(&self) -> f64 {
        let share: f64 = self.windows.iter().map(AxisWindows::independent).product();
        self.rows as f64 * share
    }

    /// The statistics of `target` over `terms`, places among the quantities.
    pub(super) fn gram(&self, terms: &[usize], target: usize) -> Gram {
        let mut gram = Gram::zeros(terms.len());
        let kept: Vec<usize> = (0..self.columns[target].len())
            .filter(|&k| self.columns[target][k].is_finite())
            .collect();
        let column = |j: usize| kept.iter().map(move |&k| self.columns[j][k]);
        let theta = DMatrix::from_iterator(
            kept.len(),
            terms.len(),
            terms.iter().flat_map(|&j| column(j)),
        );
        let y = DVector::from_iterator(kept.len(), column(target));
        gram.xtx = theta.tr_mul(&theta);
        gram.xty = theta.tr_mul(&y);
        gram.yty = y.norm_squared();
        gram.sum_y = y.sum();
        gram.rows = kept.len();
        gram.skipped = self.columns[target].len() - kept.len();
        gram
    }

    /// `Σ` over the windows of the covariance of the noise of all quantities.
    pub(super) fn noise(&self) -> DMatrix<f64> {
        let n = self.quantities.len();
        let whole = self.columns.first().map_or(1, Vec::len).max(1);
        let share = self.rows as f64 / whole as f64;
        let mut pairs: Vec<(usize, usize)> =
            (0..n).flat_map(|a| (a..n).map(move |b| (a, b))).collect();
        let mut groups = Vec::new();
        let powers =
            |(a, b): (usize, usize)| (&self.quantities[a].powers, &self.quantities[b].powers);
        while let Some(&first) = pairs.first() {
            // All pairs of the same products, with whatever derivatives.
            let (same, others) = pairs.iter().partition(|p| powers(**p) == powers(first));
            pairs = others;
            let same: Vec<(usize, usize)> = same;
            groups.push(same);
        }
        let sums = groups.par_iter().flat_map_iter(|same| {
            let (a, b) = powers(same[0]);
            let covariance = self.fields.covariance(a, b);
            let mut sums = Vec::with_capacity(same.len());
            self.weighted(&covariance, self.windows.len(), same, &mut sums);
            sums
        });
        let mut out = DMatrix::zeros(n, n);
        for ((a, b), sum) in sums.collect::<Vec<_>>() {
            out[(a, b)] = share * sum;
            out[(b, a)] = share * sum;
        }
        out
    }

    /// For each pair of quantities the sum of `values`, each weighted by how much of the windows of both lies on it. Axes from
    /// `axis` on are summed already.
    fn weighted(
        &self,
        values: &[f64],
        axis: usize,
        pairs: &[(usize, usize)],
        out: &mut Vec<((usize, usize), f64)>,
    ) {
        let Some(axis) = axis.checked_sub(1) else {
            out.extend(pairs.iter().map(|p| (*p, values[0])));
            return;
        };
        let orders = |(a, b): &(usize, usize)| {
            let of = |j: usize| self.quantities[j].orders[axis];
            (of(*a).min(of(*b)), of(*a).max(of(*b)))
        };
        let mut kinds: Vec<(u8, u8)> = pairs.iter().map(orders).collect();
        kinds.sort_unstable();
        kinds.dedup();
        for kind in kinds {
            let overlap =
                self.windows[axis].overlap(kind.0, kind.1, &self.fields.correlations[axis]);
            let lines = values.chunks_exact(overlap.len());
            let summed: Vec<f64> = lines
                .map(|line| line.iter().zip(&overlap).map(|(v, o)| v * o).sum())
                .collect();
            let same: Vec<(usize, usize)> = pairs
                .iter()
                .copied()
                .filter(|p| orders(p) == kind)
                .collect();
            self.weighted(&summed, axis, &same, out);
        }
    }

    /// The covariance of `Σ_k θ_kj r_k`, j in `terms`, from the noise in the residual `r = Σ_l c_l q_l` of `quantities` with
    /// these coefficients, to first order in the noise.
    pub(super) fn score_covariance(
        &self,
        terms: &[usize],
        residual: &[(usize, f64)],
    ) -> DMatrix<f64> {
        let s = terms.len();
        let mut out = DMatrix::zeros(s, s);
        let mut orders: Vec<&Vec<u8>> = Vec::new();
        for (l, _) in residual {
            let own = &self.quantities[*l].orders;
            if !orders.contains(&own) {
                orders.push(own);
            }
        }
        let points = self.fields.data.points();
        for field in 0..self.fields.data.names().len() {
            // By orders, how the residual's density changes with this field.
            let slopes: Vec<Vec<f64>> = orders
                .iter()
                .map(|orders| {
                    let mut sum = vec![0.0; points];
                    let own = residual
                        .iter()
                        .filter(|(l, _)| self.quantities[*l].orders == **orders);
                    for (l, c) in own {
                        let slope = self.fields.derivative(&self.quantities[*l].powers, field);
                        sum.iter_mut().zip(slope).for_each(|(s, v)| *s += c * v);
                    }
                    sum
                })
                .collect();
            let influence: Vec<Vec<f64>> = terms
                .iter()
                .map(|&j| {
                    let mut influence = vec![0.0; points];
                    for (orders, slope) in orders.iter().zip(&slopes) {
                        let spread = self.spread(j, orders);
                        for ((i, s), z) in influence.iter_mut().zip(slope).zip(spread) {
                            *i += if s.is_finite() { s * z } else { 0.0 };
                        }
                    }
                    influence
                })
                .collect();
            let shared: Vec<Vec<f64>> = influence.iter().map(|i| self.correlated(i)).collect();
            for a in 0..s {
                for b in a..s {
                    let pairs = influence[a].iter().zip(&shared[b]);
                    let sum = self.fields.variances[field] * pairs.map(|(x, y)| x * y).sum::<f64>();
                    out[(a, b)] += sum;
                    out[(b, a)] = out[(a, b)];
                }
            }
        }
        out
    }

    /// The sum over all samples of their correlation with each, times `values`.
    fn correlated(&self, values: &[f64]) -> Vec<f64> {
        let mut out = values.to_vec();
        let mut inner = 1;
        for (axis, correlation) in self.fields.correlations.iter().enumerate().rev() {
            let line = inner * self.fields.data.axes()[axis].points();
            if correlation.len() > 1 {
                let lines = out.par_chunks_mut(line);
                lines.for_each(|l| l.copy_from_slice(&convolved(l, inner, correlation)));
            }
            inner = line;
        }
        out
    }

    /// `Σ_k θ_kj w(i - k)` at every sample, with the weights of these orders.
    fn spread(&self, term: usize, orders: &[u8]) -> Vec<f64> {
        let finite = |v: &f64| if v.is_finite() { *v } else { 0.0 };
        let mut values: Vec<f64> = self.columns[term].iter().map(finite).collect();
        let mut inner = 1;
        for (axis, windows) in self.windows.iter().enumerate().rev() {
            values = windows.spread(&values, inner, orders[axis]);
            inner *= self.fields.data.axes()[axis].points();
        }
        values
    }
}

/// Sums of `data` over the windows of all axes from `axis` on, for quantities that share the sums before; `data` is in the
/// order of windows before `axis` and samples from it on.
fn sums(
    windows: &[AxisWindows],
    quantities: &[Quantity],
    data: &[f64],
    axis: usize,
    of: &[usize],
    columns: &mut [Vec<f64>],
) {
    let Some(own) = windows.get(axis) else {
        of.iter().for_each(|&j| columns[j] = data.to_vec());
        return;
    };
    let inner: usize = windows[axis + 1..]
        .iter()
        .map(AxisWindows::points)
        .product();
    let mut orders: Vec<u8> = of.iter().map(|&j| quantities[j].orders[axis]).collect();
    orders.sort_unstable();
    orders.dedup();
    for order in orders {
        let summed = own.sum(data, inner, order);
        let same: Vec<usize> = of
            .iter()
            .copied()
            .filter(|&j| quantities[j].orders[axis] == order)
            .collect();
        sums(windows, quantities, &summed, axis + 1, &same, columns);
    }
}
