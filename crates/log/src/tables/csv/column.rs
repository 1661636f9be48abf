//! A column of a text table while it is read: numbers, date-time stamps or text.

use super::cell::{Cell, has_thousands_separators};
use crate::{Column, ColumnKind};

/// Longest example of a text cell that is kept, in characters.
const EXAMPLE_CHARS: usize = 40;

/// A cell that is not a plain number.
pub(super) enum OtherCell {
    Stamp(i64),
    Text(String),
}

#[derive(Default)]
pub(super) struct RawColumn {
    values: Vec<f64>,
    numbers: usize,
    stamps: usize,
    texts: usize,
    /// By position among the rows taken.
    odd: Vec<(usize, OtherCell)>,
}

/// Type of a column, if known; for stamps also the first one, in ns.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum ColumnContent {
    Numbers,
    Stamps(Option<i64>),
    Texts,
}

impl RawColumn {
    pub(super) fn push(&mut self, position: usize, kind: Cell, cell: &[u8]) {
        let value = match kind {
            Cell::Gap => f64::NAN,
            Cell::Number(value) | Cell::CommaNumber(value) => {
                self.numbers += 1;
                value
            }
            Cell::Stamp(nanoseconds) => {
                self.stamps += 1;
                self.odd.push((position, OtherCell::Stamp(nanoseconds)));
                f64::NAN
            }
            Cell::Text => {
                self.texts += 1;
                let example = String::from_utf8_lossy(cell);
                let example = example.chars().take(EXAMPLE_CHARS).collect();
                self.odd.push((position, OtherCell::Text(example)));
                f64::NAN
            }
        };
        self.values.push(value);
    }

    /// The first number with thousands separators, and its position, if most cells of text are such numbers.
    pub(super) fn first_with_separators(&self) -> Option<(usize, String)> {
        let mut numbers = self.odd.iter().filter_map(|(position, odd)| match odd {
            OtherCell::Text(text) if has_thousands_separators(text) => Some((*position, text)),
            _ => None,
        });
        let (position, text) = numbers.next()?;
        let count = 1 + numbers.count();
        (2 * count > self.texts).then(|| (position, text.clone()))
    }

    /// Decides the type of the column, unless it is known. Notes in `bad` the faults of rows that do
    /// not match it. With `units`, the first row may be one of units, and others follow in later parts.
    pub(super) fn finish(
        mut self,
        name: String,
        held: &mut Option<ColumnContent>,
        units: bool,
        bad: &mut [Option<String>],
    ) -> Column {
        let mut blame = |position: usize, found: &str| {
            bad[position]
                .get_or_insert_with(|| format!("expected a number in {name:?}, found {found:?}"));
        };
        let unit = match self.odd.first() {
            Some((0, OtherCell::Text(text))) => Some(text.clone()),
            _ => None,
        };
        let is_unit =
            units && self.numbers == 0 && matches!(&self.odd[..], [(0, OtherCell::Text(_))]);
        let most = match is_unit {
            true => 0,
            false => self.numbers.max(self.stamps).max(self.texts),
        };
        let settled = held.unwrap_or(if self.texts == most {
            ColumnContent::Texts
        } else if self.stamps == most {
            ColumnContent::Stamps(None)
        } else {
            ColumnContent::Numbers
        });
        let kind = match settled {
            _ if most == 0 && held.is_none() => ColumnKind::Number,
            ColumnContent::Texts => {
                let example = self.odd.iter().find_map(|(_, odd)| match odd {
                    OtherCell::Text(text) => Some(text.clone()),
                    OtherCell::Stamp(_) => None,
                });
                self.values.fill(f64::NAN);
                ColumnKind::Text {
                    example: example.unwrap_or_default(),
                }
            }
            ColumnContent::Stamps(mut origin) => {
                for (position, value) in self.values.iter().enumerate() {
                    if !value.is_nan() {
                        blame(position, &value.to_string());
                    }
                }
                for (position, odd) in &self.odd {
                    match odd {
                        OtherCell::Stamp(stamp) => {
                            let origin = *origin.get_or_insert(*stamp);
                            // Stamps centuries apart differ by more nanoseconds than an i64 can hold.
                            let since = i128::from(*stamp) - i128::from(origin);
                            self.values[*position] = since as f64 / 1e9;
                        }
                        OtherCell::Text(text) => blame(*position, text),
                    }
                }
                *held = Some(ColumnContent::Stamps(origin));
                ColumnKind::Stamp
            }
            ColumnContent::Numbers => {
                for (position, odd) in &self.odd {
                    match odd {
                        OtherCell::Stamp(_) => blame(*position, "a date"),
                        OtherCell::Text(text) => blame(*position, text),
                    }
                }
                ColumnKind::Number
            }
        };
        if most > 0 {
            held.get_or_insert(settled);
        }
        Column {
            unit: unit.filter(|_| !matches!(kind, ColumnKind::Text { .. })),
            name,
            kind,
            values: self.values,
        }
    }
}
