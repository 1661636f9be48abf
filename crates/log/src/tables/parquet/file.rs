//! An opened Parquet file: its columns and row groups.

use super::bounded::Bounded;
use super::decode::{Content, column_reader};
use super::rows::{ParquetRows, ParquetValues};
use super::sizes::unpacked;
use crate::{LogError, limits};
use parquet::basic::Compression;
use parquet::column::page::PageReader;
use parquet::column::reader::ColumnReader;
use parquet::errors::ParquetError;
use parquet::file::metadata::RowGroupMetaData;
use parquet::file::reader::{FileReader, Length as _, RowGroupReader, SerializedFileReader};
use parquet::schema::types::ColumnDescPtr;
use std::fs::File;
use std::path::Path;
use std::sync::Arc;

/// An opened Parquet file. A clone reads the same file.
#[derive(Clone)]
pub struct ParquetFile {
    path: String,
    source: Bounded,
    reader: Arc<SerializedFileReader<Bounded>>,
    columns: Vec<ParquetColumn>,
    pub(super) lists: Vec<String>,
}

/// A column of a Parquet file, without its values.
#[derive(Debug, Clone)]
pub struct ParquetColumn {
    pub(super) content: Content,
    pub(super) description: ColumnDescPtr,
    leaf: usize,
}

impl ParquetColumn {
    /// The name, with dots where columns are nested.
    #[must_use]
    pub fn name(&self) -> String {
        self.description.path().string()
    }

    /// Whether it holds numbers, truth values or time stamps.
    #[must_use]
    pub fn is_number(&self) -> bool {
        !matches!(self.content, Content::Text | Content::Other)
    }

    /// Whether it holds text.
    #[must_use]
    pub fn is_text(&self) -> bool {
        self.content == Content::Text
    }

    /// The type of its values as the file states it, for messages.
    #[must_use]
    pub fn type_name(&self) -> String {
        match self.description.logical_type_ref() {
            Some(logical) => format!("{logical:?}"),
            None => format!("{} values", self.description.physical_type()),
        }
    }

    /// The reader of its values in a row group of the file.
    pub(super) fn reader(
        &self,
        file: &ParquetFile,
        group: &dyn RowGroupReader,
    ) -> Result<ColumnReader, ParquetError> {
        // A page is unpacked only if its size is known, see `check`.
        let most = unpacked(&file.source, group.metadata().column(self.leaf))?;
        let pages = self.pages(&file.source, group, most)?;
        Ok(column_reader(pages, &self.description))
    }

    #[cfg(not(target_family = "wasm"))]
    fn pages(
        &self,
        _: &Bounded,
        group: &dyn RowGroupReader,
        _: u64,
    ) -> Result<Box<dyn PageReader>, ParquetError> {
        group.get_column_page_reader(self.leaf)
    }

    /// Pages that unpack to `most` bytes at most.
    #[cfg(target_family = "wasm")]
    fn pages(
        &self,
        file: &Bounded,
        group: &dyn RowGroupReader,
        most: u64,
    ) -> Result<Box<dyn PageReader>, ParquetError> {
        use super::packed::PackedPages;
        match group.metadata().column(self.leaf).compression() {
            Compression::ZSTD(_) => PackedPages::of_column(file, group, self.leaf, most)
                .map(|pages| Box::new(pages) as Box<dyn PageReader>),
            _ => group.get_column_page_reader(self.leaf),
        }
    }
}

impl ParquetFile {
    /// Opens a file. Columns of lists are omitted.
    ///
    /// # Errors
    /// [`LogError::Read`], and [`LogError::NotALog`] for a file without its last part, which holds the
    /// table of contents.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, LogError> {
        let name = path.as_ref().display().to_string();
        match touchdown_files::open(path.as_ref()) {
            Ok(file) => Self::of(file, name),
            Err(source) => Err(LogError::Read { path: name, source }),
        }
    }

    /// As [`Self::open`], of a file that is open already; `name` names it in errors.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub fn of(file: File, name: String) -> Result<Self, LogError> {
        let file = Bounded::new(file).map_err(|source| LogError::Read {
            path: name.clone(),
            source,
        })?;
        let source = file.clone();
        let reader = SerializedFileReader::new(file).map_err(|error| broken(&name, &error))?;
        check_compression(&name, &reader)?;
        let schema = reader.metadata().file_metadata().schema_descr();
        let of_limit = |excess| LogError::excess(&name, excess);
        limits::columns(schema.num_columns()).map_err(of_limit)?;
        let (lists, columns): (Vec<_>, Vec<_>) = schema
            .columns()
            .iter()
            .enumerate()
            .map(|(leaf, description)| ParquetColumn {
                content: Content::of(description),
                description: description.clone(),
                leaf,
            })
            .partition(|column| column.description.max_rep_level() > 0);
        Ok(Self {
            source,
            path: name,
            lists: lists.iter().map(ParquetColumn::name).collect(),
            columns,
            reader: Arc::new(reader),
        })
    }

    /// The path by which the file was opened.
    #[must_use]
    pub fn path(&self) -> &str {
        &self.path
    }

    /// The columns in the file's order.
    #[must_use]
    pub fn columns(&self) -> &[ParquetColumn] {
        &self.columns
    }

    /// The number of rows that the file states.
    #[must_use]
    pub fn rows(&self) -> usize {
        let rows = self.reader.metadata().file_metadata().num_rows();
        usize::try_from(rows).unwrap_or(0)
    }

    /// The file's metadata under a key.
    #[must_use]
    pub fn note(&self, key: &str) -> Option<&str> {
        let notes = self.reader.metadata().file_metadata();
        let note = notes.key_value_metadata()?.iter().find(|n| n.key == key)?;
        note.value.as_deref()
    }

    /// Reads columns, by their places among [`columns`](Self::columns), from the first row to the last.
    ///
    /// # Errors
    /// [`LogError::NotALog`] for a damaged file, or a column that holds neither numbers nor text.
    pub fn read(&self, places: &[usize]) -> Result<Vec<ParquetValues>, LogError> {
        let mut rows = ParquetRows::new(self.clone(), places)?;
        let mut columns: Vec<ParquetValues> = rows.empty();
        while let Some(block) = rows.next(usize::MAX)? {
            for (column, more) in columns.iter_mut().zip(block) {
                column.append(more);
            }
        }
        Ok(columns)
    }

    /// The size of the file.
    pub(super) fn bytes(&self) -> u64 {
        self.source.len()
    }

    /// Checks that these columns unpack to sizes within the limit. A row group whose pages cannot be read is
    /// damaged, which its reader reports.
    pub(super) fn check(&self, columns: &[ParquetColumn]) -> Result<(), LogError> {
        let mut sum = 0_u64;
        for group in self.reader.metadata().row_groups() {
            let chunks = columns.iter().filter_map(|c| group.columns().get(c.leaf));
            for chunk in chunks {
                sum = sum.saturating_add(unpacked(&self.source, chunk).unwrap_or(0));
                limits::unpacked(self.bytes(), sum)
                    .map_err(|excess| LogError::excess(&self.path, excess))?;
            }
        }
        Ok(())
    }

    pub(super) fn groups(&self) -> usize {
        self.reader.num_row_groups()
    }

    /// The number of rows that a row group states.
    pub(super) fn rows_of(&self, group: usize) -> i64 {
        self.reader.metadata().row_group(group).num_rows()
    }

    pub(super) fn group(&self, group: usize) -> Result<Box<dyn RowGroupReader + '_>, ParquetError> {
        self.reader.get_row_group(group)
    }

    /// The error of a file whose content contradicts its table of contents.
    pub(super) fn broken(&self, error: &ParquetError) -> LogError {
        broken(&self.path, error)
    }
}

/// Refuses a file whose compression is not built in.
fn check_compression(path: &str, reader: &SerializedFileReader<Bounded>) -> Result<(), LogError> {
    let mut chunks = reader
        .metadata()
        .row_groups()
        .iter()
        .flat_map(RowGroupMetaData::columns);
    let unknown = chunks.find_map(|chunk| match chunk.compression() {
        Compression::BROTLI(_) => Some("brotli"),
        Compression::LZO => Some("LZO"),
        _ => None,
    });
    match unknown {
        None => Ok(()),
        Some(name) => Err(LogError::NotALog {
            path: path.to_owned(),
            found: format!(
                "a Parquet file compressed by {name}, which is not read: write it with snappy, gzip, zstd, lz4 or no compression"
            ),
        }),
    }
}

fn broken(path: &str, error: &ParquetError) -> LogError {
    LogError::NotALog {
        path: path.to_owned(),
        found: format!("a Parquet file that cannot be read: {error}"),
    }
}
