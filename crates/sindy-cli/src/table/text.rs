//! Text tables, by the reader of `touchdown-log`.

use std::io::Read as _;
use std::path::Path;

use touchdown_log::{Column, ColumnKind};

use super::labels;
use super::{Store, Table, label};
use crate::error::{Error, Result};

pub(super) fn open(path: &Path) -> Result<Table> {
    let (table, findings) = touchdown_log::read_csv(path)?;
    Ok(Table {
        path: table.path().to_owned(),
        names: table
            .columns()
            .iter()
            .map(|c| c.name().to_owned())
            .collect(),
        store: Store::Text(table),
        findings,
    })
}

fn column<'t>(table: &'t touchdown_log::Table, name: &str) -> Result<&'t Column> {
    table
        .column(name)
        .ok_or_else(|| Error::data(table.path(), format!("a column `{name}`"), "no such column"))
}

/// Bytes by which the length of lines is estimated.
const SAMPLE: u64 = 1 << 16;

/// About how many lines a file of so many bytes has.
pub(super) fn lines(path: &Path, bytes: u64) -> u64 {
    let mut sample = Vec::new();
    let read = std::fs::File::open(path).and_then(|f| f.take(SAMPLE).read_to_end(&mut sample));
    let ends = sample.iter().filter(|&&b| b == b'\n').count() as u64;
    match read {
        Ok(read) if read > 0 => (bytes as f64 / read as f64 * ends as f64) as u64,
        _ => 0,
    }
}

pub(super) fn numbers(table: &touchdown_log::Table, name: &str) -> Result<Vec<f64>> {
    let column = column(table, name)?;
    match column.kind() {
        ColumnKind::Text { example } => Err(Error::data(
            format!("{}, column `{name}`", table.path()),
            "numbers",
            format!("text such as {example:?}"),
        )),
        _ => Ok(column.values().to_vec()),
    }
}

pub(super) fn labels(table: &touchdown_log::Table, name: &str) -> Result<Vec<String>> {
    let column = column(table, name)?;
    match column.kind() {
        ColumnKind::Text { .. } => labels::read(table, name),
        _ => Ok(column.values().iter().map(|&v| label(v)).collect()),
    }
}
