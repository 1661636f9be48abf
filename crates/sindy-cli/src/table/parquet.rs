//! Parquet files: only the columns that are asked for are read, row group by row group.

use std::fs::File;
use std::path::Path;

use parquet::basic::{ConvertedType, LogicalType, TimeUnit, Type};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::DataType;
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader as _, SerializedFileReader};
use parquet::schema::types::ColumnDescPtr;
use touchdown_log::Findings;

use super::{Store, Table, label};
use crate::error::{Error, Result};

/// Values that are decoded at once.
const CHUNK: usize = 8192;

/// An opened file.
pub(super) struct Parquet {
    reader: SerializedFileReader<File>,
    /// The columns that are not nested, in the order of their names.
    columns: Vec<(usize, ColumnDescPtr)>,
    rows: usize,
}

/// How the numbers of a column are meant.
#[derive(Clone, Copy)]
enum Meaning {
    Number,
    Unsigned,
    /// Stamps, with so many to the second.
    Stamp(f64),
}

pub(super) fn open(path: &Path) -> Result<Table> {
    let at = path.display().to_string();
    let file = File::open(path).map_err(|e| Error::file(path, e))?;
    let reader = SerializedFileReader::new(file).map_err(|e| broken(&at, &e))?;
    let metadata = reader.metadata().file_metadata();
    let rows = usize::try_from(metadata.num_rows()).unwrap_or(0);
    let columns: Vec<(usize, ColumnDescPtr)> = metadata
        .schema_descr()
        .columns()
        .iter()
        .cloned()
        .enumerate()
        .filter(|(_, column)| column.max_rep_level() == 0)
        .collect();
    if rows == 0 {
        let reason = "the file has none".to_owned();
        return Err(Error::NoRows { at, reason });
    }
    Ok(Table {
        path: at,
        names: columns.iter().map(|(_, c)| c.path().string()).collect(),
        store: Store::Parquet(Parquet {
            reader,
            columns,
            rows,
        }),
        findings: Findings {
            rows_read: rows,
            rows_used: rows,
            ..Findings::default()
        },
    })
}

fn broken(at: &str, error: &ParquetError) -> Error {
    Error::NoRows {
        at: at.to_owned(),
        reason: format!("the Parquet file cannot be read: {error}"),
    }
}

impl Parquet {
    pub(super) fn rows(&self) -> usize {
        self.rows
    }

    /// Columns as numbers.
    pub(super) fn numbers(
        &self,
        at: &str,
        names: &[String],
        places: &[usize],
    ) -> Result<Vec<Vec<f64>>> {
        let mut columns: Vec<Vec<f64>> = places.iter().map(|_| Vec::new()).collect();
        let mut origins = vec![None; places.len()];
        self.for_each_group(at, |group| {
            for ((column, &place), origin) in columns.iter_mut().zip(places).zip(&mut origins) {
                let (leaf, description) = &self.columns[place];
                let meaning = self.meaning(at, names, place)?;
                let mut reader = group.get_column_reader(*leaf).map_err(|e| broken(at, &e))?;
                numbers(
                    &mut reader,
                    description,
                    meaning,
                    origin,
                    usize::MAX,
                    column,
                )
                .map_err(|e| broken(at, &e))?;
            }
            Ok(())
        })?;
        for column in &columns {
            self.check_rows(at, column.len())?;
        }
        Ok(columns)
    }

    /// A column of text or numbers as labels.
    pub(super) fn labels(&self, at: &str, names: &[String], place: usize) -> Result<Vec<String>> {
        let (leaf, description) = &self.columns[place];
        if description.physical_type() != Type::BYTE_ARRAY {
            let numbers = self.numbers(at, names, &[place])?;
            return Ok(numbers.into_iter().flatten().map(label).collect());
        }
        let mut labels = Vec::new();
        self.for_each_group(at, |group| {
            let mut reader = group.get_column_reader(*leaf).map_err(|e| broken(at, &e))?;
            texts(&mut reader, description, usize::MAX, &mut labels).map_err(|e| broken(at, &e))?;
            Ok(())
        })?;
        self.check_rows(at, labels.len())?;
        Ok(labels)
    }

    /// What the numbers of a column are.
    fn meaning(&self, at: &str, names: &[String], place: usize) -> Result<Meaning> {
        let description = &self.columns[place].1;
        meaning(description).ok_or_else(|| {
            let at = format!("{at}, column `{}`", names[place]);
            Error::data(at, "numbers", kind(description))
        })
    }

    fn for_each_group(
        &self,
        at: &str,
        mut visit: impl FnMut(&dyn parquet::file::reader::RowGroupReader) -> Result<()>,
    ) -> Result<()> {
        for group in 0..self.reader.num_row_groups() {
            let group = self
                .reader
                .get_row_group(group)
                .map_err(|e| broken(at, &e))?;
            visit(group.as_ref())?;
        }
        Ok(())
    }

    fn check_rows(&self, at: &str, found: usize) -> Result<()> {
        if found == self.rows {
            return Ok(());
        }
        let expected = format!("{} rows, as its footer says", self.rows);
        Err(Error::data(at, expected, found.to_string()))
    }
}

/// What the column's numbers are; `None` for what is no number.
fn meaning(column: &ColumnDescPtr) -> Option<Meaning> {
    match column.physical_type() {
        Type::BOOLEAN | Type::FLOAT | Type::DOUBLE => return Some(Meaning::Number),
        Type::INT32 | Type::INT64 => {}
        _ => return None,
    }
    let unit = |unit: &TimeUnit| match unit {
        TimeUnit::MILLIS => 1e3,
        TimeUnit::MICROS => 1e6,
        TimeUnit::NANOS => 1e9,
    };
    match (column.logical_type_ref(), column.converted_type()) {
        (Some(LogicalType::Timestamp(t) | LogicalType::Time(t)), _) => {
            Some(Meaning::Stamp(unit(&t.unit)))
        }
        (Some(LogicalType::Integer(t)), _) if !t.is_signed => Some(Meaning::Unsigned),
        (Some(LogicalType::Integer(_)), _) => Some(Meaning::Number),
        (Some(LogicalType::Decimal(_) | LogicalType::Date), _) => None,
        (_, ConvertedType::TIMESTAMP_MILLIS | ConvertedType::TIME_MILLIS) => {
            Some(Meaning::Stamp(1e3))
        }
        (_, ConvertedType::TIMESTAMP_MICROS | ConvertedType::TIME_MICROS) => {
            Some(Meaning::Stamp(1e6))
        }
        (_, ConvertedType::UINT_32 | ConvertedType::UINT_64) => Some(Meaning::Unsigned),
        (_, ConvertedType::DECIMAL | ConvertedType::DATE) => None,
        _ => Some(Meaning::Number),
    }
}

/// The column's type, for messages.
fn kind(column: &ColumnDescPtr) -> String {
    match column.logical_type_ref() {
        Some(logical) => format!("{logical:?}"),
        None => format!("{} values", column.physical_type()),
    }
}

/// Appends the next numbers of a column chunk, so many at most, and gives how many there were.
fn numbers(
    reader: &mut ColumnReader,
    column: &ColumnDescPtr,
    meaning: Meaning,
    origin: &mut Option<i64>,
    most: usize,
    out: &mut Vec<f64>,
) -> std::result::Result<usize, ParquetError> {
    let mut whole = |value: Option<i64>, narrow: bool| match (value, meaning) {
        (None, _) => f64::NAN,
        (Some(v), Meaning::Number) => v as f64,
        (Some(v), Meaning::Unsigned) if narrow => f64::from(v as u32),
        (Some(v), Meaning::Unsigned) => v as u64 as f64,
        // The difference of whole numbers is exact where that of seconds is not.
        (Some(v), Meaning::Stamp(unit)) => v.wrapping_sub(*origin.get_or_insert(v)) as f64 / unit,
    };
    match reader {
        ColumnReader::BoolColumnReader(r) => each(r, column, most, |v| {
            out.push(v.map_or(f64::NAN, |&v| f64::from(u8::from(v))));
        }),
        ColumnReader::Int32ColumnReader(r) => each(r, column, most, |v| {
            out.push(whole(v.map(|&v| i64::from(v)), true));
        }),
        ColumnReader::Int64ColumnReader(r) => each(r, column, most, |v| {
            out.push(whole(v.copied(), false));
        }),
        ColumnReader::FloatColumnReader(r) => each(r, column, most, |v| {
            out.push(v.map_or(f64::NAN, |&v| v.into()));
        }),
        ColumnReader::DoubleColumnReader(r) => each(r, column, most, |v| {
            out.push(v.copied().unwrap_or(f64::NAN));
        }),
        _ => Err(ParquetError::General("a column without numbers".to_owned())),
    }
}

/// Appends the next texts of a column chunk, so many at most, empty for nulls, and gives how many there were.
fn texts(
    reader: &mut ColumnReader,
    column: &ColumnDescPtr,
    most: usize,
    out: &mut Vec<String>,
) -> std::result::Result<usize, ParquetError> {
    match reader {
        ColumnReader::ByteArrayColumnReader(r) => each(r, column, most, |text| {
            let text = text.map(|t| String::from_utf8_lossy(t.data()).into_owned());
            out.push(text.unwrap_or_default());
        }),
        _ => Err(ParquetError::General("a column without text".to_owned())),
    }
}

/// Hands over the next values of a column chunk, so many at most, `None` for nulls, and gives how many there were.
fn each<T: DataType>(
    reader: &mut ColumnReaderImpl<T>,
    column: &ColumnDescPtr,
    most: usize,
    mut visit: impl FnMut(Option<&T::T>),
) -> std::result::Result<usize, ParquetError> {
    let present = column.max_def_level();
    let room = CHUNK.min(most);
    let (mut values, mut levels) = (Vec::with_capacity(room), Vec::with_capacity(room));
    let mut done = 0;
    while done < most {
        values.clear();
        levels.clear();
        let room = CHUNK.min(most - done);
        let (records, _, _) = reader.read_records(room, Some(&mut levels), None, &mut values)?;
        if records == 0 {
            break;
        }
        done += records;
        if present == 0 {
            values.iter().for_each(|v| visit(Some(v)));
        } else {
            let mut values = values.iter();
            for &level in &levels {
                visit(if level == present {
                    values.next()
                } else {
                    None
                });
            }
        }
    }
    Ok(done)
}

/// The rows of some columns, from the first on.
pub(super) struct Rows {
    file: Parquet,
    places: Vec<usize>,
    /// The column of labels, and whether they are text.
    label: Option<(usize, bool)>,
    meanings: Vec<Meaning>,
    origins: Vec<Option<i64>>,
    /// The next row group, and the readers of the present one, that of the labels last.
    group: usize,
    readers: Vec<ColumnReader>,
    done: usize,
}

impl Rows {
    pub(super) fn new(
        file: Parquet,
        at: &str,
        names: &[String],
        places: &[usize],
        label: Option<usize>,
    ) -> Result<Self> {
        let label = label.map(|place| {
            let text = file.columns[place].1.physical_type() == Type::BYTE_ARRAY;
            (place, text)
        });
        let places: Vec<usize> = places
            .iter()
            .copied()
            .chain(label.filter(|(_, text)| !text).map(|(place, _)| place))
            .collect();
        let meanings = places
            .iter()
            .map(|&p| file.meaning(at, names, p))
            .collect::<Result<Vec<_>>>()?;
        Ok(Self {
            origins: vec![None; places.len()],
            places,
            label,
            meanings,
            file,
            group: 0,
            readers: Vec::new(),
            done: 0,
        })
    }

    /// The rows that were read, as a share of all.
    pub(super) fn share(&self) -> f64 {
        self.done as f64 / self.file.rows.max(1) as f64
    }

    /// The next rows, `most` at most, and their labels; none at the end.
    pub(super) fn next(&mut self, at: &str, most: usize) -> Result<Option<super::Columns>> {
        loop {
            if self.readers.is_empty() {
                if self.group == self.file.reader.num_row_groups() {
                    return match self.done == self.file.rows {
                        true => Ok(None),
                        false => self.file.check_rows(at, self.done).map(|()| None),
                    };
                }
                self.open_group(at)?;
            }
            let mut columns: Vec<Vec<f64>> = Vec::new();
            let mut counts = Vec::new();
            for (k, &place) in self.places.iter().enumerate() {
                let mut column = Vec::with_capacity(most);
                let (description, meaning) = (&self.file.columns[place].1, self.meanings[k]);
                let (reader, origin) = (&mut self.readers[k], &mut self.origins[k]);
                let read = numbers(reader, description, meaning, origin, most, &mut column);
                counts.push(read.map_err(|e| broken(at, &e))?);
                columns.push(column);
            }
            let labels = match self.label {
                None => None,
                Some((_, false)) => columns
                    .pop()
                    .map(|c| c.into_iter().map(label).collect::<Vec<_>>()),
                Some((place, true)) => {
                    let mut labels = Vec::new();
                    let description = &self.file.columns[place].1;
                    let reader = &mut self.readers[self.places.len()];
                    let read = texts(reader, description, most, &mut labels);
                    counts.push(read.map_err(|e| broken(at, &e))?);
                    Some(labels)
                }
            };
            let rows = counts.first().copied().unwrap_or(0);
            if let Some(other) = counts.iter().find(|c| **c != rows) {
                let expected = format!("columns of one length in row group {}", self.group);
                return Err(Error::data(
                    at,
                    expected,
                    format!("{rows} and {other} rows"),
                ));
            }
            if rows == 0 {
                self.readers.clear();
                continue;
            }
            self.done += rows;
            return Ok(Some((columns, labels)));
        }
    }

    fn open_group(&mut self, at: &str) -> Result<()> {
        let group = self.file.reader.get_row_group(self.group);
        let group = group.map_err(|e| broken(at, &e))?;
        let text = self.label.filter(|(_, text)| *text).map(|(place, _)| place);
        for &place in self.places.iter().chain(&text) {
            let reader = group.get_column_reader(self.file.columns[place].0);
            self.readers.push(reader.map_err(|e| broken(at, &e))?);
        }
        self.group += 1;
        Ok(())
    }
}
