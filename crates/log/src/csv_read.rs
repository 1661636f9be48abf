use crate::cell::{Cell, classify};
use crate::layout::{Layout, Line, layout, split};
use crate::{Column, ColumnKind, Findings, LogError, Table};
use sha2::{Digest, Sha256};
use std::path::Path;

/// Longest example of a text cell that is kept, in characters.
const EXAMPLE_CHARS: usize = 40;

/// Reads a text table with a header, and counts what was found on the way.
///
/// Read without a word: a UTF-8 byte-order mark; line ends LF, CRLF, CR or mixed; a header that
/// starts with `#` and other comment lines that do; spaces around names and cells; quoted cells;
/// comma, semicolon, tab or `|` as delimiter; empty cells, `nan` and words such as `n/a` as gaps;
/// `true` and `false` as 1 and 0; a delimiter at the end of every line.
///
/// Date-time stamps such as `2019-11-07 18:45:58:868` become seconds from the first one. A column
/// with more text than numbers is kept as text, without values. Decimal commas are read where a
/// comma does not separate cells, with a warning.
///
/// A row of units below the header is passed over with a warning.
///
/// A row with the wrong number of cells, or with text where the column holds numbers, is corrupt:
/// it is dropped and counted. If it is the last one and breaks off, it is truncated. A row that
/// breaks off inside its very last number cannot be told from a whole one.
///
/// # Errors
/// [`LogError::Read`], [`LogError::Empty`], [`LogError::NotText`], [`LogError::NoHeader`] or
/// [`LogError::NoUsableRows`].
pub fn read_csv(path: impl AsRef<Path>) -> Result<(Table, Findings), LogError> {
    let path = path.as_ref();
    let name = path.display().to_string();
    match std::fs::read(path) {
        Ok(bytes) => parse_csv(&name, &bytes),
        Err(source) => Err(LogError::Read { path: name, source }),
    }
}

/// As [`read_csv`] for bytes in memory; `path` names them in errors and in the table.
///
/// # Errors
/// As [`read_csv`], but for [`LogError::Read`].
pub fn parse_csv(path: &str, bytes: &[u8]) -> Result<(Table, Findings), LogError> {
    let layout = layout(path, bytes)?;
    let mut rows = Rows::of(&layout);
    for (row, line) in layout.rows.iter().enumerate() {
        rows.push(row, *line, &layout);
    }
    rows.finish(path, hex_sha256(bytes), layout)
}

fn hex_sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes)
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect()
}

/// A cell that is no plain number.
enum Odd {
    Stamp(i64),
    Text(String),
}

#[derive(Default)]
struct RawColumn {
    values: Vec<f64>,
    numbers: usize,
    stamps: usize,
    texts: usize,
    /// By position among the rows taken.
    odd: Vec<(usize, Odd)>,
}

struct Rows {
    columns: Vec<RawColumn>,
    /// For each row taken its number in the file and its line.
    taken: Vec<(usize, usize)>,
    last_cell_empty: bool,
    comma_numbers: usize,
    first_fault: Option<String>,
    /// Whether the first row has two cells of text or more, and no number.
    first_is_text: bool,
    findings: Findings,
}

impl Rows {
    fn of(layout: &Layout<'_>) -> Self {
        Self {
            columns: layout.names.iter().map(|_| RawColumn::default()).collect(),
            taken: Vec::new(),
            last_cell_empty: true,
            comma_numbers: 0,
            first_fault: None,
            first_is_text: false,
            findings: Findings {
                rows_read: layout.rows.len(),
                warnings: layout.warnings.clone(),
                ..Findings::default()
            },
        }
    }

    fn push(&mut self, row: usize, line: Line<'_>, layout: &Layout<'_>) {
        let width = layout.names.len();
        let is_last = row + 1 == layout.rows.len();
        let mut cells = Vec::with_capacity(width);
        let paired = split(line.bytes, layout.delimiter, &mut cells);
        let found = cells.len();
        if found == width + 1 && cells.last().is_some_and(|cell| cell.is_empty()) {
            cells.pop();
        }
        if cells.len() + 1 == width && layout.names.last().is_some_and(String::is_empty) {
            cells.push(Vec::new().into());
        }
        if cells.iter().all(|cell| cell.is_empty()) {
            self.findings.empty_rows += 1;
            return;
        }
        // A row can break off just after its last delimiter.
        let last_empty = cells.last().is_some_and(|cell| cell.is_empty());
        let cut_at_end = is_last && !line.ended && last_empty && !self.last_cell_empty;
        if !paired || cells.len() != width || cut_at_end {
            if is_last && (cut_at_end || !paired || cells.len() < width) {
                self.findings.truncated = true;
                self.findings.warnings.push(format!(
                    "the last row (line {}) breaks off and was dropped",
                    line.number
                ));
            } else if paired {
                self.corrupt(
                    line.number,
                    &format!("expected {width} cells, found {found}"),
                );
            } else {
                self.corrupt(line.number, "quotes do not pair up");
            }
            return;
        }
        self.last_cell_empty = last_empty;
        let position = self.taken.len();
        self.taken.push((row, line.number));
        let mut texts = 0;
        for (column, cell) in self.columns.iter_mut().zip(&cells) {
            let kind = classify(cell, layout.delimiter != b',');
            texts += usize::from(kind == Cell::Text);
            self.comma_numbers += usize::from(matches!(kind, Cell::CommaNumber(_)));
            column.push(position, kind, cell);
        }
        if row == 0 {
            let filled = cells.iter().filter(|cell| !cell.is_empty()).count();
            self.first_is_text = texts == filled && texts > 1;
        }
    }

    fn corrupt(&mut self, line: usize, fault: &str) {
        self.findings.corrupt_rows += 1;
        self.first_fault
            .get_or_insert_with(|| format!("line {line}: {fault}"));
    }

    fn finish(
        mut self,
        path: &str,
        sha256: String,
        layout: Layout<'_>,
    ) -> Result<(Table, Findings), LogError> {
        let mut bad = vec![None; self.taken.len()];
        let mut columns: Vec<Column> = std::mem::take(&mut self.columns)
            .into_iter()
            .zip(layout.names)
            .map(|(raw, name)| raw.finish(name, &mut bad))
            .collect();
        // Only a delimiter at the line's end makes a column without a name, and it holds nothing.
        columns.retain(|column| !column.name.is_empty() || column.has_content());
        for (index, column) in columns.iter_mut().enumerate() {
            if column.name.is_empty() {
                column.name = format!("column_{}", index + 1);
            }
        }
        let last = layout.rows.last();
        for (position, fault) in bad.iter().enumerate() {
            let Some(fault) = fault else { continue };
            let line = self.taken[position].1;
            if position == 0 && self.first_is_text {
                self.findings.rows_read -= 1;
                self.findings.warnings.push(format!(
                    "line {line} holds no number and was taken for a row of units"
                ));
            } else if last.is_some_and(|last| last.number == line && !last.ended) {
                self.findings.truncated = true;
                self.findings.warnings.push(format!(
                    "the last row (line {line}) breaks off and was dropped"
                ));
            } else {
                self.corrupt(line, fault);
            }
        }
        if let Some(fault) = &self.first_fault {
            self.findings.warnings.push(format!(
                "{} of {} rows are corrupt and were dropped, the first in {fault}",
                self.findings.corrupt_rows, self.findings.rows_read
            ));
        }
        let kept: Vec<usize> = (0..bad.len()).filter(|&i| bad[i].is_none()).collect();
        if kept.is_empty() {
            let reason = match (&self.first_fault, self.findings.rows_read) {
                (_, 0) => "there is only a header".to_owned(),
                (Some(fault), read) => format!("all {read} rows are corrupt, the first in {fault}"),
                (None, read) => format!("{read} rows, all empty or broken off"),
            };
            let path = path.to_owned();
            return Err(LogError::NoUsableRows { path, reason });
        }
        for column in &mut columns {
            column.values = kept.iter().map(|&i| column.values[i]).collect();
            column.count(&mut self.findings);
        }
        if self.comma_numbers > 0 {
            self.findings.warnings.push(format!(
                "{} cells have a decimal comma and were read so",
                self.comma_numbers
            ));
        }
        self.findings.rows_used = kept.len();
        let table = Table {
            path: path.to_owned(),
            sha256,
            row_numbers: kept.iter().map(|&i| self.taken[i].0).collect(),
            columns,
        };
        Ok((table, self.findings))
    }
}

impl RawColumn {
    fn push(&mut self, position: usize, kind: Cell, cell: &[u8]) {
        let value = match kind {
            Cell::Gap => f64::NAN,
            Cell::Number(value) | Cell::CommaNumber(value) => {
                self.numbers += 1;
                value
            }
            Cell::Stamp(nanoseconds) => {
                self.stamps += 1;
                self.odd.push((position, Odd::Stamp(nanoseconds)));
                f64::NAN
            }
            Cell::Text => {
                self.texts += 1;
                let example = String::from_utf8_lossy(cell);
                let example = example.chars().take(EXAMPLE_CHARS).collect();
                self.odd.push((position, Odd::Text(example)));
                f64::NAN
            }
        };
        self.values.push(value);
    }

    /// Settles what the column holds; notes in `bad` what is wrong with rows that do not fit.
    fn finish(mut self, name: String, bad: &mut [Option<String>]) -> Column {
        let mut blame = |position: usize, found: &str| {
            bad[position]
                .get_or_insert_with(|| format!("expected a number in {name:?}, found {found:?}"));
        };
        let most = self.numbers.max(self.stamps).max(self.texts);
        let kind = if self.texts == most && most > 0 {
            let example = self.odd.iter().find_map(|(_, odd)| match odd {
                Odd::Text(text) => Some(text.clone()),
                Odd::Stamp(_) => None,
            });
            self.values.fill(f64::NAN);
            ColumnKind::Text {
                example: example.unwrap_or_default(),
            }
        } else if self.stamps == most && most > 0 {
            let mut origin = None;
            for (position, value) in self.values.iter().enumerate() {
                if !value.is_nan() {
                    blame(position, &value.to_string());
                }
            }
            for (position, odd) in &self.odd {
                match odd {
                    Odd::Stamp(stamp) => {
                        let origin = *origin.get_or_insert(*stamp);
                        self.values[*position] = (stamp - origin) as f64 / 1e9;
                    }
                    Odd::Text(text) => blame(*position, text),
                }
            }
            ColumnKind::Stamp
        } else {
            for (position, odd) in &self.odd {
                match odd {
                    Odd::Stamp(_) => blame(*position, "a date"),
                    Odd::Text(text) => blame(*position, text),
                }
            }
            ColumnKind::Number
        };
        Column {
            name,
            kind,
            values: self.values,
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
            return;
        }
        let gaps = self.values.iter().filter(|value| value.is_nan()).count();
        if gaps > 0 {
            findings.empty_cells.insert(self.name.clone(), gaps);
        }
    }
}
