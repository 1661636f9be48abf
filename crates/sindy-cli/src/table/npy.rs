//! NumPy arrays.

use std::fs::File;
use std::io::{BufReader, Chain, Cursor, Read};
use std::path::Path;

use npyz::{Deserialize, NpyFile, Order};
use touchdown_log::Findings;

use super::{Store, Table, label};
use crate::error::{Error, Result};

type Reader = NpyFile<Beginning<BufReader<File>>>;

/// What was read of a file, then the rest of it.
type Beginning<R> = Chain<Cursor<Vec<u8>>, R>;
/// Bytes that hold the header of an array.
const HEADER: u64 = 65_546;

/// Opens an array after a look at its header: a shape whose product is beyond all numbers is not for the reader.
fn open_array<R: Read>(mut reader: R, path: &Path) -> Result<NpyFile<Beginning<R>>> {
    let fault = |e| Error::file(path, e);
    let mut start = Vec::new();
    reader
        .by_ref()
        .take(HEADER)
        .read_to_end(&mut start)
        .map_err(fault)?;
    let text = String::from_utf8_lossy(&start);
    let shape = text
        .split_once("'shape'")
        .and_then(|(_, rest)| rest.split_once(')'));
    let shape = shape.map_or("", |(shape, _)| shape);
    let lengths = shape
        .split(|c: char| !c.is_ascii_digit())
        .filter(|n| !n.is_empty());
    let product = lengths
        .map(|n| n.parse().ok())
        .try_fold(1_u64, |product, n: Option<u64>| {
            // A length of 0 hides no other.
            product.checked_mul(n?.max(1))
        });
    if product.is_none() {
        let found = format!("shape {}", shape.trim_start_matches([':', ' ', '(']));
        let at = path.display().to_string();
        return Err(Error::data(
            at,
            "an array of a shape that can be counted",
            found,
        ));
    }
    NpyFile::new(Cursor::new(start).chain(reader)).map_err(fault)
}

/// An array of any number of dimensions, in the order of C.
pub(crate) struct NpyArray {
    pub(crate) shape: Vec<usize>,
    pub(crate) values: Vec<f64>,
}

impl NpyArray {
    /// Reads an array from a file or a part of one that has `length` bytes.
    pub(crate) fn read(reader: impl Read + 'static, path: &Path, length: u64) -> Result<Self> {
        let array = open_array(reader, path)?;
        let (shape, by_columns) = (array.shape().to_vec(), array.order() == Order::Fortran);
        let count = shape.iter().try_fold(1_u64, |n, s| n.checked_mul(*s));
        if count.is_none_or(|items| items > length) {
            let expected = format!("an array of shape {shape:?}");
            let found = format!("a file of {length} bytes");
            return Err(Error::data(path.display().to_string(), expected, found));
        }
        let values = items(array, path)?
            .collect::<std::io::Result<Vec<f64>>>()
            .map_err(|e| Error::file(path, e))?;
        let shape: Vec<usize> = shape.iter().map(|n| *n as usize).collect();
        let values = match by_columns {
            true => by_rows(&values, &shape),
            false => values,
        };
        Ok(Self { shape, values })
    }
}

/// Values in the order of Fortran in that of C.
fn by_rows(values: &[f64], shape: &[usize]) -> Vec<f64> {
    let at = |place: usize| {
        let (mut rest, mut from, mut stride) = (place, 0, 1);
        let inner = |axis: usize| shape[axis + 1..].iter().product::<usize>();
        for (axis, length) in shape.iter().enumerate() {
            from += rest / inner(axis) * stride;
            rest %= inner(axis);
            stride *= length;
        }
        values[from]
    };
    (0..values.len()).map(at).collect()
}

/// The header of an array, checked.
struct Head {
    array: Reader,
    rows: usize,
    width: usize,
    by_columns: bool,
}

/// An array of two dimensions, rows by columns; one of one dimension is a single column.
fn head(path: &Path, names: &[String]) -> Result<Head> {
    let file = File::open(path).map_err(|e| Error::file(path, e))?;
    let length = file.metadata().map_err(|e| Error::file(path, e))?.len();
    let array = open_array(BufReader::new(file), path)?;
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
    Ok(Head {
        rows: rows as usize,
        width: width as usize,
        by_columns: array.order() == Order::Fortran,
        array,
    })
}

pub(super) fn open(path: &Path, names: &[String]) -> Result<Table> {
    let Head {
        array,
        rows,
        width,
        by_columns,
    } = head(path, names)?;
    let values = items(array, path)?
        .collect::<std::io::Result<Vec<f64>>>()
        .map_err(|e| Error::file(path, e))?;
    let columns = (0..width)
        .map(|c| match by_columns {
            true => values[c * rows..][..rows].to_vec(),
            false => values.iter().skip(c).step_by(width).copied().collect(),
        })
        .collect();
    Ok(Table {
        path: path.display().to_string(),
        names: names.to_vec(),
        store: Store::Npy(columns),
        findings: Findings {
            rows_read: rows,
            rows_used: rows,
            ..Findings::default()
        },
    })
}

type Items = Box<dyn Iterator<Item = std::io::Result<f64>>>;

/// All items in the order of the file, as `f64`.
fn items<R: Read + 'static>(array: NpyFile<R>, path: &Path) -> Result<Items> {
    let found = attempt::<R, f64>(array, |v| v)
        .or_else(|array| attempt::<R, f32>(*array, f64::from))
        .or_else(|array| attempt::<R, i64>(*array, |v| v as f64))
        .or_else(|array| attempt::<R, i32>(*array, f64::from))
        .or_else(|array| attempt::<R, u32>(*array, f64::from))
        .or_else(|array| attempt::<R, i16>(*array, f64::from))
        .or_else(|array| attempt::<R, u16>(*array, f64::from))
        .or_else(|array| attempt::<R, i8>(*array, f64::from))
        .or_else(|array| attempt::<R, u8>(*array, f64::from))
        .or_else(|array| attempt::<R, bool>(*array, |v| f64::from(u8::from(v))));
    found.map_err(|array| {
        Error::data(
            path.display().to_string(),
            "numbers of type float64, float32, int64, int8 to int32, uint8 to uint32 or bool",
            format!("type {}", array.dtype().descr()),
        )
    })
}

fn attempt<R: Read + 'static, T: Deserialize + 'static>(
    array: NpyFile<R>,
    number: impl Fn(T) -> f64 + 'static,
) -> std::result::Result<Items, Box<NpyFile<R>>> {
    let items = array.try_data::<T>().map_err(Box::new)?;
    Ok(Box::new(items.map(move |item| item.map(&number))))
}

/// The rows of some columns, from the first on.
pub(super) struct Rows {
    items: Items,
    places: Vec<usize>,
    label: Option<usize>,
    width: usize,
    rows: usize,
    done: usize,
}

impl Rows {
    pub(super) fn new(
        path: &Path,
        names: &[String],
        places: &[usize],
        label: Option<usize>,
    ) -> Result<Self> {
        let head = head(path, names)?;
        if head.by_columns && head.width > 1 {
            return Err(Error::data(
                path.display().to_string(),
                "an array stored row by row, as --stream reads it (numpy.save of numpy.ascontiguousarray)",
                "one stored column by column (fortran_order)",
            ));
        }
        Ok(Self {
            items: items(head.array, path)?,
            places: places.to_vec(),
            label,
            width: head.width,
            rows: head.rows,
            done: 0,
        })
    }

    /// The rows that were read, as a share of all.
    pub(super) fn share(&self) -> f64 {
        self.done as f64 / self.rows.max(1) as f64
    }

    /// The next rows, `most` at most, and their labels; none at the end.
    pub(super) fn next(&mut self, path: &Path, most: usize) -> Result<Option<super::Columns>> {
        let rows = most.min(self.rows - self.done);
        if rows == 0 {
            return Ok(None);
        }
        let mut columns = vec![Vec::with_capacity(rows); self.places.len()];
        let mut labels = self.label.map(|_| Vec::with_capacity(rows));
        let mut row = vec![0.0; self.width];
        for _ in 0..rows {
            for cell in &mut row {
                let item = self.items.next().unwrap_or_else(|| {
                    Err(std::io::Error::from(std::io::ErrorKind::UnexpectedEof))
                });
                *cell = item.map_err(|e| Error::file(path, e))?;
            }
            for (column, &place) in columns.iter_mut().zip(&self.places) {
                column.push(row[place]);
            }
            if let (Some(labels), Some(place)) = (&mut labels, self.label) {
                labels.push(label(row[place]));
            }
        }
        self.done += rows;
        Ok(Some((columns, labels)))
    }
}
