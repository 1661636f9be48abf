//! Gathers columns of a table that is read part by part.

use super::{Column, ColumnKind, Table};

/// Room beyond the number of rows that the first part lets expect: rows at the end of a log may be shorter than those at its
/// start. A table that needs more grows once.
pub(crate) const SPARE: f64 = 1.02;

/// The wanted columns of all parts so far, and the names of all others.
pub(crate) struct GatheredColumns<'a> {
    wanted: &'a dyn Fn(&str) -> bool,
    /// All of the file's columns.
    names: Vec<String>,
    columns: Vec<Column>,
    row_numbers: Vec<usize>,
    /// Parts of this size that the file has, for the number of rows.
    parts: f64,
}

impl<'a> GatheredColumns<'a> {
    /// `parts` is the size of the file over that of its first part.
    pub(crate) fn new(wanted: &'a dyn Fn(&str) -> bool, parts: f64) -> Self {
        Self {
            wanted,
            names: Vec::new(),
            columns: Vec::new(),
            row_numbers: Vec::new(),
            parts,
        }
    }

    /// Adds the rows of a part. A column that earlier parts lack has gaps there, and the other way round.
    pub(crate) fn add(&mut self, part: Vec<Column>, row_numbers: &[usize]) {
        let before = self.row_numbers.len();
        if before == 0 {
            let rows = SPARE * self.parts.max(1.0) * row_numbers.len() as f64;
            self.row_numbers.reserve_exact(rows as usize);
        }
        self.row_numbers.extend_from_slice(row_numbers);
        let capacity = self.row_numbers.capacity();
        for (at, column) in part.into_iter().enumerate() {
            if self.names.get(at) != Some(&column.name) && !self.names.contains(&column.name) {
                self.names.push(column.name.clone());
            }
            if !(self.wanted)(&column.name) {
                continue;
            }
            match self.columns.iter_mut().find(|c| c.name == column.name) {
                Some(known) => known.append(column),
                None => {
                    let mut values = Vec::with_capacity(capacity);
                    values.resize(before, f64::NAN);
                    values.extend_from_slice(&column.values);
                    self.columns.push(Column { values, ..column });
                }
            }
        }
        for column in &mut self.columns {
            column.values.resize(self.row_numbers.len(), f64::NAN);
        }
    }

    pub(crate) fn table(self, path: &str, sha256: String, bytes: u64) -> Table {
        Table {
            path: path.to_owned(),
            sha256,
            bytes,
            row_numbers: self.row_numbers,
            columns: self.columns,
            names: self.names,
        }
    }
}

impl Column {
    fn append(&mut self, more: Self) {
        self.values.extend_from_slice(&more.values);
        let has_example = matches!(&self.kind, ColumnKind::Text { example } if !example.is_empty());
        // The first values, or the first text, may be in a later part.
        if !has_example {
            self.kind = more.kind;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parse_csv;
    use crate::tables::csv::each_part;

    #[test]
    fn prop_wanted_columns_in_parts_of_any_size_are_those_of_the_whole() {
        // Stamps, a column that begins empty, a text that begins empty, a row of units and a corrupt row.
        let mut text = "Timestamp,a,b,who,c\ns,V,A,name,m\n".to_owned();
        for i in 0..60 {
            let (b, who) = if i < 20 { ("", "") } else { ("1.5", "x") };
            text += &format!("2020-01-01 00:{i:02}:00,{i},{b},{who},2\n");
            text += if i == 23 {
                "2020-01-01 00:00:00,word,1,x,3\n"
            } else {
                ""
            };
        }
        let (whole, _) = parse_csv("t.csv", text.as_bytes()).unwrap();
        let wanted = |name: &str| ["Timestamp", "b", "who"].contains(&name);
        for part in [200, 333, 512, 1 << 20] {
            let mut gathered = GatheredColumns::new(&wanted, text.len() as f64 / part as f64);
            let (sha256, _) = each_part("t.csv", text.as_bytes(), part, &mut |part| {
                gathered.add(part.columns, &part.row_numbers);
            })
            .unwrap();
            let table = gathered.table("t.csv", sha256, text.len() as u64);
            assert_eq!(table.names, whole.names, "{part}");
            assert_eq!(table.row_numbers, whole.row_numbers, "{part}");
            let kept: Vec<&Column> = whole.columns.iter().filter(|c| wanted(&c.name)).collect();
            assert_eq!(table.columns.len(), kept.len(), "{part}");
            for (column, whole) in table.columns.iter().zip(kept) {
                // The example of a text may be another one of its cells.
                let kind = |c: &Column| (c.name.clone(), std::mem::discriminant(&c.kind));
                assert_eq!(kind(column), kind(whole), "{part}");
                let bits = |c: &Column| c.values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
                assert_eq!(bits(column), bits(whole), "{part}");
            }
        }
    }
}
