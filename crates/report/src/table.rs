//! Tables: columns with units, cells with a stated number of digits.

use crate::scale::{minus, scientific};
use crate::{Error, Result};

/// A table with a caption.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    /// What the table shows.
    pub caption: String,
    /// From left to right.
    pub columns: Vec<Column>,
    /// Each with one cell for each column.
    pub rows: Vec<Vec<Cell>>,
    /// Remarks below the table.
    pub notes: Vec<String>,
}

/// Head of a column.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// Name of the quantity.
    pub name: String,
    /// Where cells stand.
    pub align: Align,
    /// Unit, shown after the name; empty for none.
    pub unit: String,
}

/// Where the content of a column stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Align {
    /// At the left: words.
    Left,
    /// At the right: numbers.
    Right,
    /// In the middle.
    Center,
}

/// One field of a table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cell {
    text: String,
    bold: bool,
}

/// What stands where there is no value.
const MISSING: &str = "–";

impl Table {
    /// A table without columns and rows.
    pub fn new(caption: impl Into<String>) -> Self {
        Self {
            caption: caption.into(),
            ..Self::default()
        }
    }

    /// Adds a column of words.
    #[must_use]
    pub fn text_column(self, name: impl Into<String>) -> Self {
        self.column(Column {
            name: name.into(),
            align: Align::Left,
            unit: String::new(),
        })
    }

    /// Adds a column of numbers with their unit.
    #[must_use]
    pub fn number_column(self, name: impl Into<String>, unit: impl Into<String>) -> Self {
        self.column(Column {
            name: name.into(),
            align: Align::Right,
            unit: unit.into(),
        })
    }

    /// Adds a column.
    #[must_use]
    pub fn column(mut self, column: Column) -> Self {
        self.columns.push(column);
        self
    }

    /// Adds a row.
    #[must_use]
    pub fn row(mut self, cells: impl IntoIterator<Item = Cell>) -> Self {
        self.rows.push(cells.into_iter().collect());
        self
    }

    /// Adds a remark.
    #[must_use]
    pub fn note(mut self, note: impl Into<String>) -> Self {
        self.notes.push(note.into());
        self
    }

    /// Every row has one cell for each column.
    pub(crate) fn check(&self) -> Result<()> {
        let expected = self.columns.len();
        let wrong = self.rows.iter().position(|row| row.len() != expected);
        wrong.map_or(Ok(()), |row| {
            let found = self.rows[row].len();
            Err(Error::Row {
                table: self.caption.clone(),
                row: row + 1,
                expected,
                found,
            })
        })
    }
}

impl Cell {
    /// Words.
    pub fn text(text: impl Into<String>) -> Self {
        Self {
            text: text.into(),
            bold: false,
        }
    }

    /// A number with so many decimals; a dash if it is not finite. What is too large to read, or would be rounded to
    /// zero, is written with a power of ten.
    pub fn number(value: f64, decimals: usize) -> Self {
        Self::text(number(value, decimals))
    }

    /// A number, or a dash where there is none.
    pub fn maybe(value: Option<f64>, decimals: usize) -> Self {
        Self::number(value.unwrap_or(f64::NAN), decimals)
    }

    /// A value and its uncertainty; the value alone where the uncertainty is not finite. A narrow page breaks it before
    /// the sign.
    pub fn plus_minus(value: f64, uncertainty: f64, decimals: usize) -> Self {
        if !value.is_finite() || !uncertainty.is_finite() {
            return Self::number(value, decimals);
        }
        Self::text(format!(
            "{} ±\u{a0}{}",
            number(value, decimals),
            number(uncertainty, decimals)
        ))
    }

    /// A whole number.
    pub fn count(value: usize) -> Self {
        Self::text(value.to_string())
    }

    /// A dash: no value.
    pub fn missing() -> Self {
        Self::text(MISSING)
    }

    /// In bold letters.
    #[must_use]
    pub fn bold(mut self) -> Self {
        self.bold = true;
        self
    }

    /// What is shown.
    pub fn shown(&self) -> &str {
        &self.text
    }

    /// Whether it is shown in bold letters.
    pub fn is_bold(&self) -> bool {
        self.bold
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::text(text)
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::text(text)
    }
}

fn number(value: f64, decimals: usize) -> String {
    if !value.is_finite() {
        return MISSING.to_owned();
    }
    let decimals = decimals.min(15);
    let vanishes = value != 0.0 && value.abs() < 0.5 * 10f64.powi(-(decimals as i32));
    if value.abs() >= 1e7 || vanishes {
        return scientific(value, 1);
    }
    let text = format!("{value:.decimals$}");
    minus(&text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_cells_show_what_they_should() {
        assert_eq!(Cell::number(-0.125, 2).shown(), "−0.12");
        assert_eq!(Cell::number(1.2e-5, 2).shown(), "1.2×10⁻⁵");
        assert_eq!(Cell::number(0.0, 2).shown(), "0.00");
        assert_eq!(Cell::number(3.4e8, 2).shown(), "3.4×10⁸");
        assert_eq!(Cell::number(f64::NAN, 2).shown(), "–");
        assert_eq!(Cell::maybe(None, 2), Cell::missing());
        assert_eq!(Cell::plus_minus(1.0, 0.25, 2).shown(), "1.00 ±\u{a0}0.25");
        assert_eq!(Cell::plus_minus(1.0, f64::NAN, 1).shown(), "1.0");
    }

    #[test]
    fn analytic_rows_must_fit_columns() {
        let table = Table::new("t")
            .text_column("a")
            .number_column("b", "m")
            .row(["x".into()]);
        assert!(matches!(
            table.check(),
            Err(Error::Row {
                row: 1,
                expected: 2,
                found: 1,
                ..
            })
        ));
    }
}
