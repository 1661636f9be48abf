//! The values of one column of a row group: numbers and text.

use super::pages::Pages;
use parquet::basic::{ConvertedType, LogicalType, TimeUnit, Type};
use parquet::column::page::PageReader;
use parquet::column::reader::{ColumnReader, ColumnReaderImpl, get_column_reader};
use parquet::data_type::DataType;
use parquet::errors::{ParquetError, Result};
use parquet::schema::types::ColumnDescPtr;

/// Values that are decoded at once: 64 KB, which stay in the processor's caches. The value affects
/// only speed.
const BLOCK: usize = 8192;

/// Most bytes of a decimal fraction: 38 digits, which is as much as other programs write.
const DECIMAL_BYTES: usize = 16;

/// Type of a column's values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Content {
    Number,
    Unsigned,
    /// Decimal fractions: whole numbers of so many to one.
    Decimal(f64),
    /// Time stamps, with so many units to the second.
    Stamp(f64),
    Text,
    /// A type that a table cannot hold.
    Other,
}

impl Content {
    pub(super) fn of(column: &ColumnDescPtr) -> Self {
        match column.physical_type() {
            Type::BOOLEAN | Type::FLOAT | Type::DOUBLE => return Self::Number,
            Type::INT32 | Type::INT64 => {}
            Type::FIXED_LEN_BYTE_ARRAY => {
                let has_size = (1..=DECIMAL_BYTES as i32).contains(&column.type_length());
                return decimal(column).filter(|_| has_size).unwrap_or(Self::Other);
            }
            Type::BYTE_ARRAY => return Self::Text,
            _ => return Self::Other,
        }
        let unit = |unit: &TimeUnit| match unit {
            TimeUnit::MILLIS => 1e3,
            TimeUnit::MICROS => 1e6,
            TimeUnit::NANOS => 1e9,
        };
        if let Some(decimal) = decimal(column) {
            return decimal;
        }
        use ConvertedType as Old;
        match (column.logical_type_ref(), column.converted_type()) {
            (Some(LogicalType::Timestamp(t) | LogicalType::Time(t)), _) => {
                Self::Stamp(unit(&t.unit))
            }
            (Some(LogicalType::Integer(t)), _) if !t.is_signed => Self::Unsigned,
            (Some(LogicalType::Date), _) => Self::Other,
            (Some(_), _) => Self::Number,
            (_, Old::TIMESTAMP_MILLIS | Old::TIME_MILLIS) => Self::Stamp(1e3),
            (_, Old::TIMESTAMP_MICROS | Old::TIME_MICROS) => Self::Stamp(1e6),
            (_, Old::UINT_8 | Old::UINT_16 | Old::UINT_32 | Old::UINT_64) => Self::Unsigned,
            (_, Old::DATE) => Self::Other,
            _ => Self::Number,
        }
    }
}

/// The content of a column of decimal fractions.
fn decimal(column: &ColumnDescPtr) -> Option<Content> {
    let is_new = matches!(column.logical_type_ref(), Some(LogicalType::Decimal(_)));
    let is_decimal = is_new || column.converted_type() == ConvertedType::DECIMAL;
    // Powers of ten of positive exponents to 22 are exact.
    is_decimal.then(|| Content::Decimal(10_f64.powi(column.type_scale())))
}

/// The whole number in these bytes, the first of which is the highest and has the sign.
fn whole_number(bytes: &[u8]) -> f64 {
    let sign = match bytes.first() {
        Some(first) if *first >= 0x80 => 0xff,
        _ => 0,
    };
    let mut all = [sign; DECIMAL_BYTES];
    let from = DECIMAL_BYTES.saturating_sub(bytes.len());
    all[from..].copy_from_slice(&bytes[..DECIMAL_BYTES - from]);
    i128::from_be_bytes(all) as f64
}

/// The reader of the values of a column in these pages.
pub(super) fn column_reader(pages: Box<dyn PageReader>, column: &ColumnDescPtr) -> ColumnReader {
    get_column_reader(column.clone(), Box::new(Pages::new(pages)))
}

/// Appends the next numbers, `most` at most, NaN for nulls, and returns their count. Stamps are in seconds
/// since `origin`, which is the first one.
pub(super) fn numbers(
    reader: &mut ColumnReader,
    column: &ColumnDescPtr,
    content: Content,
    origin: &mut Option<i64>,
    most: usize,
    out: &mut Vec<f64>,
) -> Result<usize> {
    let mut whole = |value: Option<i64>, narrow: bool| match (value, content) {
        (None, _) => f64::NAN,
        // The difference of whole numbers is exact; that of seconds would be rounded.
        (Some(v), Content::Stamp(unit)) => v.wrapping_sub(*origin.get_or_insert(v)) as f64 / unit,
        (Some(v), Content::Unsigned) if narrow => f64::from(v as u32),
        (Some(v), Content::Unsigned) => v as u64 as f64,
        (Some(v), Content::Decimal(one)) => v as f64 / one,
        (Some(v), _) => v as f64,
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
        ColumnReader::FixedLenByteArrayColumnReader(r) if let Content::Decimal(one) = content => {
            each(r, column, most, |v| {
                out.push(v.map_or(f64::NAN, |v| whole_number(v.data()) / one));
            })
        }
        _ => Err(ParquetError::General("a column without numbers".to_owned())),
    }
}

/// Appends the next texts, `most` at most, `None` for nulls, and returns their count. A dictionary may repeat a
/// long text any number of times, so their bytes are limited, too.
pub(super) fn texts(
    reader: &mut ColumnReader,
    column: &ColumnDescPtr,
    (most, most_bytes): (usize, u64),
    out: &mut Vec<Option<String>>,
) -> Result<usize> {
    let ColumnReader::ByteArrayColumnReader(reader) = reader else {
        return Err(ParquetError::General("a column without text".to_owned()));
    };
    let mut bytes = 0_u64;
    let count = each(reader, column, most, |text| {
        bytes += text.map_or(0, |text| text.data().len() as u64);
        let text = text.filter(|_| bytes <= most_bytes);
        out.push(text.map(|text| String::from_utf8_lossy(text.data()).into_owned()));
    })?;
    if bytes > most_bytes {
        let text = format!("more than {most_bytes} bytes of text in {}", column.path());
        return Err(ParquetError::General(text));
    }
    Ok(count)
}

/// Hands over the next values of a column, `most` at most, `None` for nulls, and returns their count.
fn each<T: DataType>(
    reader: &mut ColumnReaderImpl<T>,
    column: &ColumnDescPtr,
    most: usize,
    mut visit: impl FnMut(Option<&T::T>),
) -> Result<usize> {
    let present = column.max_def_level();
    let (mut values, mut levels) = (Vec::new(), Vec::new());
    let mut done = 0;
    while done < most {
        values.clear();
        levels.clear();
        let room = BLOCK.min(most - done);
        let (records, _, _) = reader.read_records(room, Some(&mut levels), None, &mut values)?;
        if records == 0 {
            break;
        }
        done += records;
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
    Ok(done)
}
