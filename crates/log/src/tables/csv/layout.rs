//! Layout of a text table: lines, header, delimiter.

use super::cell::{Cell, classify};
use super::preamble::take_preamble;
use crate::LogError;
use crate::limits;
use std::borrow::Cow;
use std::collections::{HashMap, HashSet};

/// Number of lines that decide the delimiter.
pub(super) const SAMPLED_LINES: usize = 20;
/// The delimiter of tables whose cells are separated by any number of blanks.
const BLANKS: u8 = b' ';
/// Delimiters, in the order of preference between equals.
pub(super) const DELIMITERS: [u8; 4] = [b',', b';', b'\t', b'|'];

/// Letters that a warning shows of a line at most.
const SHOWN_CHARS: usize = 40;

/// Largest number of renamed columns that are listed one by one.
const MOST_RENAMED: usize = 16;

/// A line that is not blank.
#[derive(Clone, Copy)]
pub(crate) struct Line<'a> {
    /// From 1.
    pub(crate) number: usize,
    pub(crate) bytes: &'a [u8],
    /// Whether a line end follows it.
    pub(crate) ended: bool,
}

pub(crate) struct Layout<'a> {
    /// The number of the header's line, if there is one.
    pub(crate) header_line: Option<usize>,
    pub(crate) names: Vec<String>,
    pub(crate) delimiter: u8,
    /// The rows, without comments and blank lines.
    pub(crate) rows: Vec<Line<'a>>,
    pub(crate) warnings: Vec<String>,
    /// The number of the line after all of these.
    pub(crate) next_number: usize,
}

/// Bytes of a file in which a zero byte says that it is binary: signatures with what follows them. Further on, one is a corrupt row.
const BEGINNING: usize = 16;
const BINARY: &str = "a binary file";

pub(crate) fn layout<'a>(path: &str, bytes: &'a [u8]) -> Result<Layout<'a>, LogError> {
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return Err(not_text(path, "UTF-16; save the table as UTF-8"));
    }
    // A binary file may begin with a line of text, as PNG does.
    if bytes.iter().take(BEGINNING).any(|b| *b == 0) {
        return Err(not_text(path, BINARY));
    }
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let (mut lines, next_number) = lines(bytes, 1);
    // A spreadsheet states the delimiter so.
    let told = lines
        .first()
        .and_then(|line| told_delimiter(line.bytes))
        .inspect(|_| {
            lines.remove(0);
        });
    let comments = lines
        .iter()
        .take_while(|line| is_comment(line.bytes))
        .count();
    let mut body = lines.split_off(comments);
    if lines.is_empty() && body.is_empty() {
        let path = path.to_owned();
        return Err(LogError::Empty { path });
    }
    let first = body.first().or(lines.last());
    let first = first.map_or(&[][..], |line| line.bytes);
    if first.iter().any(|b| b.is_ascii_control() && *b != b'\t') {
        return Err(not_text(path, BINARY));
    }
    let mut warnings = Vec::new();
    warnings.extend(above_header(&take_preamble(&mut body, told)));
    let Heading {
        header,
        delimiter,
        mut rows,
    } = heading(lines, body, told, &mut warnings);
    let of_limit = |excess| LogError::excess(path, excess);
    let header_line = header.map(|line| line.number);
    let header = header.map(|line| line.bytes);
    let width = |line: &[u8]| limits::columns(width(line, delimiter)).map_err(of_limit);
    width(header.unwrap_or_default())?;
    rows.retain(|line| !is_comment(line.bytes));
    let names = match (header, rows.first()) {
        (Some(header), _) => names(header, delimiter, &mut warnings),
        (None, row) => numbered(
            row.map_or(&[], |row| row.bytes),
            delimiter,
            &width,
            &mut warnings,
        )?,
    };
    let mut long = names.iter().map(|name| limits::column_name(name));
    let long = long.find(Result::is_err).unwrap_or(Ok(()));
    long.map_err(of_limit)?;
    Ok(Layout {
        header_line,
        names,
        delimiter,
        rows,
        warnings,
        next_number,
    })
}

/// The warning of lines above the header.
fn above_header(above: &[Line<'_>]) -> Option<String> {
    let (first, last) = (above.first()?, above.last()?);
    let text = String::from_utf8_lossy(first.bytes);
    let text: String = text.trim().chars().take(SHOWN_CHARS).collect();
    let lines = match above.len() {
        1 => format!("line {} stands", first.number),
        _ => format!("lines {} to {} stand", first.number, last.number),
    };
    Some(format!(
        "{lines} above the header and were passed over: they begin with {text:?}"
    ))
}

/// The header of a table, if it has one, and its rows, with comments between them.
struct Heading<'a> {
    header: Option<Line<'a>>,
    delimiter: u8,
    rows: Vec<Line<'a>>,
}

/// Finds the header: the first line with a word in it. Of comments that come first, the last one is the header if
/// numbers follow it and it has as many cells. A row of numbers is never a header.
fn heading<'a>(
    mut comments: Vec<Line<'a>>,
    mut body: Vec<Line<'a>>,
    told: Option<u8>,
    warnings: &mut Vec<String>,
) -> Heading<'a> {
    let of_body = told.or_else(|| of_numbers(&body));
    let of_body = of_body.unwrap_or_else(|| sniff(&body));
    let first = body.first().copied();
    let is_headless = first.is_some_and(|line| is_row_of_numbers(line.bytes, of_body));
    let header = match (is_headless, first) {
        (false, Some(line)) => {
            body.remove(0);
            Some(line)
        }
        _ => comments.pop(),
    };
    let header = header.map(|line| Line {
        bytes: uncommented(line.bytes),
        ..line
    });
    let sample: Vec<Line<'_>> = header
        .iter()
        .chain(body.iter().take(SAMPLED_LINES))
        .copied()
        .collect();
    let delimiter = told.unwrap_or_else(|| sniff(&sample));
    let Some(header) = header else {
        return Heading {
            header: None,
            delimiter: of_body,
            rows: body,
        };
    };
    let of_row = body.iter().find(|line| !is_comment(line.bytes));
    let fits = |row: &Line<'_>| width(header.bytes, delimiter) == width(row.bytes, delimiter);
    let is_header = match of_row {
        Some(row) if is_headless || delimiter == BLANKS => fits(row),
        _ => true,
    };
    if is_header && !is_row_of_numbers(header.bytes, delimiter) {
        return Heading {
            header: Some(header),
            delimiter,
            rows: body,
        };
    }
    // A comment that is no header, or words that are not those of the columns.
    if !is_headless {
        warnings.push(format!(
            "line {} does not have a name for each column",
            header.number
        ));
    }
    Heading {
        header: None,
        delimiter: if is_headless { of_body } else { delimiter },
        rows: body,
    }
}

/// A line without the sign of a comment before it.
fn uncommented(line: &[u8]) -> &[u8] {
    let line = line.trim_ascii_start();
    line.strip_prefix(b"#").unwrap_or(line)
}

/// The names of columns that have none: `c1`, `c2`, ….
fn numbered(
    row: &[u8],
    delimiter: u8,
    check: &dyn Fn(&[u8]) -> Result<(), LogError>,
    warnings: &mut Vec<String>,
) -> Result<Vec<String>, LogError> {
    check(row)?;
    let mut cells = Vec::new();
    split(row, delimiter, &mut cells);
    // A delimiter at the end of the line makes no column.
    let count = cells.len() - usize::from(cells.last().is_some_and(|cell| cell.is_empty()));
    warnings.push(format!(
        "the table has no header; its columns are called c1 to c{count}"
    ));
    Ok((1..=count).map(|k| format!("c{k}")).collect())
}

/// The number of cells of a line.
fn width(line: &[u8], delimiter: u8) -> usize {
    let mut cells = Vec::new();
    split(line, delimiter, &mut cells);
    cells.len()
}

pub(crate) fn not_text(path: &str, found: &'static str) -> LogError {
    let path = path.to_owned();
    LogError::NotText { path, found }
}

/// The lines of a later part of a table, from this number on, without comments and blank ones; and
/// the number of the line after them.
pub(crate) fn rows(bytes: &[u8], number: usize) -> (Vec<Line<'_>>, usize) {
    let (mut lines, next_number) = lines(bytes, number);
    lines.retain(|line| !is_comment(line.bytes));
    (lines, next_number)
}

fn lines(bytes: &[u8], mut number: usize) -> (Vec<Line<'_>>, usize) {
    let mut found = Vec::new();
    let mut start = 0;
    while start < bytes.len() {
        let rest = &bytes[start..];
        let length = rest.iter().position(|&b| b == b'\n' || b == b'\r');
        let line = &rest[..length.unwrap_or(rest.len())];
        if !line.trim_ascii().is_empty() {
            found.push(Line {
                number,
                bytes: line,
                ended: length.is_some(),
            });
        }
        let end = if rest[line.len()..].starts_with(b"\r\n") {
            2
        } else {
            1
        };
        start += line.len() + end;
        number += 1;
    }
    (found, number)
}

fn told_delimiter(line: &[u8]) -> Option<u8> {
    match line.strip_prefix(b"sep=")? {
        &[delimiter] => Some(delimiter),
        _ => None,
    }
}

pub(super) fn is_comment(line: &[u8]) -> bool {
    line.trim_ascii_start().starts_with(b"#")
}

/// Whether every cell is a number, a stamp or a gap, and not all are gaps.
pub(super) fn is_row_of_numbers(line: &[u8], delimiter: u8) -> bool {
    let mut cells = Vec::new();
    split(line, delimiter, &mut cells);
    let kinds: Vec<Cell> = cells
        .iter()
        .map(|cell| classify(cell, delimiter != b','))
        .collect();
    kinds.iter().all(|kind| *kind != Cell::Text) && kinds.iter().any(|kind| *kind != Cell::Gap)
}

/// The delimiter with which most lines have as many cells as the first, and more than one. Between
/// equals, the one with more cells.
fn sniff(lines: &[Line<'_>]) -> u8 {
    let Some((header, rows)) = lines.split_first() else {
        return DELIMITERS[0];
    };
    let mut best = (0, 0, DELIMITERS[0]);
    let mut cells = Vec::new();
    for delimiter in DELIMITERS {
        split(header.bytes, delimiter, &mut cells);
        let width = cells.len();
        if width < 2 {
            continue;
        }
        let alike = rows
            .iter()
            .take(SAMPLED_LINES)
            .filter(|row| {
                split(row.bytes, delimiter, &mut cells);
                cells.len() == width
            })
            .count();
        if (alike + 1, width) > (best.0, best.1) {
            best = (alike + 1, width, delimiter);
        }
    }
    // Words may hold blanks, rows of numbers may not.
    match of_numbers(rows) {
        Some(BLANKS) if best.0 == 0 => BLANKS,
        _ => best.2,
    }
}

/// The delimiter with which all of the first lines are rows of numbers of one width, of two columns at least.
fn of_numbers(lines: &[Line<'_>]) -> Option<u8> {
    let rows = lines.iter().take(SAMPLED_LINES);
    let rows = rows.filter(|row| !is_comment(row.bytes));
    let first = rows.clone().next()?;
    DELIMITERS.into_iter().chain([BLANKS]).find(|&delimiter| {
        let columns = width(first.bytes, delimiter);
        let alike = |row: &Line<'_>| {
            is_row_of_numbers(row.bytes, delimiter) && width(row.bytes, delimiter) == columns
        };
        columns > 1 && rows.clone().all(alike)
    })
}

/// Splits a line into cells without the spaces around them. `false` if quotes do not pair up.
///
/// A quoted cell ends with its line at the latest. So a stray quote in a corrupt section costs only
/// its own row, not all rows up to the next quote.
pub(crate) fn split<'a>(line: &'a [u8], delimiter: u8, cells: &mut Vec<Cow<'a, [u8]>>) -> bool {
    cells.clear();
    if delimiter == BLANKS {
        let words = line.split(u8::is_ascii_whitespace);
        cells.extend(words.filter(|word| !word.is_empty()).map(Cow::Borrowed));
        return true;
    }
    if !line.contains(&b'"') {
        cells.extend(
            line.split(|&b| b == delimiter)
                .map(|cell| Cow::Borrowed(cell.trim_ascii())),
        );
        return true;
    }
    let mut whole = true;
    let mut rest = line;
    loop {
        let opening = rest
            .iter()
            .position(|&b| b == delimiter || !b.is_ascii_whitespace());
        let quoted = opening.filter(|&at| rest[at] == b'"' && delimiter != b'"');
        let end = if let Some(at) = quoted {
            let (cell, closed, length) = unquote(&rest[at + 1..]);
            whole &= closed;
            cells.push(Cow::Owned(cell));
            let after = &rest[at + 1 + length..];
            let end = after.iter().position(|&b| b == delimiter);
            whole &= after[..end.unwrap_or(after.len())].trim_ascii().is_empty();
            end.map(|end| at + 1 + length + end)
        } else {
            let end = rest.iter().position(|&b| b == delimiter);
            let cell = &rest[..end.unwrap_or(rest.len())];
            cells.push(Cow::Borrowed(cell.trim_ascii()));
            end
        };
        match end {
            Some(end) => rest = &rest[end + 1..],
            None => return whole,
        }
    }
}

/// The cell after an opening quote, whether it is closed, and its length including the closing
/// quote. A doubled quote counts as one quote.
fn unquote(text: &[u8]) -> (Vec<u8>, bool, usize) {
    let mut cell = Vec::new();
    let mut at = 0;
    while at < text.len() {
        match (text[at], text.get(at + 1)) {
            (b'"', Some(b'"')) => {
                cell.push(b'"');
                at += 2;
            }
            (b'"', _) => return (cell, true, at + 1),
            (byte, _) => {
                cell.push(byte);
                at += 1;
            }
        }
    }
    (cell, false, text.len())
}

/// Column names, unique and not empty. Only the last one may be empty, after a trailing delimiter.
fn names(header: &[u8], delimiter: u8, warnings: &mut Vec<String>) -> Vec<String> {
    let mut cells = Vec::new();
    if !split(header, delimiter, &mut cells) {
        warnings.push("quotes in the header do not pair up".to_owned());
    }
    let mut latin = false;
    let mut names: Vec<String> = Vec::with_capacity(cells.len());
    let mut taken = HashSet::new();
    let mut repeats: HashMap<String, usize> = HashMap::new();
    let mut renamed = Vec::new();
    let last = cells.len() - 1;
    for (index, cell) in cells.iter().enumerate() {
        let text = std::str::from_utf8(cell).map_or_else(
            |_| {
                latin = true;
                cell.iter().copied().map(char::from).collect()
            },
            str::to_owned,
        );
        let mut name = text.trim().to_owned();
        if name.is_empty() && index < last {
            name = format!("column_{}", index + 1);
            renamed.push(format!(
                "column {} has no name; it is called {name:?}",
                index + 1
            ));
        }
        if !taken.insert(name.clone()) {
            let wanted = name;
            let count = repeats.entry(wanted.clone()).or_insert(1);
            name = loop {
                *count += 1;
                let candidate = format!("{wanted}#{count}");
                if taken.insert(candidate.clone()) {
                    break candidate;
                }
            };
            renamed.push(format!(
                "two columns are called {wanted:?}; column {} is called {name:?}",
                index + 1
            ));
        }
        names.push(name);
    }
    let more = renamed.len().saturating_sub(MOST_RENAMED);
    warnings.extend(renamed.into_iter().take(MOST_RENAMED));
    if more > 0 {
        warnings.push(format!(
            "{more} further columns have no name or a repeated one"
        ));
    }
    if latin {
        warnings.push("the header is not UTF-8; it was read as Latin-1".to_owned());
    }
    names
}
