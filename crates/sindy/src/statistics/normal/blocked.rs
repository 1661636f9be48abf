//! Cholesky's factor of large systems, by blocks of columns: most of the work is a product of matrices.
//!
//! Source: G. H. Golub, C. F. Van Loan, "Matrix Computations" (2013), section 4.2.9.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use pulp::{Arch, Simd, WithSimd};

use super::{Factor, PIVOT};

/// Columns of a block. From twice as many unknowns on, blocks are faster than a factor that grows row by row: a fifth of the
/// time for 286.
const BLOCK: usize = 32;

/// Solves `A x = b` for a symmetric positive definite A; `None` where a column depends on those before.
pub(crate) fn solve_definite(a: &DMatrix<f64>, b: &DVector<f64>) -> Option<DVector<f64>> {
    match b.len() < 2 * BLOCK {
        true => solve_by_rows(a, b),
        false => solve_by_blocks(a.clone(), b),
    }
}

fn solve_by_rows(a: &DMatrix<f64>, b: &DVector<f64>) -> Option<DVector<f64>> {
    let mut factor = Factor::new(b.len());
    for j in 0..b.len() {
        if !factor.push(|c| a[(j, c)], b[j]) {
            return None;
        }
    }
    Some(DVector::from_vec(factor.solve()))
}

/// Only the lower triangle of `a` is read.
fn solve_by_blocks(mut a: DMatrix<f64>, b: &DVector<f64>) -> Option<DVector<f64>> {
    let p = b.len();
    let least: Vec<f64> = a.diagonal().iter().map(|d| PIVOT * d).collect();
    for first in (0..p).step_by(BLOCK) {
        let end = (first + BLOCK).min(p);
        columns(&mut a, first..end, &least)?;
        let done = a.view((end, first), (p - end, end - first)).into_owned();
        // What is left, a panel of columns at a time, so that little above the diagonal is computed.
        for panel in (end..p).step_by(BLOCK) {
            let width = BLOCK.min(p - panel);
            let rows = done.rows(panel - end, p - panel);
            let own = done.rows(panel - end, width).transpose();
            a.view_mut((panel, panel), (p - panel, width))
                .gemm(-1.0, &rows, &own, 1.0);
        }
    }
    let z = a.solve_lower_triangular(b)?;
    a.tr_solve_lower_triangular(&z)
}

/// The columns of one block of the factor, from what the blocks before it left.
fn columns(a: &mut DMatrix<f64>, block: Range<usize>, least: &[f64]) -> Option<()> {
    Arch::new().dispatch(Columns { a, block, least })
}

struct Columns<'a> {
    a: &'a mut DMatrix<f64>,
    block: Range<usize>,
    least: &'a [f64],
}

impl WithSimd for Columns<'_> {
    type Output = Option<()>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Option<()> {
        let p = self.a.nrows();
        let first = self.block.start;
        for j in self.block {
            let (before, own) = self.a.as_mut_slice()[first * p..].split_at_mut((j - first) * p);
            let own = &mut own[j..p];
            for column in before.chunks_exact(p) {
                let column = &column[j..];
                let factor = column[0];
                for (own, other) in own.iter_mut().zip(column) {
                    *own -= factor * other;
                }
            }
            let pivot = own[0];
            if !(pivot > self.least[j]) {
                return None;
            }
            let root = pivot.sqrt();
            own.iter_mut().for_each(|v| *v /= root);
        }
        Some(())
    }
}
