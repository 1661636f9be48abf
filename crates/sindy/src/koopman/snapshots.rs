//! Pairs of successive samples, kept as a triangular factor.

use nalgebra::DMatrix;
use nalgebra::linalg::QR;
use sindy_expr::{Expr, Scratch};

use super::BLOW_UP;
use crate::data::samples::{BlockSource, passed, position};
use crate::error::SindyError;
use crate::library::compile;

/// Rows that are evaluated, and pairs that are folded into the factor, at a time.
const CHUNK: usize = 256;

/// The triangular factor R, w x w, of the rows `[z_k, v_k, x_k, z_{k+1}]` of all pairs.
pub(super) struct Snapshots {
    r: DMatrix<f64>,
    lifted: usize,
    drives: usize,
    states: usize,
    /// Pairs that were found.
    pub(super) pairs: usize,
    /// Rows with a value that cannot be used.
    pub(super) skipped: usize,
}

/// States, observables and drives of each row.
pub(super) struct Lift<'a> {
    /// The states' names.
    pub(super) states: &'a [String],
    /// Expressions of the states: z.
    pub(super) lifted: &'a [Expr],
    /// Regressors that are not predicted: v.
    pub(super) drives: &'a [Expr],
}

/// Pairs that wait to be folded in.
struct Factor {
    stack: DMatrix<f64>,
    width: usize,
    waiting: usize,
}

impl Factor {
    fn new(width: usize) -> Self {
        Self {
            stack: DMatrix::zeros(width + CHUNK, width),
            width,
            waiting: 0,
        }
    }

    fn push(&mut self, row: impl Iterator<Item = f64>) {
        let at = self.width + self.waiting;
        for (column, value) in row.enumerate() {
            self.stack[(at, column)] = value;
        }
        self.waiting += 1;
        if self.waiting == CHUNK {
            self.fold();
        }
    }

    fn fold(&mut self) {
        let empty = DMatrix::zeros(self.width + CHUNK, self.width);
        let r = QR::new(std::mem::replace(&mut self.stack, empty)).unpack_r();
        self.stack.rows_mut(0, self.width).copy_from(&r);
        self.waiting = 0;
    }

    fn finish(mut self) -> DMatrix<f64> {
        if self.waiting > 0 {
            self.fold();
        }
        self.stack.rows(0, self.width).into_owned()
    }
}

impl Snapshots {
    pub(super) fn accumulate(
        lift: &Lift<'_>,
        source: &dyn BlockSource,
    ) -> Result<Self, SindyError> {
        let (n, m, s) = (lift.lifted.len(), lift.drives.len(), lift.states.len());
        let names: Vec<&str> = source.names().iter().map(String::as_str).collect();
        for name in lift.states {
            position(source.names(), name)?;
        }
        // Columns of the table that is evaluated: z, v, x.
        let exprs: Vec<Expr> = lift.lifted.iter().chain(lift.drives).cloned().collect();
        let exprs = [
            exprs,
            lift.states.iter().map(|x| Expr::variable(x)).collect(),
        ]
        .concat();
        let program = compile(&exprs, &names)?;
        let width = n + m + s;

        let mut factor = Factor::new(width + n);
        let mut table = vec![0.0; CHUNK * width];
        let mut scratch = Scratch::default();
        let (mut pairs, mut skipped) = (0, 0);
        // The row before, if it can begin a pair, and its group.
        let mut before: Option<(usize, Vec<f64>)> = None;
        source.for_each_block(&mut |block| {
            if before.as_ref().is_some_and(|(g, _)| *g != block.group) {
                before = None;
            }
            let rows = block.columns.first().map_or(0, |c| c.len());
            for start in (0..rows).step_by(CHUNK) {
                let count = CHUNK.min(rows - start);
                let part: Vec<&[f64]> = block
                    .columns
                    .iter()
                    .map(|c| &c[start..start + count])
                    .collect();
                let table = &mut table[..count * width];
                program.eval_block(&part, table, &mut scratch);
                for k in 0..count {
                    let at = |j: usize| table[j * count + k];
                    let usable = |j: usize| at(j).abs() <= BLOW_UP;
                    let ends = (0..n).chain(n + m..width).all(usable);
                    let begins = ends && (n..n + m).all(usable);
                    if let Some((_, row)) = &before
                        && ends
                    {
                        factor.push(row.iter().copied().chain((0..n).map(at)));
                        pairs += 1;
                    }
                    skipped += usize::from(!begins);
                    before = begins.then(|| (block.group, (0..width).map(at).collect()));
                }
            }
        });
        passed(source)?;
        if pairs == 0 {
            // One pair takes two rows in sequence.
            return Err(SindyError::too_short(2, 1));
        }
        Ok(Self {
            r: factor.finish(),
            lifted: n,
            drives: m,
            states: s,
            pairs,
            skipped,
        })
    }

    fn part(&self, size: usize, from: usize, columns: usize) -> DMatrix<f64> {
        self.r.view((0, from), (size, columns)).into_owned()
    }

    /// Factor of `[z_k, v_k]` and right-hand sides `z_{k+1}`.
    pub(super) fn step(&self) -> (DMatrix<f64>, DMatrix<f64>) {
        let p = self.lifted + self.drives;
        (
            self.part(p, 0, p),
            self.part(p, p + self.states, self.lifted),
        )
    }

    /// Factor of `z_k` and right-hand sides `x_k`.
    pub(super) fn projection(&self) -> (DMatrix<f64>, DMatrix<f64>) {
        let n = self.lifted;
        (
            self.part(n, 0, n),
            self.part(n, n + self.drives, self.states),
        )
    }

    /// Root mean square over the pairs of `z_{k+1}` less its prediction, for each z.
    pub(super) fn residual_rms(&self, coefficients: &DMatrix<f64>) -> Vec<f64> {
        let p = coefficients.nrows();
        let from = p + self.states;
        let prediction = self.r.columns(0, p) * coefficients;
        let rest = self.r.columns(from, self.lifted) - prediction;
        let rms = |norm: f64| norm / (self.pairs as f64).sqrt();
        rest.column_iter().map(|c| rms(c.norm())).collect()
    }
}
