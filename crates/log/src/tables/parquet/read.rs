//! Reads Parquet files into tables, row group by row group, only the columns that are asked for.

use super::bounded::Bounded;
use super::pages::Pages;
use crate::hashing::sha256_of;
use crate::{Column, ColumnKind, Findings, LogError, Table};
use parquet::basic::{ConvertedType, LogicalType, TimeUnit, Type};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl, get_column_reader};
use parquet::data_type::DataType;
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, Length, RowGroupReader, SerializedFileReader};
use parquet::schema::types::ColumnDescPtr;
use std::fs::File;
use std::io::Read;
use std::ops::Range;
use std::path::Path;

/// How a file starts and ends.
const MAGIC: [u8; 4] = *b"PAR1";
/// Values that are decoded at once.
const BLOCK: usize = 8192;
/// Most rows for each byte of a file, and rows of any file beside.
const ROWS_A_BYTE: u64 = 64;
const ROWS_ANYWAY: u64 = 1 << 20;
/// Longest example of a text cell that is kept, in characters.
const EXAMPLE_CHARS: usize = 40;

/// How the numbers of a column are meant.
#[derive(Clone, Copy, PartialEq)]
enum Meaning {
    Number,
    Unsigned,
    /// Stamps, with so many to the second.
    Stamp(f64),
    Text,
    /// Nothing that a table could hold.
    Other,
}

struct Building {
    leaf: usize,
    column: ColumnDescPtr,
    meaning: Meaning,
    values: Vec<f64>,
    /// The first stamp.
    origin: Option<i64>,
    example: Option<String>,
}

/// Reads a Parquet file into a table: columns of numbers as they are, stamps in seconds from the
/// first one, nulls as gaps; nested columns are left out. With `wanted`, only those columns are
/// read.
///
/// A row group that is damaged is left out and counted as corrupt rows.
///
/// # Errors
/// [`LogError::Read`], [`LogError::NotALog`] for a file without its last part, which holds the
/// table of contents, and [`LogError::NoUsableRows`].
pub fn read_parquet(
    path: impl AsRef<Path>,
    wanted: Option<&dyn Fn(&str) -> bool>,
) -> Result<(Table, Findings), LogError> {
    let path = path.as_ref();
    let (mut columns, mut row_numbers): (Vec<Column>, Vec<usize>) = Default::default();
    let (sha256, findings) = each_group(path, wanted, &mut |group, rows| {
        row_numbers.extend(rows);
        if columns.is_empty() {
            columns = group;
            return;
        }
        for (column, more) in columns.iter_mut().zip(group) {
            column.values.extend(more.values);
            // The first text may come late.
            column.kind = more.kind;
        }
    })?;
    let table = Table {
        path: path.display().to_string(),
        sha256,
        row_numbers,
        columns,
    };
    Ok((table, findings))
}

/// Hands over the row groups that are whole with their rows' numbers, and tells the file's SHA-256.
pub(crate) fn each_group(
    path: &Path,
    wanted: Option<&dyn Fn(&str) -> bool>,
    visit: &mut dyn FnMut(Vec<Column>, Range<usize>),
) -> Result<(String, Findings), LogError> {
    let name = path.display().to_string();
    let of_read = |source| LogError::Read {
        path: name.clone(),
        source,
    };
    let broken = |error: &ParquetError| LogError::NotALog {
        path: name.clone(),
        found: format!("a Parquet file that cannot be read: {error}"),
    };
    let file = File::open(path).map_err(of_read)?;
    let sha256 = sha256_of(&file).map_err(of_read)?;
    let file = Bounded::new(file).map_err(of_read)?;
    let most_rows = file.len() * ROWS_A_BYTE + ROWS_ANYWAY;
    let reader = SerializedFileReader::new(file).map_err(|e| broken(&e))?;
    let schema = reader.metadata().file_metadata().schema_descr();
    let mut findings = Findings::default();
    let mut columns = Vec::new();
    for (leaf, column) in schema.columns().iter().enumerate() {
        let label = column.path().string();
        if column.max_rep_level() > 0 {
            findings
                .warnings
                .push(format!("{label}: left out, for it holds lists"));
        } else if wanted.is_none_or(|wanted| wanted(&label)) {
            columns.push(Building {
                leaf,
                column: column.clone(),
                meaning: meaning(column),
                values: Vec::new(),
                origin: None,
                example: None,
            });
        }
    }
    for group in 0..reader.num_row_groups() {
        let told = reader.metadata().row_group(group).num_rows();
        let rows = usize::try_from(told).unwrap_or(0);
        // A number of rows that nothing bears out must not take memory, and does not count.
        let is_borne_out = (findings.rows_used as u64).saturating_add(rows as u64) <= most_rows;
        let rows = if is_borne_out { rows } else { 0 };
        let first = findings.rows_read;
        findings.rows_read = findings.rows_read.saturating_add(rows);
        let opened = if is_borne_out {
            reader.get_row_group(group)
        } else {
            let text = "there are not that many in a file of its size".to_owned();
            Err(ParquetError::General(text))
        };
        let read = opened.and_then(|group| read_group(group.as_ref(), &mut columns, rows));
        match read {
            Ok(()) => {
                findings.rows_used += rows;
                let group: Vec<Column> = columns.iter_mut().map(Building::take).collect();
                for column in &group {
                    column.count(&mut findings);
                }
                visit(group, first..first + rows);
            }
            Err(error) => {
                findings.corrupt_rows = findings.corrupt_rows.saturating_add(rows.max(1));
                let text = format!("row group {group} of {told} rows is damaged: {error}");
                findings.warnings.push(text);
                columns.iter_mut().for_each(|column| column.values.clear());
            }
        }
    }
    if findings.rows_used == 0 {
        let reason = match findings.corrupt_rows {
            0 => "the file has none".to_owned(),
            _ => findings.warnings.join("; "),
        };
        return Err(LogError::NoUsableRows { path: name, reason });
    }
    Ok((sha256, findings))
}

/// By its first bytes; what cannot be opened is for others to tell.
pub(crate) fn is_parquet(path: &Path) -> bool {
    let mut start = [0; 4];
    let read = File::open(path).and_then(|mut file| file.read_exact(&mut start));
    read.is_ok() && start == MAGIC
}

/// Reads the rows of a group into every column.
fn read_group(
    group: &dyn RowGroupReader,
    columns: &mut [Building],
    rows: usize,
) -> Result<(), ParquetError> {
    for column in columns {
        let pages = Pages::new(group.get_column_page_reader(column.leaf)?);
        let mut reader = get_column_reader(column.column.clone(), Box::new(pages));
        match column.meaning {
            Meaning::Text => {
                column.example = match column.example.take() {
                    Some(example) => Some(example),
                    None => first_text(&mut reader, &column.column)?,
                };
                column.values.resize(rows, f64::NAN);
            }
            Meaning::Other => column.values.resize(rows, f64::NAN),
            _ => column.numbers(&mut reader)?,
        }
        if column.values.len() != rows {
            let found = column.values.len();
            let text = format!("{} has {found} values", column.column.path().string());
            return Err(ParquetError::General(text));
        }
    }
    Ok(())
}

impl Building {
    fn numbers(&mut self, reader: &mut ColumnReader) -> Result<(), ParquetError> {
        let (meaning, origin, out) = (self.meaning, &mut self.origin, &mut self.values);
        let mut whole = |value: Option<i64>, narrow: bool| match (value, meaning) {
            (None, _) => f64::NAN,
            // The difference of whole numbers is exact where that of seconds is not.
            (Some(v), Meaning::Stamp(unit)) => {
                v.wrapping_sub(*origin.get_or_insert(v)) as f64 / unit
            }
            (Some(v), Meaning::Unsigned) if narrow => f64::from(v as u32),
            (Some(v), Meaning::Unsigned) => v as u64 as f64,
            (Some(v), _) => v as f64,
        };
        let column = &self.column;
        match reader {
            ColumnReader::BoolColumnReader(r) => each(r, column, |v| {
                out.push(v.map_or(f64::NAN, |&v| f64::from(u8::from(v))));
            }),
            ColumnReader::Int32ColumnReader(r) => each(r, column, |v| {
                out.push(whole(v.map(|&v| i64::from(v)), true));
            }),
            ColumnReader::Int64ColumnReader(r) => {
                each(r, column, |v| out.push(whole(v.copied(), false)))
            }
            ColumnReader::FloatColumnReader(r) => each(r, column, |v| {
                out.push(v.map_or(f64::NAN, |&v| v.into()));
            }),
            ColumnReader::DoubleColumnReader(r) => each(r, column, |v| {
                out.push(v.copied().unwrap_or(f64::NAN));
            }),
            _ => Err(ParquetError::General("a column without numbers".to_owned())),
        }
    }

    /// The values that were read.
    fn take(&mut self) -> Column {
        let kind = match self.meaning {
            Meaning::Number | Meaning::Unsigned => ColumnKind::Number,
            Meaning::Stamp(_) => ColumnKind::Stamp,
            Meaning::Text => ColumnKind::Text {
                example: self.example.clone().unwrap_or_default(),
            },
            Meaning::Other => ColumnKind::Text {
                example: format!("{}", self.column.physical_type()),
            },
        };
        Column {
            name: self.column.path().string(),
            kind,
            values: std::mem::take(&mut self.values),
        }
    }
}

/// What the column's values are.
fn meaning(column: &ColumnDescPtr) -> Meaning {
    match column.physical_type() {
        Type::BOOLEAN | Type::FLOAT | Type::DOUBLE => return Meaning::Number,
        Type::INT32 | Type::INT64 => {}
        Type::BYTE_ARRAY => return Meaning::Text,
        _ => return Meaning::Other,
    }
    let unit = |unit: &TimeUnit| match unit {
        TimeUnit::MILLIS => 1e3,
        TimeUnit::MICROS => 1e6,
        TimeUnit::NANOS => 1e9,
    };
    match (column.logical_type_ref(), column.converted_type()) {
        (Some(LogicalType::Timestamp(t) | LogicalType::Time(t)), _) => {
            Meaning::Stamp(unit(&t.unit))
        }
        (Some(LogicalType::Integer(t)), _) if !t.is_signed => Meaning::Unsigned,
        (Some(LogicalType::Decimal(_) | LogicalType::Date), _) => Meaning::Other,
        (Some(_), _) => Meaning::Number,
        (_, ConvertedType::TIMESTAMP_MILLIS | ConvertedType::TIME_MILLIS) => Meaning::Stamp(1e3),
        (_, ConvertedType::TIMESTAMP_MICROS | ConvertedType::TIME_MICROS) => Meaning::Stamp(1e6),
        (_, ConvertedType::UINT_8 | ConvertedType::UINT_16 | ConvertedType::UINT_32) => {
            Meaning::Unsigned
        }
        (_, ConvertedType::UINT_64) => Meaning::Unsigned,
        (_, ConvertedType::DECIMAL | ConvertedType::DATE) => Meaning::Other,
        _ => Meaning::Number,
    }
}

fn first_text(
    reader: &mut ColumnReader,
    column: &ColumnDescPtr,
) -> Result<Option<String>, ParquetError> {
    let ColumnReader::ByteArrayColumnReader(reader) = reader else {
        return Ok(None);
    };
    let (mut values, mut levels) = (Vec::new(), Vec::new());
    let levels = (column.max_def_level() > 0).then_some(&mut levels);
    reader.read_records(1, levels, None, &mut values)?;
    let text = values
        .first()
        .map(|text| String::from_utf8_lossy(text.data()).into_owned());
    Ok(text.map(|text| text.chars().take(EXAMPLE_CHARS).collect()))
}

/// Hands over the values of a column chunk in order, `None` for nulls.
fn each<T: DataType>(
    reader: &mut ColumnReaderImpl<T>,
    column: &ColumnDescPtr,
    mut visit: impl FnMut(Option<&T::T>),
) -> Result<(), ParquetError> {
    let present = column.max_def_level();
    let (mut values, mut levels) = (Vec::new(), Vec::new());
    loop {
        values.clear();
        levels.clear();
        let (records, _, _) = reader.read_records(BLOCK, Some(&mut levels), None, &mut values)?;
        if records == 0 {
            return Ok(());
        }
        if present == 0 {
            values.iter().for_each(|value| visit(Some(value)));
            continue;
        }
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
