//! Sums over rows.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use sindy_expr::Scratch;

use super::aligned::Aligned;
use super::kernel::{self, LANES, Lanes};
use super::pass::Pass;
use super::plan::{CHUNK, Plan};
use super::{Gram, Weights};
use crate::error::{SindyError, require};
use crate::statistics::tsqr::Triangle;

/// The sums of a [`Gram`], for several targets at once.
#[derive(Clone, Debug)]
pub(crate) struct Sums {
    /// In the order of [`Plan::factors`].
    products: Vec<f64>,
    /// What is to be added to them; empty where there is nothing.
    lanes: Vec<Lanes>,
    targets: Vec<f64>,
    rows: usize,
    skipped: usize,
    weights: Option<Weights>,
    /// One for each target, where they are asked for.
    triangles: Vec<Triangle>,
}

impl Sums {
    pub(crate) fn zeros(pass: &Pass) -> Self {
        let targets = pass.plan.targets.len();
        let triangles = if pass.triangle { targets } else { 0 };
        Self {
            products: vec![0.0; pass.plan.products()],
            lanes: Vec::new(),
            targets: vec![0.0; targets],
            rows: 0,
            skipped: 0,
            weights: pass.weight.map(|_| Weights::default()),
            triangles: vec![Triangle::new(pass.plan.p); triangles],
        }
    }

    /// From sums in the order of [`Plan::factors`].
    pub(crate) fn from_parts(plan: &Plan, sums: &[f64], rows: usize, skipped: usize) -> Self {
        let (products, targets) = sums.split_at(plan.products());
        Self {
            products: products.to_vec(),
            lanes: Vec::new(),
            targets: targets.to_vec(),
            rows,
            skipped,
            weights: None,
            triangles: Vec::new(),
        }
    }

    /// Whether no rows have been added, not even rows that were dropped.
    pub(super) fn is_empty(&self) -> bool {
        self.rows + self.skipped == 0
    }

    /// Evaluates the given rows and adds them, chunk by chunk. Rows with a non-finite entry are left out
    /// and counted; rows of weight zero are left out. [`Sums::settle`] ends a segment of rows.
    pub(super) fn add_rows(
        &mut self,
        pass: &Pass,
        columns: &[&[f64]],
        range: Range<usize>,
        work: &mut Workspace,
    ) -> Result<(), SindyError> {
        let plan = &pass.plan;
        self.lanes.resize(plan.products(), [0.0; LANES]);
        for start in range.clone().step_by(plan.chunk()) {
            let rows = plan.chunk().min(range.end - start);
            work.load(plan, columns, start..start + rows);
            let mut weight = [0.0; CHUNK];
            let mut used = rows;
            if let Some(column) = pass.weight {
                for (r, &w) in columns[column][start..start + rows].iter().enumerate() {
                    require(
                        w >= 0.0 && w.is_finite(),
                        "weights",
                        "finite, at least 0",
                        w,
                    )?;
                    weight[r] = w;
                    if w == 0.0 {
                        work.clear_row(rows, r);
                        used -= 1;
                    }
                }
            }
            let skipped = work.clear_bad_rows(rows, |r| weight[r] = 0.0);
            if let Some(sums) = &mut self.weights {
                for w in &weight[..rows] {
                    sums.sum += w;
                    sums.squares += w * w;
                }
                for (k, sum) in self.targets.iter_mut().enumerate() {
                    let target = &work.columns[(plan.p + k) * rows..][..rows];
                    *sum += target.iter().zip(&weight).map(|(y, w)| w * y).sum::<f64>();
                }
                weight.iter_mut().for_each(|w| *w = w.sqrt());
                for column in work.columns.chunks_exact_mut(rows) {
                    for (v, root) in column.iter_mut().zip(&weight) {
                        *v *= root;
                    }
                }
            } else {
                for (k, sum) in self.targets.iter_mut().enumerate() {
                    *sum += kernel::sum(&work.columns[(plan.p + k) * rows..][..rows]);
                }
            }
            match &plan.runs {
                Some(runs) => kernel::some_products(&work.columns, rows, runs, &mut self.lanes),
                None => kernel::all_products(&work.columns, rows, &mut self.lanes),
            }
            self.rows += used - skipped;
            self.skipped += skipped;
            for (k, triangle) in self.triangles.iter_mut().enumerate() {
                let (theta, targets) = work.columns.split_at(plan.p * rows);
                work.with_target.clear();
                work.with_target.extend_from_slice(theta);
                work.with_target
                    .extend_from_slice(&targets[k * rows..(k + 1) * rows]);
                triangle.fold(&mut work.with_target, rows);
            }
        }
        Ok(())
    }

    /// Ends a segment of rows: what comes later is summed on its own first.
    pub(super) fn settle(&mut self) {
        for (sum, lanes) in self.products.iter_mut().zip(&self.lanes) {
            *sum += kernel::total(lanes);
        }
        self.lanes = Vec::new();
    }

    /// Adds the sums of another part, which is settled.
    pub(super) fn merge(&mut self, other: &Self) {
        for (a, b) in [
            (&mut self.products, &other.products),
            (&mut self.targets, &other.targets),
        ] {
            for (a, b) in a.iter_mut().zip(b) {
                *a += b;
            }
        }
        self.rows += other.rows;
        self.skipped += other.skipped;
        if let (Some(own), Some(more)) = (&mut self.weights, other.weights) {
            own.sum += more.sum;
            own.squares += more.squares;
        }
        for (own, more) in self.triangles.iter_mut().zip(&other.triangles) {
            own.merge(more);
        }
    }

    /// The statistics of each target.
    pub(crate) fn grams(&self, plan: &Plan) -> Vec<Gram> {
        let p = plan.p;
        let sum = |i: usize, j: usize| {
            self.products[plan.sum_of[kernel::place(i.min(j), i.max(j))] as usize]
        };
        let xtx = DMatrix::from_fn(p, p, sum);
        (0..plan.targets.len())
            .map(|k| Gram {
                xtx: xtx.clone(),
                xty: DVector::from_fn(p, |i, _| sum(i, p + k)),
                yty: sum(p + k, p + k),
                sum_y: self.targets[k],
                rows: self.rows,
                skipped: self.skipped,
                weights: self.weights,
                triangle: self.triangles.get(k).cloned(),
            })
            .collect()
    }
}

/// What one thread needs to add rows.
#[derive(Default)]
pub(crate) struct Workspace {
    scratch: Scratch,
    /// The terms and the targets of one chunk, column after column.
    columns: Aligned,
    /// The terms and one target.
    with_target: Vec<f64>,
}

impl Workspace {
    /// Evaluates a chunk of rows.
    pub(crate) fn load(&mut self, plan: &Plan, columns: &[&[f64]], range: Range<usize>) {
        let rows = range.len();
        self.columns.set_len(rows * (plan.p + plan.targets.len()));
        let part: Vec<&[f64]> = columns.iter().map(|c| &c[range.clone()]).collect();
        let (theta, y) = self.columns.split_at_mut(rows * plan.p);
        plan.program.eval_block(&part, theta, &mut self.scratch);
        for (to, &target) in y.chunks_exact_mut(rows).zip(&plan.targets) {
            to.copy_from_slice(part[target]);
        }
    }

    /// The terms and the targets of the chunk, column after column.
    pub(crate) fn columns(&self) -> &[f64] {
        &self.columns
    }

    /// Zeroes the rows of a chunk that are not finite, hands each to `found`, and returns their number.
    pub(crate) fn clear_bad_rows(&mut self, rows: usize, mut found: impl FnMut(usize)) -> usize {
        if kernel::sum(&self.columns).is_finite() {
            return 0;
        }
        let mut bad = 0;
        for r in 0..rows {
            if self.columns[r..]
                .iter()
                .step_by(rows)
                .any(|v| !v.is_finite())
            {
                self.clear_row(rows, r);
                found(r);
                bad += 1;
            }
        }
        bad
    }

    fn clear_row(&mut self, rows: usize, r: usize) {
        self.columns[r..]
            .iter_mut()
            .step_by(rows)
            .for_each(|v| *v = 0.0);
    }
}
