//! Writes Parquet.

use super::rows::ParquetValues;
use parquet::basic::{Compression, ConvertedType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use std::io;
use std::sync::Arc;

/// The bytes of a Parquet file with these named columns, all of one length, in one row group.
///
/// `schema` names the table, `created_by` the program, and `notes` are keys and values beside the table
/// ([`ParquetFile::note`](super::ParquetFile::note)).
///
/// # Errors
/// [`io::ErrorKind::InvalidInput`] for columns of different lengths.
pub fn to_parquet(
    schema: &str,
    created_by: &str,
    notes: &[(&str, &str)],
    columns: &[(String, ParquetValues)],
) -> io::Result<Vec<u8>> {
    let notes = notes
        .iter()
        .map(|(key, value)| KeyValue::new((*key).to_owned(), (*value).to_owned()));
    let properties = WriterProperties::builder()
        .set_created_by(created_by.to_owned())
        .set_compression(Compression::SNAPPY)
        .set_key_value_metadata(Some(notes.collect()))
        .build();
    let invalid = |error: ParquetError| io::Error::new(io::ErrorKind::InvalidInput, error);
    written(schema, properties, columns).map_err(invalid)
}

fn written(
    schema: &str,
    properties: WriterProperties,
    columns: &[(String, ParquetValues)],
) -> Result<Vec<u8>, ParquetError> {
    let fields: Result<_, ParquetError> = columns
        .iter()
        .map(|(name, values)| field(name, values).map(Arc::new))
        .collect();
    let schema = Type::group_type_builder(schema)
        .with_fields(fields?)
        .build()?;
    let mut bytes = Vec::new();
    let mut writer = SerializedFileWriter::new(&mut bytes, Arc::new(schema), Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    for (_, values) in columns {
        let Some(mut out) = group.next_column()? else {
            break;
        };
        match values {
            ParquetValues::Whole(values) => {
                out.typed::<Int64Type>().write_batch(values, None, None)?
            }
            ParquetValues::Numbers(values) => {
                let there = values.iter().copied().filter(|value| !value.is_nan());
                let levels: Vec<i16> = values.iter().map(|v| i16::from(!v.is_nan())).collect();
                out.typed::<DoubleType>().write_batch(
                    &there.collect::<Vec<_>>(),
                    Some(&levels),
                    None,
                )?
            }
            ParquetValues::Texts(values) => {
                let there = values.iter().flatten().map(|text| text.as_bytes().to_vec());
                let there: Vec<ByteArray> = there.map(ByteArray::from).collect();
                let levels: Vec<i16> = values.iter().map(|v| i16::from(v.is_some())).collect();
                out.typed::<ByteArrayType>()
                    .write_batch(&there, Some(&levels), None)?
            }
        };
        out.close()?;
    }
    group.close()?;
    writer.close()?;
    Ok(bytes)
}

fn field(name: &str, values: &ParquetValues) -> Result<Type, ParquetError> {
    let (physical, converted, repetition) = match values {
        ParquetValues::Whole(_) => (Physical::INT64, ConvertedType::NONE, Repetition::REQUIRED),
        ParquetValues::Numbers(_) => (Physical::DOUBLE, ConvertedType::NONE, Repetition::OPTIONAL),
        ParquetValues::Texts(_) => (
            Physical::BYTE_ARRAY,
            ConvertedType::UTF8,
            Repetition::OPTIONAL,
        ),
    };
    Type::primitive_type_builder(name, physical)
        .with_converted_type(converted)
        .with_repetition(repetition)
        .build()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tables::parquet::{ParquetFile, ParquetRows};

    #[test]
    fn roundtrip_columns_notes_and_blocks() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.parquet");
        let text = |text: &str| Some(text.to_owned());
        let columns = [
            ("n".to_owned(), ParquetValues::Whole(vec![1, -2, 3])),
            (
                "x".to_owned(),
                ParquetValues::Numbers(vec![0.5, f64::NAN, -0.0]),
            ),
            (
                "s".to_owned(),
                ParquetValues::Texts(vec![text("a"), None, text("")]),
            ),
        ];
        let bytes = to_parquet("table", "test", &[("key", "value")], &columns).unwrap();
        std::fs::write(&path, bytes).unwrap();
        let file = ParquetFile::open(&path).unwrap();
        assert_eq!((file.rows(), file.note("key")), (3, Some("value")));
        let read = file.read(&[2, 1, 0]).unwrap();
        assert_eq!(read[0], columns[2].1);
        assert_eq!(format!("{:?}", read[1]), "Numbers([0.5, NaN, -0.0])");
        assert_eq!(read[2], ParquetValues::Numbers(vec![1.0, -2.0, 3.0]));
        let mut rows = ParquetRows::new(file, &[0]).unwrap();
        let blocks = [vec![1.0, -2.0], vec![3.0]];
        for block in blocks {
            let found = rows.next(2).unwrap();
            assert_eq!(found, Some(vec![ParquetValues::Numbers(block)]));
        }
        assert_eq!(rows.next(2).unwrap(), None);
    }

    #[test]
    fn prop_columns_of_different_lengths_are_refused() {
        let columns = [
            ("a".to_owned(), ParquetValues::Whole(vec![1, 2])),
            ("b".to_owned(), ParquetValues::Numbers(vec![1.0])),
        ];
        assert!(to_parquet("table", "test", &[], &columns).is_err());
    }
}
