//! Samples: named columns, in groups (trajectories), handed on in blocks.
//!
//! Everything that reads data reads it through [`BlockSource`], so data may come from memory, from a
//! file that is larger than memory, or from a simulation.

use crate::error::{SindyError, same_size};

/// Rows that belong together: equally long columns of one group, in the order of
/// [`BlockSource::names`].
#[derive(Clone, Copy, Debug)]
pub struct Block<'a> {
    /// Index of the group (trajectory, fold) that these rows belong to.
    pub group: usize,
    /// The columns.
    pub columns: &'a [&'a [f64]],
}

/// Anything that can hand over its rows block by block.
pub trait BlockSource {
    /// The columns' names.
    fn names(&self) -> &[String];
    /// The number of groups.
    fn groups(&self) -> usize;
    /// Calls `visit` with every block, in a fixed order.
    fn for_each_block(&self, visit: &mut dyn FnMut(Block<'_>));
    /// Why the last pass came to its end before all rows, if it did: a file that could not be read on, a stream
    /// that can be read only once. Callers ask after each pass.
    fn failure(&self) -> Option<SindyError> {
        None
    }
}

/// Samples held in memory.
#[derive(Clone, Debug, Default)]
pub struct Samples {
    names: Vec<String>,
    groups: Vec<Vec<Vec<f64>>>,
}

impl Samples {
    /// An empty set of samples with the given columns.
    #[must_use]
    pub fn new(names: &[&str]) -> Self {
        Self {
            names: names.iter().map(ToString::to_string).collect(),
            groups: Vec::new(),
        }
    }

    /// Adds a group (trajectory): one column per name, all of one length.
    ///
    /// # Errors
    /// A wrong number of columns, or columns of unequal length.
    pub fn push_group(&mut self, columns: Vec<Vec<f64>>) -> Result<(), SindyError> {
        same_size("columns of a group", self.names.len(), columns.len())?;
        let n = columns.first().map_or(0, Vec::len);
        if let Some(c) = columns.iter().find(|c| c.len() != n) {
            return Err(SindyError::shape("rows of a column", n, c.len()));
        }
        self.groups.push(columns);
        Ok(())
    }

    /// The position of the column `name`.
    ///
    /// # Errors
    /// No such column.
    pub fn position(&self, name: &str) -> Result<usize, SindyError> {
        position(&self.names, name)
    }

    /// The columns of group `g`.
    #[must_use]
    pub fn group(&self, g: usize) -> &[Vec<f64>] {
        &self.groups[g]
    }

    /// Rows in all groups together.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.groups
            .iter()
            .map(|g| g.first().map_or(0, Vec::len))
            .sum()
    }
}

impl BlockSource for Samples {
    fn names(&self) -> &[String] {
        &self.names
    }

    fn groups(&self) -> usize {
        self.groups.len()
    }

    fn for_each_block(&self, visit: &mut dyn FnMut(Block<'_>)) {
        for (group, columns) in self.groups.iter().enumerate() {
            let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
            visit(Block {
                group,
                columns: &columns,
            });
        }
    }
}

pub(crate) fn position(names: &[String], name: &str) -> Result<usize, SindyError> {
    names
        .iter()
        .position(|n| n == name)
        .ok_or_else(|| SindyError::UnknownColumn {
            name: name.to_string(),
            known: names.join(", "),
        })
}

/// Fails where a pass over the source failed.
pub(crate) fn passed(source: &dyn BlockSource) -> Result<(), SindyError> {
    source.failure().map_or(Ok(()), Err)
}
