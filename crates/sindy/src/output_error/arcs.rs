//! Arcs: pieces of the data over which one trajectory of the model is followed, linearised.
//!
//! An arc starts freely and runs through nodes a few samples apart. Between nodes the model is simulated;
//! at a node the simulation may miss the next node's state by a *defect*, which the linearisation closes:
//!
//! ```text
//! δs_{k+1} = A_k δs_k + B_k δξ + c_k,     c_k the defect,    hence    δs_k = M_k (δs_0, δξ) + d_k
//! ```
//!
//! so that all residuals of an arc are linear in its start and the coefficients, however long it is.

use nalgebra::{DMatrix, DVector};

use super::system::System;

/// Samples from one node to the next, at most.
const NODE: usize = 10;
/// Nodes are so close that states change by this share of their scatter in between (root mean square).
const CHANGE: f64 = 0.3;
/// Columns of residuals are added to the normal equations so many rows at a time.
const CHUNK: usize = 192;

/// One stretch of data as the search sees it.
pub(super) struct Record {
    pub time: Vec<f64>,
    /// One column for each state.
    pub states: Vec<Vec<f64>>,
    /// By row: inputs at the sample.
    pub inputs: Vec<Vec<f64>>,
    /// The states at the nodes, as they are estimated now.
    pub nodes: Vec<Vec<f64>>,
    /// The rows of the nodes, the first of them 0.
    pub rows: Vec<usize>,
}

impl Record {
    pub(super) fn new(
        time: &[f64],
        states: &[&[f64]],
        inputs: &[&[f64]],
        smooth: &[Vec<f64>],
    ) -> Self {
        let n = time.len();
        let pace = smooth.iter().map(|c| pace(c)).fold(0.0, f64::max);
        let node = ((CHANGE / pace) as usize).clamp(1, NODE);
        let rows: Vec<usize> = (0..n.saturating_sub(1)).step_by(node).collect();
        Self {
            time: time.to_vec(),
            states: states.iter().map(|c| c.to_vec()).collect(),
            inputs: (0..n)
                .map(|i| inputs.iter().map(|c| c[i]).collect())
                .collect(),
            nodes: rows
                .iter()
                .map(|&r| smooth.iter().map(|c| c[r]).collect())
                .collect(),
            rows,
        }
    }
}

/// Root mean square of the steps of a signal over its standard deviation.
fn pace(x: &[f64]) -> f64 {
    let n = x.len() as f64;
    let mean = x.iter().sum::<f64>() / n;
    let variance = x.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n;
    let steps = x.windows(2).map(|w| (w[1] - w[0]).powi(2)).sum::<f64>() / n;
    if variance > 0.0 { (steps / variance).sqrt() } else { 0.0 }
}

/// How arcs are cut and simulated.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cut {
    /// An arc ends where a change of its start has grown by this factor.
    pub growth: f64,
    /// Nodes of an arc, at most.
    pub longest: usize,
    /// Steps of the integrator between samples.
    pub substeps: usize,
}

/// The normal equations over the coefficients of all candidates, arcs' starts eliminated, and the sums
/// that judge the point they were taken at.
pub(super) struct Normal {
    /// P x P.
    pub xtx: DMatrix<f64>,
    /// P: products with the residuals that the linearisation predicts at δξ = 0.
    pub xty: DVector<f64>,
    /// Their sum of squares.
    pub yty: f64,
    /// Sum of squares of each state's residuals as simulated from the nodes, in its unit squared.
    pub misfit: Vec<f64>,
    /// Samples that were compared, for each state.
    pub rows: usize,
    /// Sum of squares of the defects over the noise.
    pub defects: f64,
    /// Arcs.
    pub arcs: usize,
    /// How nodes follow from the coefficients.
    moves: Vec<ArcMoves>,
}

/// What one arc's nodes do when coefficients change.
struct ArcMoves {
    record: usize,
    first: usize,
    /// δs_0 = `start` - `by` δξ.
    start: DVector<f64>,
    by: DMatrix<f64>,
    /// For each node: M (n x (n+P)) and d (n).
    nodes: Vec<(DMatrix<f64>, DVector<f64>)>,
}

/// Linearises all records around their nodes and `coefficients`. Where `breaks` are known, the nodes that
/// arcs start from, they are kept; otherwise arcs are cut by `cut` and `breaks` set. `None` where the
/// simulation leaves the finite numbers.
pub(super) fn linearise(
    system: &System,
    records: &[Record],
    coefficients: &[f64],
    sigma: &[f64],
    cut: Cut,
    breaks: &mut Option<Vec<Vec<usize>>>,
) -> Option<Normal> {
    let (n, p) = (system.n, system.size());
    let mut out = Normal {
        xtx: DMatrix::zeros(p, p),
        xty: DVector::zeros(p),
        yty: 0.0,
        misfit: vec![0.0; n],
        rows: 0,
        defects: 0.0,
        arcs: 0,
        moves: Vec::new(),
    };
    for (index, record) in records.iter().enumerate() {
        let mut first = 0;
        while first < record.rows.len() {
            let until = breaks.as_ref().map(|b| {
                let next = b[index].iter().copied().find(|&k| k > first);
                next.unwrap_or(record.rows.len())
            });
            first = arc(system, record, index, first, until, coefficients, sigma, cut, &mut out)?;
        }
    }
    if breaks.is_none() {
        let mut found = vec![Vec::new(); records.len()];
        for arc in &out.moves {
            found[arc.record].push(arc.first);
        }
        *breaks = Some(found);
    }
    Some(out)
}

/// One arc from node `first`; returns the node that the next one starts from.
#[allow(clippy::too_many_arguments)]
fn arc(
    system: &System,
    record: &Record,
    index: usize,
    first: usize,
    until: Option<usize>,
    coefficients: &[f64],
    sigma: &[f64],
    cut: Cut,
    out: &mut Normal,
) -> Option<usize> {
    let (n, p) = (system.n, system.size());
    let columns = n + p;
    let mut sums = Sums::new(columns);
    let mut work = system.work();
    let mut step = system.blank();
    // M and d at the node, then at the sample.
    let mut m = DMatrix::<f64>::zeros(n, columns);
    (0..n).for_each(|i| m[(i, i)] = 1.0);
    let mut d = DVector::<f64>::zeros(n);
    let mut moves = Vec::new();
    let mut node = first;
    loop {
        moves.push((m.clone(), d.clone()));
        let from = record.rows[node];
        let last = node + 1 == record.rows.len();
        let to = if last {
            record.time.len() - 1
        } else {
            record.rows[node + 1]
        };
        let mut x = record.nodes[node].clone();
        if node == first {
            add_row(record, from, &x, &m, &d, sigma, &mut sums, out);
        }
        for row in from..to {
            simulate(
                system,
                record,
                row,
                cut.substeps,
                coefficients,
                &mut x,
                &mut work,
                &mut step,
                Some((&mut m, &mut d)),
            );
            if !x.iter().all(|v| v.is_finite()) || !m.iter().all(|v| v.is_finite()) {
                return None;
            }
            // The sample at the next arc's first node belongs to that arc as well: its start is free.
            add_row(record, row + 1, &x, &m, &d, sigma, &mut sums, out);
        }
        if last {
            node += 1;
            break;
        }
        let growth = (0..n)
            .flat_map(|i| (0..n).map(move |j| (i, j)))
            .map(|(i, j)| (m[(i, j)] * sigma[j] / sigma[i]).abs())
            .fold(0.0, f64::max);
        node += 1;
        let ends = until.map_or(
            growth > cut.growth || node - first >= cut.longest,
            |until| node == until,
        );
        if ends {
            break;
        }
        for i in 0..n {
            let defect = x[i] - record.nodes[node][i];
            d[i] += defect;
            out.defects += (defect / sigma[i]).powi(2);
        }
    }
    sums.finish();
    let (start, by) = sums.eliminate(n, out)?;
    out.arcs += 1;
    out.moves.push(ArcMoves {
        record: index,
        first,
        start,
        by,
        nodes: moves,
    });
    Some(node)
}

/// From sample `row` to the next, in substeps; the sensitivities along with it where they are given.
#[allow(clippy::too_many_arguments)]
fn simulate(
    system: &System,
    record: &Record,
    row: usize,
    substeps: usize,
    coefficients: &[f64],
    x: &mut [f64],
    work: &mut super::system::Work,
    step: &mut super::system::Step,
    mut sensitivities: Option<(&mut DMatrix<f64>, &mut DVector<f64>)>,
) {
    let (u0, u1) = (&record.inputs[row], &record.inputs[row + 1]);
    let h = (record.time[row + 1] - record.time[row]) / substeps as f64;
    let between = |part: f64| -> Vec<f64> {
        u0.iter().zip(u1).map(|(a, b)| a + part * (b - a)).collect()
    };
    for k in 0..substeps {
        let part = |offset: f64| (k as f64 + offset) / substeps as f64;
        let (start, middle, end) = (between(part(0.0)), between(part(0.5)), between(part(1.0)));
        system.step(
            x,
            h,
            [&start, &middle, &end],
            coefficients,
            sensitivities.is_some(),
            work,
            step,
        );
        x.copy_from_slice(&step.state);
        if let Some((m, d)) = &mut sensitivities {
            let mut next = &step.transition * &**m;
            let n = x.len();
            let mut of_coefficients = next.columns_mut(n, step.forcing.ncols());
            of_coefficients += &step.forcing;
            **m = next;
            **d = &step.transition * &**d;
        }
    }
}

#[allow(clippy::too_many_arguments)]
fn add_row(
    record: &Record,
    row: usize,
    x: &[f64],
    m: &DMatrix<f64>,
    d: &DVector<f64>,
    sigma: &[f64],
    sums: &mut Sums,
    out: &mut Normal,
) {
    out.rows += 1;
    for (i, x) in x.iter().enumerate() {
        let residual = record.states[i][row] - x;
        out.misfit[i] += residual * residual;
        sums.push(m.row(i).iter().map(|v| v / sigma[i]), (residual - d[i]) / sigma[i]);
    }
}

/// `[X | y]ᵀ [X | y]` of an arc, gathered in chunks.
struct Sums {
    columns: usize,
    chunk: DMatrix<f64>,
    filled: usize,
    total: DMatrix<f64>,
}

impl Sums {
    fn new(columns: usize) -> Self {
        Self {
            columns,
            chunk: DMatrix::zeros(columns + 1, CHUNK),
            filled: 0,
            total: DMatrix::zeros(columns + 1, columns + 1),
        }
    }

    fn push(&mut self, row: impl Iterator<Item = f64>, y: f64) {
        let mut column = self.chunk.column_mut(self.filled);
        for (to, v) in column.iter_mut().zip(row.chain(std::iter::once(y))) {
            *to = v;
        }
        self.filled += 1;
        if self.filled == CHUNK {
            self.flush();
        }
    }

    fn flush(&mut self) {
        let part = self.chunk.columns(0, self.filled);
        self.total += part * part.transpose();
        self.filled = 0;
    }

    fn finish(&mut self) {
        if self.filled > 0 {
            self.flush();
        }
    }

    /// Eliminates the arc's start and adds what is left to `out`.
    fn eliminate(&self, n: usize, out: &mut Normal) -> Option<(DVector<f64>, DMatrix<f64>)> {
        let p = self.columns - n;
        let t = &self.total;
        let a = t.view((0, 0), (n, n)).into_owned();
        let b = t.view((0, n), (n, p)).into_owned();
        let y = t.view((0, n + p), (n, 1)).into_owned();
        let cholesky = a.cholesky()?;
        let by = cholesky.solve(&b);
        let start = cholesky.solve(&y);
        out.xtx += t.view((n, n), (p, p)) - b.transpose() * &by;
        out.xty += t.view((n, n + p), (p, 1)) - b.transpose() * &start;
        out.yty += t[(n + p, n + p)] - y.dot(&start);
        Some((start.column(0).into_owned(), by))
    }
}

impl Normal {
    /// Moves the records' nodes by `part` of the step that goes with `change` of the coefficients.
    pub(super) fn move_nodes(&self, records: &mut [Record], change: &DVector<f64>, part: f64) {
        for arc in &self.moves {
            let n = arc.start.len();
            let mut all = DVector::zeros(n + change.len());
            all.rows_mut(0, n).copy_from(&(&arc.start - &arc.by * change));
            all.rows_mut(n, change.len()).copy_from(change);
            for (k, (m, d)) in arc.nodes.iter().enumerate() {
                let shift = m * &all + d;
                let node = &mut records[arc.record].nodes[arc.first + k];
                for (s, shift) in node.iter_mut().zip(shift.iter()) {
                    *s += part * shift;
                }
            }
        }
    }
}

/// Sum of squares of each state's residuals, and of the defects over the noise, without sensitivities,
/// where arcs are cut as in `normal`.
pub(super) fn judge(
    system: &System,
    records: &[Record],
    coefficients: &[f64],
    sigma: &[f64],
    cut: Cut,
    normal: &Normal,
) -> Option<(Vec<f64>, f64)> {
    let mut misfit = vec![0.0; system.n];
    let mut defects = 0.0;
    let mut work = system.work();
    let mut step = system.blank();
    for arc in &normal.moves {
        let record = &records[arc.record];
        for k in 0..arc.nodes.len() {
            let node = arc.first + k;
            let mut x = record.nodes[node].clone();
            let from = record.rows[node];
            let to = record
                .rows
                .get(node + 1)
                .copied()
                .unwrap_or(record.time.len() - 1);
            let mut compare = |x: &[f64], row: usize| {
                for (i, x) in x.iter().enumerate() {
                    misfit[i] += (record.states[i][row] - x).powi(2);
                }
            };
            if k == 0 {
                compare(&x, from);
            }
            for row in from..to {
                simulate(
                    system, record, row, cut.substeps, coefficients, &mut x, &mut work, &mut step,
                    None,
                );
                compare(&x, row + 1);
            }
            if !x.iter().all(|v| v.is_finite()) {
                return None;
            }
            if k + 1 < arc.nodes.len() {
                defects += (0..system.n)
                    .map(|i| ((x[i] - record.nodes[node + 1][i]) / sigma[i]).powi(2))
                    .sum::<f64>();
            }
        }
    }
    Some((misfit, defects))
}

/// Root mean square over nodes, largest over states: how far half the step takes the simulation from node to
/// node elsewhere, in units of the noise. At most some hundred nodes are tried.
pub(super) fn integration_error(
    system: &System,
    records: &[Record],
    coefficients: &[f64],
    sigma: &[f64],
    substeps: usize,
) -> f64 {
    let mut work = system.work();
    let mut step = system.blank();
    let mut squares = vec![0.0; system.n];
    let mut count = 0;
    let stride = records.iter().map(|r| r.rows.len()).sum::<usize>().div_ceil(200).max(1);
    for record in records {
        for node in (0..record.rows.len().saturating_sub(1)).step_by(stride) {
            let mut end = |substeps: usize| {
                let mut x = record.nodes[node].clone();
                for row in record.rows[node]..record.rows[node + 1] {
                    simulate(
                        system, record, row, substeps, coefficients, &mut x, &mut work, &mut step,
                        None,
                    );
                }
                x
            };
            let (coarse, fine) = (end(substeps), end(2 * substeps));
            for i in 0..system.n {
                squares[i] += ((coarse[i] - fine[i]) / sigma[i]).powi(2);
            }
            count += 1;
        }
    }
    let worst = squares.into_iter().fold(0.0, f64::max);
    (worst / f64::from(count.max(1))).sqrt()
}
