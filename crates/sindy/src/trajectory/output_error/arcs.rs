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
use rayon::prelude::*;

use super::colour::Whitener;
use super::follow::{Follow, Sensitivity};
use super::record::Record;

/// Rows of residuals that are added to the normal equations at once. The value affects only speed.
const CHUNK: usize = 192;
/// Arcs, or records, that are linearised side by side before their sums are added up in order, so that the number of threads changes
/// no digit. Each holds a matrix of P x P.
const BATCH: usize = 32;

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
    /// Samples of each measured state that were compared.
    pub samples: Vec<usize>,
    /// Sum of squares of the defects over the noise.
    pub defects: f64,
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

/// Linearises all records around their nodes and the model's coefficients. Where `breaks` are known, the
/// nodes that arcs start from, they are kept; otherwise arcs are cut by the rule and `breaks` set. `None`
/// where the simulation leaves the finite numbers.
pub(super) fn linearise(
    follow: &Follow<'_>,
    records: &[Record],
    breaks: &mut Option<Vec<Vec<usize>>>,
) -> Option<Normal> {
    let tasks: Vec<Task> = match breaks {
        Some(breaks) => breaks
            .iter()
            .enumerate()
            .flat_map(|(record, starts)| {
                let ends = starts.iter().skip(1).map(|&end| Some(end));
                let arcs = starts.iter().zip(ends.chain([None]));
                arcs.map(move |(&first, until)| Task {
                    record,
                    first,
                    until: until.or(Some(usize::MAX)),
                })
            })
            .collect(),
        None => (0..records.len())
            .map(|record| Task {
                record,
                first: 0,
                until: None,
            })
            .collect(),
    };
    let mut out = Normal::zeros(follow);
    for batch in tasks.chunks(BATCH) {
        let parts: Vec<Option<Normal>> = batch
            .par_iter()
            .map(|task| Normal::of(follow, &records[task.record], task))
            .collect();
        for part in parts {
            out.merge(part?);
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

/// What is linearised by itself.
struct Task {
    record: usize,
    /// The node that it starts from.
    first: usize,
    /// The node that the one arc of the task ends at, beyond the record for its last arc; `None` where arcs are cut by the rule, to
    /// the record's end.
    until: Option<usize>,
}

impl Normal {
    fn zeros(follow: &Follow<'_>) -> Self {
        let (n, p) = (follow.system.n, follow.system.size());
        Self {
            xtx: DMatrix::zeros(p, p),
            xty: DVector::zeros(p),
            yty: 0.0,
            misfit: vec![0.0; n],
            samples: vec![0; follow.system.measured],
            defects: 0.0,
            moves: Vec::new(),
        }
    }

    fn of(follow: &Follow<'_>, record: &Record, task: &Task) -> Option<Self> {
        let mut out = Self::zeros(follow);
        let mut first = task.first;
        loop {
            first = out.arc(follow, record, (task.record, first), task.until)?;
            if task.until.is_some() || first >= record.rows.len() {
                return Some(out);
            }
        }
    }

    fn merge(&mut self, part: Self) {
        self.xtx += part.xtx;
        self.xty += part.xty;
        self.yty += part.yty;
        self.misfit
            .iter_mut()
            .zip(part.misfit)
            .for_each(|(sum, misfit)| *sum += misfit);
        self.samples
            .iter_mut()
            .zip(part.samples)
            .for_each(|(sum, samples)| *sum += samples);
        self.defects += part.defects;
        self.moves.extend(part.moves);
    }

    /// Arcs.
    pub(super) fn arcs(&self) -> usize {
        self.moves.len()
    }

    /// Whether an arc has as many nodes.
    pub(super) fn reaches(&self, nodes: usize) -> bool {
        self.moves.iter().any(|a| a.nodes.len() >= nodes)
    }

    /// The arcs as record, first node and number of nodes.
    pub(super) fn cuts(&self) -> impl Iterator<Item = (usize, usize, usize)> {
        self.moves
            .iter()
            .map(|a| (a.record, a.first, a.nodes.len()))
    }

    /// One arc from node `first`, to node `until` if that is known; returns the node that the next starts from.
    fn arc(
        &mut self,
        follow: &Follow<'_>,
        record: &Record,
        (index, first): (usize, usize),
        until: Option<usize>,
    ) -> Option<usize> {
        let system = follow.system;
        let (n, p) = (system.n, system.size());
        let mut sums = Sums::new(n + p);
        let mut whitener = Whitener::new(follow.colour);
        let (mut work, mut step) = (system.work(follow.coefficients), system.blank());
        let mut at = Sensitivity::start(n, p);
        let scales = follow.scales(record);
        let mut nodes = Vec::new();
        let mut node = first;
        loop {
            nodes.push((at.m.clone(), at.d.clone()));
            let (from, to) = record.between(node);
            let mut x = record.nodes[node].clone();
            if node == first {
                self.compare(follow, record, from, (&x, &at), (&mut whitener, &mut sums));
            }
            for row in from..to {
                follow.advance(
                    record,
                    row,
                    follow.cut.substeps,
                    &mut x,
                    (&mut work, &mut step),
                    Some(&mut at),
                );
                if row + 1 < to {
                    self.compare(
                        follow,
                        record,
                        row + 1,
                        (&x, &at),
                        (&mut whitener, &mut sums),
                    );
                }
            }
            if !x.iter().all(|v| v.is_finite()) || !at.m.iter().all(|v| v.is_finite()) {
                return None;
            }
            if record.is_last(node) {
                self.compare(follow, record, to, (&x, &at), (&mut whitener, &mut sums));
                node += 1;
                break;
            }
            node += 1;
            let ends = until.map_or_else(
                || growth(&at.m, &scales) > follow.cut.growth || node - first >= follow.cut.longest,
                |until| node == until,
            );
            // Where an arc ends, the sample belongs to the next.
            if ends {
                break;
            }
            self.compare(follow, record, to, (&x, &at), (&mut whitener, &mut sums));
            for i in 0..n {
                let defect = x[i] - record.nodes[node][i];
                at.d[i] += defect;
                self.defects += (defect / follow.sigma[i]).powi(2);
            }
        }
        let (start, by) = sums.eliminate(record, self)?;
        self.moves.push(ArcMoves {
            record: index,
            first,
            start,
            by,
            nodes,
        });
        Some(node)
    }

    fn compare(
        &mut self,
        follow: &Follow<'_>,
        record: &Record,
        row: usize,
        (x, at): (&[f64], &Sensitivity),
        (whitener, sums): (&mut Whitener<'_>, &mut Sums),
    ) {
        let root = record.root_weight(row);
        if root == 0.0 {
            return;
        }
        for (i, x) in x.iter().take(follow.system.measured).enumerate() {
            let Some(sample) = record.sample(i, row) else {
                continue;
            };
            self.samples[i] += 1;
            let residual = record.residual(i, row, *x);
            let scale = root / follow.sigma[i];
            let y = residual / follow.sigma[i] - at.d[i] * scale;
            let along = at.m.row(i);
            let values = along.iter().map(|v| v * scale);
            if whitener.changes(i) {
                let mut values: Vec<f64> = values.chain([y, residual]).collect();
                whitener.apply(i, sample, &mut values);
                if let [values @ .., y, residual] = values.as_slice() {
                    self.misfit[i] += residual * residual;
                    sums.push(values.iter().copied(), *y);
                }
            } else {
                self.misfit[i] += residual * residual;
                sums.push(values, y);
            }
        }
    }
}

/// How far a change of the arc's start by the scale of one state has grown in another, in its scale.
pub(super) fn growth(m: &DMatrix<f64>, scales: &[f64]) -> f64 {
    let mut most: f64 = 0.0;
    for j in 0..scales.len() {
        for i in 0..scales.len() {
            most = most.max((m[(i, j)] * scales[j] / scales[i]).abs());
        }
    }
    most
}

/// `[X | y]ᵀ [X | y]`, gathered in chunks.
pub(super) struct Sums {
    columns: usize,
    chunk: DMatrix<f64>,
    filled: usize,
    pub total: DMatrix<f64>,
}

impl Sums {
    pub(super) fn new(columns: usize) -> Self {
        Self {
            columns,
            chunk: DMatrix::zeros(columns + 1, CHUNK),
            filled: 0,
            total: DMatrix::zeros(columns + 1, columns + 1),
        }
    }

    pub(super) fn push(&mut self, row: impl Iterator<Item = f64>, y: f64) {
        let mut column = self.chunk.column_mut(self.filled);
        for (to, v) in column.iter_mut().zip(row.chain(std::iter::once(y))) {
            *to = v;
        }
        self.filled += 1;
        if self.filled == CHUNK {
            self.flush();
        }
    }

    pub(super) fn flush(&mut self) {
        if self.filled == 0 {
            return;
        }
        let part = self.chunk.columns(0, self.filled);
        self.total.gemm(1.0, &part, &part.transpose(), 1.0);
        self.filled = 0;
    }

    /// Keeps the arc's start near where it is, in directions in which hardly any sample sees it: variances are those of the states over
    /// the record.
    fn hold(&mut self, variances: &[f64]) {
        for (i, variance) in variances.iter().enumerate() {
            self.total[(i, i)] += 1.0 / variance.max(f64::MIN_POSITIVE);
        }
    }

    /// Eliminates the arc's start and adds the reduced equations to `out`.
    fn eliminate(
        &mut self,
        record: &Record,
        out: &mut Normal,
    ) -> Option<(DVector<f64>, DMatrix<f64>)> {
        self.flush();
        if record.is_sparse() {
            self.hold(&record.spread);
        }
        let n = record.spread.len();
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
            all.rows_mut(0, n)
                .copy_from(&(&arc.start - &arc.by * change));
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
