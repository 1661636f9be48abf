//! Rows from an iterator: a single pass over what need not fit into memory.

use std::cell::RefCell;

use crate::data::samples::{Block, BlockSource};
use crate::error::SindyError;

/// Rows that belong together, with their own memory.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnedBlock {
    /// Index of the group (trajectory, fold) that these rows belong to.
    pub group: usize,
    /// The columns, equally long, in the order of the stream's names.
    pub columns: Vec<Vec<f64>>,
}

/// A source over an iterator of blocks, such as the row groups of a file as they are read. One block is held
/// at a time.
///
/// It can be passed over once. A second pass has no rows, and whatever was asked for fails with
/// [`SindyError::Source`]. The iterator reports a failure by an error item, which ends the pass.
///
/// ```
/// use sindy::{Gram, Library, OwnedBlock, Stream};
///
/// let blocks = (0..100).map(|k| {
///     let x: Vec<f64> = (0..50).map(|i| f64::from(50 * k + i).sin()).collect();
///     let y = x.iter().map(|x| 2.0 * x).collect();
///     Ok(OwnedBlock { group: 0, columns: vec![x, y] })
/// });
/// let source = Stream::new(&["x", "y"], 1, blocks);
/// let gram = Gram::total(&Gram::accumulate(&Library::parse(&["x"])?, "y", &source)?);
/// assert_eq!(gram.rows, 5000);
/// # Ok::<(), sindy::SindyError>(())
/// ```
pub struct Stream<I> {
    names: Vec<String>,
    groups: usize,
    blocks: RefCell<Option<I>>,
    failure: RefCell<Option<SindyError>>,
}

impl<I: Iterator<Item = Result<OwnedBlock, SindyError>>> Stream<I> {
    /// A stream of blocks with columns of these names, in `groups` groups.
    pub fn new<S: AsRef<str>>(
        names: &[S],
        groups: usize,
        blocks: impl IntoIterator<IntoIter = I>,
    ) -> Self {
        Self {
            names: names.iter().map(|n| n.as_ref().to_string()).collect(),
            groups,
            blocks: RefCell::new(Some(blocks.into_iter())),
            failure: RefCell::new(None),
        }
    }

    fn pass(&self, visit: &mut dyn FnMut(Block<'_>)) -> Result<(), SindyError> {
        let blocks = self
            .blocks
            .borrow_mut()
            .take()
            .ok_or_else(|| SindyError::Source {
                reason: "a stream can be read only once".to_string(),
            })?;
        for block in blocks {
            let OwnedBlock { group, columns } = block?;
            let shape = |what, expected, found| Err(SindyError::shape(what, expected, found));
            if group >= self.groups {
                return shape("groups of the stream (at least)", group + 1, self.groups);
            }
            if columns.len() != self.names.len() {
                return shape("columns of a block", self.names.len(), columns.len());
            }
            let n = columns.first().map_or(0, Vec::len);
            if let Some(column) = columns.iter().find(|c| c.len() != n) {
                return shape("rows of a column", n, column.len());
            }
            let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
            visit(Block {
                group,
                columns: &columns,
            });
        }
        Ok(())
    }
}

impl<I: Iterator<Item = Result<OwnedBlock, SindyError>>> BlockSource for Stream<I> {
    fn names(&self) -> &[String] {
        &self.names
    }

    fn groups(&self) -> usize {
        self.groups
    }

    fn for_each_block(&self, visit: &mut dyn FnMut(Block<'_>)) {
        *self.failure.borrow_mut() = self.pass(visit).err();
    }

    fn failure(&self) -> Option<SindyError> {
        self.failure.borrow().clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Gram, Library, Samples};

    fn columns(rows: std::ops::Range<usize>) -> Vec<Vec<f64>> {
        let x: Vec<f64> = rows.map(|i| (1e-3 * i as f64).sin()).collect();
        let y = x.iter().map(|x| 1.0 / (2.0 + x)).collect();
        vec![x, y]
    }

    #[test]
    fn prop_a_million_rows_in_blocks_give_the_bits_of_one_block() {
        let library = Library::parse(&["1", "x", "x^2"]).unwrap();
        let mut whole = Samples::new(&["x", "y"]);
        whole.push_group(columns(0..1_000_000)).unwrap();
        let expected = Gram::accumulate(&library, "y", &whole).unwrap();
        for (threads, size) in [(1, 1000), (2, 1000), (2, 50_000), (3, 9_999)] {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            let blocks = (0..1_000_000).step_by(size).map(|start| {
                Ok(OwnedBlock {
                    group: 0,
                    columns: columns(start..(start + size).min(1_000_000)),
                })
            });
            let found = pool.install(|| {
                let stream = Stream::new(&["x", "y"], 1, blocks.collect::<Vec<_>>());
                Gram::accumulate(&library, "y", &stream).unwrap()
            });
            assert_eq!(found, expected, "{threads} threads, blocks of {size}");
        }
    }

    #[test]
    fn prop_errors_of_the_iterator_and_its_blocks_come_out() {
        let library = Library::parse(&["x"]).unwrap();
        let good = || {
            Ok(OwnedBlock {
                group: 0,
                columns: vec![vec![1.0; 5]; 2],
            })
        };
        let broken = || {
            Err(SindyError::Source {
                reason: "row group 3".into(),
            })
        };
        let of = |item| {
            let stream = Stream::new(&["x", "y"], 1, vec![good(), item, good()]);
            Gram::accumulate(&library, "y", &stream)
                .unwrap_err()
                .to_string()
        };
        assert!(of(broken()).contains("row group 3"));
        let odd = |group, columns| Ok(OwnedBlock { group, columns });
        assert!(of(odd(1, vec![vec![]; 2])).contains("groups"));
        assert!(of(odd(0, vec![vec![]; 3])).contains("columns"));
        assert!(of(odd(0, vec![vec![1.0], vec![]])).contains("rows"));
        let stream = Stream::new(&["x", "y"], 1, vec![good()]);
        assert!(Gram::accumulate(&library, "y", &stream).is_ok());
        let again = Gram::accumulate(&library, "y", &stream).unwrap_err();
        assert!(again.to_string().contains("only once"), "{again}");
    }
}
