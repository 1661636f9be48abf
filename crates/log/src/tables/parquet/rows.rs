//! Rows of a Parquet file block by block, for tables that need not fit into memory.

use super::decode::{numbers, texts};
use super::file::{ParquetColumn, ParquetFile};
use crate::{LogError, limits};
use parquet::column::reader::ColumnReader;
use parquet::errors::ParquetError;

/// Values of one column.
#[derive(Debug, Clone, PartialEq)]
pub enum ParquetValues {
    /// Whole numbers, written as 64 bits and never null. Read, they are [`Numbers`](Self::Numbers).
    Whole(Vec<i64>),
    /// Numbers; NaN is null. Time stamps are in seconds since the column's first.
    Numbers(Vec<f64>),
    /// Text; `None` is null.
    Texts(Vec<Option<String>>),
}

impl ParquetValues {
    pub(super) fn append(&mut self, more: Self) {
        match (self, more) {
            (Self::Whole(values), Self::Whole(more)) => values.extend(more),
            (Self::Numbers(values), Self::Numbers(more)) => values.extend(more),
            (Self::Texts(values), Self::Texts(more)) => values.extend(more),
            _ => {}
        }
    }

    fn empty(column: &ParquetColumn) -> Self {
        if column.is_text() {
            Self::Texts(Vec::new())
        } else {
            Self::Numbers(Vec::new())
        }
    }
}

/// The rows of some columns, from the first row on.
pub struct ParquetRows {
    file: ParquetFile,
    columns: Vec<ParquetColumn>,
    /// First stamp of each column.
    origins: Vec<Option<i64>>,
    /// The row group to open next, and the readers of the present one.
    group: usize,
    readers: Vec<ColumnReader>,
    done: usize,
}

impl ParquetRows {
    /// Begins to read columns, by their places among [`ParquetFile::columns`].
    ///
    /// # Errors
    /// [`LogError::NotALog`] for a column that holds neither numbers nor text.
    pub fn new(file: ParquetFile, places: &[usize]) -> Result<Self, LogError> {
        let columns: Vec<_> = places.iter().map(|&p| file.columns()[p].clone()).collect();
        let readable = |column: &&ParquetColumn| column.is_number() || column.is_text();
        if let Some(other) = columns.iter().find(|column| !readable(column)) {
            let (name, found) = (other.name(), other.type_name());
            let text = format!("{name}: expected numbers or text, found {found}");
            return Err(file.broken(&ParquetError::General(text)));
        }
        file.check(&columns)?;
        Ok(Self {
            file,
            origins: vec![None; columns.len()],
            columns,
            group: 0,
            readers: Vec::new(),
            done: 0,
        })
    }

    /// The share of rows that have been read.
    #[must_use]
    pub fn share(&self) -> f64 {
        self.done as f64 / self.file.rows().max(1) as f64
    }

    /// The next rows, at most `most`; none at the end.
    ///
    /// # Errors
    /// [`LogError::NotALog`] for a damaged file, or one with more or fewer rows than it states.
    pub fn next(&mut self, most: usize) -> Result<Option<Vec<ParquetValues>>, LogError> {
        let read = self.read(most);
        read.map_err(|error| self.file.broken(&error))
    }

    /// An empty buffer for each column that is read.
    pub(super) fn empty(&self) -> Vec<ParquetValues> {
        self.columns.iter().map(ParquetValues::empty).collect()
    }

    fn read(&mut self, most: usize) -> Result<Option<Vec<ParquetValues>>, ParquetError> {
        if self.columns.is_empty() {
            return Ok(None);
        }
        loop {
            if self.readers.is_empty() && !self.open_group()? {
                let (found, stated) = (self.done, self.file.rows());
                if found == stated {
                    return Ok(None);
                }
                let text = format!("expected {stated} rows, as its footer states, found {found}");
                return Err(ParquetError::General(text));
            }
            let mut block = self.empty();
            let mut counts = Vec::with_capacity(block.len());
            for (k, values) in block.iter_mut().enumerate() {
                let (reader, column) = (&mut self.readers[k], &self.columns[k]);
                let (description, origin) = (&column.description, &mut self.origins[k]);
                counts.push(match values {
                    ParquetValues::Texts(out) => {
                        let most_bytes = limits::memory(self.file.bytes());
                        texts(reader, description, (most, most_bytes), out)?
                    }
                    ParquetValues::Numbers(out) => {
                        numbers(reader, description, column.content, origin, most, out)?
                    }
                    ParquetValues::Whole(_) => 0,
                });
            }
            let rows = counts.first().copied().unwrap_or(0);
            if let Some(other) = counts.iter().find(|count| **count != rows) {
                let text = format!(
                    "expected columns of one length in row group {}, found {rows} and {other} rows",
                    self.group
                );
                return Err(ParquetError::General(text));
            }
            if rows > 0 {
                self.done += rows;
                return Ok(Some(block));
            }
            self.readers.clear();
        }
    }

    /// Opens the next row group; whether there was one.
    fn open_group(&mut self) -> Result<bool, ParquetError> {
        if self.group == self.file.groups() {
            return Ok(false);
        }
        let group = self.file.group(self.group)?;
        let file = &self.file;
        let readers = self.columns.iter().map(|c| c.reader(file, group.as_ref()));
        self.readers = readers.collect::<Result<_, _>>()?;
        self.group += 1;
        Ok(true)
    }
}
