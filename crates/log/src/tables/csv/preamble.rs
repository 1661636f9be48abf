//! Lines above the header of a text table, such as the program and the date of a test.

use super::cell::{Cell, classify};
use super::layout::{DELIMITERS, Line, SAMPLED_LINES, is_comment, is_row_of_numbers, split};

/// Most lines above a header.
const MOST: usize = 10;

/// The lines above the header, taken away from `body`. There are some only where the header is clear: all further lines
/// have as many cells as it has, the lines above it have not, and it has no number in it.
pub(super) fn take_preamble<'a>(body: &mut Vec<Line<'a>>, told: Option<u8>) -> Vec<Line<'a>> {
    let places = (0..body.len()).filter(|&at| !is_comment(body[at].bytes));
    let mut places: Vec<usize> = places.take(SAMPLED_LINES + MOST).collect();
    // The last line of a file may be incomplete.
    if places.len() > 2 && body.last().is_some_and(|line| !line.ended) {
        places.retain(|&at| at + 1 < body.len());
    }
    let lines: Vec<&[u8]> = places.iter().map(|&at| body[at].bytes).collect();
    let mut found: Option<(usize, usize)> = None;
    for delimiter in told.map_or(DELIMITERS.to_vec(), |told| vec![told]) {
        match header_of(&lines, delimiter) {
            // A table from its first line on.
            Some((0, _)) => return Vec::new(),
            Some((at, width)) if found.is_none_or(|(_, most)| width > most) => {
                found = Some((at, width));
            }
            _ => {}
        }
    }
    match found {
        Some((at, _)) => body.drain(..places[at]).collect(),
        None => Vec::new(),
    }
}

/// The place of the header and its number of cells, if lines are a table from there on.
fn header_of(lines: &[&[u8]], delimiter: u8) -> Option<(usize, usize)> {
    let kinds_of = |line: &&[u8]| -> Vec<Cell> {
        let mut cells = Vec::new();
        split(line, delimiter, &mut cells);
        let kinds = cells.iter().map(|cell| classify(cell, delimiter != b','));
        kinds.collect()
    };
    let kinds: Vec<Vec<Cell>> = lines.iter().map(kinds_of).collect();
    let width = kinds.last()?.len();
    let other = kinds.iter().rposition(|kinds| kinds.len() != width);
    let at = other.map_or(0, |other| other + 1);
    if width < 2 || at == 0 {
        return (width > 1).then_some((0, width));
    }
    let (header, rows) = kinds[at..].split_first()?;
    let texts = header.iter().filter(|kind| **kind == Cell::Text).count();
    let is_header = header
        .iter()
        .all(|kind| matches!(kind, Cell::Text | Cell::Gap));
    let is_number = |kind: &Cell| matches!(kind, Cell::Number(_) | Cell::CommaNumber(_));
    let has_numbers = rows.iter().any(|row| row.iter().any(is_number));
    // Rows above are another table.
    let is_row = |line: &&[u8]| is_row_of_numbers(line, delimiter);
    let mut above = lines[..at].iter().zip(&kinds);
    let has_rows = above.any(|(line, kinds)| kinds.len() > 1 && is_row(line));
    (at <= MOST && is_header && texts > 1 && has_numbers && !has_rows).then_some((at, width))
}
