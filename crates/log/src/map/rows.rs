//! Rows of named numbers, the input of expressions.

use super::Rule;
use crate::{ColumnKind, LogError, Table};
use sindy_expr::nearest;
use std::collections::HashMap;

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
pub(crate) struct TableRows<'a> {
    table: &'a Table,
    /// Columns of numbers by name; the first of one name.
    places: HashMap<&'a str, usize>,
}

impl<'a> TableRows<'a> {
    pub(crate) fn new(table: &'a Table) -> Self {
        let mut places = HashMap::new();
        for (place, column) in table.columns.iter().enumerate() {
            places.entry(column.name.as_str()).or_insert(place);
        }
        places.retain(|_, place| !table.columns[*place].is_text());
        Self { table, places }
    }
}

impl Rows for TableRows<'_> {
    fn path(&self) -> &str {
        &self.table.path
    }

    fn sha256(&self) -> &str {
        &self.table.sha256
    }

    fn len(&self) -> usize {
        self.table.len()
    }

    fn row_number(&self, row: usize) -> usize {
        self.table.row_numbers[row]
    }

    fn place(&self, name: &str) -> Option<usize> {
        self.places.get(name).copied()
    }

    fn fill(&mut self, place: usize, first: usize, into: &mut [f64]) {
        into.copy_from_slice(&self.table.columns[place].values[first..first + into.len()]);
    }

    fn lacks(&self, rule: &Rule, name: &str) -> LogError {
        let at = Box::new(rule.place.clone());
        let (found, table) = (name.to_owned(), self.table.path.clone());
        match self.table.column(name).map(|column| &column.kind) {
            Some(ColumnKind::Text { example }) => LogError::TextColumn {
                at,
                table,
                found,
                example: example.clone(),
            },
            _ => LogError::UnknownColumn {
                at,
                table,
                nearest: nearest(name, self.table.names.iter().map(String::as_str))
                    .map(str::to_owned),
                found,
                available: self.table.names.clone(),
            },
        }
    }
}
