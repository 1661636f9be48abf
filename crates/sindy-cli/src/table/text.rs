//! Text tables, by the reader of `touchdown-log`.

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
