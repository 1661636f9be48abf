//! Text tables part by part: each part of whole lines goes with the header to the reader of `touchdown-log`.

use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use touchdown_log::{ColumnKind, Findings, LogError};

use super::{Columns, label, labels, text};
use crate::error::{Error, Result};

/// Bytes of a part, about, and of a line at most.
const PART: usize = 4 << 20;
const LONGEST: usize = 64 << 20;
/// Lines in which the first row must be found.
const HEADER_LINES: usize = 1000;

/// A file, read up to some line.
pub(super) struct Rows {
    file: File,
    path: String,
    /// Bytes of the file, and those that were read.
    size: u64,
    read: u64,
    /// Bytes that were read and not handed on.
    rest: Vec<u8>,
    /// The lines up to the header.
    header: Vec<u8>,
    /// The first part, with the header.
    first: Option<Vec<u8>>,
    pub(super) names: Vec<String>,
    /// Rows and dropped rows so far.
    pub(super) findings: Findings,
}

impl Rows {
    pub(super) fn open(path: &Path) -> Result<Self> {
        let file = File::open(path).map_err(|e| Error::file(path, e))?;
        let size = file.metadata().map_err(|e| Error::file(path, e))?.len();
        let mut rows = Self {
            file,
            path: path.display().to_string(),
            size,
            read: 0,
            rest: Vec::new(),
            header: Vec::new(),
            first: None,
            names: Vec::new(),
            findings: Findings::default(),
        };
        let first = rows.part()?.unwrap_or_default();
        let (table, findings) = touchdown_log::parse_csv(&rows.path, &first)?;
        let columns = table.columns().iter();
        rows.names = columns.map(|c| c.name().to_owned()).collect();
        rows.findings.warnings = findings.warnings;
        rows.header = first[..rows.header_length(&first)?].to_vec();
        rows.first = Some(first);
        Ok(rows)
    }

    /// Bytes that were read, as a share of all.
    pub(super) fn share(&self) -> f64 {
        self.read as f64 / self.size.max(1) as f64
    }

    /// The next whole lines.
    fn part(&mut self) -> Result<Option<Vec<u8>>> {
        let path = self.path.clone();
        let fail = |e| Error::file(path.as_ref(), e);
        loop {
            let mut more = Vec::new();
            let room = PART.saturating_sub(self.rest.len()).max(PART / 4) as u64;
            let read = (&mut self.file).take(room).read_to_end(&mut more);
            let read = read.map_err(fail)?;
            self.read += read as u64;
            self.rest.append(&mut more);
            if read == 0 {
                let last = std::mem::take(&mut self.rest);
                return Ok((!last.is_empty()).then_some(last));
            }
            let end = |byte: u8| self.rest.iter().rposition(|&b| b == byte);
            if let Some(end) = end(b'\n').or_else(|| end(b'\r')) {
                let rest = self.rest.split_off(end + 1);
                return Ok(Some(std::mem::replace(&mut self.rest, rest)));
            }
            if self.rest.len() > LONGEST {
                let expected = format!("lines of less than {} MB", LONGEST >> 20);
                return Err(Error::data(&self.path, expected, "a longer one"));
            }
        }
    }

    /// The length of the lines before the first row: those without which there is none.
    fn header_length(&self, first: &[u8]) -> Result<usize> {
        let ends = (0..first.len()).filter(|&i| {
            first[i] == b'\n' || (first[i] == b'\r' && first.get(i + 1) != Some(&b'\n'))
        });
        let mut before = 0;
        for end in ends.take(HEADER_LINES) {
            if touchdown_log::parse_csv(&self.path, &first[..=end]).is_ok() {
                return Ok(before);
            }
            before = end + 1;
        }
        match first.len() < PART / 2 {
            // A single row that no line end follows.
            true => Ok(before),
            false => Err(Error::data(
                &self.path,
                format!("a row in the first {HEADER_LINES} lines"),
                "none",
            )),
        }
    }

    /// The next rows and their labels; none at the end. `numbers` gets the number of each in the file.
    pub(super) fn next(
        &mut self,
        places: &[usize],
        label_place: Option<usize>,
        numbers: &mut Vec<usize>,
    ) -> Result<Option<Columns>> {
        loop {
            let (bytes, is_first) = match self.first.take() {
                Some(first) => (first, true),
                None => match self.part()? {
                    Some(part) => ([self.header.as_slice(), &part].concat(), false),
                    None => return Ok(None),
                },
            };
            let before = self.findings.rows_read;
            let (table, found) = match touchdown_log::parse_csv(&self.path, &bytes) {
                Ok(parsed) => parsed,
                Err(LogError::NoUsableRows { .. }) if !is_first => {
                    let body = String::from_utf8_lossy(&bytes[self.header.len()..]).into_owned();
                    let rows = body.lines().filter(|l| !l.trim().is_empty()).count();
                    self.lose(rows, rows, before);
                    continue;
                }
                Err(error) => return Err(error.into()),
            };
            if is_first {
                self.findings = found;
            } else {
                self.lose(found.rows_read, found.corrupt_rows, before);
                self.findings.truncated |= found.truncated;
                self.findings.empty_rows += found.empty_rows;
                let broken = found.warnings.iter().any(|w| w.contains("breaks off"));
                if broken {
                    let warning = "the last row breaks off and was dropped".to_owned();
                    self.findings.warnings.push(warning);
                }
            }
            let column = |&place: &usize| {
                let name = &self.names[place];
                if let Some(ColumnKind::Stamp) = table.column(name).map(touchdown_log::Column::kind)
                {
                    return Err(Error::data(
                        format!("{}, column `{name}`", self.path),
                        "numbers, as --stream reads them from text (date-time stamps it reads from Parquet)",
                        "date-time stamps",
                    ));
                }
                text::numbers(&table, name)
            };
            let columns = places.iter().map(column).collect::<Result<Vec<_>>>()?;
            let labels = match label_place.map(|place| &self.names[place]) {
                None => None,
                Some(name) => Some(self.labels(&table, &bytes, name)?),
            };
            numbers.clear();
            numbers.extend(table.row_numbers().iter().map(|&row| before + row + 1));
            return Ok(Some((columns, labels)));
        }
    }

    fn labels(
        &self,
        table: &touchdown_log::Table,
        bytes: &[u8],
        name: &str,
    ) -> Result<Vec<String>> {
        match table.column(name) {
            Some(column) if !column.is_text() && *column.kind() == ColumnKind::Number => {
                Ok(column.values().iter().map(|&v| label(v)).collect())
            }
            _ => {
                let all = String::from_utf8_lossy(bytes);
                labels::of_text(&all, name, table.row_numbers()).ok_or_else(|| {
                    Error::data(
                        format!("{}, column `{name}`", self.path),
                        "a label for every row",
                        "text that does not line up with the rows; number the trajectories instead",
                    )
                })
            }
        }
    }

    /// Counts rows of a later part, and those of them that are corrupt.
    fn lose(&mut self, rows: usize, corrupt: usize, before: usize) {
        let found = &mut self.findings;
        if corrupt > 0 {
            found.warnings.push(format!(
                "{corrupt} of data rows {} to {} are corrupt and were dropped",
                before + 1,
                before + rows
            ));
        }
        found.rows_read += rows;
        found.corrupt_rows += corrupt;
    }
}
