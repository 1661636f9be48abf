//! Tables that need not fit into memory: their rows part by part, in order.

use std::path::{Path, PathBuf};

use touchdown_log::Findings;

use super::{Columns, Format, Store, Table, find, lines, not_one_table, npy, parquet};
use crate::error::Result;

/// Rows of a part of a file that has its own row count.
const PART: usize = 32_768;

/// A file of which the header is known.
pub(crate) struct Header {
    path: PathBuf,
    at: String,
    names: Vec<String>,
    kind: Kind,
}

enum Kind {
    Text(Box<lines::Rows>),
    Parquet(touchdown_log::ParquetFile),
    Npy,
}

/// A file whose rows are read.
pub(crate) struct Rows {
    path: PathBuf,
    source: Source,
    places: Vec<usize>,
    label: Option<usize>,
    /// Rows so far.
    done: usize,
    numbers: Vec<usize>,
}

enum Source {
    Text(Box<lines::Rows>),
    Parquet(Box<parquet::Rows>),
    Npy(npy::Rows),
}

impl Header {
    /// Opens a file. `columns` names the columns of an array, which has no names of its own.
    pub(crate) fn open(path: &Path, columns: &[String]) -> Result<Self> {
        let at = path.display().to_string();
        let (names, kind) = match Format::of(path)? {
            Format::Text => {
                let rows = lines::Rows::open(path)?;
                (rows.names.clone(), Kind::Text(Box::new(rows)))
            }
            Format::Parquet => {
                let Table { names, store, .. } = parquet::open(path)?;
                match store {
                    Store::Parquet(file) => (names, Kind::Parquet(file)),
                    _ => (names, Kind::Npy),
                }
            }
            Format::Zip => return Err(not_one_table(path)),
            Format::Npy => (columns.to_vec(), Kind::Npy),
        };
        Ok(Self {
            path: path.to_owned(),
            at,
            names,
            kind,
        })
    }

    /// The file's path as it was given.
    pub(crate) fn path(&self) -> &str {
        &self.at
    }

    /// The columns' names.
    pub(crate) fn names(&self) -> &[String] {
        &self.names
    }

    /// As [`Table::find`].
    pub(crate) fn find(&self, name: &str, why: &str) -> Result<usize> {
        find(&self.at, &self.names, name, why)
    }

    /// The rows of these columns, and the labels of that one.
    pub(crate) fn rows(self, places: &[usize], label: Option<usize>) -> Result<Rows> {
        let source = match self.kind {
            Kind::Text(rows) => Source::Text(rows),
            Kind::Parquet(file) => {
                let rows = parquet::Rows::new(file, places, label)?;
                Source::Parquet(Box::new(rows))
            }
            Kind::Npy => Source::Npy(npy::Rows::new(&self.path, &self.names, places, label)?),
        };
        Ok(Rows {
            path: self.path,
            source,
            places: places.to_vec(),
            label,
            done: 0,
            numbers: Vec::new(),
        })
    }
}

impl Rows {
    /// The next rows, and their labels if there is a column of them; none at the end.
    pub(crate) fn next(&mut self) -> Result<Option<Columns>> {
        let next = match &mut self.source {
            Source::Text(rows) => rows.next(&self.places, self.label, &mut self.numbers)?,
            Source::Parquet(rows) => rows.next(PART)?,
            Source::Npy(rows) => rows.next(&self.path, PART)?,
        };
        if let Some((columns, _)) = &next {
            let rows = columns.first().map_or(0, Vec::len);
            if !matches!(self.source, Source::Text(_)) {
                self.numbers = (self.done + 1..=self.done + rows).collect();
            }
            self.done += rows;
        }
        Ok(next)
    }

    /// The numbers in the file of the rows that [`Rows::next`] gave last, from 1.
    pub(crate) fn numbers(&self) -> &[usize] {
        &self.numbers
    }

    /// The share of the file that was read.
    pub(crate) fn share(&self) -> f64 {
        match &self.source {
            Source::Text(rows) => rows.share(),
            Source::Parquet(rows) => rows.share(),
            Source::Npy(rows) => rows.share(),
        }
    }

    /// The counts so far.
    pub(crate) fn findings(&self) -> Findings {
        match &self.source {
            Source::Text(rows) => rows.findings.clone(),
            _ => Findings {
                rows_read: self.done,
                rows_used: self.done,
                ..Findings::default()
            },
        }
    }
}
