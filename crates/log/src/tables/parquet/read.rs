//! Reads requested columns of Parquet files into tables, row group by row group.

use super::decode::{Content, numbers, texts};
use super::file::{ParquetColumn, ParquetFile};
use crate::hashing::sha256_of;
use crate::tables::GatheredColumns;
use crate::{Column, ColumnKind, Findings, LogError, Table, limits};
use parquet::errors::ParquetError;
use std::ops::Range;
use std::path::Path;

/// Largest number of rows that a file may state per byte, and in addition. Plain numbers take bytes
/// for each row, repeated ones less than a bit. Smaller limits reject files that compress well; larger
/// ones let a damaged count use more memory.
const ROWS_A_BYTE: u64 = 64;
const ROWS_ANYWAY: u64 = 1 << 20;
/// Longest stored example of a text cell, in characters, so that a message stays readable.
const EXAMPLE_CHARS: usize = 40;

/// A column whose row groups are read one after the other.
struct PartialColumn {
    column: ParquetColumn,
    values: Vec<f64>,
    /// The first stamp.
    origin: Option<i64>,
    example: Option<String>,
}

/// Reads a Parquet file into a table: columns of numbers without conversion, stamps in seconds from
/// the first one, nulls as gaps. Columns of lists are omitted. With `wanted`, only those columns are
/// read.
///
/// A damaged row group is skipped, and its rows count as corrupt.
///
/// # Errors
/// [`LogError::Read`], [`LogError::NotALog`] for a file without its last part, which holds the
/// table of contents, and [`LogError::NoUsableRows`].
pub fn read_parquet(
    path: impl AsRef<Path>,
    wanted: Option<&dyn Fn(&str) -> bool>,
) -> Result<(Table, Findings), LogError> {
    let path = path.as_ref();
    let name = path.display().to_string();
    let mut bytes = 0;
    let mut gathered = GatheredColumns::new(&|_| true, 1.0);
    let visit = &mut |group, rows: Range<usize>| gathered.add(group, &rows.collect::<Vec<_>>());
    let (sha256, findings) = each_group(path, wanted, Some(&mut bytes), visit)?;
    let mut table = gathered.table(&name, sha256, bytes);
    if wanted.is_some() {
        // An error of a map names the columns that there are.
        table.names = ParquetFile::open(path)?
            .columns()
            .iter()
            .map(ParquetColumn::name)
            .collect();
    }
    Ok((table, findings))
}

/// Passes on the undamaged row groups with their row numbers, and returns the file's SHA-256. The whole table is
/// to fit into memory if its file's size is asked for, otherwise each row group.
pub(crate) fn each_group(
    path: &Path,
    wanted: Option<&dyn Fn(&str) -> bool>,
    whole: Option<&mut u64>,
    visit: &mut dyn FnMut(Vec<Column>, Range<usize>),
) -> Result<(String, Findings), LogError> {
    let name = path.display().to_string();
    let hashed = touchdown_files::open(path)
        .and_then(|file| Ok((sha256_of(&file)?, file.metadata()?.len())));
    let (sha256, bytes) = hashed.map_err(|source| LogError::Read {
        path: name.clone(),
        source,
    })?;
    let most_rows = bytes * ROWS_A_BYTE + ROWS_ANYWAY;
    let file = ParquetFile::open(path)?;
    let lists = file.lists.iter();
    let mut findings = Findings {
        warnings: lists
            .map(|label| format!("{label}: omitted, because it holds lists"))
            .collect(),
        ..Findings::default()
    };
    let is_wanted = |column: &&ParquetColumn| wanted.is_none_or(|wanted| wanted(&column.name()));
    let partial = |column: &ParquetColumn| PartialColumn {
        column: column.clone(),
        values: Vec::new(),
        origin: None,
        example: None,
    };
    let columns = file.columns().iter().filter(is_wanted);
    let mut columns: Vec<PartialColumn> = columns.map(partial).collect();
    let is_whole = whole.map(|size| *size = bytes).is_some();
    let of_limit = |excess| LogError::excess(&name, excess);
    let leaves: Vec<ParquetColumn> = columns.iter().map(|c| c.column.clone()).collect();
    file.check(&leaves)?;
    for group in (0..file.groups()).filter(|&group| file.rows_of(group) != 0) {
        let stated = file.rows_of(group);
        let rows = usize::try_from(stated).unwrap_or(0);
        // An impossible number of rows must not allocate memory, and does not count as lost rows.
        let is_borne_out = (findings.rows_used as u64).saturating_add(rows as u64) <= most_rows;
        let rows = if is_borne_out { rows } else { 0 };
        let held = if is_whole { findings.rows_used } else { 0 };
        limits::values(held + rows, columns.len(), bytes).map_err(of_limit)?;
        let first = findings.rows_read;
        findings.rows_read = findings.rows_read.saturating_add(rows);
        let read = if is_borne_out {
            read_group(&file, group, &mut columns, rows)
        } else {
            let text = "a file of this size cannot hold that many rows".to_owned();
            Err(ParquetError::General(text))
        };
        match read {
            Ok(()) => {
                findings.rows_used += rows;
                let group: Vec<Column> = columns.iter_mut().map(PartialColumn::take).collect();
                for column in &group {
                    column.count(&mut findings);
                }
                visit(group, first..first + rows);
            }
            Err(error) => {
                findings.corrupt_rows = findings.corrupt_rows.saturating_add(rows.max(1));
                let text = format!("row group {group} of {stated} rows is damaged: {error}");
                findings.warnings.push(text);
                columns.iter_mut().for_each(|column| column.values.clear());
            }
        }
    }
    findings.unite_text_columns();
    if findings.rows_used == 0 {
        let reason = match findings.corrupt_rows {
            0 => "the file has none".to_owned(),
            _ => findings.warnings.join("; "),
        };
        return Err(LogError::NoUsableRows { path: name, reason });
    }
    Ok((sha256, findings))
}

/// Reads the rows of a group into every column.
fn read_group(
    file: &ParquetFile,
    group: usize,
    columns: &mut [PartialColumn],
    rows: usize,
) -> Result<(), ParquetError> {
    let group = file.group(group)?;
    for partial in columns {
        let mut reader = partial.column.reader(file, group.as_ref())?;
        let description = &partial.column.description;
        match partial.column.content {
            Content::Text => {
                if partial.example.is_none() {
                    let mut first = Vec::new();
                    texts(&mut reader, description, (1, u64::MAX), &mut first)?;
                    let first = first.pop().flatten();
                    partial.example = first.map(|text| text.chars().take(EXAMPLE_CHARS).collect());
                }
                partial.values.resize(rows, f64::NAN);
            }
            Content::Other => partial.values.resize(rows, f64::NAN),
            content => {
                let (origin, values) = (&mut partial.origin, &mut partial.values);
                numbers(
                    &mut reader,
                    description,
                    content,
                    origin,
                    usize::MAX,
                    values,
                )?;
            }
        }
        if partial.values.len() != rows {
            let found = partial.values.len();
            let text = format!("{} has {found} values", partial.column.name());
            return Err(ParquetError::General(text));
        }
    }
    Ok(())
}

impl PartialColumn {
    /// The values of the present row group.
    fn take(&mut self) -> Column {
        let kind = match self.column.content {
            Content::Number | Content::Unsigned | Content::Decimal(_) => ColumnKind::Number,
            Content::Stamp(_) => ColumnKind::Stamp,
            Content::Text => ColumnKind::Text {
                example: self.example.clone().unwrap_or_default(),
            },
            Content::Other => ColumnKind::Text {
                example: self.column.type_name(),
            },
        };
        Column {
            name: self.column.name(),
            kind,
            unit: None,
            values: std::mem::take(&mut self.values),
        }
    }
}
