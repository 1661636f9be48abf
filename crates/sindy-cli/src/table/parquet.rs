//! Parquet files: only the columns that are asked for are read, row group by row group.

use std::path::Path;

use touchdown_log::{Findings, LogError, ParquetColumn, ParquetFile, ParquetRows, ParquetValues};

use super::{Columns, Store, Table, label};
use crate::error::{Error, Result};

pub(super) fn open(path: &Path) -> Result<Table> {
    let file = ParquetFile::open(path)?;
    let (path, rows) = (file.path().to_owned(), file.rows());
    if rows == 0 {
        let reason = "the file has none".to_owned();
        return Err(LogError::NoUsableRows { path, reason }.into());
    }
    Ok(Table {
        path,
        names: file.columns().iter().map(ParquetColumn::name).collect(),
        store: Store::Parquet(file),
        findings: Findings {
            rows_read: rows,
            rows_used: rows,
            ..Findings::default()
        },
    })
}

/// Columns as numbers.
pub(super) fn numbers(file: &ParquetFile, places: &[usize]) -> Result<Vec<Vec<f64>>> {
    check_numbers(file, places)?;
    Ok(file.read(places)?.into_iter().map(as_numbers).collect())
}

/// A column of text or numbers as labels.
pub(super) fn labels(file: &ParquetFile, place: usize) -> Result<Vec<String>> {
    check_labels(file, place)?;
    Ok(file
        .read(&[place])?
        .into_iter()
        .flat_map(as_labels)
        .collect())
}

fn check_numbers(file: &ParquetFile, places: &[usize]) -> Result<()> {
    let columns = places.iter().map(|&place| &file.columns()[place]);
    match columns.into_iter().find(|column| !column.is_number()) {
        None => Ok(()),
        Some(other) => {
            let at = format!("{}, column `{}`", file.path(), other.name());
            Err(Error::data(at, "numbers", other.type_name()))
        }
    }
}

fn check_labels(file: &ParquetFile, place: usize) -> Result<()> {
    if file.columns()[place].is_text() {
        return Ok(());
    }
    check_numbers(file, &[place])
}

fn as_numbers(values: ParquetValues) -> Vec<f64> {
    match values {
        ParquetValues::Numbers(values) => values,
        _ => Vec::new(),
    }
}

fn as_labels(values: ParquetValues) -> Vec<String> {
    match values {
        ParquetValues::Texts(texts) => texts.into_iter().map(Option::unwrap_or_default).collect(),
        other => as_numbers(other).into_iter().map(label).collect(),
    }
}

/// The rows of some columns, from the first on.
pub(super) struct Rows {
    rows: ParquetRows,
    /// Whether the last column is that of the labels.
    labelled: bool,
}

impl Rows {
    pub(super) fn new(file: ParquetFile, places: &[usize], label: Option<usize>) -> Result<Self> {
        check_numbers(&file, places)?;
        if let Some(place) = label {
            check_labels(&file, place)?;
        }
        let all: Vec<usize> = places.iter().copied().chain(label).collect();
        Ok(Self {
            rows: ParquetRows::new(file, &all)?,
            labelled: label.is_some(),
        })
    }

    /// The rows that were read, as a share of all.
    pub(super) fn share(&self) -> f64 {
        self.rows.share()
    }

    /// The next rows, `most` at most, and their labels; none at the end.
    pub(super) fn next(&mut self, most: usize) -> Result<Option<Columns>> {
        let Some(mut block) = self.rows.next(most)? else {
            return Ok(None);
        };
        let labels = if self.labelled { block.pop() } else { None };
        let numbers = block.into_iter().map(as_numbers).collect();
        Ok(Some((numbers, labels.map(as_labels))))
    }
}
