//! Tables from files: text with a header, Parquet, NumPy arrays; which of them a file is, its first bytes tell.

mod labels;
mod npy;
mod parquet;
#[cfg(test)]
mod tests;
mod text;

use std::io::Read as _;
use std::path::Path;

use touchdown_log::Findings;

use crate::error::{Error, Result};

/// A file with named columns, opened.
pub(crate) struct Table {
    path: String,
    names: Vec<String>,
    store: Store,
    /// What was found while opening; nothing but rows for tables that cannot have odd ones.
    pub(crate) findings: Findings,
}

enum Store {
    Text(touchdown_log::Table),
    Parquet(parquet::Parquet),
    Npy(Vec<Vec<f64>>),
}

impl Table {
    /// Opens a file. `columns` names the columns of an array, which has no names of its own.
    pub(crate) fn open(path: &Path, columns: &[String]) -> Result<Self> {
        let mut start = [0; 6];
        let mut file = std::fs::File::open(path).map_err(|e| Error::file(path, e))?;
        let length = read_up_to(&mut file, &mut start).map_err(|e| Error::file(path, e))?;
        drop(file);
        let start = &start[..length];
        if start.starts_with(b"PAR1") {
            return parquet::open(path);
        }
        if start.starts_with(b"\x93NUMPY") {
            return npy::open(path, columns);
        }
        if start.starts_with(b"PK\x03\x04") {
            return Err(Error::data(
                path.display().to_string(),
                "a text table (CSV), Parquet or one NumPy array (.npy)",
                "a ZIP archive (.npz or a spreadsheet); save its table as CSV or .npy",
            ));
        }
        text::open(path)
    }

    /// The file's path as it was given.
    pub(crate) fn path(&self) -> &str {
        &self.path
    }

    /// The columns' names.
    pub(crate) fn names(&self) -> &[String] {
        &self.names
    }

    /// The number of rows.
    pub(crate) fn rows(&self) -> usize {
        match &self.store {
            Store::Text(table) => table.len(),
            Store::Parquet(file) => file.rows(),
            Store::Npy(columns) => columns.first().map_or(0, Vec::len),
        }
    }

    /// Columns as numbers, NaN for gaps; date-time stamps in seconds from the first.
    pub(crate) fn numbers(&self, places: &[usize]) -> Result<Vec<Vec<f64>>> {
        match &self.store {
            Store::Text(table) => places
                .iter()
                .map(|&p| text::numbers(table, &self.names[p]))
                .collect(),
            Store::Parquet(file) => file.numbers(&self.path, &self.names, places),
            Store::Npy(columns) => Ok(places.iter().map(|&p| columns[p].clone()).collect()),
        }
    }

    /// A column as labels, empty for gaps.
    pub(crate) fn labels(&self, place: usize) -> Result<Vec<String>> {
        match &self.store {
            Store::Text(table) => text::labels(table, &self.names[place]),
            Store::Parquet(file) => file.labels(&self.path, &self.names, place),
            Store::Npy(columns) => Ok(columns[place].iter().map(|&v| label(v)).collect()),
        }
    }

    /// A row's number in the file, from 1, without the header.
    pub(crate) fn row_number(&self, row: usize) -> usize {
        match &self.store {
            Store::Text(table) => table.row_numbers()[row] + 1,
            _ => row + 1,
        }
    }

    /// File, row and column, for messages.
    pub(crate) fn place(&self, row: usize, column: &str) -> String {
        let row = self.row_number(row);
        format!("{}, data row {row}, column `{column}`", self.path)
    }

    /// The place of the column `name`: of that name exactly, or of that name with a unit behind it, as in `x (m)` or
    /// `x [m]`. `why` says what asked for it.
    pub(crate) fn find(&self, name: &str, why: &str) -> Result<usize> {
        if let Some(place) = self.names.iter().position(|n| n == name) {
            return Ok(place);
        }
        let with_unit = |n: &String| without_unit(n).is_some_and(|bare| bare == name);
        let matches: Vec<usize> = (0..self.names.len())
            .filter(|&p| with_unit(&self.names[p]))
            .collect();
        if let [place] = matches[..] {
            return Ok(place);
        }
        let nearest = self.names.iter().find(|n| n.eq_ignore_ascii_case(name));
        let hint = nearest.map_or_else(String::new, |n| format!(" (did you mean `{n}`?)"));
        Err(Error::data(
            &self.path,
            format!("a column `{name}` ({why}){hint}"),
            format!("the columns {}", self.names.join(", ")),
        ))
    }
}

/// A name without the unit behind it; `None` where there is none.
pub(crate) fn without_unit(name: &str) -> Option<&str> {
    let open = match name.chars().last()? {
        ')' => '(',
        ']' => '[',
        _ => return None,
    };
    let bare = name[..name.find(open)?].trim();
    (!bare.is_empty()).then_some(bare)
}

/// A number as a label.
fn label(value: f64) -> String {
    if value.is_nan() {
        String::new()
    } else {
        value.to_string()
    }
}

fn read_up_to(file: &mut std::fs::File, buffer: &mut [u8]) -> std::io::Result<usize> {
    let mut filled = 0;
    while filled < buffer.len() {
        match file.read(&mut buffer[filled..])? {
            0 => break,
            n => filled += n,
        }
    }
    Ok(filled)
}
