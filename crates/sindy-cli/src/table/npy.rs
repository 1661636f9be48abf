//! NumPy arrays.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use npyz::{Deserialize, NpyFile, Order};
use touchdown_log::Findings;

use super::{Store, Table};
use crate::error::{Error, Result};

type Reader = NpyFile<BufReader<File>>;

/// An array of two dimensions, rows by columns; one of one dimension is a single column.
pub(super) fn open(path: &Path, names: &[String]) -> Result<Table> {
    let file = File::open(path).map_err(|e| Error::file(path, e))?;
    let length = file.metadata().map_err(|e| Error::file(path, e))?.len();
    let array = NpyFile::new(BufReader::new(file)).map_err(|e| Error::file(path, e))?;
    let at = path.display().to_string();
    let (rows, width) = match *array.shape() {
        [rows, width] => (rows, width),
        [rows] => (rows, 1),
        _ => {
            return Err(Error::data(
                at,
                "an array of 2 dimensions, rows by columns",
                format!("one of shape {:?}", array.shape()),
            ));
        }
    };
    let shape = format!("{rows} rows by {width} columns");
    if names.len() as u64 != width {
        let found = match names {
            [] => {
                format!("{shape} without names; name them with --columns, such as --columns t,x,y")
            }
            _ => format!("{shape} and {} names in --columns", names.len()),
        };
        return Err(Error::data(at, "one name for each column", found));
    }
    // Each item takes a byte at least: a header that promises more than the file holds is not believed.
    if rows.checked_mul(width).is_none_or(|items| items > length) {
        let found = format!("a file of {length} bytes");
        return Err(Error::data(at, format!("an array of {shape}"), found));
    }
    if rows == 0 {
        let reason = "the array has none".to_owned();
        return Err(Error::NoRows { at, reason });
    }
    let (rows, width) = (rows as usize, width as usize);
    let by_columns = array.order() == Order::Fortran;
    let values = values(array, path)?;
    let columns = (0..width)
        .map(|c| match by_columns {
            true => values[c * rows..][..rows].to_vec(),
            false => values.iter().skip(c).step_by(width).copied().collect(),
        })
        .collect();
    Ok(Table {
        path: at,
        names: names.to_vec(),
        store: Store::Npy(columns),
        findings: Findings {
            rows_read: rows,
            rows_used: rows,
            ..Findings::default()
        },
    })
}

/// All items in the order of the file, as `f64`.
fn values(array: Reader, path: &Path) -> Result<Vec<f64>> {
    let array = match attempt::<f64>(array, path, |v| v)? {
        Ok(values) => return Ok(values),
        Err(array) => array,
    };
    let array = match attempt::<f32>(array, path, f64::from)? {
        Ok(values) => return Ok(values),
        Err(array) => array,
    };
    let array = match attempt::<i64>(array, path, |v| v as f64)? {
        Ok(values) => return Ok(values),
        Err(array) => array,
    };
    let array = match attempt::<i32>(array, path, f64::from)? {
        Ok(values) => return Ok(values),
        Err(array) => array,
    };
    let array = match attempt::<bool>(array, path, |v| f64::from(u8::from(v)))? {
        Ok(values) => return Ok(values),
        Err(array) => array,
    };
    Err(Error::data(
        path.display().to_string(),
        "numbers of type float64, float32, int64, int32 or bool",
        format!("type {}", array.dtype().descr()),
    ))
}

fn attempt<T: Deserialize>(
    array: Reader,
    path: &Path,
    number: impl Fn(T) -> f64,
) -> Result<std::result::Result<Vec<f64>, Reader>> {
    match array.try_data::<T>() {
        Err(array) => Ok(Err(array)),
        Ok(items) => items
            .map(|item| item.map(&number))
            .collect::<std::io::Result<Vec<f64>>>()
            .map(Ok)
            .map_err(|e| Error::file(path, e)),
    }
}
