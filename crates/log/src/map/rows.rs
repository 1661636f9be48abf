//! Rows of named numbers, the input of expressions.

use super::Rule;
use crate::{ColumnKind, LogError, Table};
use sindy_expr::nearest;

/// Rows of named columns, filled in block by block.
pub(crate) trait Rows {
    /// The file.
    fn path(&self) -> &str;
    /// SHA-256 of the file.
    fn sha256(&self) -> &str;
    /// Number of rows.
    fn len(&self) -> usize;
    /// The number of a row in its file.
    fn row_number(&self, row: usize) -> usize;
    /// The place of the column of numbers of this name.
    fn place(&self, name: &str) -> Option<usize>;
    /// The values of a column from row `first` on. Blocks are asked for in order.
    fn fill(&mut self, place: usize, first: usize, into: &mut [f64]);
    /// The error of a rule that uses an unavailable column.
    fn lacks(&self, rule: &Rule, name: &str) -> LogError;
}

/// The rows of a table.
pub(crate) struct TableRows<'a>(pub(crate) &'a Table);

impl Rows for TableRows<'_> {
    fn path(&self) -> &str {
        &self.0.path
    }

    fn sha256(&self) -> &str {
        &self.0.sha256
    }

    fn len(&self) -> usize {
        self.0.len()
    }

    fn row_number(&self, row: usize) -> usize {
        self.0.row_numbers[row]
    }

    fn place(&self, name: &str) -> Option<usize> {
        let named = |column: &crate::Column| column.name == name;
        let place = self.0.columns.iter().position(named)?;
        (!self.0.columns[place].is_text()).then_some(place)
    }

    fn fill(&mut self, place: usize, first: usize, into: &mut [f64]) {
        into.copy_from_slice(&self.0.columns[place].values[first..first + into.len()]);
    }

    fn lacks(&self, rule: &Rule, name: &str) -> LogError {
        let at = Box::new(rule.place.clone());
        let (found, table) = (name.to_owned(), self.0.path.clone());
        match self.0.column(name).map(|column| &column.kind) {
            Some(ColumnKind::Text { example }) => LogError::TextColumn {
                at,
                table,
                found,
                example: example.clone(),
            },
            _ => LogError::UnknownColumn {
                at,
                table,
                nearest: nearest(name, self.0.columns.iter().map(|c| c.name.as_str()))
                    .map(str::to_owned),
                found,
                available: self.0.column_names(),
            },
        }
    }
}
