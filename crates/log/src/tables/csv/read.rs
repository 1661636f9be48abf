use super::cell::{Cell, classify};
use super::column::{ColumnContent, RawColumn};
use super::layout::{Layout, Line, layout, split};
use crate::hashing::sha256;
use crate::{Column, Findings, LogError, Table};
use std::io::Read;
use std::path::Path;

/// Reads a text table, and counts faulty rows and gaps.
///
/// These are read without a warning:
///
/// - a UTF-8 byte-order mark; line ends LF, CRLF, CR or mixed;
/// - a header or comment lines that start with `#`;
/// - comma, semicolon, tab or `|` as delimiter, also at the end of every line;
/// - spaces around names and cells; quoted cells;
/// - empty cells, `nan` and words such as `n/a` as gaps; `true` and `false` as 1 and 0.
///
/// Date-time stamps such as `2019-11-07 18:45:58:868` become seconds from the first one. A column
/// with more text than numbers is kept as text, without values; a warning names one of numbers with thousands separators. Decimal commas are read where a
/// comma does not separate cells, with a warning.
///
/// The columns of a table without a header are called `c1`, `c2`, …, with a warning: a row of numbers is never a
/// header. Rows of numbers may be separated by blanks.
///
/// Lines above the header, such as the name of a program and a date, are passed over with a warning, where all lines from
/// the header on have as many cells as it has, and those above it have not.
///
/// A row of units below the header is skipped with a warning; its cells are the [units](Column::unit) of the columns.
///
/// A row with the wrong number of cells, or with text in a column of numbers, is corrupt: it is
/// dropped and counted. An incomplete last row counts as truncated. A row that ends inside its last
/// number cannot be recognised as incomplete.
///
/// # Errors
/// [`LogError::Read`], [`LogError::Empty`], [`LogError::NotText`], [`LogError::Excess`] or
/// [`LogError::NoUsableRows`].
pub fn read_csv(path: impl AsRef<Path>) -> Result<(Table, Findings), LogError> {
    let path = path.as_ref();
    let name = path.display().to_string();
    let mut bytes = Vec::new();
    match touchdown_files::open(path).and_then(|mut file| file.read_to_end(&mut bytes)) {
        Ok(_) => parse_csv(&name, &bytes),
        Err(source) => Err(LogError::Read { path: name, source }),
    }
}

/// As [`read_csv`] for bytes in memory; `path` names them in errors and in the table.
///
/// # Errors
/// As [`read_csv`], but for [`LogError::Read`].
pub fn parse_csv(path: &str, bytes: &[u8]) -> Result<(Table, Findings), LogError> {
    let layout = layout(path, bytes)?;
    let mut reading = TableReader::of(&layout);
    let part = reading.part(&layout.rows, true);
    let findings = reading.conclude(path)?;
    let table = Table {
        path: path.to_owned(),
        sha256: sha256(bytes),
        bytes: bytes.len() as u64,
        row_numbers: part.row_numbers,
        names: part.columns.iter().map(|c| c.name.clone()).collect(),
        columns: part.columns,
    };
    Ok((table, findings))
}

/// A table that is read in one part or in several.
pub(crate) struct TableReader {
    names: Vec<String>,
    header_line: Option<usize>,
    delimiter: u8,
    held: Vec<Option<ColumnContent>>,
    /// Rows so far, complete or not.
    rows: usize,
    comma_numbers: usize,
    first_fault: Option<String>,
    findings: Findings,
}

/// Rows of a table, and their numbers in the file.
pub(crate) struct TablePart {
    pub(crate) row_numbers: Vec<usize>,
    pub(crate) columns: Vec<Column>,
}

/// The rows of a part while it is read.
struct PartReader<'a> {
    reading: &'a mut TableReader,
    columns: Vec<RawColumn>,
    /// For each row taken its number in the file and its line.
    taken: Vec<(usize, usize)>,
    last_cell_empty: bool,
    /// Whether the first row has two cells of text or more, and no number.
    first_is_text: bool,
}

impl TableReader {
    pub(crate) fn of(layout: &Layout<'_>) -> Self {
        Self {
            names: layout.names.clone(),
            header_line: layout.header_line,
            delimiter: layout.delimiter,
            held: vec![None; layout.names.len()],
            rows: 0,
            comma_numbers: 0,
            first_fault: None,
            findings: Findings {
                warnings: layout.warnings.clone(),
                ..Findings::default()
            },
        }
    }

    /// Reads the next lines, without comments and blank ones; `ends` is true for the last lines. The
    /// first part with values of a column decides its type.
    pub(crate) fn part(&mut self, lines: &[Line<'_>], ends: bool) -> TablePart {
        let first = self.rows;
        self.rows += lines.len();
        self.findings.rows_read += lines.len();
        let mut rows = PartReader {
            columns: self.names.iter().map(|_| RawColumn::default()).collect(),
            reading: self,
            taken: Vec::new(),
            last_cell_empty: true,
            first_is_text: false,
        };
        for (at, line) in lines.iter().enumerate() {
            rows.push(first + at, *line, ends && at + 1 == lines.len());
        }
        rows.finish(lines.last().filter(|_| ends))
    }

    fn corrupt(&mut self, line: usize, fault: &str) {
        self.findings.corrupt_rows += 1;
        self.first_fault
            .get_or_insert_with(|| format!("line {line}: {fault}"));
    }

    fn breaks_off(&mut self, line: usize) {
        self.findings.truncated = true;
        self.findings.warnings.push(format!(
            "the last row (line {line}) breaks off and was dropped"
        ));
    }

    /// The counts of all parts.
    pub(crate) fn conclude(mut self, path: &str) -> Result<Findings, LogError> {
        self.findings.unite_text_columns();
        if let Some(fault) = &self.first_fault {
            self.findings.warnings.push(format!(
                "{} of {} rows are corrupt and were dropped, the first in {fault}",
                self.findings.corrupt_rows, self.findings.rows_read
            ));
        }
        if self.findings.rows_used == 0 {
            let reason = match (&self.first_fault, self.findings.rows_read) {
                (_, 0) => "the file contains only a header".to_owned(),
                (Some(fault), read) => {
                    let header = self.header_line.map_or_else(String::new, |line| {
                        format!(". Line {line} was taken for the header: if it is not, delete the lines above the header")
                    });
                    format!("all {read} rows are corrupt, the first in {fault}{header}")
                }
                (None, read) => format!("{read} rows, all empty or broken off"),
            };
            let path = path.to_owned();
            return Err(LogError::NoUsableRows { path, reason });
        }
        if self.comma_numbers > 0 {
            self.findings.warnings.push(format!(
                "{} cells have a decimal comma; it was read as a decimal point",
                self.comma_numbers
            ));
        }
        Ok(self.findings)
    }
}

impl PartReader<'_> {
    fn push(&mut self, row: usize, line: Line<'_>, is_last: bool) {
        let TableReader {
            names, delimiter, ..
        } = &*self.reading;
        let (width, delimiter) = (names.len(), *delimiter);
        let mut cells = Vec::with_capacity(width);
        let paired = split(line.bytes, delimiter, &mut cells);
        let found = cells.len();
        if found == width + 1 && cells.last().is_some_and(|cell| cell.is_empty()) {
            cells.pop();
        }
        if cells.len() + 1 == width && names.last().is_some_and(String::is_empty) {
            cells.push(Vec::new().into());
        }
        if cells.iter().all(|cell| cell.is_empty()) {
            self.reading.findings.empty_rows += 1;
            return;
        }
        // A row can end just after its last delimiter.
        let last_empty = cells.last().is_some_and(|cell| cell.is_empty());
        let cut_at_end = is_last && !line.ended && last_empty && !self.last_cell_empty;
        if !paired || cells.len() != width || cut_at_end {
            if is_last && (cut_at_end || !paired || cells.len() < width) {
                self.reading.breaks_off(line.number);
            } else if paired {
                let mut fault = format!("expected {width} cells, found {found}");
                if delimiter == b',' && width > 1 && found == 2 * width {
                    fault.push_str(
                        " (decimal commas between commas? Write decimal points, or semicolons between the cells)",
                    );
                }
                self.reading.corrupt(line.number, &fault);
            } else {
                self.reading.corrupt(line.number, "quotes do not pair up");
            }
            return;
        }
        self.last_cell_empty = last_empty;
        let position = self.taken.len();
        self.taken.push((row, line.number));
        let (mut texts, mut filled) = (0, 0);
        for (column, cell) in self.columns.iter_mut().zip(&cells) {
            let kind = classify(cell, delimiter != b',');
            texts += usize::from(kind == Cell::Text);
            // In a row of units, a column without a unit has a dash or a one.
            let has_no_unit = cell.iter().all(|&byte| byte == b'-') || &**cell == b"1";
            filled += usize::from(!has_no_unit);
            self.reading.comma_numbers += usize::from(matches!(kind, Cell::CommaNumber(_)));
            column.push(position, kind, cell);
        }
        if row == 0 {
            self.first_is_text = texts == filled && texts > 1;
        }
    }

    /// `last` is the file's last line.
    fn finish(mut self, last: Option<&Line<'_>>) -> TablePart {
        let mut bad = vec![None; self.taken.len()];
        // A column with nothing but a unit is not text: its numbers may be in a later part.
        let units = self.first_is_text && last.is_none();
        let raw = std::mem::take(&mut self.columns).into_iter();
        let known = self.reading.names.iter().zip(&mut self.reading.held);
        let warnings = &mut self.reading.findings.warnings;
        let mut columns: Vec<Column> = raw
            .zip(known)
            .map(|(raw, (name, held))| {
                let separated = match held {
                    None => raw.first_with_separators(),
                    Some(_) => None,
                };
                let column = raw.finish(name.clone(), held, units, &mut bad);
                if let (true, Some((position, found))) = (column.is_text(), separated) {
                    let line = self.taken[position].1;
                    warnings.push(format!(
                        "column {name:?} was taken for text: most of its cells are numbers with thousands separators, the first in \
                         line {line}: expected a number, found {found:?}. Write its numbers without separators"
                    ));
                }
                column
            })
            .collect();
        // Only a delimiter at the line's end makes a column without a name, which is always empty.
        columns.retain(|column| !column.name.is_empty() || column.has_content());
        for (index, column) in columns.iter_mut().enumerate() {
            if column.name.is_empty() {
                column.name = format!("column_{}", index + 1);
            }
        }
        let mut has_units = false;
        for (position, fault) in bad.iter().enumerate() {
            let Some(fault) = fault else { continue };
            let line = self.taken[position].1;
            if position == 0 && self.first_is_text {
                has_units = true;
                self.reading.findings.rows_read -= 1;
                self.reading.findings.warnings.push(format!(
                    "line {line} holds no number; it was read as a row of units"
                ));
            } else if last.is_some_and(|last| last.number == line && !last.ended) {
                self.reading.breaks_off(line);
            } else {
                self.reading.corrupt(line, fault);
            }
        }
        let kept: Vec<usize> = (0..bad.len()).filter(|&i| bad[i].is_none()).collect();
        let findings = &mut self.reading.findings;
        findings.rows_used += kept.len();
        for column in &mut columns {
            column.unit.take_if(|_| !has_units);
            column.values = kept.iter().map(|&i| column.values[i]).collect();
            column.count(findings);
        }
        TablePart {
            row_numbers: kept.iter().map(|&i| self.taken[i].0).collect(),
            columns,
        }
    }
}

impl Column {
    fn has_content(&self) -> bool {
        self.is_text() || self.values.iter().any(|value| !value.is_nan())
    }

    pub(crate) fn count(&self, findings: &mut Findings) {
        if self.is_text() {
            findings.text_columns.push(self.name.clone());
            // Earlier parts held only empty cells and counted them.
            findings.empty_cells.remove(&self.name);
            return;
        }
        let gaps = self.values.iter().filter(|value| value.is_nan()).count();
        if gaps > 0 {
            *findings.empty_cells.entry(self.name.clone()).or_default() += gaps;
        }
    }
}
