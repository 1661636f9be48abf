//! Tables from files: text with a header, Parquet, NumPy arrays; the first bytes of a file decide which it is.

pub(crate) mod args;
mod labels;
mod lines;
mod npy;
mod parquet;
mod rows;
#[cfg(test)]
mod tests;
mod text;

use std::io::Read as _;
use std::path::Path;

use touchdown_log::Findings;

pub(crate) use args::TableArgs;
pub(crate) use npy::NpyArray;
pub(crate) use rows::{Header, Rows};

use crate::error::{Error, Result};

/// A file with named columns, opened.
pub(crate) struct Table {
    path: String,
    names: Vec<String>,
    store: Store,
    /// The counts while opening; nothing but rows for tables that cannot have odd ones.
    pub(crate) findings: Findings,
}

enum Store {
    Text(touchdown_log::Table),
    Parquet(touchdown_log::ParquetFile),
    Npy(Vec<Vec<f64>>),
}

impl Table {
    /// Opens a file. `columns` names the columns of an array, which has no names of its own.
    pub(crate) fn open(path: &Path, columns: &[String]) -> Result<Self> {
        match Format::of(path)? {
            Format::Parquet => parquet::open(path),
            Format::Npy => npy::open(path, columns),
            Format::Text => text::open(path),
            Format::Zip => Err(not_one_table(path)),
        }
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
            Store::Parquet(file) => parquet::numbers(file, places),
            Store::Npy(columns) => Ok(places.iter().map(|&p| columns[p].clone()).collect()),
        }
    }

    /// A column as labels, empty for gaps.
    pub(crate) fn labels(&self, place: usize) -> Result<Vec<String>> {
        match &self.store {
            Store::Text(table) => text::labels(table, &self.names[place]),
            Store::Parquet(file) => parquet::labels(file, place),
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
    /// `x [m]`. `why` names the argument that asks for it.
    pub(crate) fn find(&self, name: &str, why: &str) -> Result<usize> {
        find(&self.path, &self.names, name, why)
    }
}

/// Rows of some columns, and their labels.
pub(crate) type Columns = (Vec<Vec<f64>>, Option<Vec<String>>);

/// The format of a file.
#[derive(Clone, Copy)]
pub(crate) enum Format {
    Text,
    Parquet,
    Npy,
    /// Several NumPy arrays.
    Zip,
}

impl Format {
    pub(crate) fn of(path: &Path) -> Result<Self> {
        let mut start = [0; 6];
        let mut file = std::fs::File::open(path).map_err(|e| Error::file(path, e))?;
        let length = read_up_to(&mut file, &mut start).map_err(|e| Error::file(path, e))?;
        let start = &start[..length];
        if start.starts_with(b"PAR1") {
            return Ok(Self::Parquet);
        }
        if start.starts_with(b"\x93NUMPY") {
            return Ok(Self::Npy);
        }
        if start.starts_with(b"PK\x03\x04") {
            return Ok(Self::Zip);
        }
        let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        let claimed = match ending.as_deref() {
            Some("parquet") => "a Parquet file (`PAR1` at its beginning)",
            Some("npy") => "a NumPy array (`\\x93NUMPY` at its beginning)",
            Some("npz") => "NumPy arrays in a ZIP archive (`PK` at its beginning)",
            _ => return Ok(Self::Text),
        };
        let found = format!("`{}`", start.escape_ascii());
        Err(Error::data(path.display().to_string(), claimed, found))
    }
}

/// The place of the column `name` among `names`, as [`Table::find`].
pub(crate) fn find(at: &str, names: &[String], name: &str, why: &str) -> Result<usize> {
    let same: Vec<usize> = (0..names.len()).filter(|&p| names[p] == name).collect();
    match same[..] {
        [] => {}
        [place] => return Ok(place),
        _ => {
            return Err(Error::data(
                at,
                format!("one column `{name}` ({why})"),
                format!("{} of that name", same.len()),
            ));
        }
    }
    let with_unit = |n: &String| without_unit(n).is_some_and(|bare| bare == name);
    let matches: Vec<usize> = (0..names.len()).filter(|&p| with_unit(&names[p])).collect();
    if let [place] = matches[..] {
        return Ok(place);
    }
    let nearest = names.iter().find(|n| n.eq_ignore_ascii_case(name));
    let hint = nearest.map_or_else(String::new, |n| format!(" (did you mean `{n}`?)"));
    Err(Error::data(
        at,
        format!("a column `{name}` ({why}){hint}"),
        format!("the columns {}", names.join(", ")),
    ))
}

/// The error for an archive where one table is expected.
fn not_one_table(path: &Path) -> Error {
    Error::data(
        path.display().to_string(),
        "a text table (CSV), Parquet or one NumPy array (.npy)",
        "a ZIP archive (.npz or a spreadsheet); save its table as CSV or .npy (`sindy pde` reads the fields of an .npz)",
    )
}

/// How large a file is, as far as that is known without reading it.
pub(crate) struct Size {
    pub(crate) bytes: u64,
    /// Exact for Parquet, estimated for the others.
    pub(crate) rows: u64,
}

/// The size of a file; nothing for one that cannot be opened, which its reader will report.
pub(crate) fn size(path: &Path, columns: &[String]) -> Size {
    let bytes = std::fs::metadata(path).map_or(0, |m| m.len());
    let rows = match Format::of(path) {
        Ok(Format::Parquet) => parquet::open(path).map_or(0, |table| table.rows() as u64),
        Ok(Format::Npy) => bytes / (8 * columns.len().max(1) as u64),
        Ok(Format::Text) => text::lines(path, bytes),
        Ok(Format::Zip) | Err(_) => 0,
    };
    Size { bytes, rows }
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
