//! Cutting groups into blocks of consecutive rows.

use crate::data::samples::{Block, BlockSource, passed};
use crate::error::{SindyError, require};

/// A source whose groups are blocks of consecutive rows of another source's groups; no block spans two
/// groups, and the last block of a group may be shorter.
///
/// With one row a block, [`Gram::accumulate`](crate::Gram::accumulate) makes one p x p matrix for each row:
/// for small data only.
pub struct Blocks<'a> {
    source: &'a dyn BlockSource,
    rows: usize,
    /// The first block of each group of the source, and the number of all blocks at the end.
    first: Vec<usize>,
}

impl<'a> Blocks<'a> {
    /// Blocks of `rows` rows. Passes over the source once, to count.
    ///
    /// # Errors
    /// `rows` is zero, or the pass failed.
    pub fn new(source: &'a dyn BlockSource, rows: usize) -> Result<Self, SindyError> {
        require(rows != 0, "rows of a block", "at least 1", rows)?;
        let mut length = vec![0; source.groups()];
        source.for_each_block(&mut |block| {
            length[block.group] += block.columns.first().map_or(0, |c| c.len());
        });
        passed(source)?;
        let mut first = vec![0];
        for n in length {
            first.push(first[first.len() - 1] + usize::div_ceil(n, rows));
        }
        Ok(Self {
            source,
            rows,
            first,
        })
    }

    /// The group of the source that a block comes from.
    #[must_use]
    pub fn group_of(&self, block: usize) -> usize {
        self.first.partition_point(|&f| f <= block) - 1
    }
}

impl BlockSource for Blocks<'_> {
    fn names(&self) -> &[String] {
        self.source.names()
    }

    fn groups(&self) -> usize {
        self.first[self.first.len() - 1]
    }

    fn for_each_block(&self, visit: &mut dyn FnMut(Block<'_>)) {
        let mut seen = vec![0; self.first.len() - 1];
        self.source.for_each_block(&mut |block| {
            let n = block.columns.first().map_or(0, |c| c.len());
            let mut start = 0;
            while start < n {
                let row = seen[block.group];
                let take = (self.rows - row % self.rows).min(n - start);
                let columns: Vec<&[f64]> = block
                    .columns
                    .iter()
                    .map(|c| &c[start..start + take])
                    .collect();
                visit(Block {
                    group: self.first[block.group] + row / self.rows,
                    columns: &columns,
                });
                seen[block.group] += take;
                start += take;
            }
        });
    }
    fn failure(&self) -> Option<SindyError> {
        self.source.failure()
    }
}
