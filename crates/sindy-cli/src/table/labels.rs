//! The cells of a text column: labels that separate trajectories.

use std::path::Path;

use touchdown_log::Table;

use crate::error::{Error, Result};

/// Reads the column's cells again, for the rows that the table kept.
///
/// The table's reader passes over comments and blank lines, and so does this.
pub(super) fn read(table: &Table, name: &str) -> Result<Vec<String>> {
    let path = Path::new(table.path());
    let bytes = std::fs::read(path).map_err(|e| Error::file(path, e))?;
    let text = String::from_utf8_lossy(&bytes);
    of_text(&text, name, table.row_numbers()).ok_or_else(|| {
        Error::data(
            format!("{}, column `{name}`", table.path()),
            "a label for every row",
            "text that does not line up with the rows; number the trajectories instead",
        )
    })
}

pub(super) fn of_text(text: &str, name: &str, rows: &[usize]) -> Option<Vec<String>> {
    let text = text.trim_start_matches('\u{feff}');
    let mut lines = text
        .split(['\n', '\r'])
        .map(str::trim)
        .filter(|l| !l.is_empty());
    let (delimiter, place, width) = lines.by_ref().find_map(|line| header(line, name))?;
    let labels: Vec<String> = lines
        .filter(|line| !line.starts_with('#'))
        .map(|line| {
            let cells = cells(line, delimiter);
            match cells.len() >= width {
                true => cells[place].clone(),
                false => String::new(),
            }
        })
        .collect();
    rows.iter().map(|&row| labels.get(row).cloned()).collect()
}

/// Delimiter, place of the column and number of columns, if this line is the header.
fn header(line: &str, name: &str) -> Option<(u8, usize, usize)> {
    let line = line.strip_prefix('#').unwrap_or(line);
    b",;\t|".iter().find_map(|&delimiter| {
        let cells = cells(line, delimiter);
        let place = cells.iter().position(|cell| cell == name)?;
        (cells.len() > 1).then_some((delimiter, place, cells.len()))
    })
}

fn cells(line: &str, delimiter: u8) -> Vec<String> {
    let mut reader = csv::ReaderBuilder::new()
        .delimiter(delimiter)
        .has_headers(false)
        .flexible(true)
        .trim(csv::Trim::All)
        .from_reader(line.as_bytes());
    let record = reader.records().next().and_then(std::result::Result::ok);
    record.map_or_else(Vec::new, |r| r.iter().map(str::to_owned).collect())
}

#[cfg(test)]
mod tests {
    use super::of_text;

    #[test]
    fn analytic_labels_line_up_with_the_rows_that_were_kept() {
        let text = "# made by hand\r\nt;run;x\r\n0;first;1\r\n\r\n# a remark\r\n1;\"second; b\";2\r\n2;third;3\r\n";
        let labels = of_text(text, "run", &[0, 1, 2]).unwrap();
        assert_eq!(labels, ["first", "second; b", "third"]);
        assert_eq!(of_text(text, "run", &[2]).unwrap(), ["third"]);
        assert_eq!(of_text(text, "run", &[3]), None);
        assert_eq!(of_text(text, "lap", &[0]), None);
    }
}
