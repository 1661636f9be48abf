//! NumPy arrays as a source of blocks, read where they are.

use numpy::PyReadonlyArray2;
use numpy::ndarray::ArrayView2;
use sindy::{Block, BlockSource};

use crate::run::Cancel;

/// Rows of a block: eight of the segments that the statistics share out among threads. Columns that do not lie in one
/// piece (NumPy's default order) are copied so many rows at a time, 0.5 MB for each column; the copy of an array of 10⁶ rows
/// is never held.
const ROWS: usize = 8 * 8192;

/// Trajectories, each of arrays with as many rows, whose columns stand side by side.
pub(crate) struct Columns<'a> {
    names: Vec<String>,
    groups: Vec<Vec<ArrayView2<'a, f64>>>,
    cancel: Cancel,
}

/// What the caller's arrays hold, without a copy.
pub(crate) fn views<'a>(
    groups: &'a [Vec<PyReadonlyArray2<'_, f64>>],
) -> Vec<Vec<ArrayView2<'a, f64>>> {
    let of =
        |arrays: &'a Vec<PyReadonlyArray2<'_, f64>>| arrays.iter().map(|a| a.as_array()).collect();
    groups.iter().map(of).collect()
}

impl<'a> Columns<'a> {
    /// Columns of these names, in the order of the arrays and of their columns.
    ///
    /// # Errors
    /// Arrays of a trajectory with different numbers of rows, or not one column for each name.
    pub(crate) fn new(
        names: Vec<String>,
        groups: Vec<Vec<ArrayView2<'a, f64>>>,
        cancel: &Cancel,
    ) -> Result<Self, sindy::SindyError> {
        for group in &groups {
            let columns = group.iter().map(ArrayView2::ncols).sum();
            let rows = group.first().map_or(0, ArrayView2::nrows);
            let other = group.iter().map(ArrayView2::nrows).find(|n| *n != rows);
            let shape = |what, expected, found| sindy::SindyError::Shape {
                what,
                expected,
                found,
            };
            if columns != names.len() {
                return Err(shape("columns", names.len(), columns));
            }
            if let Some(found) = other {
                return Err(shape("rows (those of x)", rows, found));
            }
        }
        Ok(Self {
            names,
            groups,
            cancel: cancel.clone(),
        })
    }
}

impl BlockSource for Columns<'_> {
    fn names(&self) -> &[String] {
        &self.names
    }

    fn groups(&self) -> usize {
        self.groups.len()
    }

    fn for_each_block(&self, visit: &mut dyn FnMut(Block<'_>)) {
        for (group, arrays) in self.groups.iter().enumerate() {
            let columns: Vec<_> = arrays.iter().flat_map(|a| a.columns()).collect();
            let rows = arrays.first().map_or(0, ArrayView2::nrows);
            // One for each column that does not lie in one piece.
            let mut copies: Vec<Vec<f64>> = vec![Vec::new(); columns.len()];
            for start in (0..rows).step_by(ROWS) {
                self.cancel.heed();
                let part = start..rows.min(start + ROWS);
                for (column, copy) in columns.iter().zip(&mut copies) {
                    if column.as_slice().is_none() {
                        copy.clear();
                        copy.extend(part.clone().map(|k| column[k]));
                    }
                }
                let block: Vec<&[f64]> = columns
                    .iter()
                    .zip(&copies)
                    .map(|(column, copy)| match column.as_slice() {
                        Some(whole) => &whole[part.clone()],
                        None => copy.as_slice(),
                    })
                    .collect();
                visit(Block {
                    group,
                    columns: &block,
                });
            }
        }
    }
}

/// The columns of an array, copied.
pub(crate) fn columns(array: &ArrayView2<'_, f64>) -> Vec<Vec<f64>> {
    array.columns().into_iter().map(|c| c.to_vec()).collect()
}
